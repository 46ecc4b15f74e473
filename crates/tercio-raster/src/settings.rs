//! The settings of the renderer. Size, culling, shading and sampling change the picture; parts, bands and planes determine
//! what of it a frame holds; everything else may change only how fast it is drawn.

use std::ops::Range;
use std::sync::Arc;

use tercio_scene::{Framing, Surface};

use crate::cluster_set::ClusterSet;
use crate::error::RenderError;
use crate::frame::Outputs;
use crate::sampling::Sampling;
use crate::screen::TileSet;
use crate::shadow_map::ShadowMaps;
pub use crate::simd::SimdLevel;
use crate::tone::Tone;

/// The largest width and height of a picture, in pixels.
pub const MAX_SIZE: u32 = 65536;

/// How triangles are sorted into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Binning {
    /// Into every tile that the bounding box touches.
    BoundingBox,
    /// Only into tiles in which the triangle can cover a sample.
    #[default]
    Exact,
}

/// What is sorted into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Sorting {
    /// Clusters that are small on the screen as a whole; the triangles of the other clusters one by one.
    #[default]
    Clusters,
    /// All triangles, one by one.
    Triangles,
}

/// The last stage of a frame that is executed. For measurements: only with [`LastStage::Output`] is there a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
#[non_exhaustive]
pub enum LastStage {
    /// Clusters are culled; the remaining ones are discarded.
    Cull,
    /// Clusters and triangles are sorted into tiles, then discarded.
    Bin,
    /// The triangles that reach a sample are found in each tile, then discarded.
    Sieve,
    /// Visibility is resolved at each sample, then discarded.
    Visibility,
    /// All stages are executed.
    #[default]
    Output,
}

/// Face culling: which triangles are not drawn because of the side that they show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Cull {
    /// Surfaces are two-sided; hidden back faces are skipped where that provably leaves the picture the same.
    #[default]
    Auto,
    /// Surfaces are two-sided; no face is culled.
    None,
    /// Triangles that show their back are not drawn.
    Back,
    /// Triangles that show their front are not drawn.
    Front,
}

impl Cull {
    /// Which winding on the screen is culled: `Some(true)` the clockwise one, `Some(false)` the counter-clockwise one,
    /// `None` neither. The front faces of a mirrored instance appear clockwise.
    pub(crate) fn drops_clockwise(self, mirrored: bool) -> Option<bool> {
        match self {
            Self::Auto | Self::None => None,
            Self::Back => Some(!mirrored),
            Self::Front => Some(mirrored),
        }
    }

    /// From the lanes of clockwise and of counter-clockwise triangles: the lanes to draw, the lanes to cull.
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
    /// At every pixel, with the normal of the triangle's plane: facets are visible.
    Flat,
    /// At the vertices; the light is interpolated. Surfaces with scene-wide materials are shaded at every pixel.
    Gouraud,
    /// At every pixel, with the interpolated normal.
    #[default]
    Phong,
    /// Not at all: unlit colours.
    Unlit,
    /// At every pixel, with the interpolated normal, from roughness and metallicity.
    Physical,
}

impl Shading {
    /// How a surface is shaded in a picture with this shading.
    #[inline(always)]
    pub fn of(self, surface: &Surface) -> Self {
        if surface.unlit { Self::Unlit } else { self }
    }
}

/// How textures are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum TextureFilter {
    /// The nearest texel: with fewer pixels than texels, texels are skipped.
    Nearest,
    /// Interpolated between four texels; likewise.
    Bilinear,
    /// Interpolated, also between mipmaps: blurred where a surface is seen at a grazing angle.
    Trilinear,
    /// The same at up to [`MAX_ANISOTROPY`](crate::conventions::MAX_ANISOTROPY) points along the ellipse that a pixel covers.
    #[default]
    Anisotropic,
}

/// One of `of` equal shares of clusters or entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Number of the share, below `of`.
    pub number: u32,
    /// Number of shares, at least 1.
    pub of: u32,
}

impl Part {
    /// The only share of one: everything.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// The share of `count` items as a range of consecutive items; the sizes of the shares differ by one at most.
    pub fn range(self, count: u32) -> Range<u32> {
        let begin = |number: u32| (u64::from(count) * u64::from(number) / u64::from(self.of)) as u32;
        begin(self.number)..begin(self.number + 1)
    }

    /// The share of some items as every `of`-th item, from item `number` on.
    pub(crate) fn every<T>(self, items: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
        items.skip(self.number as usize).step_by(self.of as usize)
    }
}

impl Default for Part {
    fn default() -> Self {
        Self::WHOLE
    }
}

