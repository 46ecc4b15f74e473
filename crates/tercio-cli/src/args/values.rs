//! Syntax of sizes, colours, points and amounts of memory on the command line.

use clap::ValueEnum;
use tercio::glam::DVec3;
use tercio::scene::{Background, srgb_to_linear};

/// Limits of the zoom: below, an angle of view of 179 degrees would reach 180; above, pixels would be finer than the
/// precision of positions.
const ZOOM: (f64, f64) = (0.001, 1e6);

/// Squares of coordinates must not overflow.
const FARTHEST: f64 = 1e100;

/// The name of an option's value on the command line.
pub fn name(value: &impl ValueEnum) -> Option<String> {
    value.to_possible_value().map(|value| value.get_name().to_owned())
}

/// `WxH` or `W,H`, pixels.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let part = |s: &str| s.parse().ok().filter(|n| (1..=tercio::raster::settings::MAX_SIZE).contains(n));
    text.split_once(['x', 'X', ','])
        .and_then(|(w, h)| Some((part(w)?, part(h)?)))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT, 1 to {} each", tercio::raster::settings::MAX_SIZE))
}

/// `x,y,z`.
pub fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> =
        text.split(',').map_while(|s| s.trim().parse().ok()).filter(|v: &f64| v.is_finite()).collect();
    match (numbers[..].try_into().map(DVec3::from_array), text.split(',').count()) {
        (Ok(v), 3) if v.abs().max_element() <= FARTHEST => Ok(v),
        (Ok(_), 3) => Err(format!("expected numbers of at most {FARTHEST:e}")),
        _ => Err("expected three numbers: x,y,z".into()),
    }
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| "expected a number".into())
}

/// A finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|&v| v > 0.0).ok_or_else(|| "expected a number above 0".into())
}

/// A finite number, 0 or more.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|&v| v >= 0.0).ok_or_else(|| "expected a number, 0 or more".into())
}

/// A share of 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    let share = number(text).ok().filter(|v| (0.0..=1.0).contains(v));
    share.ok_or_else(|| "expected a number of 0 to 1".into())
}

/// An opacity.
pub fn opacity(text: &str) -> Result<f64, String> {
    share(text).map_err(|_| "expected a number of 0 (invisible) to 1 (opaque)".into())
}

/// A difference in steps of 8-bit components; fractions are allowed.
pub fn steps(text: &str) -> Result<f64, String> {
    let steps = number(text).ok().filter(|v| (0.0..=255.0).contains(v));
    steps.ok_or_else(|| "expected a number of 0 to 255, the largest difference that there is".into())
}

/// A factor by which a model is shown larger or smaller.
pub fn zoom(text: &str) -> Result<f64, String> {
    let zoom = number(text).ok().filter(|v| (ZOOM.0..=ZOOM.1).contains(v));
    zoom.ok_or_else(|| format!("expected a factor of {} to {}", ZOOM.0, ZOOM.1))
}

/// An angle of view in degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    let degrees = number(text).ok().filter(|v| (0.01..=179.0).contains(v));
    degrees.ok_or_else(|| "expected an angle of 0.01 to 179 degrees".into())
}

/// A crease angle in degrees.
pub fn crease_angle(text: &str) -> Result<f64, String> {
    let degrees = number(text).ok().filter(|v| (0.0..=180.0).contains(v));
    degrees.ok_or_else(|| "expected an angle of 0 to 180 degrees".into())
}

/// An amount of memory: `2G` is 2,000,000,000 bytes, `2Gi` is 2^31.
pub fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let unit = unit.trim().to_ascii_lowercase();
    let unit = unit.strip_suffix('b').unwrap_or(&unit);
    let factor: u64 = match unit {
        "" => 1,
        "k" => 1000,
        "m" => 1_000_000,
        "g" => 1_000_000_000,
        "t" => 1_000_000_000_000,
        "ki" => 1 << 10,
        "mi" => 1 << 20,
        "gi" => 1 << 30,
        "ti" => 1 << 40,
        _ => 0,
    };
    let number = number.parse().ok().filter(|n: &f64| factor > 0 && n * factor as f64 <= 1e18);
    let bytes = number.map(|n| (n * factor as f64) as u64).filter(|&b| b > 0);
    bytes.ok_or_else(|| "expected an amount of memory such as 500M, 2G or 2Gi".into())
}

/// `#rrggbb`, `#rgb` or `#rrggbbaa`; shells may read a leading # as a comment, so it may be omitted.
fn hex(text: &str) -> Option<[u8; 4]> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let values: Vec<u8> = digits.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect::<Option<_>>()?;
    match values[..] {
        [r, g, b] => Some([r * 17, g * 17, b * 17, 255]),
        [a, b, c, d, e, f] => Some([a * 16 + b, c * 16 + d, e * 16 + f, 255]),
        [a, b, c, d, e, f, g, h] => Some([a * 16 + b, c * 16 + d, e * 16 + f, g * 16 + h]),
        _ => None,
    }
}

