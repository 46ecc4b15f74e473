//! Drawings of lines: what of a model becomes an SVG or PDF.

use std::borrow::Cow;
use std::sync::{Arc, Once};
use std::time::Instant;

use anyhow::Result;
use tercio::data::StrokeData;
use tercio::mesh::AttributeDomain;
use tercio::mesh::edges::{EdgeKind, Edges};
use tercio::mesh::strokes::Strokes;
use tercio::raster::{Frame, Sampling};
use tercio::scene::color_map::Isolines;
use tercio::scene::{Background, Camera, DataColors, Instance, Scene, SurfaceData};
use tercio::strokes::{EdgePart, Eye, Length, Pen};
use tercio::vector::{Hiders, Page, Sketch, areas};

use super::members::OfModel;
use super::strokes::Drawable;
use super::{Drawn, Loaded, Render};
use crate::messages;
use crate::output::{Plan, UsageError};
use crate::report::grouped;

/// Bands of contours, if nothing else is said.
const BANDS: u32 = 10;
/// Width of contours in pixels.
const WIDTH: f32 = 1.5;

impl Render {
    /// Options that do not go together with drawings of lines, or with contours.
    ///
    /// # Errors
    /// One sentence.
    pub(super) fn check_vector(&self, plan: &Plan) -> Result<(), String> {
        for Self { strokes, data, .. } in self.members() {
            if strokes.is_contours() && !data.is_given() {
                return Err("--mode contours shows data: name them with --color-by".into());
            }
            data.check_isolines(strokes.is_contours())?;
        }
        let Some((_, format)) = &plan.drawing else { return Ok(()) };
        let name = format.name().to_uppercase();
        if self.members().any(|member| member.strokes.has_bodies()) {
            return Err(format!(
                "{name} holds lines: --glyphs and --line-shape tube draw bodies; choose .png, .ppm or .webp"
            ));
        }
        if !plan.arrays.is_empty() {
            return Err(format!(
                "--output-depth, --output-ids and --output-normals do not go together with {name}"
            ));
        }
        if self.effects.are_given() {
            return Err(format!("--exposure, --tone, --ao and --edl have no effect on the lines of {name}"));
        }
        if self.annotation.is_behind() && self.members().any(|member| member.strokes.has_surface()) {
            return Err(format!(
                "--bounds and --grid are drawn behind surfaces, which {name} does not have: leave them out, or give --mode wireframe or edges"
            ));
        }
        Ok(())
    }

    /// Refuses a surface that is shaded, or drawn as points, in a drawing of lines. Whether a model has one is known when it is read:
    /// one that has only lines is drawn in every mode.
    ///
    /// # Errors
    /// [`UsageError`], which names the model.
    pub(super) fn check_surface(&self, plan: &Plan, has_surface: bool) -> Result<(), UsageError> {
        match &plan.drawing {
            Some((_, format)) if has_surface && !self.strokes.has_lines() => {
                let (model, name) = (self.model.name(), format.name().to_uppercase());
                Err(UsageError(format!(
                    "{model}: {name} holds lines, not surfaces: give it --mode hidden-line, wireframe, edges or contours, or choose .png, .ppm or .webp"
                )))
            }
            _ => Ok(()),
        }
    }

    /// Says, once in a run, that samples are asked for where there are none. Not an error: a scene file or a configuration may be for
    /// pictures, too.
    pub(super) fn warn_of_samples(&self, plan: &Plan) {
        static SAID: Once = Once::new();
        let Some((_, format)) = plan.drawing.as_ref().filter(|_| !self.running.quiet) else { return };
        if self.sampling.sampling() != Sampling::default() {
            let name = format.name().to_uppercase();
            SAID.call_once(|| {
                messages::warning(&format!(
                    "--aa, --aa-shading and --aa-filter have no effect on {name}, which has no pixels"
                ));
            });
        }
    }

    /// Says, once in a run, that a drawing of contours has no areas.
    fn warn_of_areas(format: &str) {
        static SAID: Once = Once::new();
        SAID.call_once(|| {
            messages::warning(&format!(
                "{format} holds lines: --mode contours leaves out the bands between them, and draws each line in the colour of its \
                 value (--isoline-color gives them one, --edges=silhouette an outline; .png has the bands)"
            ));
        });
    }

