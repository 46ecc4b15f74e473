//! Drawings of lines as vectors: SVG and PDF, without what surfaces hide.
//!
//! A [`Sketch`] collects edges, contours, lines and points that one camera sees. With [`Hiders`], the triangles of a scene, it
//! keeps only what they do not hide: visibility is computed in `f64` from the triangles themselves, not from a picture, so a line
//! ends exactly where a surface begins to hide it, or where it goes into one, at any size of the page. Then pieces that meet are
//! joined, and [`Page::write`] writes the file.
//!
//! ```
//! use tercio::mesh::edges::{Edges, Selection};
//! use tercio::raster::view::View;
//! use tercio::strokes::{Eye, Length, Pen};
//! use tercio::vector::{Hiders, Sketch, VectorFormat};
//!
//! let scene = tercio::Scene::from_mesh(tercio::load("builtin:teapot@1k")?.mesh);
//! let camera = tercio::Settings::new(320, 240).framing().camera_for_scene(&scene);
//! let eye = Eye::new(View::new(&camera, &scene.bounds(), 320, 240).expect("a camera"));
//! let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
//! let mut sketch = Sketch::new(&eye, Some(&hiders));
//! let model = &scene.instances[0];
//! let edges = Edges::of_clusters(&model.mesh, Selection::Silhouette);
//! let pen = Pen { width: Length::Pixels(1.5), color: [0, 0, 0, 255] };
//! sketch.edges(&edges, &model.world_from_object, &pen, true);
//! let page = sketch.page(Some([255; 4]));
//! let mut svg = Vec::new();
//! page.write(VectorFormat::Svg, &mut svg)?;
//! # assert!(page.line_count() > 0 && svg.starts_with(b"<?xml"));
//! # Ok::<(), tercio::Error>(())
//! ```
//!
//! What is exact: positions in the model are `f32`, so surfaces that touch (an edge that lies on another face, a line of the file
//! on the surface) do so up to 1.2e-7 of the model's size, and what is not farther than that behind a triangle is not hidden by it.
//! Where a line is hidden on both sides of a gap of less than 1/128 pixel, that gap is a crack in the surface, and closed.
//! Everything else is computed with the precision of `f64`. Every surface hides, also one that is not opaque. The result is the same for any number of threads.

mod annotation;
mod chain;
mod contours;
mod grid;
mod hiders;
mod page;
mod pdf;
mod sketch;
mod svg;
#[cfg(test)]
mod tests;
mod text;

use std::io::{self, Write};
use std::path::Path;
use std::str::FromStr;

pub use annotation::areas;
pub use hiders::Hiders;
pub use page::{Cap, Page, Shape, Style};
pub use sketch::Sketch;
pub use text::{Anchor, Text, text_width};

/// The format of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VectorFormat {
    /// SVG, 1.1; coordinates are pixels, with four decimals.
    Svg,
    /// PDF, one page; 96 pixels are an inch.
    Pdf,
}

impl VectorFormat {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Svg, Self::Pdf];

    /// Its name, which is its extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Pdf => "pdf",
        }
    }

    /// The format of a file name, by its extension in any case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        path.as_ref().extension()?.to_str()?.to_ascii_lowercase().parse().ok()
    }
}

impl FromStr for VectorFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = Self::ALL.into_iter().find(|format| format.name() == text);
        all.ok_or_else(|| format!("expected svg or pdf, found \"{text}\""))
    }
}

impl Page {
    /// Writes the drawing.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, format: VectorFormat, out: &mut dyn Write) -> io::Result<()> {
        match format {
            VectorFormat::Svg => svg::write(self, out),
            VectorFormat::Pdf => pdf::write(self, out),
        }
    }

    /// The drawing as a file in memory.
    pub fn to_bytes(&self, format: VectorFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing into memory cannot fail.
        let written = self.write(format, &mut bytes);
        debug_assert!(written.is_ok(), "{written:?}");
        bytes
    }
}
