//! Anti-aliasing: where the samples of a pixel are, how they are shaded, and how they become the pixel.
//!
//! Coverage, depth and visibility are exact at each sample. Each triangle is shaded once in each pixel that it covers,
//! or at each sample; then the samples are averaged in linear light.

mod cells;
mod filter;

pub use cells::{MAX_SAMPLES, SampleCells, SampleCenters};
pub use filter::{FilterWeights, Tap};

use std::fmt;
use std::str::FromStr;

/// Where the samples of a pixel are.
///
/// Sparse patterns place N samples on a grid of N by N cells, one in each row and each column, well apart. 4 are the
/// default: strings thinner than a pixel are continuous, and a frame takes about two and a half times as long as with one.
/// Source: Holten-Lund, Design for Scalability in 3D Computer Graphics Architectures (2001), figure 3.25.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum SamplePattern {
    /// One sample, in the middle of the pixel.
    Center,
    /// 2 samples in 2 by 2 cells.
    Sparse2,
    /// 4 samples in 4 by 4 cells: a rotated grid.
    #[default]
    Sparse4,
    /// 8 samples in 8 by 8 cells.
    Sparse8,
    /// 16 samples in 16 by 16 cells.
    Sparse16,
    /// All of 2 by 2 cells.
    Ordered2x2,
    /// All of 4 by 4 cells.
    Ordered4x4,
}

impl SamplePattern {
    /// All patterns.
    pub const ALL: [Self; 7] = [
        Self::Center,
        Self::Sparse2,
        Self::Sparse4,
        Self::Sparse8,
        Self::Sparse16,
        Self::Ordered2x2,
        Self::Ordered4x4,
    ];

    /// The name: the number of samples, or the ordered grid.
    pub fn name(self) -> &'static str {
        match self {
            Self::Center => "1",
            Self::Sparse2 => "2",
            Self::Sparse4 => "4",
            Self::Sparse8 => "8",
            Self::Sparse16 => "16",
            Self::Ordered2x2 => "2x2",
            Self::Ordered4x4 => "4x4",
        }
    }

    /// Number of samples per pixel: 1, 2, 4, 8 or 16.
    pub fn count(self) -> usize {
        self.cells().count
    }

    /// The samples' positions.
    pub fn cells(self) -> SampleCells {
        match self {
            Self::Center => SampleCells::CENTER,
            Self::Sparse2 => SampleCells::sparse([0, 1]),
            Self::Sparse4 => SampleCells::sparse([1, 3, 0, 2]),
            Self::Sparse8 => SampleCells::sparse([0, 3, 6, 1, 4, 7, 2, 5]),
            Self::Sparse16 => SampleCells::sparse([11, 7, 0, 4, 12, 8, 2, 14, 6, 10, 1, 13, 5, 9, 15, 3]),
            Self::Ordered2x2 => SampleCells::ordered(2),
            Self::Ordered4x4 => SampleCells::ordered(4),
        }
    }
}

impl fmt::Display for SamplePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name of a sample pattern is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected 1, 2, 4, 8, 16, 2x2 or 4x4 samples, found {0:?}")]
pub struct UnknownPattern(pub String);

impl FromStr for SamplePattern {
    type Err = UnknownPattern;

    fn from_str(name: &str) -> Result<Self, UnknownPattern> {
        Self::ALL.into_iter().find(|p| p.name() == name).ok_or_else(|| UnknownPattern(name.into()))
    }
}

/// How often a triangle is shaded in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum SampleShading {
    /// Once, at the centre of the samples that it covers there, rounded to whole sub-pixels.
    #[default]
    Pixel,
    /// At each sample that it covers.
    Sample,
}

/// How the samples around a pixel become its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Filter {
    /// The mean of the pixel's own samples.
    #[default]
    Box,
    /// Weights that fall linearly to zero at the centres of the neighbouring pixels, across and down: softer, and
    /// without the steps that remain in nearly horizontal and vertical edges. With one sample per pixel it is the same
    /// as [`Filter::Box`].
    Tent,
}

/// Anti-aliasing of a picture. The default is 4 samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sampling {
    /// Where the samples are.
    pub pattern: SamplePattern,
    /// How often a triangle is shaded in a pixel.
    pub shading: SampleShading,
    /// How samples become pixels.
    pub filter: Filter,
}

impl Sampling {
    /// One sample per pixel.
    pub const NONE: Self =
        Self { pattern: SamplePattern::Center, shading: SampleShading::Pixel, filter: Filter::Box };

    /// A pattern with the default shading and filter.
    pub fn of(pattern: SamplePattern) -> Self {
        Self { pattern, ..Self::default() }
    }

    /// Pixels around a pixel whose samples contribute to it, in each direction.
    pub fn halo(&self) -> u32 {
        u32::from(self.filter == Filter::Tent && self.pattern != SamplePattern::Center)
    }
}