    /// Says so if contours are drawn.
    pub(super) fn warn_of_bands(&self, plan: &Plan) {
        let Some((_, format)) = plan.drawing.as_ref().filter(|_| !self.running.quiet) else { return };
        if self.members().any(|member| member.strokes.is_contours()) {
            Self::warn_of_areas(&format.name().to_uppercase());
        }
    }

    /// Gives a dressed instance the look of contours: no light, bands of one colour, and lines between them.
    /// SVG and PDF have only the lines (`is_drawing`).
    pub(super) fn dress_contours(&self, instance: &mut Instance, is_drawing: bool) {
        if !self.strokes.is_contours() {
            return;
        }
        instance.surface.unlit = true;
        let domain = instance.data.as_ref().map(|data| data.domain(instance.mesh.layout()));
        let Some(data) = &mut instance.data else { return };
        let SurfaceData::Mapped { colors, .. } = Arc::make_mut(data) else { return };
        if !colors.categories.is_empty() {
            return;
        }
        let colors = Arc::make_mut(colors);
        let between = |colors: &DataColors, bands: u32| -> Vec<f64> {
            (1..bands).map(|i| colors.value_at(f64::from(i) / f64::from(bands))).collect()
        };
        // Lines that are spread evenly are the limits of bands.
        if let Some(lines) = &colors.isolines {
            let bands = lines.values.len() as u32 + 1;
            if colors.bands.is_none() && lines.values == between(colors, bands) {
                colors.bands = Some(bands);
            } else if !is_drawing {
                colors.levels.clone_from(&lines.values);
            }
            return;
        }
        let bands = colors.steps().unwrap_or(BANDS);
        if colors.steps().is_none() {
            colors.bands = Some(bands);
        }
        let values = between(colors, bands);
        if domain == Some(AttributeDomain::Vertex) && !values.is_empty() {
            let color = self.data.isoline_color().unwrap_or([0, 0, 0, 255]);
            let width = self.data.isoline_width().map_or(WIDTH, |width| width as f32);
            colors.isolines = Some(Isolines { values, color, width });
        }
    }

    /// The drawing of one camera.
    pub(super) fn draw_page(&self, loaded: &Loaded, camera: &Camera, mut frame: Frame) -> Result<Drawn> {
        let begin = Instant::now();
        let Loaded { scene, models, .. } = loaded;
        let eye = Eye::new(self.view(loaded, camera)?);
        let all = || self.members().zip(models);
        let instances = |of_model: &OfModel| scene.instances[of_model.instances.clone()].iter();
        let surfaces = all().filter(|(member, _)| member.strokes.has_surface());
        let surfaces = Scene {
            instances: surfaces.flat_map(|(_, of_model)| instances(of_model)).cloned().collect(),
            ..Scene::default()
        };
        let hiders = if surfaces.instances.is_empty() {
            None
        } else {
            let taken = models.iter().filter(|of_model| of_model.shares_with.is_none());
            let taken = taken.map(|of_model| of_model.report.mesh.bytes).sum();
            self.check_memory(Hiders::needed_bytes(&surfaces), taken)?;
            let widths: Vec<Length> = self.members().flat_map(Self::widths).collect();
            Some(Hiders::of_scene(&eye, &surfaces, Sketch::margin(&eye, &widths)))
        };
        let mut sketch = Sketch::new(&eye, hiders.as_ref());
        for (member, of_model) in all() {
            member.add_lines(&mut sketch, of_model, instances(of_model));
        }
        let mut page = sketch.page(Some(paper(&loaded.background)));
        let annotation = self.lay_out(&loaded.annotated, camera)?;
        page.shapes.splice(0..0, areas(&annotation.behind));
        page.shapes.extend(areas(&annotation.onto));
        frame = Frame { planes: Default::default(), stats: Default::default(), ..frame };
        frame.stats.threads = rayon::current_num_threads();
        frame.stats.milliseconds.total = begin.elapsed().as_secs_f64() * 1e3;
        Ok(Drawn { frame, page: Some(page), parallel: None, effect_milliseconds: 0.0 })
    }

    /// The widths of all lines and points of a model.
    fn widths(&self) -> [Length; 3] {
        let pens = self.strokes.pens(self.drawing.color(), false);
        [self.strokes.edge_pen().width, pens.lines.width, pens.points.width]
    }

