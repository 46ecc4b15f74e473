//! The models of one picture.

use std::borrow::Cow;
use std::ops::Range;

use serde_json::{Value, json};
use tercio::glam::DAffine3;
use tercio::glyphs::Glyphs;
use tercio::mesh::Aabb;
use tercio::mesh::strokes::Strokes;
use tercio::parallel::Communicator;
use tercio::parallel::comm::CommError;
use tercio::scene::framing::Extent;
use tercio::scene::{Instance, Scene};
use tercio::{LoadReport, TextureReport};

use super::Render;
use super::strokes::Drawable;
use super::subject::Subject;
use crate::args::place::PlaceArgs;
use crate::args::strokes::StrokeArgs;
use crate::series::pattern::{self, Names};
use crate::{look, report};

/// A further place of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Placement {
    /// Applied after the transform of the model itself.
    pub place: PlaceArgs,
    /// Linear RGB, if it is not that of the model; also of its lines and points that have no colours of their own.
    pub color: Option<[f32; 3]>,
    /// If it is not that of the model; also of its lines, its points, and its edges that are drawn alone.
    pub opacity: Option<f64>,
    /// Whether it is drawn in `color`, with its lines and points, whatever colours the model has.
    pub no_mesh_colors: bool,
}

impl Placement {
    /// The copy of an instance, which is the model itself or its caps.
    pub(super) fn of(&self, instance: &Instance, is_model: bool) -> Instance {
        let mut copy = instance.clone();
        copy.world_from_object = self.place.transform() * copy.world_from_object;
        let surface = &mut copy.surface;
        surface.opacity = self.opacity.map_or(surface.opacity, |opacity| opacity as f32);
        if is_model && !surface.unlit {
            surface.base_color = self.color.unwrap_or(surface.base_color);
            surface.use_mesh_colors &= !self.no_mesh_colors;
        }
        copy
    }
}

/// A loaded model of the picture.
pub(super) struct OfModel {
    pub report: LoadReport,
    /// `None` if materials and textures are not used.
    pub textures: Option<TextureReport>,
    /// The number of the model in the picture whose mesh this one shares, if it was loaded already.
    pub shares_with: Option<usize>,
    /// Where it is.
    pub places: Vec<DAffine3>,
    /// The numbers of its instances in the scene.
    pub instances: Range<usize>,
    pub drawable: Drawable,
}

impl OfModel {
    /// Adds it to what the camera frames: all of a model that is clipped, and all lines and points of its `file`, with their widths in
    /// world units.
    pub fn frame_in<'a>(
        &self,
        subject: &mut Subject<'a>,
        scene: &'a Scene,
        (whole, file): (Option<&'a Extent>, &Strokes),
        strokes: &StrokeArgs,
    ) {
        let margin = strokes.margin_of_mesh();
        match whole {
            Some(whole) => {
                self.places.iter().for_each(|&place| subject.add_extent(Cow::Borrowed(whole), place, margin));
            }
            None => {
                let instances = &scene.instances[self.instances.clone()];
                instances.iter().for_each(|instance| subject.add_instance(instance, margin));
            }
        }
        if !file.is_empty() {
            let (extent, margin) = (Extent::of_strokes(file), strokes.margin_of(file));
            self.places
                .iter()
                .for_each(|&place| subject.add_extent(Cow::Owned(extent.clone()), place, margin));
        }
        for glyphs in &self.drawable.glyphs {
            subject.add_extent(Cow::Owned(Extent::of_strokes(&ends_of(glyphs))), DAffine3::IDENTITY, 0.0);
        }
    }

    /// The box of what is drawn of the model itself: not of glyphs, which show its data.
    /// Of models in parts, together with the ranks that have the others.
    ///
    /// # Errors
    /// Another rank is gone.
    pub fn model_box(
        &self,
        scene: &Scene,
        parts: &mut Option<&mut impl Communicator>,
    ) -> Result<Aabb, CommError> {
        let mut subject = Subject::default();
        scene.instances[self.instances.clone()]
            .iter()
            .for_each(|instance| subject.add_instance(instance, 0.0));
        let own = Extent::of_strokes(&self.drawable.file);
        self.places.iter().for_each(|&place| subject.add_extent(Cow::Borrowed(&own), place, 0.0));
        subject.smallest_box(parts)
    }
}

/// The ends of glyphs, as points in world space.
fn ends_of(glyphs: &Glyphs) -> Strokes {
    let ends = || glyphs.list.iter().flat_map(|glyph| [glyph.place, glyph.place + glyph.vector]);
    let origin = ends().next().unwrap_or_default();
    let positions: Vec<[f32; 3]> = ends().map(|p| (p - origin).as_vec3().to_array()).collect();
    let points = (0..positions.len() as u32).collect();
    Strokes { origin, positions, points, ..Strokes::default() }
}

/// What is said about a model when the scene is gone.
#[derive(Clone)]
pub(super) struct ModelReport {
    pub report: LoadReport,
    pub textures: Option<TextureReport>,
    /// Its instances, for `--stats`.
    pub json: Value,
}

