//! Syntax of a light on the command line.

use std::str::FromStr;

use tercio::glam::DVec3;
use tercio::scene::{Light, LightSpace};

use super::values::{linear_color, positive, vector};

/// One `--light`, which may expand to several lights.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpec(pub Vec<Light>);

/// The help of `--light`.
pub const HELP: &str = "\
A light; may be given several times, and then replaces the default lights:
  ambient:COLOR                from everywhere
  dir:X,Y,Z[:COLOR]            from far away; X,Y,Z points towards the light
  wide:X,Y,Z[:COLOR]           the same from a wide area: soft, without a line between lit and unlit sides
  camera-dir:X,Y,Z[:COLOR]     as dir, moving with the camera (x right, y up, z to the viewer)
  point:X,Y,Z[:COLOR]          from a point in the world
  spot:X,Y,Z:DX,DY,DZ:DEG[:COLOR]
                               from a point X,Y,Z into a cone around the direction DX,DY,DZ, up to DEG degrees from it
  camera-wide:X,Y,Z[:COLOR]    as wide, moving with the camera
  camera-point:X,Y,Z[:COLOR]   as point, moving with the camera
  camera-spot:...              as spot, moving with the camera
  head[:COLOR]                 from the camera
  studio                       the default lights
COLOR is #rrggbb, #rrggbb*STRENGTH or *STRENGTH";

impl FromStr for LightSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').map_or((text, None), |(kind, rest)| (kind, Some(rest)));
        let placed = || {
            let rest = rest.ok_or_else(|| format!("expected {kind}:X,Y,Z[:COLOR]"))?;
            let (place, tint) = rest.split_once(':').map_or((rest, None), |(p, t)| (p, Some(t)));
            Ok::<_, String>((vector(place)?, color(tint)?))
        };
        let directed = || match placed()? {
            (DVec3::ZERO, _) => Err("the direction of a light must not be 0,0,0".to_owned()),
            placed => Ok(placed),
        };
        let directional =
            |space| directed().map(|(to_light, color)| Light::Directional { to_light, space, color });
        let wide = |space| {
            directed().map(|(to_light, color)| Light::Wide { to_light, space, color, highlight: true })
        };
        let point = |space| placed().map(|(position, color)| Light::Point { position, space, color });
        let spot = |space| spot(kind, rest.unwrap_or_default(), space);
        let light = match (kind, rest) {
            ("studio", None) => return Ok(Self(Light::studio())),
            ("ambient", Some(tint)) => Light::Ambient { color: color(Some(tint))? },
            ("head", tint) => Light::headlight(color(tint)?),
            ("dir", _) => directional(LightSpace::World)?,
            ("camera-dir", _) => directional(LightSpace::Camera)?,
            ("wide", _) => wide(LightSpace::World)?,
            ("camera-wide", _) => wide(LightSpace::Camera)?,
            ("point", _) => point(LightSpace::World)?,
            ("camera-point", _) => point(LightSpace::Camera)?,
            ("spot", _) => spot(LightSpace::World)?,
            ("camera-spot", _) => spot(LightSpace::Camera)?,
            _ => {
                return Err(
                    "expected ambient:COLOR, dir:X,Y,Z, wide:X,Y,Z, point:X,Y,Z, spot:X,Y,Z:DX,DY,DZ:DEG, \
                            any of these but ambient with camera- before, head or studio"
                        .into(),
                );
            }
        };
        Ok(Self(vec![light]))
    }
}

/// `X,Y,Z:DX,DY,DZ:DEG[:COLOR]`.
fn spot(kind: &str, text: &str, space: LightSpace) -> Result<Light, String> {
    let fields: Vec<&str> = text.splitn(4, ':').collect();
    let &[position, direction, degrees, ..] = &fields[..] else {
        return Err(format!("expected {kind}:X,Y,Z:DX,DY,DZ:DEG[:COLOR]"));
    };
    let (position, direction) = (vector(position)?, vector(direction)?);
    if direction == DVec3::ZERO {
        return Err("the direction of a light must not be 0,0,0".into());
    }
    let angle = positive(degrees)?.to_radians();
    if angle >= std::f64::consts::FRAC_PI_2 {
        return Err("the angle of a spot light must be below 90 degrees".into());
    }
    Ok(Light::Spot { position, direction, space, angle, color: color(fields.get(3).copied())? })
}

/// `#rrggbb`, `#rrggbb*k` or `*k`; white by default.
fn color(text: Option<&str>) -> Result<[f32; 3], String> {
    let Some(text) = text else { return Ok([1.0; 3]) };
    let (tint, strength) = text.split_once('*').map_or((text, None), |(t, s)| (t, Some(s)));
    let tint = if tint.is_empty() && strength.is_some() { [1.0; 3] } else { linear_color(tint)? };
    let strength = strength.map_or(Ok(1.0), positive)? as f32;
    Ok(tint.map(|v| v * strength))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_light() {
        let one = |text: &str| text.parse::<LightSpec>().unwrap().0.remove(0);
        assert_eq!(one("ambient:#fff*0.5"), Light::Ambient { color: [0.5; 3] });
        assert_eq!(one("head"), Light::headlight([1.0; 3]));
        assert_eq!(one("head:*2"), Light::headlight([2.0; 3]));
        let (to_light, space) = (DVec3::new(0.0, 1.0, -2.0), LightSpace::World);
        let red = [1.0, 0.0, 0.0];
        assert_eq!(one("dir:0,1,-2:#f00"), Light::Directional { to_light, space, color: red });
        let wide = Light::Wide { to_light, space, color: [1.0; 3], highlight: true };
        assert_eq!(one("wide:0,1,-2"), wide);
        let space = LightSpace::Camera;
        assert_eq!(one("camera-point:0,1,-2"), Light::Point { position: to_light, space, color: [1.0; 3] });
        assert_eq!("studio".parse::<LightSpec>().unwrap().0, Light::studio());
        let (position, direction) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, -1.0, 0.0));
        let (space, angle) = (LightSpace::World, 30f64.to_radians());
        let spot = Light::Spot { position, direction, space, angle, color: red };
        assert_eq!(one("spot:1,2,3:0,-1,0:30:#f00"), spot);
        let spot = Light::Spot { position, direction, space: LightSpace::Camera, angle, color: [1.0; 3] };
        assert_eq!(one("camera-spot:1,2,3:0,-1,0:30"), spot);
    }

    #[test]
    fn nonsense_is_refused() {
        for bad in [
            "",
            "sun",
            "ambient",
            "dir",
            "dir:0,0,0",
            "dir:1,2",
            "point:1,2,3:bluish",
            "head:*-1",
            "head:*",
            "spot:1,2,3",
            "spot:1,2,3:0,0,0:30",
            "spot:1,2,3:0,0,1:90",
            "spot:1,2,3:0,0,1:0",
        ] {
            assert!(bad.parse::<LightSpec>().is_err(), "{bad}");
        }
    }
}
