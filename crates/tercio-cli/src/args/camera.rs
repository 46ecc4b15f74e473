//! Options of the camera.

use clap::{Args, ValueEnum};
use tercio::glam::DVec3;
use tercio::mesh::Aabb;
use tercio::mesh::trig::atan2;
use tercio::parallel::{Communicator, ParallelError, parts};
use tercio::scene::camera::CameraBasis;
use tercio::scene::{Camera, Framing, Scene, UpAxis, View};

use super::values;

/// A view by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
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
    #[value(alias = "isometric")]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
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

/// `--up`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Up {
    /// Of the picture.
    Vector(DVec3),
    /// Of the model.
    Axis(UpAxis),
}

/// An axis by its name, and whether it is meant against its direction: `Z`, `+z`, `-Z`.
fn signed_axis(text: &str) -> Option<(Axis, bool)> {
    let is_negative = text.starts_with('-');
    let axis = match text.strip_prefix(['+', '-']).unwrap_or(text) {
        "X" | "x" => Axis::X,
        "Y" | "y" => Axis::Y,
        "Z" | "z" => Axis::Z,
        _ => return None,
    };
    Some((axis, is_negative))
}

fn up(text: &str) -> Result<Up, String> {
    let axis = match signed_axis(text) {
        Some((axis, false)) => axis.into(),
        Some((Axis::X, true)) => UpAxis::NegX,
        Some((Axis::Y, true)) => UpAxis::NegY,
        Some((Axis::Z, true)) => UpAxis::NegZ,
        None => {
            let vector = values::vector(text)
                .map_err(|_| "expected three numbers X,Y,Z, or an axis: +X, -X, +Y, -Y, +Z or -Z");
            return Ok(Up::Vector(vector?));
        }
    };
    Ok(Up::Axis(axis))
}

fn direction(text: &str) -> Result<DVec3, String> {
    let Some((axis, is_negative)) = signed_axis(text) else {
        let expected = |_| "expected three numbers X,Y,Z, or an axis: +X, -X, +Y, -Y, +Z or -Z".into();
        return values::vector(text).map_err(expected);
    };
    let axis = match axis {
        Axis::X => DVec3::X,
        Axis::Y => DVec3::Y,
        Axis::Z => DVec3::Z,
    };
    Ok(if is_negative { -axis } else { axis })
}

/// Position and projection of the camera. By default it frames the model.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A view by name; several, as in front,top,iso or with several --view, make a picture each.
    #[arg(long, value_name = "NAME", value_enum, value_delimiter = ',')]
    #[arg(conflicts_with_all = ["azimuth", "elevation", "eye"])]
    view: Vec<NamedView>,
    /// Degrees round the up axis; 0 is the front, positive turns the camera to its right [default: 15].
    #[arg(long, alias = "camera-azimuth-angle", value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(conflicts_with = "eye")]
    azimuth: Option<f64>,
    /// Degrees above the horizon [default: 18].
    #[arg(long, alias = "camera-elevation-angle", value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(conflicts_with = "eye")]
    elevation: Option<f64>,
    /// Degrees by which the camera is turned counter-clockwise round its line of sight.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(default_value = "0", hide_default_value = true)]
    roll: f64,
    /// Shows the model larger (above 1, up to 1000000) or smaller (down to 0.001), by narrowing the angle of view.
    #[arg(long, alias = "camera-zoom-factor", value_name = "FACTOR", allow_negative_numbers = true, value_parser = values::zoom)]
    #[arg(default_value = "1", hide_default_value = true)]
    zoom: f64,
    /// The axis that points upwards [default: y; of STL, LAS, LAZ and point clouds as text, z].
    #[arg(long, value_name = "AXIS", value_enum)]
    up_axis: Option<Axis>,
    /// Direction in which the camera looks at the model that it frames, instead of --azimuth and --elevation:
    /// X,Y,Z or an axis such as +X or -Z.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction)]
    #[arg(conflicts_with_all = ["view", "azimuth", "elevation", "eye"])]
    camera_direction: Option<DVec3>,
    /// Position of the camera, instead of framing the model.
    #[arg(long, alias = "camera-position", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    eye: Option<DVec3>,
    /// What the camera at --eye looks at [default: the middle of the model].
    #[arg(long, alias = "camera-focal-point", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    #[arg(requires = "eye")]
    target: Option<DVec3>,
    /// What points upwards in the picture of a camera at --eye [default: the up axis]; or an axis, +X to -Z, for that of the
    /// model, as with --up-axis.
    #[arg(long, alias = "camera-view-up", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = up)]
    up: Option<Up>,
    /// Vertical angle of view at zoom 1, degrees [default: 30].
    #[arg(long, aliases = ["camera-view-angle", "view-angle"], value_name = "DEG", allow_negative_numbers = true, value_parser = values::field_of_view)]
    fov: Option<f64>,
    /// Parallel projection instead of perspective.
    #[arg(long, aliases = ["camera-orthographic", "parallel-projection"], conflicts_with = "fov")]
    orthographic: bool,
    /// Leaves out what is nearer to the camera than this, in the units of the model.
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = values::positive)]
    near: Option<f64>,
}