/// `r,g,b`, shares of 0 to 1 of sRGB's components: colours of F3D, of which some options are known here.
fn shares(text: &str) -> Option<[u8; 4]> {
    let shares: Vec<f64> = text.split(',').map(|word| share(word.trim()).ok()).collect::<Option<_>>()?;
    let [r, g, b]: [f64; 3] = shares.try_into().ok()?;
    let byte = |v: f64| (v * 255.0).round() as u8;
    Some([byte(r), byte(g), byte(b), 255])
}

/// A colour as in CSS: hexadecimal, by name, `rgb(...)`, `hsl(...)` and so on; or three numbers of 0 to 1.
pub fn color(text: &str) -> Result<[u8; 4], String> {
    let css = || csscolorparser::parse(text).ok().map(|color| color.to_rgba8());
    hex(text).or_else(|| shares(text)).or_else(css).ok_or_else(|| {
        format!(
            "expected a colour such as #c0ffee, white, rgb(255, 128, 0) or 1,0.5,0 (of 0 to 1), found \"{text}\""
        )
    })
}

/// The parts of a text between the commas that are not in brackets.
pub fn between_commas(text: &str) -> Vec<&str> {
    let mut depth = 0i32;
    let is_comma = |c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth <= 0
    };
    text.split(is_comma).map(str::trim).collect()
}

/// An opaque sRGB colour, as linear light.
pub fn linear_color(text: &str) -> Result<[f32; 3], String> {
    let [r, g, b, alpha] = color(text)?;
    if alpha < 255 {
        return Err(format!("expected an opaque colour, found \"{text}\""));
    }
    Ok([r, g, b].map(|v| srgb_to_linear(f64::from(v) / 255.0) as f32))
}

/// A colour, two colours with a comma between them (upper and lower border), or `transparent`. Three numbers with commas are one
/// colour.
pub fn background(text: &str) -> Result<Background, String> {
    if text == "transparent" {
        return Ok(Background::Solid([0.0; 4]));
    }
    let color = |s: &str| color(s).map(|c| c.map(|v| f32::from(v) / 255.0));
    match between_commas(text)[..] {
        [one] => Ok(Background::Solid(color(one)?)),
        [top, bottom] => Ok(Background::Gradient { top: color(top)?, bottom: color(bottom)? }),
        [_, _, _] if shares(text).is_some() => Ok(Background::Solid(color(text)?)),
        _ => Err(
            "expected one colour (white, #c0ffee, or 1,0.5,0 of 0 to 1), or two for a gradient: TOP,BOTTOM"
                .into(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for bad in ["", "640", "640x", "0x1", "1x99999", "-1x5", "640*480", "4294967297x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn vectors() {
        assert_eq!(vector("1,-2.5,3e2"), Ok(DVec3::new(1.0, -2.5, 300.0)));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,inf", "1,2,3,x", "-1e101,0,0"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn amounts_of_memory() {
        assert_eq!(bytes("2G"), Ok(2_000_000_000));
        assert_eq!(bytes("1.5Gi"), Ok(3 << 29));
        assert_eq!(bytes("64kB"), Ok(64_000));
        assert_eq!(bytes("123"), Ok(123));
        for bad in ["", "G", "-1", "2X", "0", "1e3", "99999999T", "1.2.3M"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn colors() {
        assert_eq!(linear_color("#ffffff"), Ok([1.0; 3]));
        assert_eq!(linear_color("000"), Ok([0.0; 3]));
        assert_eq!(linear_color("white"), linear_color("#fff"));
        assert_eq!(linear_color("SteelBlue"), linear_color("#4682b4"));
        assert_eq!(linear_color("rgb(255, 128, 0)"), linear_color("ff8000"));
        assert_eq!(linear_color("0.2,0.4,1"), linear_color("#3366ff"));
        assert_eq!(linear_color("1, 1, 1"), linear_color("white"));
        assert_eq!(color("0,0,0"), Ok([0, 0, 0, 255]));
        assert!((linear_color("#808080").unwrap()[0] - 0.2158605).abs() < 1e-6);
        let bad_shares = ["1,1", "1,1,1,1", "1,1,2", "0.1,0.2,-0.3", "1,1,", "255,128,0", "nan,0,0"];
        let bad =
            ["", "#", "#12", "#ggg", "#fffffff", "#ffffff80", "reddish", "ééé", "rgb(1,2", "rgba(1,2,3,0.5)"];
        for bad in bad.into_iter().chain(bad_shares) {
            assert!(linear_color(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn backgrounds() {
        assert_eq!(background("transparent"), Ok(Background::Solid([0.0; 4])));
        assert_eq!(background("#fff"), Ok(Background::Solid([1.0; 4])));
        let gradient = Background::Gradient { top: [1.0; 4], bottom: [0.0, 0.0, 0.0, 0.0] };
        assert_eq!(background("#ffffff,#00000000"), Ok(gradient));
        assert_eq!(background("white,rgba(0,0,0,0)"), Ok(gradient));
        assert_eq!(background("1,1,1"), Ok(Background::Solid([1.0; 4])));
        let gradient = Background::Gradient { top: [0.0, 0.0, 0.0, 1.0], bottom: [1.0; 4] };
        assert_eq!(background("000,fff"), Ok(gradient));
        assert!(background("1,1,2").is_err() && background("1,1,1,white").is_err());
        assert!(background("#fff,").is_err() && background("red,green,blue").is_err());
    }
}