/// The settings of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width in pixels, 1 to [`MAX_SIZE`].
    pub width: u32,
    /// Height in pixels, 1 to [`MAX_SIZE`].
    pub height: u32,
    /// Face culling.
    pub cull: Cull,
    /// Where and how light is computed.
    pub shading: Shading,
    /// The samples of a pixel.
    pub sampling: Sampling,
    /// How textures are sampled.
    pub texture_filter: TextureFilter,
    /// The shadows of the scene's lights, made by [`ShadowMaps::draw`] for the same scene; for the same camera, if a light
    /// moves with it; and for the same camera and picture, if they have only what it shows ([`ShadowArea`](crate::ShadowArea)). With shadows, surfaces are shaded at every pixel as with [`Shading::Phong`] also where
    /// [`Shading::Gouraud`] is requested.
    pub shadows: Option<Arc<ShadowMaps>>,
    /// Exposure and tone mapping.
    pub tone: Tone,
    /// The rows of pixels that the frame holds; `None` for all. Whole rows of tiles, except at the lower border of the
    /// picture, which requires that [`Settings::tile_size`] is given. For pictures that are larger than memory: bands
    /// below each other are the picture.
    pub band: Option<Range<u32>>,
    /// Keeps the samples: the frame then has as many columns for each pixel as the pixel has samples. For programs that
    /// filter them themselves, and for tests.
    pub unresolved: bool,
    /// Keeps the fragments of the tiles ([`Frame::fragments`](crate::Frame::fragments)), and has no planes, unless other ranks are known
    /// ([`FrameContext::nearest_of_others`](crate::context::FrameContext::nearest_of_others)). For pictures
    /// that are made from the fragments of several ranks, by [`Renderer::merge`](crate::Renderer::merge).
    pub keep_fragments: bool,
    /// The planes of the frame to draw.
    pub outputs: Outputs,
    /// Pixels along the edge of a tile: 8, 16, 32, 64 or 128; `None` lets the renderer choose.
    pub tile_size: Option<u32>,
    /// What is sorted into tiles.
    pub sorting: Sorting,
    /// How triangles are sorted into tiles.
    pub binning: Binning,
    /// Whether whole clusters are tested before their triangles.
    pub cluster_culling: bool,
    /// Which clusters are drawn. Any set but [`ClusterSet::ALL`] draws an incomplete picture, to be composed with the others.
    pub clusters: ClusterSet,
    /// Which tiles are drawn. The pixels of the others keep their values in the frame. Any set but [`TileSet::ALL`]
    /// requires that [`Settings::tile_size`] is given, and must be made for the resulting number of tiles.
    pub tiles: TileSet,
    /// The last stage that is executed; with anything but [`LastStage::Output`] there is no picture.
    pub last_stage: LastStage,
    /// Memory for layers that may not be opaque, in bytes, of all threads together. With less, tiles of many layers are
    /// drawn in more slices of depth.
    pub layer_memory: usize,
    /// The SIMD level; `None` selects the best one of this processor.
    pub simd: Option<SimdLevel>,
}

/// Edge in pixels of the smallest tile that the renderer chooses by itself.
const SMALLEST_TILE: u32 = 16;
/// Number of tiles per thread that the automatic tile size aims at.
const TILES_PER_THREAD: usize = 8;

/// Default memory for layers, in bytes.
const LAYER_MEMORY: usize = 128 << 20;

