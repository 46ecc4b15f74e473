//! Options of the camera.

use clap::{Args, ValueEnum};
use tercio::glam::DVec3;
use tercio::mesh::strokes::Strokes;
use tercio::parallel::{Communicator, ParallelError, parts};
use tercio::scene::camera::CameraBasis;
use tercio::scene::framing::Extent;
use tercio::scene::{Camera, Framing, Scene, UpAxis, View};

use super::values;

/// A view by name.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum NamedView {
    /// From the front.
    Front,
    /// From behind.
    Back,
    /// From the left of the front view.
    Left,
    /// From the right of the front view.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
    /// From above, front and right, at equal angles to the axes.
    Iso,
}

impl From<NamedView> for View {
    fn from(view: NamedView) -> Self {
        match view {
            NamedView::Front => Self::Front,
            NamedView::Back => Self::Back,
            NamedView::Left => Self::Left,
            NamedView::Right => Self::Right,
            NamedView::Top => Self::Top,
            NamedView::Bottom => Self::Bottom,
            NamedView::Iso => Self::Iso,
        }
    }
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Axis {
    /// +x up, the front seen from +z.
    X,
    /// +y up, the front seen from +z.
    Y,
    /// +z up, the front seen from -y, as in CAD.
    Z,
}

impl From<Axis> for UpAxis {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::X => Self::X,
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
        }
    }
}

/// Position and projection of the camera. By default it frames the model.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A view by name.
    #[arg(long, value_name = "NAME", value_enum, conflicts_with_all = ["azimuth", "elevation", "eye"])]
    view: Option<NamedView>,
    /// Degrees round the up axis; 0 is the front, positive turns the camera to its right [default: 15].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(conflicts_with = "eye")]
    azimuth: Option<f64>,
    /// Degrees above the horizon [default: 18].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(conflicts_with = "eye")]
    elevation: Option<f64>,
    /// Degrees by which the camera is turned counter-clockwise round its line of sight.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(default_value = "0", hide_default_value = true)]
    roll: f64,
    /// Shows the model larger (above 1, up to 1000000) or smaller (down to 0.001), by narrowing the angle of view.
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = values::zoom)]
    #[arg(default_value = "1", hide_default_value = true)]
    zoom: f64,
    /// The axis that points upwards.
    #[arg(long, value_name = "AXIS", value_enum, default_value_t = Axis::Y)]
    up_axis: Axis,
    /// Position of the camera, instead of framing the model.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    eye: Option<DVec3>,
    /// What the camera at --eye looks at [default: the middle of the model].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    #[arg(requires = "eye")]
    target: Option<DVec3>,
    /// What points upwards in the picture of a camera at --eye [default: the up axis].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    #[arg(requires = "eye")]
    up: Option<DVec3>,
    /// Vertical angle of view at zoom 1, degrees [default: 30].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::field_of_view)]
    fov: Option<f64>,
    /// Parallel projection instead of perspective.
    #[arg(long, conflicts_with = "fov")]
    orthographic: bool,
    /// Leaves out what is nearer to the camera than this, in the units of the model.
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = values::positive)]
    near: Option<f64>,
}

impl CameraArgs {
    /// The camera for a scene in a picture of this size.
    pub fn camera(&self, scene: &Scene, size: (u32, u32)) -> Camera {
        self.camera_for(scene, None, size)
    }

    /// The camera for a scene, or for all of a model of which a part is in it.
    pub fn camera_for(&self, scene: &Scene, whole: Option<&Extent>, (width, height): (u32, u32)) -> Camera {
        let framing = self.framing(width, height);
        let camera = match (self.eye, whole) {
            (Some(eye), _) => {
                let bounds = whole.map_or_else(|| scene.bounds(), Extent::bounds);
                let target = self.target.unwrap_or_else(|| bounds.center());
                framing.camera_at(eye, target, self.up)
            }
            (None, Some(whole)) => framing.camera_for_extent(whole),
            (None, None) => framing.camera_for_scene(scene),
        };
        Camera { near: self.near, ..camera }
    }

    /// As [`CameraArgs::camera_for`], of a model that also has lines and points.
    pub fn camera_with(
        &self,
        scene: &Scene,
        whole: Option<&Extent>,
        strokes: &Strokes,
        (width, height): (u32, u32),
    ) -> Camera {
        if strokes.is_empty() {
            return self.camera_for(scene, whole, (width, height));
        }
        let strokes = Extent::of_strokes(strokes);
        let bounds = whole.map_or_else(|| scene.bounds(), Extent::bounds).union(strokes.bounds());
        let framing = self.framing(width, height);
        let camera = match self.eye {
            Some(eye) => framing.camera_at(eye, self.target.unwrap_or_else(|| bounds.center()), self.up),
            None => framing.camera_for_reach(&bounds, |direction, from| {
                let surface = match whole {
                    Some(whole) => whole.reach(direction, from),
                    None => scene.reach(direction, from),
                };
                // Without triangles that is not a number.
                strokes.reach(direction, from).max(surface)
            }),
        };
        Camera { near: self.near, ..camera }
    }

    /// The camera for a scene of which each rank has a part; all ranks have to call this.
    ///
    /// # Errors
    /// Another rank is gone.
    pub fn camera_of_parts(
        &self,
        comm: &mut impl Communicator,
        scene: &Scene,
        (width, height): (u32, u32),
    ) -> Result<Camera, ParallelError> {
        if self.eye.is_some() {
            // The bounds are those of all parts.
            return Ok(self.camera(scene, (width, height)));
        }
        let camera = parts::camera_for_scene(comm, &self.framing(width, height), scene)?;
        Ok(Camera { near: self.near, ..camera })
    }

    /// The axes of the front view.
    pub fn front(&self) -> CameraBasis {
        UpAxis::from(self.up_axis).front()
    }

    /// Whether the projection is parallel.
    pub fn is_orthographic(&self) -> bool {
        self.orthographic
    }

    /// How much larger the model is shown than without `--zoom`.
    pub fn zoom(&self) -> f64 {
        self.zoom
    }

    fn framing(&self, width: u32, height: u32) -> Framing {
        let mut framing = Framing::new(width, height);
        if let Some(view) = self.view {
            framing = framing.with_view(view.into());
        }
        framing.up_axis = self.up_axis.into();
        framing.azimuth = self.azimuth.unwrap_or(framing.azimuth);
        framing.elevation = self.elevation.unwrap_or(framing.elevation);
        framing.roll = self.roll;
        framing.zoom = self.zoom;
        framing.fov_y = (!self.orthographic).then(|| self.fov.unwrap_or(Framing::FOV_Y));
        framing
    }
}
