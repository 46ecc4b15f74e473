//! What a picture is drawn with. Size, culling and shading change the picture; everything else may change
//! only how fast it is there.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use fearless_simd::Level;
use tercio_scene::Framing;

use crate::error::RenderError;
use crate::frame::Outputs;
use crate::screen::TileSet;

/// The largest width and height of a picture, in pixels.
pub const MAX_SIZE: u32 = 32768;

/// How triangles are sorted into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Binning {
    /// Into every tile that the bounding box touches.
    BoundingBox,
    /// Only into tiles of which the triangle can cover a sample.
    #[default]
    Exact,
}

/// What is sorted into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Sorting {
    /// Clusters that are small on the screen as a whole, of the others every triangle.
    #[default]
    Clusters,
    /// Every triangle.
    Triangles,
}

/// Where the work on a frame ends: for measuring, what is drawn then is no picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
#[non_exhaustive]
pub enum LastStage {
    /// Clusters are tested, then tossed.
    Cull,
    /// Clusters and triangles are sorted into tiles, then tossed.
    Bin,
    /// Triangles that reach a sample are found in each tile, then tossed.
    Sieve,
    /// What is seen at each sample is known, and tossed.
    Visibility,
    /// Nothing is tossed.
    #[default]
    Output,
}

/// Which triangles are left out by their facing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Cull {
    /// Surfaces are two-sided; hidden back faces are skipped where that provably leaves the picture the same.
    #[default]
    Auto,
    /// Surfaces are two-sided; nothing is skipped by its facing.
    None,
    /// Triangles that show their back are not drawn.
    Back,
    /// Triangles that show their front are not drawn.
    Front,
}

impl Cull {
    /// Which orientation on the screen is left out: `Some(true)` the clockwise one, `Some(false)` the
    /// counter-clockwise one, `None` neither. A mirrored instance shows its fronts clockwise.
    pub(crate) fn drops_clockwise(self, mirrored: bool) -> Option<bool> {
        match self {
            Self::Auto | Self::None => None,
            Self::Back => Some(!mirrored),
            Self::Front => Some(mirrored),
        }
    }

    /// Of lanes that run clockwise and counter-clockwise on the screen: those that are drawn, those left out.
    #[inline(always)]
    pub(crate) fn split(self, mirrored: bool, clockwise: u32, counter: u32) -> (u32, u32) {
        match self.drops_clockwise(mirrored) {
            None => (clockwise | counter, 0),
            Some(true) => (counter, clockwise),
            Some(false) => (clockwise, counter),
        }
    }
}

/// Where and how light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Shading {
    /// Once a triangle's plane: facets show.
    Flat,
    /// At the vertices, colours are interpolated.
    Gouraud,
    /// At every pixel from the interpolated normal.
    #[default]
    Phong,
    /// Not at all: the colours as they are.
    Unlit,
}

/// A share of clusters or entries: number `number` of `of` shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which share, below `of`.
    pub number: u32,
    /// How many there are, at least 1.
    pub of: u32,
}

impl Part {
    /// All of it.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// The consecutive ones of `count` things that the share holds; the shares differ by one at most.
    pub fn range(self, count: u32) -> Range<u32> {
        let begin = |number: u32| (u64::from(count) * u64::from(number) / u64::from(self.of)) as u32;
        begin(self.number)..begin(self.number + 1)
    }

    /// Every `of`-th of some things, from number `number` on.
    pub(crate) fn every<T>(self, things: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
        things.skip(self.number as usize).step_by(self.of as usize)
    }
}

impl Default for Part {
    fn default() -> Self {
        Self::WHOLE
    }
}

/// A SIMD level by name; the processor decides which of them exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SimdLevel {
    /// One number at a time.
    Scalar,
    /// x86-64 baseline, 128 bits.
    Sse2,
    /// x86-64-v2, 128 bits.
    Sse42,
    /// x86-64-v3, 256 bits.
    Avx2,
    /// AVX-512 as in Ice Lake, Zen 4 and later, 512 bits.
    Avx512,
    /// AArch64, 128 bits.
    Neon,
}

impl SimdLevel {
    /// All names.
    pub const ALL: [Self; 6] = [Self::Scalar, Self::Sse2, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
        }
    }

    /// The best level of this processor.
    pub fn best() -> Self {
        *Self::available().last().unwrap_or(&Self::Scalar)
    }

    /// The levels of this processor, slowest first.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|l| l.level().is_some()).collect()
    }

    /// The proof that this processor has the level.
    pub(crate) fn level(self) -> Option<Level> {
        let best = Level::new();
        match self {
            #[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
            Self::Scalar => Some(Level::Fallback(fearless_simd::Fallback::new())),
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => best.as_sse2().map(Level::Sse2),
            #[cfg(target_arch = "x86_64")]
            Self::Sse42 => best.as_sse4_2().map(Level::Sse4_2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => best.as_avx2().map(Level::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => best.as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => best.as_neon().map(Level::Neon),
            #[allow(unreachable_patterns, reason = "which levels exist depends on the architecture")]
            _ => {
                let _ = best;
                None
            }
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SimdLevel {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|l| l.name() == s).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|l| l.name()).collect();
            format!("expected one of {}, found \"{s}\"", names.join(", "))
        })
    }
}

