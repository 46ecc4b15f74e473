//! Boxes and polygons of a real model under a real camera, by the renderer's own front end.
//!
//! Vertices are projected by [`ObjectView::project`], and triangles that cross the near plane or the guard band are
//! clipped by [`clip_triangle`], as in the renderer, so that a workload's polygons equal those that tercio draws, to
//! the sub-pixel. Triangles are in the mesh's order.

use std::sync::Arc;

use tercio_mesh::Mesh;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::projection::clip::clip_triangle;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_scene::camera::CameraError;
use tercio_scene::{Camera, Scene};

use super::polygons::SUBPIXELS;
use super::{BoundingBox, BoxScene, PixelBox, PolygonScene, ScreenPoint, ScreenPolygon};

const _: () =
    assert!(SUBPIXELS == tercio_raster::conventions::SUBPIXELS, "workloads have the renderer's sub-pixels");

/// A projected triangle: itself, its pieces after clipping, or nothing.
fn project(mesh: &Mesh, view: &ObjectView, corners: [u32; 3]) -> Vec<[ScreenVertex; 3]> {
    let positions = Mesh::canonical(corners).map(|v| mesh.positions[v as usize]);
    let projected = positions.map(|p| view.project(p));
    if projected.iter().all(|v| v.inside) {
        return vec![projected];
    }
    let mut pieces = Vec::new();
    clip_triangle(view, positions, projected, |piece| pieces.push(piece));
    pieces
}

fn shows_front(view: &ObjectView, [a, b, c]: [ScreenVertex; 3]) -> bool {
    let from_a = |p: ScreenVertex| [i64::from(p.x) - i64::from(a.x), i64::from(p.y) - i64::from(a.y)];
    let (b, c) = (from_a(b), from_a(c));
    let area = b[0] * c[1] - b[1] * c[0];
    // Corners that run counter-clockwise with y upwards have a negative area with y downwards.
    if view.mirrored { area > 0 } else { area < 0 }
}

/// A model as the source of workloads.
pub struct Model {
    /// Positions and triangles in the order of the model.
    mesh: Mesh,
    scene: Scene,
}

impl Model {
    /// The model of a mesh. The positions are stored twice.
    pub fn new(mesh: Mesh) -> Self {
        let plain = Mesh {
            origin: mesh.origin,
            exponent: mesh.exponent,
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            ..Mesh::default()
        };
        let clusters = partition(mesh, &PartitionOptions::default());
        Self { mesh: plain, scene: Scene::from_mesh(Arc::new(clusters)) }
    }

    /// The model as input of the renderer, with which cameras are placed.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The bounding boxes of all triangles. Culled are those that show their back or have no area, and those outside
    /// the screen or the view; the last ones have the box of pixel (0, 0).
    ///
    /// # Errors
    /// [`CameraError`].
    ///
    /// # Panics
    /// If the screen has no pixel.
    pub fn boxes(&self, camera: &Camera, (width, height): (u32, u32)) -> Result<BoxScene, CameraError> {
        let view = self.view(camera, (width, height))?;
        let screen = PixelBox::screen(width, height);
        let nowhere = BoundingBox { visible: false, pixels: PixelBox { x0: 0, y0: 0, x1: 0, y1: 0 } };
        let boxes = self.mesh.triangles.iter().map(|&corners| {
            let pieces = project(&self.mesh, &view, corners);
            let visible = pieces.iter().any(|&piece| shows_front(&view, piece));
            let corners: Vec<ScreenPoint> = pieces.iter().flatten().map(point).collect();
            let pixels = if corners.is_empty() {
                None
            } else {
                ScreenPolygon { front: visible, corners }.bounds().intersection(&screen)
            };
            pixels.map_or(nowhere, |pixels| BoundingBox { visible, pixels })
        });
        Ok(BoxScene { boxes: boxes.collect() })
    }

