//! Options that cut a part of the model away.

use std::sync::Arc;

use clap::Args;
use tercio::glam::DVec3;
use tercio::mesh::clip::{Axis, Clip, ClipPlane};
use tercio::scene::Instance;
use tercio::{Clipping, ClusteredMesh};

use super::values;

/// The colour of caps if none is given: unlike the default colour of models, and as bright.
const CAP_COLOR: &str = "#c8553d";

const HELP: &str = "\
Cuts the model at a plane; may be given several times, then what is on the right side of all planes is left.

  X,Y,Z,D     keeps the points x, y, z with X*x + Y*y + Z*z + D >= 0, in the coordinates of the file: those to which \
the normal X,Y,Z points, as VTK and ParaView do (ParaView's filter inverts that by default)
  AXIS:PART   a plane across the axis x, y or z, at a part of the model's bounds from 0 to 1, or 0 % to 100 %; keeps \
the side of the higher coordinates: x:0.25, z:40%
  -AXIS:PART  the same plane; keeps the side of the lower coordinates: -x:0.25

The camera frames the whole model, so that pictures of different cuts fit. Triangles are cut, before anything is drawn: \
the cut is exact. A model from `tercio prepare` cannot be cut.";

/// Where the model is cut.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Clipping")]
pub struct ClipArgs {
    /// Cuts the model at a plane X,Y,Z,D, or at a part of its bounds, such as x:0.5 or -z:40%; --help has more.
    #[arg(long = "clip", value_name = "PLANE", allow_hyphen_values = true, value_parser = clip, long_help = HELP)]
    planes: Vec<Clip>,
    /// Closes the cut of closed models, in a colour. Outlines that are not closed, because the model is not, stay
    /// open; a warning counts them. The faces of the caps are numbered behind those of the whole model.
    #[arg(long, value_name = "COLOR", num_args = 0..=1, default_missing_value = CAP_COLOR, require_equals = true)]
    #[arg(requires = "planes", value_parser = values::linear_color)]
    clip_cap: Option<[f32; 3]>,
}

impl ClipArgs {
    /// For the options of loading.
    pub fn clipping(&self) -> Option<Clipping<'_>> {
        let clipping = Clipping { planes: &self.planes, caps: self.clip_cap.is_some() };
        (!self.planes.is_empty()).then_some(clipping)
    }

    /// The caps of a model: they have the surface of its instance, in their own colour, and its place.
    pub fn caps(&self, model: &Instance, caps: Option<Arc<ClusteredMesh>>) -> Option<Instance> {
        let (base_color, caps) = (self.clip_cap?, caps?);
        let mut instance = Instance::new(caps);
        (instance.surface, instance.world_from_object) = (model.surface, model.world_from_object);
        (instance.surface.base_color, instance.surface.use_mesh_colors) = (base_color, false);
        Some(instance)
    }
}

/// `X,Y,Z,D`, `AXIS:PART` or `-AXIS:PART`.
fn clip(text: &str) -> Result<Clip, String> {
    if let Some((axis, part)) = text.split_once(':') {
        return fraction(axis.trim(), part.trim());
    }
    let numbers: Vec<f64> = text.split(',').map_while(|s| s.trim().parse().ok()).collect();
    match (<[f64; 4]>::try_from(numbers), text.split(',').count()) {
        (Ok([x, y, z, d]), 4) => ClipPlane::new(DVec3::new(x, y, z), d).map(Clip::Plane).ok_or_else(|| {
            format!(
                "expected a normal X,Y,Z that is not zero, and numbers of at most {:e}",
                ClipPlane::LARGEST
            )
        }),
        _ => Err("expected a plane X,Y,Z,D, or a part of the bounds such as x:0.5 or -z:40%".into()),
    }
}

fn fraction(axis: &str, part: &str) -> Result<Clip, String> {
    let (name, keeps_lower) = match axis.strip_prefix('-') {
        Some(name) => (name, true),
        None => (axis.strip_prefix('+').unwrap_or(axis), false),
    };
    let axis = match name {
        "x" | "X" => Axis::X,
        "y" | "Y" => Axis::Y,
        "z" | "Z" => Axis::Z,
        _ => return Err(format!("expected x, y or z before the colon, found \"{name}\"")),
    };
    let number = match part.strip_suffix('%') {
        Some(percent) => percent.trim_end().parse().map(|p: f64| p / 100.0),
        None => part.parse(),
    };
    let fraction = number.ok().filter(|f| (0.0..=1.0).contains(f));
    let fraction =
        fraction.ok_or_else(|| format!("expected a part of 0 to 1, or 0% to 100%, found \"{part}\""))?;
    Ok(Clip::Fraction { axis, fraction, keeps_lower })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes() {
        let plane = |x, y, z, d| Ok(Clip::Plane(ClipPlane::new(DVec3::new(x, y, z), d).expect("a plane")));
        assert_eq!(clip("1,0,0,-0.5"), plane(1.0, 0.0, 0.0, -0.5));
        assert_eq!(clip("-1, 2e3,0 ,7"), plane(-1.0, 2e3, 0.0, 7.0));
        let part = |axis, fraction, keeps_lower| Ok(Clip::Fraction { axis, fraction, keeps_lower });
        assert_eq!(clip("x:0.5"), part(Axis::X, 0.5, false));
        assert_eq!(clip("+Y:0"), part(Axis::Y, 0.0, false));
        assert_eq!(clip("-z:40%"), part(Axis::Z, 0.4, true));
        for bad in [
            "",
            "1,0,0",
            "1,0,0,0,0",
            "0,0,0,0",
            "0,0,0,1",
            "nan,0,0,1",
            "1,0,0,inf",
            "1,0,0,x",
            "1e300,0,0,0",
            "w:0.5",
            "x:",
            "x:-0.1",
            "x:1.5",
            "x:101%",
            "x:nan",
            "--x:0.5",
            ":0.5",
            "x=0.5",
        ] {
            assert!(clip(bad).is_err(), "{bad}");
        }
    }
}