/// What a picture is drawn with.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across, 1 to [`MAX_SIZE`].
    pub width: u32,
    /// Pixels down, 1 to [`MAX_SIZE`].
    pub height: u32,
    /// Which triangles are left out by their facing.
    pub cull: Cull,
    /// Where and how light is computed.
    pub shading: Shading,
    /// Which pictures are wanted.
    pub outputs: Outputs,
    /// Pixels along the edge of a tile: 8, 16, 32, 64 or 128; `None` lets the renderer choose.
    pub tile_size: Option<u32>,
    /// What is sorted into tiles.
    pub sorting: Sorting,
    /// How triangles are sorted into tiles.
    pub binning: Binning,
    /// Whole clusters are tested before their triangles are.
    pub cluster_culling: bool,
    /// Which clusters are drawn: a share of consecutive ones. All but the whole makes a part of the picture.
    pub clusters: Part,
    /// Which tiles are drawn. The pixels of the others stay as they are in the frame. All but [`TileSet::ALL`] is made for
    /// tiles of a size that is asked for by [`Settings::tile_size`].
    pub tiles: TileSet,
    /// Where the work ends; anything but [`LastStage::Output`] makes no picture.
    pub last_stage: LastStage,
    /// `None` takes the best of this processor.
    pub simd: Option<SimdLevel>,
}

/// Pixels along the edge of the smallest tile that is not asked for.
const SMALLEST_TILE: u32 = 16;
/// Tiles of which there should be so many for each thread.
const TILES_A_THREAD: usize = 8;

impl Settings {
    /// A picture of this size, everything else by default.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            cull: Cull::default(),
            shading: Shading::default(),
            outputs: Outputs::default(),
            tile_size: None,
            sorting: Sorting::default(),
            binning: Binning::default(),
            cluster_culling: true,
            clusters: Part::WHOLE,
            tiles: TileSet::ALL,
            last_stage: LastStage::default(),
            simd: None,
        }
    }

    /// The default framing for a picture of this size: makes the camera without the size being said again.
    ///
    /// ```
    /// use tercio_raster::Settings;
    /// use tercio_scene::Framing;
    ///
    /// let settings = Settings::new(1920, 1080);
    /// let from_the_right = Framing { azimuth: 90.0, ..settings.framing() };
    /// assert_eq!(from_the_right.aspect, 16.0 / 9.0);
    /// ```
    pub fn framing(&self) -> Framing {
        Framing::new(self.width, self.height)
    }

    /// Pixels along the edge of a tile: what was asked for, or by the size of the picture. Small tiles share the work
    /// of small pictures better; in large ones clusters reach into fewer tiles.
    pub fn tile_edge(&self) -> u32 {
        self.tile_size.unwrap_or(match u64::from(self.width) * u64::from(self.height) {
            0..=0x4000 => SMALLEST_TILE,
            0x4001..=0x1_0000 => 32,
            0x1_0001..=0x8_0000 => 64,
            _ => 128,
        })
    }

    /// The same where some threads share the tiles: small enough for each to get several, because no two tiles are
    /// the same work.
    pub fn tile_edge_for(&self, threads: usize) -> u32 {
        let mut edge = self.tile_edge();
        while self.tile_size.is_none()
            && edge > SMALLEST_TILE
            && self.tiles_of(edge) < TILES_A_THREAD * threads
        {
            edge /= 2;
        }
        edge
    }

    /// Number of tiles of the picture if they have this many pixels along an edge.
    pub fn tiles_of(&self, edge: u32) -> usize {
        self.width.div_ceil(edge) as usize * self.height.div_ceil(edge) as usize
    }

    /// Tells whether these settings make a picture on this processor.
    ///
    /// # Errors
    /// [`RenderError::Setting`] names the first that does not.
    pub fn check(&self) -> Result<(), RenderError> {
        let setting = |what, range: String, value: String| Err(RenderError::Setting { what, range, value });
        for (what, value) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_SIZE).contains(&value) {
                return setting(what, format!("1 to {MAX_SIZE} pixels"), value.to_string());
            }
        }
        if let Some(t) = self.tile_size.filter(|t| ![8, 16, 32, 64, 128].contains(t)) {
            return setting("tile size", "8, 16, 32, 64 or 128 pixels".into(), t.to_string());
        }
        if self.clusters.number >= self.clusters.of {
            let range = format!("below {}", self.clusters.of);
            return setting("part of the clusters", range, self.clusters.number.to_string());
        }
        let tiles = self.tiles_of(self.tile_edge());
        if let Some(made_for) = self.tiles.tiles().filter(|&of| of != tiles || self.tile_size.is_none()) {
            let range = format!("made for the {tiles} tiles of a size that is asked for");
            return setting("set of tiles", range, format!("made for {made_for}"));
        }
        if let Some(level) = self.simd.filter(|l| l.level().is_none()) {
            let names: Vec<_> = SimdLevel::available().iter().map(|l| l.name()).collect();
            let range = format!("a level of this processor ({})", names.join(", "));
            return setting("SIMD level", range, level.to_string());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_get_smaller_with_the_picture_and_with_more_threads() {
        let edge = |width, height, threads| Settings::new(width, height).tile_edge_for(threads);
        assert_eq!([64, 256, 512, 1024].map(|size| edge(size, size, 2)), [16, 32, 64, 128]);
        // 64, 256, 1024 and 4096 tiles.
        assert_eq!([8, 9, 128, 1000].map(|threads| edge(1024, 1024, threads)), [128, 64, 32, 16]);
        assert_eq!(edge(16384, 16384, 1000), 128);
        assert_eq!(edge(1, 1, 1000), 16);
        let asked = Settings { tile_size: Some(64), ..Settings::new(64, 64) };
        assert_eq!(asked.tile_edge_for(1000), 64);
    }
}
