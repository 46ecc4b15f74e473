//! Lines, edges and points of the models, for one camera.

use std::borrow::Cow;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use tercio::LoadReport;
use tercio::data::{StrokeData, of_edges_at};
use tercio::glam::DAffine3;
use tercio::glyphs::{self, Glyphs};
use tercio::mesh::AttributeDomain;
use tercio::mesh::edges::Edges;
use tercio::mesh::strokes::Strokes;
use tercio::raster::Cull;
use tercio::raster::view::View;
use tercio::scene::framing::Extent;
use tercio::scene::{Camera, DataSource, Instance, Scene, SurfaceData};
use tercio::strokes::{self, EdgePart, Eye, LineShape};

use super::members::{OfModel, Placement};
use super::subject::{grown, placed};
use super::{Loaded, Render};
use crate::messages;

/// What is drawn of a model besides the surface.
pub(super) struct Drawable {
    /// Lines and points of the file.
    pub file: Arc<Strokes>,
    /// The same without colours of their own, if a copy of the model is drawn so.
    pub plain: Option<Arc<Strokes>>,
    /// What their colours show.
    pub data: Option<StrokeData>,
    /// Edges, and what of them is drawn.
    pub edges: Vec<(Edges, EdgePart)>,
    /// What the colours of each of these edges show, if anything: at the first place of the model, or at each.
    pub edge_data: Vec<Vec<StrokeData>>,
    /// Glyphs in world space, of each place.
    pub glyphs: Vec<Glyphs>,
}

impl Drawable {
    /// Lines and points of a file, until edges and glyphs are found.
    pub fn of_file(file: Arc<Strokes>, data: Option<StrokeData>, copies: &[Placement]) -> Self {
        let is_plain = file.colors.is_some() && copies.iter().any(|copy| copy.no_mesh_colors);
        let plain = is_plain.then(|| without_colors(&file));
        Self { file, plain, data, edges: Vec::new(), edge_data: Vec::new(), glyphs: Vec::new() }
    }
}

impl Render {
    /// The lines and points of the file that are drawn: those that are not cut away. Planes across a part of the model refer to the
    /// bounds of its surface, if it has one.
    pub(super) fn strokes_of(&self, whole: Option<&Extent>, strokes: Arc<Strokes>) -> Result<Arc<Strokes>> {
        let strokes = match strokes.colors {
            Some(_) if !self.drawing.surface().use_mesh_colors => without_colors(&strokes),
            _ => strokes,
        };
        let Some(clipping) = self.clip.clipping().filter(|_| !strokes.is_empty()) else { return Ok(strokes) };
        let bounds = whole.map(Extent::bounds).filter(|bounds| !bounds.is_empty());
        let bounds = bounds.unwrap_or_else(|| strokes.bounds());
        Ok(Arc::new(clipping.clip_strokes(&strokes, &bounds, &self.model.name())?))
    }

    /// If no triangle was drawn, is that because of where strokes are?
    pub(super) fn strokes_are_beside(&self, report: &LoadReport) -> bool {
        let has_no_surface = self.members().any(|member| !member.strokes.has_surface());
        report.lines + report.points > 0 || report.mesh.triangles > 0 && has_no_surface
    }

    /// Finds the edges and the glyphs of the model of an instance at some places, if they are drawn, as a picture or as a drawing
    /// of lines; so many bytes are taken.
    pub(super) fn find_strokes(
        &self,
        drawable: &mut Drawable,
        model: &Instance,
        places: &[DAffine3],
        (is_drawing, taken): (bool, u64),
    ) -> Result<()> {
        let domain = model.data.as_ref().map(|data| data.domain(model.mesh.layout()));
        let is_at_cells = domain == Some(AttributeDomain::Triangle) && !model.mesh.clusters().is_empty();
        if self.strokes.has_vertices() && is_at_cells {
            let name = self.model.name();
            bail!("{name}: --mode points shows data of vertices, those of --color-by are at faces");
        }
        if self.strokes.has_edges() && !self.is_measured {
            let needed = Edges::needed_bytes(&model.mesh).saturating_mul(self.strokes.searches());
            self.check_memory(taken, needed)?;
            drawable.edges = self.strokes.edges_of(&model.mesh);
            if let Some(data) = model.data.as_deref().filter(|_| self.strokes.edges_show_data(is_drawing)) {
                let places = if depends_on_place(data) { places } else { &places[..places.len().min(1)] };
                let edges = drawable.edges.iter().map(|(edges, _)| edges.list.len()).sum::<usize>() as u64;
                // The order of the triangles, and two values an edge, or colours made from up to four.
                let order = 24 * model.mesh.triangle_count() as u64;
                let of_edge = if matches!(data, SurfaceData::Direct { .. }) { 40 } else { 8 };
                self.check_memory(taken, needed + order + of_edge * edges * places.len() as u64)?;
                let of = |(edges, _): &(Edges, EdgePart)| of_edges_at(model, edges, places);
                drawable.edge_data = drawable.edges.iter().map(of).collect();
            }
        }
        self.report_edges(&drawable.edges);
        if let Some(options) = self.strokes.glyphs() {
            self.check_memory(taken, glyph_bytes(model, &drawable.file))?;
            for &place in places {
                let placed = Instance { world_from_object: place, ..model.clone() };
                let glyphs = options.glyphs(&placed, &drawable.file, drawable.data.as_ref());
                drawable.glyphs.push(glyphs.with_context(|| self.model.name())?);
            }
        }
        if let Some(glyphs) = drawable.glyphs.first().filter(|_| self.running.verbose && !self.is_measured) {
            messages::note(&summary(glyphs));
        }
        Ok(())
    }

