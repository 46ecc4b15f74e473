//! How a picture was shaded and lit, for `--stats`. The keys are stable: programs rely on them.

use clap::ValueEnum;
use serde_json::{Value, json};
use tercio::scene::{Background, Light, LightSpace, Scene};

/// The look of a scene whose instances were all given the same surface; colours are linear RGB,
/// those of the background sRGB with alpha.
pub fn scene_json(scene: &Scene, background: &Background) -> Value {
    let surface = scene.instances.first().map(|instance| &instance.surface);
    json!({
        "color": surface.map(|s| numbers(&s.base_color)),
        "mesh_colors": surface.map(|s| s.use_mesh_colors),
        "opacity": surface.map(|s| number(s.opacity)),
        "specular": surface.map(|s| number(s.specular)),
        "roughness": surface.map(|s| number(s.roughness)),
        "metallic": surface.map(|s| number(s.metallic)),
        "lights": scene.lights.iter().map(light_json).collect::<Value>(),
        "background": match background {
            Background::Solid(color) => json!({ "color": numbers(color) }),
            Background::Gradient { top, bottom } => json!({ "top": numbers(top), "bottom": numbers(bottom) }),
        },
    })
}

/// The name of an option's value on the command line.
pub fn name(value: &impl ValueEnum) -> Option<String> {
    value.to_possible_value().map(|value| value.get_name().to_owned())
}

/// A 32-bit number with the digits that tell it from the next ones: 0.3, not 0.30000001192092896.
fn number(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(value.into())
}

/// [`number`] of all.
pub fn numbers(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(number).collect()
}

/// A light with the names of `--light`: directions and positions in the system `space`, angles in degrees.
fn light_json(light: &Light) -> Value {
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
