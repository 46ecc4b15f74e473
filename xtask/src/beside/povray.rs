//! A scene in the language of POV-Ray, set so that it computes light as tercio does.
//!
//! * All colours are linear (`assumed_gamma 1`), and so is the picture that it writes (`File_Gamma=1`).
//! * `diffuse 1`, `brilliance 1` and `ambient 1` are Lambert's law and the ambient light of tercio. `specular` with
//!   `roughness` 1 / n is the highlight of tercio with the exponent n: a power of the cosine between the normal and the
//!   middle between light and viewer, in the colour of the light.
//! * Lights do not fade with distance. A spot light fades by the same polynomial from `falloff`, the edge of the cone,
//!   to `radius`, if `tightness` is 0.
//! * Its camera is given by its axes, which makes it independent of the handedness of the coordinates.
//! * Every pixel is the mean of 4 x 4 rays or more, taken here in linear light: POV-Ray draws a larger picture,
//!   without its own anti-aliasing.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, ensure};
use glam::DVec3;
use tercio_mesh::Mesh;
use tercio_scene::{Light, LightSpace, Projection, srgb_to_linear};

use super::SIZE;
use super::measure::Rays;
use super::scenes::{Files, Scene};
use crate::process;

/// Share of the way from the edge of a spot light's cone to its middle, as cosines, on which tercio lets it fade.
const FADE: f64 = 0.2;

/// Name and version.
///
/// # Errors
/// It is not installed.
pub fn version() -> Result<String> {
    // It writes all its text to standard error.
    let output = Command::new("povray").arg("--version").stdin(Stdio::null()).output()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = text.lines().find(|line| line.starts_with("POV-Ray"));
    Ok(line.context("povray --version names no version")?.trim().to_owned())
}

/// Draws a scene with POV-Ray.
///
/// # Errors
/// It fails.
pub fn draw(scene: &Scene, files: &Files) -> Result<Rays> {
    let (source, picture) = (files.stem.with_extension("pov"), files.stem.with_extension("ppm"));
    std::fs::write(&source, describe(scene, files)?)?;
    let folder = source.parent().context("the folder of the scenes")?;
    let mut command = Command::new("povray");
    command.current_dir(folder).arg(format!("+I{}", file_name(&source)?));
    command.arg(format!("+O{}", file_name(&picture)?)).args([
        "+FP16",
        "File_Gamma=1.0",
        "-A",
        "-D",
        "-GD",
        "-GR",
        "-GS",
        "-GW",
    ]);
    command.args([format!("+W{}", SIZE.0 * scene.rays), format!("+H{}", SIZE.1 * scene.rays)]);
    process::show(&command);
    let output = command.stdin(Stdio::null()).output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    // Its credits and settings are pages.
    let reasons: Vec<_> = text.lines().filter(|line| line.contains("rror")).collect();
    ensure!(output.status.success(), "povray failed ({}): {}", output.status, reasons.join("; "));
    Rays::read(&picture, scene.rays)
}

fn file_name(path: &Path) -> Result<&str> {
    path.file_name().and_then(|name| name.to_str()).context("a file name in UTF-8")
}

fn describe(scene: &Scene, files: &Files) -> Result<String> {
    let mut text = String::from("#version 3.7;\n");
    let ambient = scene.lights.iter().map(|l| match l {
        Light::Ambient { color } => color.map(f64::from),
        _ => [0.0; 3],
    });
    let ambient = ambient.fold(DVec3::ZERO, |sum, color| sum + DVec3::from(color));
    // Rays through many layers must not end early.
    let settings = "assumed_gamma 1 max_trace_level 200 adc_bailout 0";
    let _ = writeln!(text, "global_settings {{ {settings} ambient_light rgb {} }}", vector(ambient));
    let _ = writeln!(text, "background {{ rgb {} }}", vector(linear(scene.background)));
    camera(scene, &mut text)?;
    for light in &scene.lights {
        self::light(scene, light, &mut text)?;
    }
    let look = format!(
        "finish {{ ambient 1 diffuse 1 brilliance 1 phong 0 specular {} roughness {} }}",
        scene.specular,
        1.0 / Scene::SHININESS
    );
    let pigment = |color: [u8; 3]| {
        let transmit = 1.0 - scene.opacity;
        format!("texture {{ pigment {{ rgb {} transmit {transmit} }} {look} }}", vector(linear(color)))
    };
    let texture = match &scene.texture {
        Some(_) => {
            let file = format!("{}-texture.png", file_name(&files.stem)?);
            let pigment = format!("uv_mapping image_map {{ png \"{file}\" gamma srgb }}");
            format!("texture {{ pigment {{ {pigment} }} {look} }}")
        }
        None => pigment(scene.color),
    };
    // Not a light without shadows: those have no highlights.
    let shadow = if scene.has_shadows { "" } else { "no_shadow" };
    match &scene.clip {
        None => {
            mesh(&scene.mesh, scene.is_flat, &mut text);
            let _ = writeln!(text, "{texture} {shadow} }}");
        }
        Some((normal, distance, cap)) => {
            text += "intersection {\n";
            mesh(&scene.mesh, scene.is_flat, &mut text);
            let _ = writeln!(text, "inside_vector <0.31, 0.87, 0.23> {texture} }}");
            // The inside of a plane is behind its normal, at most this far from 0.
            let (normal, distance) = (vector(-*normal), distance / normal.length());
            let _ = writeln!(text, "plane {{ {normal}, {distance} {} }}\n{shadow} }}", pigment(*cap));
        }
    }
    Ok(text)
}