impl Settings {
    /// Default settings for a picture of this size: 4 samples per pixel.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            cull: Cull::default(),
            shading: Shading::default(),
            sampling: Sampling::default(),
            texture_filter: TextureFilter::default(),
            shadows: None,
            tone: Tone::NONE,
            band: None,
            unresolved: false,
            keep_fragments: false,
            outputs: Outputs::default(),
            tile_size: None,
            sorting: Sorting::default(),
            binning: Binning::default(),
            cluster_culling: true,
            clusters: ClusterSet::ALL,
            tiles: TileSet::ALL,
            last_stage: LastStage::default(),
            layer_memory: LAYER_MEMORY,
            simd: None,
        }
    }

    /// [`Settings::new`] with one sample per pixel, at its centre: without anti-aliasing, for measurements, and for depths
    /// and ids at the centres of pixels.
    pub fn one_sample(width: u32, height: u32) -> Self {
        Self { sampling: Sampling::NONE, ..Self::new(width, height) }
    }

    /// The default framing for a picture of this size, to make a camera without giving the size again.
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

    /// Columns of a frame for each pixel: one, or one for each sample if the samples are kept.
    pub fn elements_per_pixel(&self) -> u32 {
        if self.unresolved { self.sampling.pattern.count() as u32 } else { 1 }
    }

    /// Pixels along the edge of a tile: as requested, or by the size of the picture. Small tiles distribute the work of
    /// small pictures better; with large tiles, clusters overlap fewer of them. The more samples a pixel has, the fewer
    /// pixels of a tile fit into the cache.
    pub fn tile_edge(&self) -> u32 {
        let largest = match self.sampling.pattern.count() {
            1 => 128,
            2..=4 => 64,
            _ => 32,
        };
        self.tile_size.unwrap_or(match u64::from(self.width) * u64::from(self.height) {
            0..=0x4000 => SMALLEST_TILE,
            0x4001..=0x1_0000 => 32,
            0x1_0001..=0x8_0000 => largest.min(64),
            _ => largest,
        })
    }

    /// The same for a number of threads: tiles are small enough that each thread draws several of them, which balances
    /// the load.
    pub fn tile_edge_for(&self, threads: usize) -> u32 {
        let mut edge = self.tile_edge();
        while self.tile_size.is_none()
            && edge > SMALLEST_TILE
            && self.tiles_of(edge) < TILES_PER_THREAD * threads
        {
            edge /= 2;
        }
        edge
    }

    /// The rows of pixels that the frame holds.
    pub fn rows(&self) -> Range<u32> {
        self.band.clone().unwrap_or(0..self.height)
    }

    /// Number of tiles of the frame if they have this many pixels along an edge.
    pub fn tiles_of(&self, edge: u32) -> usize {
        let rows = self.rows();
        self.width.div_ceil(edge) as usize * (rows.end.div_ceil(edge) - rows.start / edge) as usize
    }

    /// Checks that the settings are valid on this processor.
    ///
    /// # Errors
    /// [`RenderError::Setting`] names the first setting that is not.
    pub fn check(&self) -> Result<(), RenderError> {
        let setting = |what, range: String, value: String| Err(RenderError::Setting { what, range, value });
        for (what, value) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_SIZE).contains(&value) {
                return setting(what, format!("1 to {MAX_SIZE} pixels"), value.to_string());
            }
        }
        self.tone.check()?;
        if let Some(t) = self.tile_size.filter(|t| ![8, 16, 32, 64, 128].contains(t)) {
            return setting("tile size", "8, 16, 32, 64 or 128 pixels".into(), t.to_string());
        }
        if let Some(band) = &self.band {
            let edge = self.tile_edge();
            let is_whole = |row: u32| row.is_multiple_of(edge) || row == self.height;
            let is_valid = band.start < band.end && band.end <= self.height;
            if !is_valid || !is_whole(band.start) || !is_whole(band.end) || self.tile_size.is_none() {
                let range = format!("whole rows of tiles of an explicit tile size, below {}", self.height);
                return setting("band", range, format!("{band:?}"));
            }
            if self.unresolved {
                let range = "`None` where samples are kept".to_string();
                return setting("band", range, format!("{band:?}"));
            }
        }
        if self.keep_fragments && self.unresolved {
            let range = "`false` where samples are kept".to_string();
            return setting("keeping fragments", range, "true".into());
        }
        let tiles = self.tiles_of(self.tile_edge());
        if let Some(made_for) = self.tiles.tiles().filter(|&of| of != tiles || self.tile_size.is_none()) {
            let range = format!("made for the {tiles} tiles of an explicit tile size");
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
    use crate::sampling::SamplePattern;

    #[test]
    fn tiles_get_smaller_with_the_picture_and_with_more_threads() {
        let edge = |width, height, threads| Settings::one_sample(width, height).tile_edge_for(threads);
        assert_eq!([64, 256, 512, 1024].map(|size| edge(size, size, 2)), [16, 32, 64, 128]);
        // 64, 256, 1024 and 4096 tiles.
        assert_eq!([8, 9, 128, 1000].map(|threads| edge(1024, 1024, threads)), [128, 64, 32, 16]);
        assert_eq!(edge(16384, 16384, 1000), 128);
        let with = |pattern| Settings { sampling: Sampling::of(pattern), ..Settings::new(1024, 1024) };
        let patterns = [SamplePattern::Center, SamplePattern::Sparse4, SamplePattern::Sparse16];
        assert_eq!(patterns.map(|pattern| with(pattern).tile_edge()), [128, 64, 32]);
        assert_eq!(edge(1, 1, 1000), 16);
        let requested = Settings { tile_size: Some(64), ..Settings::new(64, 64) };
        assert_eq!(requested.tile_edge_for(1000), 64);
    }
}
