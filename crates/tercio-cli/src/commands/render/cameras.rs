//! The cameras of all shots of a model.

use anyhow::{Context, Result, bail};
use tercio::annotate::Annotation;
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
        let size = if frames_model { annotation.room(self.drawing.size) } else { self.drawing.size };
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
        let with_room = |camera: Camera| {
            if frames_model { annotation.make_room(&camera, self.drawing.size) } else { camera }
        };
        let of_eyes = |camera| self.stereo.cameras(camera, self.camera.zoom());
        cameras.into_iter().map(|c| of_eyes(with_room(c)).with_context(|| self.model.name())).collect()
    }
}
