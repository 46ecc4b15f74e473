//! A scene as a command line of tercio.

use std::path::Path;
use std::process::Command;

use anyhow::Result;
use glam::DVec3;
use tercio_scene::{Light, LightSpace, Projection};
use tercio_testkit::Picture;

use super::SIZE;
use super::scenes::{Files, Scene};
use crate::process;

/// Draws a scene with tercio.
///
/// # Errors
/// The program fails.
pub fn draw(program: &Path, scene: &Scene, files: &Files) -> Result<Picture> {
    let picture = files.stem.with_extension("tercio.png");
    let mut command = Command::new(program);
    command.arg("render").arg(&files.mesh).arg("-o").arg(&picture).args(arguments(scene)).arg("--quiet");
    process::run(&mut command)?;
    Ok(Picture::read(&picture)?)
}

/// Everything but the files.
fn arguments(scene: &Scene) -> Vec<String> {
    // As many samples as the ray tracer has rays, so that edges are as smooth.
    let mut all = vec![format!("--size={}x{}", SIZE.0, SIZE.1), "--aa=16".into()];
    let camera = &scene.camera;
    all.push(format!("--eye={}", vector(camera.eye)));
    all.push(format!("--target={}", vector(camera.target)));
    all.push(format!("--up={}", vector(camera.up)));
    match camera.projection {
        Projection::Perspective { fov_y } => all.push(format!("--fov={}", fov_y.to_degrees())),
        Projection::Orthographic { height } => {
            // Without a zoom the picture shows what a perspective camera would show of the target's plane.
            let seen = 2.0 * camera.eye.distance(camera.target) * 15_f64.to_radians().tan();
            all.extend(["--orthographic".into(), format!("--zoom={}", seen / height)]);
        }
    }
    all.extend(scene.lights.iter().map(|l| format!("--light={}", light(l))));
    all.push(format!("--background={}", hex(scene.background)));
    all.push(format!("--specular={}", scene.specular));
    match &scene.texture {
        Some(_) => all.push("--texture-alpha=cutout".into()),
        None => all.push(format!("--color={}", hex(scene.color))),
    }
    if scene.opacity < 1.0 {
        all.push(format!("--opacity={}", scene.opacity));
    }
    if scene.has_shadows {
        all.push("--shadows".into());
    }
    if scene.is_flat {
        all.push("--shading=flat".into());
    }
    if let Some((normal, distance, cap)) = &scene.clip {
        all.push(format!("--clip={},{distance}", vector(*normal)));
        all.push(format!("--clip-cap={}", hex(*cap)));
    }
    all
}

fn light(light: &Light) -> String {
    let name = |name: &str, space| match space {
        LightSpace::World => name.to_owned(),
        LightSpace::Camera => format!("camera-{name}"),
    };
    match *light {
        Light::Ambient { color } => format!("ambient:{}", linear(color)),
        Light::Directional { to_light, space, color } => {
            format!("{}:{}:{}", name("dir", space), vector(to_light), linear(color))
        }
        Light::Point { position, space, color } => {
            format!("{}:{}:{}", name("point", space), vector(position), linear(color))
        }
        Light::Spot { position, direction, space, angle, color } => format!(
            "{}:{}:{}:{}:{}",
            name("spot", space),
            vector(position),
            vector(direction),
            angle.to_degrees(),
            linear(color)
        ),
        Light::Wide { .. } => unreachable!("no ray tracer has them"),
    }
}

fn vector(v: DVec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A linear colour as an sRGB colour, whose largest component is 255, and a strength: the inverse of `tinted` of the
/// scenes.
fn linear(color: [f32; 3]) -> String {
    let strength = color.into_iter().fold(0.0, f32::max);
    format!("{}*{strength}", hex(color.map(|c| super::level(f64::from(c / strength)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beside::scenes::SCENES;

    #[test]
    fn colors_of_lights_can_be_written() {
        let lights = SCENES.iter().flat_map(|(_, make)| make().lights);
        for light in lights {
            let (Light::Ambient { color }
            | Light::Directional { color, .. }
            | Light::Point { color, .. }
            | Light::Spot { color, .. }
            | Light::Wide { color, .. }) = light;
            let text = linear(color);
            let (tint, strength) = text.split_once('*').expect("a strength");
            let strength: f32 = strength.parse().expect("a number");
            for (k, color) in color.into_iter().enumerate() {
                let level = u8::from_str_radix(&tint[1 + 2 * k..3 + 2 * k], 16).expect("two digits");
                let back = tercio_scene::srgb_to_linear(f64::from(level) / 255.0) as f32 * strength;
                assert!((back - color).abs() < 1e-6, "{text}");
            }
        }
    }
}