    /// Has the instances of the model draw its edges with their surface, if they can: what is beside it remains.
    /// Lines on surfaces that are not opaque would not be opaque themselves, and on triangles that are culled there would be none;
    /// of a closed surface these are hidden.
    pub(super) fn put_edges_on(&self, instances: &mut [Instance], drawable: &mut Drawable) {
        let [(edges, part)] = &mut drawable.edges[..] else { return };
        let shows_culled = match self.drawing.cull() {
            Cull::Back => !edges.is_solid,
            Cull::Front => true,
            _ => false,
        };
        if shows_culled || instances.iter().any(Instance::is_translucent) {
            return;
        }
        let (Some(lines), [first, ..]) = (self.strokes.on_surface(edges), &*instances) else { return };
        *part = EdgePart::BesideSurface;
        let (lines, mesh) = (Arc::new(lines), Arc::clone(&first.mesh));
        // The others are where the model is cut.
        let own = instances.iter_mut().filter(|instance| Arc::ptr_eq(&instance.mesh, &mesh));
        own.for_each(|instance| instance.edges = Some(Arc::clone(&lines)));
    }

    /// Is nothing of the model drawn but its surface?
    fn is_surface(&self, of_model: &OfModel) -> bool {
        let Drawable { file, edges, glyphs, .. } = &of_model.drawable;
        let has_strokes = !file.is_empty() || !edges.is_empty() || !glyphs.is_empty();
        !has_strokes && !self.strokes.has_vertices() && self.strokes.has_surface()
    }

    /// Is nothing drawn but the surfaces of all models?
    pub(super) fn is_plain(&self, loaded: &Loaded) -> bool {
        self.members().zip(&loaded.models).all(|(member, of_model)| member.is_surface(of_model))
    }

    /// The view of a camera, with all that is drawn between its planes.
    pub(super) fn view(&self, loaded: &Loaded, camera: &Camera) -> Result<View> {
        let (width, height) = self.drawing.size;
        let widest = self.members().map(|member| member.strokes.margin_of_mesh()).fold(0.0, f64::max);
        let surfaces = grown(loaded.scene.bounds(), widest);
        let all = loaded.models.iter().zip(self.members());
        let bounds = all.fold(surfaces, |bounds, (of_model, member)| {
            let Drawable { file, glyphs, .. } = &of_model.drawable;
            let (own, margin) = (file.bounds(), member.strokes.margin_of(file));
            let placed = of_model.places.iter().map(|place| grown(placed(&own, place), margin));
            placed.chain(glyphs.iter().map(Glyphs::bounds)).fold(bounds, |all, other| all.union(other))
        });
        View::new(camera, &bounds, width, height).with_context(|| self.model.name())
    }