    /// The triangles on the screen, fronts and backs. Those outside the screen or the view are dropped; a clipped one
    /// may become several.
    ///
    /// # Errors
    /// [`CameraError`].
    ///
    /// # Panics
    /// If the screen has no pixel.
    pub fn polygons(
        &self,
        camera: &Camera,
        (width, height): (u32, u32),
    ) -> Result<PolygonScene, CameraError> {
        let view = self.view(camera, (width, height))?;
        let screen = PixelBox::screen(width, height);
        let mut polygons = Vec::new();
        for &corners in &self.mesh.triangles {
            for piece in project(&self.mesh, &view, corners) {
                let corners = piece.iter().map(point).collect();
                let polygon = ScreenPolygon { front: shows_front(&view, piece), corners };
                if polygon.bounds().intersection(&screen).is_some() {
                    polygons.push(polygon);
                }
            }
        }
        Ok(PolygonScene { width, height, polygons })
    }

    fn view(&self, camera: &Camera, (width, height): (u32, u32)) -> Result<ObjectView, CameraError> {
        Ok(View::new(camera, &self.scene.bounds(), width, height)?.object(&self.scene.instances[0]))
    }
}

fn point(v: &ScreenVertex) -> ScreenPoint {
    ScreenPoint { x: v.x, y: v.y, depth: v.d }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulators::ortega;
    use tercio_mesh::builtin;
    use tercio_raster::{Cull, FrameStats, Renderer, Settings, Sorting};
    use tercio_scene::{Framing, Projection};

    const SIZE: (u32, u32) = (160, 120);

    fn model(spec: &str) -> Model {
        Model::new(builtin::make(spec).unwrap())
    }

    fn framed(model: &Model) -> Camera {
        Framing::new(SIZE.0, SIZE.1).camera_for_scene(model.scene())
    }

    /// A camera inside the model: triangles cross the near plane.
    fn inside(model: &Model) -> Camera {
        let bounds = model.scene().bounds();
        let eye = bounds.center() + bounds.size() * 0.2;
        let framed = framed(model);
        Camera { eye, projection: Projection::Perspective { fov_y: 1.2 }, ..framed }
    }

    fn render(model: &Model, camera: &Camera, cull: Cull) -> FrameStats {
        // Triangles of hidden clusters would not be counted.
        let settings = Settings { cull, sorting: Sorting::Triangles, ..Settings::one_sample(SIZE.0, SIZE.1) };
        Renderer::new().render(model.scene(), camera, &settings).unwrap().stats
    }

    fn covered(scene: &PolygonScene) -> u64 {
        ortega::simulate(&ortega::Machine { processors: 64, buffer: 1000 }, scene).0.pixels
    }

    #[test]
    fn polygons_cover_the_samples_that_the_renderer_counts() {
        for spec in ["builtin:teapot@6k", "builtin:soup@2k", "builtin:gyroid@5k"] {
            let model = model(spec);
            for camera in [framed(&model), inside(&model)] {
                let mut scene = model.polygons(&camera, SIZE).unwrap();
                assert_eq!(
                    covered(&scene),
                    render(&model, &camera, Cull::None).backend.samples_covered,
                    "{spec}"
                );
                scene.polygons.retain(|p| p.front);
                assert_eq!(
                    covered(&scene),
                    render(&model, &camera, Cull::Back).backend.samples_covered,
                    "{spec}"
                );
            }
        }
    }

    #[test]
    fn boxes_are_those_of_the_polygons() {
        let model = model("builtin:teapot@6k");
        let camera = framed(&model);
        let (boxes, polygons) = (model.boxes(&camera, SIZE).unwrap(), model.polygons(&camera, SIZE).unwrap());
        // Everything is inside the picture, so that no polygon is dropped or clipped.
        assert_eq!(boxes, polygons.boxes());
        assert_eq!(boxes.boxes.len(), model.mesh.triangles.len());
        let visible = boxes.visible() as f64 / boxes.boxes.len() as f64;
        assert!((0.3..0.6).contains(&visible), "{visible}");
    }

    #[test]
    fn triangles_outside_are_culled() {
        let model = model("builtin:sphere@2k");
        let camera = inside(&model);
        let boxes = model.boxes(&camera, SIZE).unwrap();
        // From inside, a sphere shows its back only.
        assert_eq!((boxes.boxes.len(), boxes.visible()), (model.mesh.triangles.len(), 0));
        let screen = PixelBox::screen(SIZE.0, SIZE.1);
        assert!(boxes.boxes.iter().all(|b| b.pixels.intersection(&screen) == Some(b.pixels)));
    }
}
