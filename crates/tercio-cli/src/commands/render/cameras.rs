//! The cameras of all shots of a model.

use anyhow::{Context, Result, bail};
use tercio::annotate::annotation::{ModelRoom, Shape};
use tercio::annotate::{Annotation, project};
use tercio::glam::DVec3;
use tercio::mesh::Aabb;
use tercio::mesh::trig::sin_cos;
use tercio::parallel::Communicator;
use tercio::scene::{Camera, Framing, Scene};

use super::Render;
use super::subject::Subject;
use crate::args::camera::CameraArgs;
use crate::args::series::Motion;
use crate::args::stereo::Cameras;

impl Render {
    /// The cameras of all shots, those of eyes included; `options` are those for the model's format. If each rank has a part of the scene, all ranks have to call this.
    ///
    /// # Errors
    /// A camera that cannot be used; another rank is gone.
    pub(super) fn cameras(
        &self,
        motion: &Motion,
        options: &CameraArgs,
        (scene, subject): (&Scene, &Subject),
        annotation: &Annotation,
        mut parts: Option<&mut impl Communicator>,
    ) -> Result<Vec<Cameras>> {
        // Beside the annotation, where the camera is placed.
        let frames_model = options.frames_model() && !matches!(motion, Motion::Path(..));
        let room = match frames_model && !annotation.is_empty() {
            true => annotation.room(self.drawing.size, &self.shapes(motion, options, &subject.bounds())?),
            false => ModelRoom::whole(self.drawing.size),
        };
        let size = room.size();
        let mut place = |options: &CameraArgs, framing: &Framing| -> Result<Camera> {
            Ok(match &mut parts {
                // All of the box has to be in the picture, not only the model.
                parts if annotation.bounds && frames_model => {
                    options.camera_for_box(&subject.smallest_box(parts)?, framing)
                }
                None => options.camera_for(&subject.bounds(), |d, from| subject.reach(d, from), framing),
                Some(comm) => options.camera_of_parts(*comm, scene, framing)?,
            })
        };
        let framing = options.framing(size);
        let cameras: Vec<Camera> = match motion {
            Motion::Still => vec![place(options, &framing)?],
            Motion::Views(views) => {
                let of_view = |&view| {
                    let of_view = options.with_view(view);
                    place(&of_view, &of_view.framing(size))
                };
                views.iter().map(of_view).collect::<Result<_>>()?
            }
            Motion::Turntable(count) => {
                let first = place(options, &Framing { all_round: true, ..framing })?;
                let up = framing.up_axis.front().up;
                let turned = |number| first.turned(up, 360.0 * f64::from(number) / f64::from(*count));
                (0..*count).map(turned).collect()
            }
            Motion::Path(keys, count) => {
                // The target is that of a camera that frames the model: its middle.
                let bounds = subject.bounds();
                let (up, fov) = (framing.up_axis.front().up, framing.fov_y.unwrap_or(Framing::FOV_Y));
                let path = Motion::path(keys, bounds.center(), up, fov).map_err(anyhow::Error::msg)?;
                let near = options.near();
                let at = |time| {
                    let key = path.at(time);
                    let framing = Framing { fov_y: framing.fov_y.map(|_| key.fov_y), ..framing };
                    Camera { near, ..framing.camera_at(key.eye, key.target, Some(key.up)) }
                };
                path.times(*count as usize).map(at).collect()
            }
        };
        if let Motion::Path(..) | Motion::Turntable(_) = motion
            && let Some((number, error)) =
                cameras.iter().enumerate().find_map(|(number, c)| Some((number, c.basis().err()?)))
        {
            bail!("{}: picture {number}: {error}", self.model.name());
        }
        let of_eyes = |camera| self.stereo.cameras(camera, self.camera.zoom());
        cameras.into_iter().map(|c| of_eyes(room.place(&c)).with_context(|| self.model.name())).collect()
    }

    /// The shapes of a model with this box, in the whole picture: of each view, or of a turntable from all round. Those of the box alone, so
    /// that they are the same where each rank has a part of the model.
    fn shapes(&self, motion: &Motion, options: &CameraArgs, bounds: &Aabb) -> Result<Vec<Shape>> {
        let size = self.drawing.size;
        let views: Vec<CameraArgs> = match motion {
            Motion::Views(views) => views.iter().map(|&view| options.with_view(view)).collect(),
            _ => vec![options.clone()],
        };
        let mut shapes = Vec::new();
        for view in views {
            let framing = view.framing(size);
            let points = match motion {
                Motion::Turntable(_) => around(bounds, framing.up_axis.front().up),
                _ => bounds.corners().to_vec(),
            };
            let camera = view.camera_for_box(bounds, &framing);
            let own = if bounds.is_empty() { None } else { project::shape(&camera, size, points)? };
            shapes.push(own.unwrap_or([1.0; 2]));
        }
        Ok(shapes)
    }
}

/// Points on the circles through the corners of a box, round its middle.
fn around(bounds: &Aabb, up: DVec3) -> Vec<DVec3> {
    const DIRECTIONS: u32 = 16;
    let middle = bounds.center();
    let offset = bounds.max - middle;
    let height = up * up.dot(offset).abs();
    let radius = (offset.length_squared() - height.length_squared()).max(0.0).sqrt();
    let (right, back) = up.any_orthonormal_pair();
    let at = |number: u32| {
        let (sin, cos) = sin_cos(f64::from(number) / f64::from(DIRECTIONS) * std::f64::consts::TAU);
        let out = (right * cos + back * sin) * radius;
        [middle + out - height, middle + out + height]
    };
    (0..DIRECTIONS).flat_map(at).collect()
}
