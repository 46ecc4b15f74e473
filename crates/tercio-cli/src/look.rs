//! Values of the look of a picture, for `--stats`. The keys are stable: programs rely on them.

use serde_json::{Value, json};
use tercio::scene::{Background, Light, LightSpace};

/// A 32-bit number with the digits that tell it from the next ones: 0.3, not 0.30000001192092896.
pub fn number(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(value.into())
}

/// [`number`] of all.
pub fn numbers(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(number).collect()
}

/// Colours in sRGB with alpha.
pub fn background_json(background: &Background) -> Value {
    match background {
        Background::Solid(color) => json!({ "color": numbers(color) }),
        Background::Gradient { top, bottom } => json!({ "top": numbers(top), "bottom": numbers(bottom) }),
    }
}

/// A light with the names of `--light`: its colour in linear RGB, directions and positions in the system `space`, angles in degrees.
pub fn light_json(light: &Light) -> Value {
    let space = |space: &LightSpace| match space {
        LightSpace::World => "world",
        LightSpace::Camera => "camera",
    };
    match light {
        Light::Ambient { color } => json!({ "kind": "ambient", "color": numbers(color) }),
        Light::Directional { to_light, space: s, color } => json!({
            "kind": "directional", "to_light": to_light.to_array(), "space": space(s), "color": numbers(color),
        }),
        Light::Wide { to_light, space: s, color, highlight } => json!({
            "kind": "wide", "to_light": to_light.to_array(), "space": space(s), "color": numbers(color),
            "highlight": highlight,
        }),
        Light::Point { position, space: s, color } => json!({
            "kind": "point", "position": position.to_array(), "space": space(s), "color": numbers(color),
        }),
        Light::Spot { position, direction, space: s, angle, color } => json!({
            "kind": "spot", "position": position.to_array(), "direction": direction.to_array(),
            "space": space(s), "angle": angle.to_degrees(), "color": numbers(color),
        }),
    }
}