    /// Adds the contours, the edges, and the lines and points of the file of this model, which has these instances.
    fn add_lines<'a>(
        &self,
        sketch: &mut Sketch,
        of_model: &OfModel,
        instances: impl Iterator<Item = &'a Instance>,
    ) {
        if self.strokes.is_contours() {
            instances.for_each(|instance| self.add_contours(sketch, instance));
        }
        let Drawable { data, edges, .. } = &of_model.drawable;
        for (copy, place) in of_model.places.iter().enumerate() {
            let opacity = self.opacity_of(copy);
            let pens = self.strokes.pens(self.color_of(copy), false);
            let file = &*faded(in_colors_of(data.as_ref(), self.file_of(copy, &of_model.drawable)), opacity);
            let [lines, points] =
                [pens.lines, pens.points].map(|pen| Pen { color: fade(pen.color, opacity), ..pen });
            let mut edge_pen = self.strokes.edge_pen();
            if !self.strokes.has_surface() {
                edge_pen.color = fade(edge_pen.color, opacity);
            }
            for (edges, part) in edges {
                sketch.edges(edges, place, &edge_pen, *part != EdgePart::All);
            }
            sketch.lines(file, place, &lines);
            sketch.points(file, place, self.strokes.shape(), &points);
        }
    }

    /// Lines of equal value, each in the colour that it has in the map.
    fn add_contours(&self, sketch: &mut Sketch, instance: &Instance) {
        let Some(SurfaceData::Mapped { colors, .. }) = instance.data.as_deref() else { return };
        let Some(lines) = &colors.isolines else { return };
        let mut values = lines.values.clone();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let smooth = DataColors { bands: None, ..(**colors).clone() };
        let color = |value: f64| self.data.isoline_color().unwrap_or_else(|| smooth.color(value));
        let values: Vec<_> = values.into_iter().map(|value| (value, color(value))).collect();
        sketch.contours(instance, &values, Length::Pixels(f64::from(lines.width)));
    }

    /// Says how many edges of each kind there are, of those that are drawn.
    pub(super) fn report_edges(&self, edges: &[(Edges, EdgePart)]) {
        if !self.running.verbose {
            return;
        }
        for (edges, part) in edges {
            // Those of more than two triangles are listed once for every two.
            let several = edges.list.iter().filter(|e| e.kind == EdgeKind::NonManifold).map(|e| e.ends);
            let mut ends: Vec<_> = several.collect();
            ends.iter_mut().for_each(|ends| ends.sort_unstable());
            ends.sort_unstable();
            ends.dedup();
            messages::note(&format!(
                "edges: {} of two triangles, {} of one (boundary), {} of more (non-manifold){}",
                grouped(edges.count(EdgeKind::Inner) as u64),
                grouped(edges.count(EdgeKind::Boundary) as u64),
                grouped(ends.len() as u64),
                if *part == EdgePart::Silhouette {
                    "; of those of two, the ones on the silhouette are drawn"
                } else {
                    ""
                },
            ));
        }
    }
}

/// Lines and points in the colours of data.
fn in_colors_of<'a>(data: Option<&StrokeData>, file: &'a Strokes) -> Cow<'a, Strokes> {
    let colors = match data {
        None => return Cow::Borrowed(file),
        Some(StrokeData::Direct(colors)) => colors.iter().copied().map(Some).collect(),
        Some(StrokeData::Mapped { values, colors }) => {
            values.iter().map(|&value| Some(colors.color(colors.full(value)))).collect()
        }
    };
    Cow::Owned(Strokes { colors: Some(colors), ..file.clone() })
}

/// Lines and points whose colours have this opacity in addition.
fn faded(mut file: Cow<Strokes>, opacity: f32) -> Cow<Strokes> {
    if opacity < 1.0
        && file.colors.is_some()
        && let Some(colors) = &mut file.to_mut().colors
    {
        colors.iter_mut().flatten().for_each(|color| *color = fade(*color, opacity));
    }
    file
}

fn fade([r, g, b, a]: [u8; 4], opacity: f32) -> [u8; 4] {
    [r, g, b, (f32::from(a) * opacity).round() as u8]
}

/// The colour of the page: white, unless another one is asked for.
fn paper(background: &Background) -> [u8; 4] {
    let color = if *background == Background::default() { [1.0; 4] } else { background.middle() };
    color.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Why a drawing has no line.
pub(super) fn page_reason(page: &Page) -> Option<String> {
    (page.line_count() == 0)
        .then(|| "nothing was drawn: no line is visible in the picture, or there are none".into())
}
