//! The costs of a ring machine, and the parameters of its algorithm (document 000, tables 4.2, 4.3 and A.1).

use serde::Serialize;

use super::compositing;
use crate::machines::{self, DataKind, MachineError, Operation};

/// A ring of processors. Costs are in instructions; the machine is SIMD, so they are also cycles of its clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// n: processors.
    pub processors: u32,
    /// G_i: transforming a polygon and keeping or rejecting it.
    pub examine_polygon: u64,
    /// G_f: lighting a polygon and computing its linear equations.
    pub finish_polygon: u64,
    /// a: the words of a polygon descriptor.
    pub descriptor_words: u64,
    /// b: overhead of a pass of descriptors, besides moving the words.
    pub pass_overhead: u64,
    /// R: rasterizing a pixel.
    pub raster_pixel: u64,
    /// a of sort-last: the words of a pixel, colour and depth.
    pub pixel_words: u64,
    /// b of sort-last: overhead of a pass of pixels, besides moving the words.
    pub pixel_overhead: u64,
}

impl Machine {
    /// The Princeton Engine of document 000: tables 4.2 (sort-middle; dense sort-last), 4.3 and A.1.
    pub fn princeton_engine() -> Self {
        Self {
            processors: 1024,
            examine_polygon: 1000,
            finish_polygon: 5000,
            descriptor_words: 42,
            pass_overhead: 30,
            raster_pixel: 100,
            pixel_words: 3,
            pixel_overhead: 15,
        }
    }

    /// The ring of a description. A word is what a link carries in a cycle.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without clock, network or the sizes of descriptors and samples.
    pub fn of(machine: &machines::Machine) -> Result<Self, MachineError> {
        let clock = machine.clock()?;
        let network = machine.need(machine.network.as_ref(), "network")?;
        let word = network.bandwidth.value / clock;
        let cycles = |seconds: f64| (seconds * clock).round() as u64;
        let words = |kind: DataKind| {
            let bytes = machine.need(machine.bytes.get(&kind), &format!("bytes.{}", kind.name()))?;
            Ok::<_, MachineError>((bytes.value / word).ceil() as u64)
        };
        let cost = |operation| cycles(machine.seconds_or_0(operation));
        Ok(Self {
            processors: machine.processors.count.whole() as u32,
            examine_polygon: cost(Operation::Polygon),
            finish_polygon: cost(Operation::PolygonSetUp),
            descriptor_words: words(DataKind::Descriptor)?,
            pass_overhead: cycles(network.message.value),
            raster_pixel: cost(Operation::Pixel),
            pixel_words: words(DataKind::Sample)?,
            pixel_overhead: cost(Operation::CompositePixel),
        })
    }

    /// Instructions of one pass of descriptors over `stride` processors: (2 + d) a + b (section 5.3).
    pub fn pass(&self, stride: u32) -> u64 {
        (2 + u64::from(stride)) * self.descriptor_words + self.pass_overhead
    }

    /// Instructions of one pass of pixels over `stride` processors: (2 + d) a + b (section 6.4).
    pub fn pixel_pass(&self, stride: u32) -> u64 {
        (2 + u64::from(stride)) * self.pixel_words + self.pixel_overhead
    }
}

/// The parameters of the algorithm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Algorithm {
    /// m: how many processors hold each polygon (section 5.4). It divides n.
    pub duplication: u32,
    /// t: passes between two checks for descriptors that all processors have seen. 1 is the dense network, n the sparse
    /// one (section 5.2).
    pub test_period: u32,
    /// d[]: the stride of each stage, decreasing, the last one 1 (section 5.3).
    pub strides: Vec<u32>,
    /// g: number of neighbouring processors that hold one copy of the screen (chapter 6). It divides n; g = n is plain
    /// sort-middle, smaller values are sort-twice.
    pub group: u32,
}

/// Why an algorithm does not fit a machine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AlgorithmError {
    /// No processor.
    #[error("expected at least 1 processor, found 0")]
    NoProcessor,
    /// More processors than the simulator's 32-bit numbers allow.
    #[error("expected at most {MAX_PROCESSORS} processors, found {0}")]
    TooManyProcessors(u32),
    /// m is 0 or does not divide n.
    #[error("expected a duplication that divides the {processors} processors, found {found}")]
    Duplication {
        /// n.
        processors: u32,
        /// m.
        found: u32,
    },
    /// g is 0 or does not divide n.
    #[error("expected a group that divides the {processors} processors, found {found}")]
    Group {
        /// n.
        processors: u32,
        /// g.
        found: u32,
    },
    /// t is 0.
    #[error("expected a test period of at least 1 pass, found 0")]
    TestPeriod,
    /// The strides do not decrease to 1, or one is longer than the ring.
    #[error("expected strides that fall from at most {limit} to 1, found {found:?}")]
    Strides {
        /// The largest useful stride.
        limit: u32,
        /// d[].
        found: Vec<u32>,
    },
    /// The screen map gives pixels to processors that the group does not have.
    #[error("expected a screen map of at most {group} processors, found one of {found}")]
    ScreenMap {
        /// g.
        group: u32,
        /// Processors of the map.
        found: u32,
    },
}

/// Maximum number of processors of a ring.
const MAX_PROCESSORS: u32 = 1 << 24;

impl Algorithm {
    /// The defaults of table A.1: no duplication, a dense network, one stage of neighbour passes, one group.
    pub fn sort_middle(machine: &Machine) -> Self {
        Self { duplication: 1, test_period: 1, strides: vec![1], group: machine.processors }
    }

    /// Checks that the algorithm can run on a machine whose screen is divided by a map of this many processors.
    ///
    /// # Errors
    /// [`AlgorithmError`].
    pub fn check(&self, machine: &Machine, map_processors: u32) -> Result<(), AlgorithmError> {
        let n = machine.processors;
        let divides = |part: u32| part > 0 && n.is_multiple_of(part);
        let falling = self.strides.windows(2).all(|w| w[0] > w[1]);
        let limit = n.max(2) - 1;
        let fit = self.strides.first().is_some_and(|&d| d <= limit) && self.strides.last() == Some(&1);
        match () {
            () if n == 0 => Err(AlgorithmError::NoProcessor),
            () if n > MAX_PROCESSORS => Err(AlgorithmError::TooManyProcessors(n)),
            () if !divides(self.duplication) => {
                Err(AlgorithmError::Duplication { processors: n, found: self.duplication })
            }
            () if !divides(self.group) => Err(AlgorithmError::Group { processors: n, found: self.group }),
            () if self.test_period == 0 => Err(AlgorithmError::TestPeriod),
            () if !(falling && fit) => Err(AlgorithmError::Strides { limit, found: self.strides.clone() }),
            () if map_processors > self.group => {
                Err(AlgorithmError::ScreenMap { group: self.group, found: map_processors })
            }
            () => Ok(()),
        }
    }

    /// Passes of pixels that composite the groups' pictures; none for one group.
    pub fn composite_passes(&self, machine: &Machine, pixels: u64) -> u64 {
        compositing::passes(machine.processors, self.group, pixels)
    }
}