impl CameraArgs {
    /// The camera for a scene in a picture of this size.
    pub fn camera(&self, scene: &Scene, size: (u32, u32)) -> Camera {
        self.camera_for(&scene.bounds(), |d, from| scene.reach(d, from), &self.framing(size))
    }

    /// The views by name.
    pub fn views(&self) -> &[NamedView] {
        &self.view
    }

    /// These options with one view.
    pub fn with_view(&self, view: NamedView) -> Self {
        Self { view: vec![view], ..self.clone() }
    }

    /// The camera for what has these bounds and this [reach](Scene::reach).
    pub fn camera_for(
        &self,
        bounds: &Aabb,
        reach: impl Fn(DVec3, DVec3) -> f64,
        framing: &Framing,
    ) -> Camera {
        let camera = match self.eye {
            Some(eye) => {
                framing.camera_at(eye, self.target.unwrap_or_else(|| bounds.center()), self.up_vector())
            }
            None => framing.camera_for_reach(bounds, reach),
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
        framing: &Framing,
    ) -> Result<Camera, ParallelError> {
        if self.eye.is_some() {
            // The bounds are those of all parts.
            return Ok(self.camera_for(&scene.bounds(), |_, _| 0.0, framing));
        }
        let camera = parts::camera_for_scene(comm, framing, scene)?;
        Ok(Camera { near: self.near, ..camera })
    }

    /// Finds options that have no effect.
    ///
    /// # Errors
    /// One sentence.
    pub fn check(&self) -> Result<(), &'static str> {
        if matches!(self.up, Some(Up::Vector(_))) && self.eye.is_none() {
            return Err("--up X,Y,Z needs --eye; --up +Z, or --up-axis z, turns the model that is framed");
        }
        if matches!(self.up, Some(Up::Axis(_))) && self.up_axis.is_some() {
            return Err("--up +Z and --up-axis say the same: give one of them");
        }
        if self.camera_direction == Some(DVec3::ZERO) {
            return Err("--camera-direction must not be 0,0,0");
        }
        Ok(())
    }

    fn up_vector(&self) -> Option<DVec3> {
        match self.up {
            Some(Up::Vector(up)) => Some(up),
            _ => None,
        }
    }

    fn given_axis(&self) -> Option<UpAxis> {
        match self.up {
            Some(Up::Axis(axis)) => Some(axis),
            _ => self.up_axis.map(UpAxis::from),
        }
    }

    /// Whether the up axis is given.
    pub fn has_up_axis(&self) -> bool {
        self.given_axis().is_some()
    }

    /// These options for a model of a format, in the words of its reader: STL, LAS, LAZ and text clouds have z up, other formats
    /// y, unless an axis is given.
    pub fn for_format(&self, format: &str) -> Self {
        let usual = if ["STL", "LAS", "LAZ", "text"].iter().any(|f| format.starts_with(f)) {
            Axis::Z
        } else {
            Axis::Y
        };
        let up_axis = match self.given_axis() {
            Some(_) => self.up_axis,
            None => Some(usual),
        };
        Self { up_axis, ..self.clone() }
    }

    /// The axis that points upwards.
    pub fn up_axis(&self) -> UpAxis {
        self.given_axis().unwrap_or_default()
    }

    /// The camera that frames a box.
    pub fn camera_for_box(&self, bounds: &Aabb, framing: &Framing) -> Camera {
        Camera { near: self.near, ..framing.camera(bounds) }
    }

    /// Whether the camera is placed so that it frames the model.
    pub fn frames_model(&self) -> bool {
        self.eye.is_none()
    }

    /// The axes of the front view.
    pub fn front(&self) -> CameraBasis {
        self.up_axis().front()
    }

    /// What is nearer is left out.
    pub fn near(&self) -> Option<f64> {
        self.near
    }

    /// Whether the projection is parallel.
    pub fn is_orthographic(&self) -> bool {
        self.orthographic
    }

    /// How much larger the model is shown than without `--zoom`.
    pub fn zoom(&self) -> f64 {
        self.zoom
    }

    /// How the camera is placed for a picture of this size.
    pub fn framing(&self, (width, height): (u32, u32)) -> Framing {
        let mut framing = Framing::new(width, height);
        if let Some(&view) = self.view.first() {
            framing = framing.with_view(view.into());
        }
        framing.up_axis = self.up_axis();
        if let Some(direction) = self.camera_direction {
            let (front, back) = (self.front(), -direction);
            let (right, away, up) = (back.dot(front.right), -back.dot(front.forward), back.dot(front.up));
            framing.azimuth = atan2(right, away).to_degrees();
            framing.elevation = atan2(up, (right * right + away * away).sqrt()).to_degrees();
        }
        framing.azimuth = self.azimuth.unwrap_or(framing.azimuth);
        framing.elevation = self.elevation.unwrap_or(framing.elevation);
        framing.roll = self.roll;
        framing.zoom = self.zoom;
        framing.fov_y = (!self.orthographic).then(|| self.fov.unwrap_or(Framing::FOV_Y));
        framing
    }
}