    /// The scene with strokes for a camera.
    pub(super) fn with_strokes<'a>(&self, loaded: &'a Loaded, camera: &Camera) -> Result<Cow<'a, Scene>> {
        let Loaded { scene, models, .. } = loaded;
        let all = || self.members().zip(models);
        if self.is_plain(loaded) {
            return Ok(Cow::Borrowed(scene));
        }
        let eye = Eye::new(self.view(loaded, camera)?);
        let with_surface = all().filter(|(member, _)| member.strokes.has_surface());
        let surfaces = with_surface.flat_map(|(_, of_model)| &scene.instances[of_model.instances.clone()]);
        let mut drawn = Scene {
            instances: surfaces.cloned().collect(),
            lights: scene.lights.clone(),
            environment: scene.environment.clone(),
            background: scene.background,
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
        };
        for (member, of_model) in all() {
            let instances = &scene.instances[of_model.instances.clone()];
            drawn.instances.extend(member.strokes_for(&eye, of_model, instances, self.effects.darkens()));
        }
        Ok(Cow::Owned(drawn))
    }

    /// The strokes of this model, which has these instances; `is_darkened` if an effect of the picture darkens what is deep.
    fn strokes_for(
        &self,
        eye: &Eye,
        of_model: &OfModel,
        instances: &[Instance],
        is_darkened: bool,
    ) -> Vec<Instance> {
        let Drawable { data, edges, edge_data, glyphs, .. } = &of_model.drawable;
        let (line_shape, shape) = (self.strokes.line_shape(), self.strokes.shape());
        let mut drawn = Vec::new();
        let pen = self.strokes.edge_pen();
        for (copy, place) in of_model.places.iter().enumerate() {
            let first_of_copy = drawn.len();
            for (number, (edges, part)) in edges.iter().enumerate() {
                let data = edge_data.get(number).and_then(|all| all.get(copy).or(all.first()));
                drawn.extend(match line_shape {
                    LineShape::Flat => strokes::edges(eye, (edges, place), &pen, *part, data),
                    LineShape::Tube => strokes::edge_tubes(eye, (edges, place), &pen, data),
                });
            }
            // Edges on a surface have the alpha of their colour only.
            if !self.strokes.has_surface() {
                fade(&mut drawn[first_of_copy..], self.opacity_of(copy));
            }
        }
        let pens = |copy: usize| self.strokes.pens(self.color_of(copy), is_darkened);
        if self.strokes.has_vertices() {
            // All places have the same: the model, and what closes its cuts.
            let of_place = instances.len() / of_model.places.len();
            for (number, instance) in instances.iter().enumerate() {
                let (first, pen) = (drawn.len(), pens(number / of_place).points);
                drawn.extend(strokes::vertices(eye, instance, shape, &pen));
                fade(&mut drawn[first..], instance.surface.opacity);
            }
        }
        for (copy, place) in of_model.places.iter().enumerate() {
            let (first_of_copy, pens) = (drawn.len(), pens(copy));
            let file = self.file_of(copy, &of_model.drawable);
            drawn.extend(strokes::lines(eye, (file, place), line_shape, &pens.lines, data.as_ref()));
            drawn.extend(strokes::points(eye, (file, place), shape, &pens.points, data.as_ref()));
            fade(&mut drawn[first_of_copy..], self.opacity_of(copy));
        }
        for glyphs in glyphs {
            drawn.extend(glyphs::draw(eye, glyphs, &self.strokes.glyph_pen()));
        }
        drawn
    }
}

/// Lines and points without colours of their own.
fn without_colors(strokes: &Strokes) -> Arc<Strokes> {
    Arc::new(Strokes { colors: None, ..strokes.clone() })
}

/// Gives lines, edges or points an opacity in addition to that of their colours.
fn fade(drawn: &mut [Instance], opacity: f32) {
    drawn.iter_mut().for_each(|instance| instance.surface.opacity = opacity);
}

/// Do the data of an instance depend on where it is?
fn depends_on_place(data: &SurfaceData) -> bool {
    let depends = |source: &DataSource| matches!(source, DataSource::Along(_) | DataSource::Normal(_));
    match data {
        SurfaceData::Mapped { source, .. } => depends(source),
        SurfaceData::Direct { components, .. } => components.iter().any(depends),
    }
}

/// Bytes that the places of glyphs take while some of them are chosen.
fn glyph_bytes(model: &Instance, file: &Strokes) -> u64 {
    let vertices = model.mesh.clusters().len() as u64 * 128;
    (vertices + file.positions.len() as u64) * 128
}

/// How many glyphs there are, and why not more.
fn summary(glyphs: &Glyphs) -> String {
    let Glyphs { zero, not_finite, places, scale, .. } = glyphs;
    let drawn = glyphs.list.len();
    let mut text = format!(
        "{drawn} glyphs at {places} places (--glyph-every), {scale:.4} times as long as their vectors"
    );
    if *zero > 0 {
        text += &format!("; {zero} vectors are 0");
    }
    if *not_finite > 0 {
        text += &format!("; {not_finite} are not numbers");
    }
    text
}