fn camera(scene: &Scene, text: &mut String) -> Result<()> {
    let camera = &scene.camera;
    let basis = camera.basis()?;
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    let (kind, height) = match camera.projection {
        Projection::Perspective { fov_y } => ("perspective", 2.0 * (fov_y * 0.5).tan()),
        Projection::Orthographic { height } => ("orthographic", height),
    };
    let (right, up) = (basis.right * (height * aspect), basis.up * height);
    let [eye, direction, right, up] = [camera.eye, basis.forward, right, up].map(vector);
    let _ = writeln!(text, "camera {{ {kind} location {eye} direction {direction} right {right} up {up} }}");
    Ok(())
}

fn light(scene: &Scene, light: &Light, text: &mut String) -> Result<()> {
    let basis = scene.camera.basis()?;
    let turned = |v: DVec3, space| match space {
        LightSpace::World => v,
        LightSpace::Camera => basis.right * v.x + basis.up * v.y - basis.forward * v.z,
    };
    let place = |p: DVec3, space| match space {
        LightSpace::World => p,
        LightSpace::Camera => scene.camera.eye + turned(p, space),
    };
    let rgb = |color: [f32; 3]| vector(color.map(f64::from).into());
    let bounds = scene.mesh.bounds();
    let _ = match *light {
        Light::Ambient { .. } | Light::Wide { .. } => return Ok(()),
        Light::Directional { to_light, space, color } => {
            let far = turned(to_light, space).normalize() * (20.0 * bounds.radius());
            let (from, to) = (vector(bounds.center() + far), vector(bounds.center()));
            writeln!(text, "light_source {{ {from} rgb {} parallel point_at {to} }}", rgb(color))
        }
        Light::Point { position, space, color } => {
            writeln!(text, "light_source {{ {} rgb {} }}", vector(place(position, space)), rgb(color))
        }
        Light::Spot { position, direction, space, angle, color } => {
            let from = place(position, space);
            let to = vector(from + turned(direction, space));
            let full = (angle.cos() + FADE * (1.0 - angle.cos())).acos().to_degrees();
            let (from, edge) = (vector(from), angle.to_degrees());
            let cone = format!("spotlight point_at {to} radius {full} falloff {edge} tightness 0");
            writeln!(text, "light_source {{ {from} rgb {} {cone} }}", rgb(color))
        }
    };
    Ok(())
}

/// A mesh, up to its texture and closing brace.
fn mesh(mesh: &Mesh, is_flat: bool, text: &mut String) {
    let list = |name: &str, items: Vec<String>, text: &mut String| {
        let _ = writeln!(text, "{name} {{ {},\n{} }}", items.len(), items.join(",\n"));
    };
    let three = |v: [f32; 3]| format!("<{},{},{}>", v[0], v[1], v[2]);
    text.push_str("mesh2 {\n");
    let origin = mesh.origin.as_vec3();
    let place = |p: &[f32; 3]| three((origin + glam::Vec3::from(*p)).to_array());
    list("vertex_vectors", mesh.positions.iter().map(place).collect(), text);
    if let Some(normals) = mesh.normals.as_ref().filter(|_| !is_flat) {
        list("normal_vectors", normals.iter().map(|n| three(n.decode())).collect(), text);
    }
    if let Some(texcoords) = &mesh.texcoords {
        list("uv_vectors", texcoords.iter().map(|[u, v]| format!("<{u},{v}>")).collect(), text);
    }
    let corners = |t: &[u32; 3]| format!("<{},{},{}>", t[0], t[1], t[2]);
    list("face_indices", mesh.triangles.iter().map(corners).collect(), text);
}

fn vector(v: DVec3) -> String {
    format!("<{},{},{}>", v.x, v.y, v.z)
}

fn linear(color: [u8; 3]) -> DVec3 {
    DVec3::from(color.map(|c| srgb_to_linear(f64::from(c) / 255.0)))
}
