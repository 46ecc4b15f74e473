//! Lines, edges and points of the models, for one camera.

use std::borrow::Cow;
use std::sync::Arc;

use anyhow::{Context, Result};
use tercio::LoadReport;
use tercio::mesh::edges::Edges;
use tercio::mesh::strokes::Strokes;
use tercio::raster::view::View;
use tercio::scene::{Camera, Instance, Scene};
use tercio::strokes::{self, Eye};

use super::members::OfModel;
use super::subject::placed;
use super::{Loaded, Render};

/// What is drawn of a model besides the surface.
pub(super) struct Drawable {
    /// Lines and points of the file.
    pub file: Arc<Strokes>,
    /// Edges, and whether only those on the silhouette are drawn.
    pub edges: Vec<(Edges, bool)>,
}

impl Drawable {
    /// Lines and points of a file, until edges are found.
    pub fn of_file(file: Arc<Strokes>) -> Self {
        Self { file, edges: Vec::new() }
    }
}

impl Render {
    /// The lines and points of the file that are drawn. Those of a model that is clipped are not, and the report says so.
    pub(super) fn strokes_of(&self, report: &mut LoadReport, strokes: Arc<Strokes>) -> Arc<Strokes> {
        if self.clip.clipping().is_none() {
            return strokes;
        }
        (report.lines, report.points) = (0, 0);
        Arc::default()
    }

    /// If no triangle was drawn, is that because of where strokes are?
    pub(super) fn strokes_are_beside(&self, report: &LoadReport) -> bool {
        let has_no_surface = self.members().any(|member| !member.strokes.has_surface());
        report.lines + report.points > 0 || report.mesh.triangles > 0 && has_no_surface
    }

    /// Finds the edges of the model of an instance, if they are drawn.
    pub(super) fn find_edges(&self, drawable: &mut Drawable, model: &Instance, taken: u64) -> Result<()> {
        if self.strokes.has_edges() {
            let needed = Edges::needed_bytes(&model.mesh).saturating_mul(self.strokes.searches());
            self.check_memory(taken, needed)?;
            drawable.edges = self.strokes.edges_of(&model.mesh);
        }
        self.report_edges(&drawable.edges);
        Ok(())
    }

    /// Is nothing of the model drawn but its surface?
    fn is_plain(&self, of_model: &OfModel) -> bool {
        let Drawable { file, edges } = &of_model.drawable;
        file.is_empty() && edges.is_empty() && !self.strokes.has_vertices() && self.strokes.has_surface()
    }

    /// The view of a camera, with all that is drawn between its planes.
    pub(super) fn view(&self, loaded: &Loaded, camera: &Camera) -> Result<View> {
        let (width, height) = self.drawing.size;
        let bounds = loaded.models.iter().fold(loaded.scene.bounds(), |bounds, of_model| {
            let own = of_model.drawable.file.bounds();
            of_model.places.iter().fold(bounds, |bounds, place| bounds.union(placed(&own, place)))
        });
        View::new(camera, &bounds, width, height).with_context(|| self.model.name())
    }

    /// The scene with strokes for a camera.
    pub(super) fn with_strokes<'a>(&self, loaded: &'a Loaded, camera: &Camera) -> Result<Cow<'a, Scene>> {
        let Loaded { scene, models, .. } = loaded;
        let all = || self.members().zip(models);
        if all().all(|(member, of_model)| member.is_plain(of_model)) {
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
            drawn.instances.extend(member.strokes_for(&eye, of_model, instances));
        }
        Ok(Cow::Owned(drawn))
    }

    /// The strokes of this model, which has these instances.
    fn strokes_for(&self, eye: &Eye, of_model: &OfModel, instances: &[Instance]) -> Vec<Instance> {
        let Drawable { file, edges } = &of_model.drawable;
        let mut drawn = Vec::new();
        for place in &of_model.places {
            for (edges, only_silhouette) in edges {
                drawn.extend(strokes::edges(eye, edges, place, &self.strokes.edge_pen(), *only_silhouette));
            }
        }
        let pens = self.strokes.pens(self.drawing.color());
        if self.strokes.has_vertices() {
            for Instance { mesh, world_from_object: place, .. } in instances {
                drawn.extend(strokes::vertices(eye, mesh, place, self.strokes.shape(), &pens.points));
            }
        }
        for place in &of_model.places {
            drawn.extend(strokes::lines(eye, file, place, &pens.lines));
            drawn.extend(strokes::points(eye, file, place, self.strokes.shape(), &pens.points));
        }
        drawn
    }
}