impl Render {
    /// The models of the picture, each with its options.
    pub(super) fn members(&self) -> impl Iterator<Item = &Self> + Clone {
        std::iter::once(self).chain(&self.others)
    }

    /// What the placeholders in the texts of this model, one of several in a picture with these names, stand for.
    pub(super) fn names_in(&self, picture: &Names) -> Names {
        let is_shown = self.annotation.has_placeholder("time");
        let time = || self.model.time().or_else(|| self.time_of_file(&self.model.model));
        let name = Some(pattern::name_of(&self.model.model));
        Names { name, time: is_shown.then(time).flatten(), ..picture.clone() }
    }

    /// How this model is placed once more: the model itself is 0, and its further places follow.
    fn placement(&self, copy: usize) -> Option<&Placement> {
        copy.checked_sub(1).and_then(|number| self.placements.get(number))
    }

    /// The opacity of this model at one of its places.
    pub(super) fn opacity_of(&self, copy: usize) -> f32 {
        let own = self.placement(copy).and_then(|placement| placement.opacity);
        own.map_or_else(|| self.drawing.surface().opacity, |opacity| opacity as f32)
    }

    /// Its colour there, in linear RGB, if it has one.
    pub(super) fn color_of(&self, copy: usize) -> Option<[f32; 3]> {
        self.placement(copy).and_then(|placement| placement.color).or_else(|| self.drawing.color())
    }

    /// The lines and points of its file as they are drawn there: without colours of their own, if the place wants that.
    pub(super) fn file_of<'a>(&self, copy: usize, drawable: &'a Drawable) -> &'a Strokes {
        let is_plain = self.placement(copy).is_some_and(|placement| placement.no_mesh_colors);
        drawable.plain.as_ref().filter(|_| is_plain).unwrap_or(&drawable.file)
    }

    /// What is said about each model.
    pub(super) fn model_reports(&self, models: &[OfModel], scene: &Scene) -> Vec<ModelReport> {
        let (mut primitives, mut faces) = (0, 0);
        let mut of_model = |(number, (member, model)): (usize, (&Self, &OfModel))| {
            let mut instances = Vec::new();
            for instance in &scene.instances[model.instances.clone()] {
                let drawn = member.strokes.has_surface();
                instances.push(instance_json(instance, drawn.then_some((primitives, faces))));
                if drawn {
                    primitives += triangles_of(instance);
                    faces += faces_of(instance);
                }
            }
            let mut json = report::load_json(&member.model.name(), &model.report);
            json["number"] = number.into();
            json["mesh_of"] = model.shares_with.into();
            if model.shares_with.is_some() {
                json["memory_bytes"] = 0.into();
            }
            json["textures"] = model.textures.as_ref().map(report::textures_json).into();
            json["data"] = member.data.json(scene.instances.get(model.instances.start));
            json["strokes"] = member.strokes.json();
            json["instances"] = instances.into();
            ModelReport { report: model.report.clone(), textures: model.textures.clone(), json }
        };
        self.members().zip(models).enumerate().map(&mut of_model).collect()
    }
}

/// An instance, and the numbers of its first triangle and its first face in the picture, if it is drawn.
fn instance_json(instance: &Instance, first: Option<(u64, u64)>) -> Value {
    json!({
        "transform": crate::args::place::json(&instance.world_from_object),
        "triangles": instance.mesh.triangle_count(),
        "faces": faces_of(instance),
        "first_primitive": first.map(|first| first.0),
        "first_face": first.map(|first| first.1),
        "color": look::numbers(&instance.surface.base_color),
        "mesh_colors": instance.surface.use_mesh_colors,
        "opacity": look::number(instance.surface.opacity),
    })
}

/// Triangles that count in the numbers of primitives.
fn triangles_of(instance: &Instance) -> u64 {
    instance.share.map_or(instance.mesh.triangle_count() as u64, |share| share.triangles)
}

/// Input faces that count in the numbers of `--output-ids`.
fn faces_of(instance: &Instance) -> u64 {
    instance.share.map_or_else(|| tercio::raster::context::faces_of(&instance.mesh), |share| share.faces)
}

/// What the reports of all models say together, for the question why nothing was drawn.
pub(super) fn together(models: &[OfModel], scene: &Scene) -> LoadReport {
    let mut all = models.first().map(|model| model.report.clone()).unwrap_or_default();
    if models.len() > 1 || models.iter().any(|model| model.places != [DAffine3::IDENTITY]) {
        all.mesh.bounds = scene.bounds();
    }
    for OfModel { report, .. } in models.iter().skip(1) {
        all.mesh.triangles += report.mesh.triangles;
        all.lines += report.lines;
        all.points += report.points;
        let left = &report.read.not_drawn;
        let into = &mut all.read.not_drawn;
        into.points = into.points.saturating_add(left.points);
        into.lines = into.lines.saturating_add(left.lines);
    }
    all
}
