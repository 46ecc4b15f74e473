//! What both programs draw.

use std::path::{Path, PathBuf};

use anyhow::Result;
use glam::DVec3;
use tercio_mesh::Mesh;
use tercio_scene::{Camera, Framing, Light, LightSpace, View, srgb_to_linear};
use tercio_testkit::Picture;

use super::{SIZE, meshes};
use crate::models::formats;

/// A scene.
pub struct Scene {
    /// Its description in the table.
    pub title: &'static str,
    /// Whether its picture is in the documentation.
    pub is_shown: bool,
    /// Rays of the ray tracer along the edge of a pixel.
    pub rays: u32,
    pub mesh: Mesh,
    /// The texture of the whole mesh, which has texture coordinates then. What is not opaque in it is invisible.
    pub texture: Option<Picture>,
    pub camera: Camera,
    pub lights: Vec<Light>,
    pub has_shadows: bool,
    /// sRGB.
    pub color: [u8; 3],
    /// sRGB.
    pub background: [u8; 3],
    /// Strength of the highlight, whose exponent is [`Scene::SHININESS`].
    pub specular: f32,
    pub opacity: f32,
    /// One normal a triangle instead of interpolated ones.
    pub is_flat: bool,
    /// A plane, and the colour of the cap in sRGB.
    pub clip: Option<(DVec3, f64, [u8; 3])>,
}

/// The files of a scene.
pub struct Files {
    /// The mesh, as tercio reads it.
    pub mesh: PathBuf,
    /// The beginning of the names of all other files.
    pub stem: PathBuf,
}

type Maker = fn() -> Scene;

/// All scenes by name.
pub const SCENES: [(&str, Maker); 13] = [
    ("highlights", highlights),
    ("facets", facets),
    ("lamp-at-the-camera", lamp_at_the_camera),
    ("sun", sun),
    ("lamp", lamp),
    ("spot", spot),
    ("wide-spot", wide_spot),
    ("low-sun", low_sun),
    ("opacity", opacity),
    ("floor", floor),
    ("cap", cap),
    ("lamp-inside", lamp_inside),
    ("fence", fence),
];

impl Scene {
    /// Exponent of highlights: that of tercio's default surface.
    pub const SHININESS: f64 = 32.0;

    fn new(title: &'static str, mesh: Mesh, azimuth: f64, elevation: f64) -> Self {
        let framing = Framing { azimuth, elevation, ..Framing::new(SIZE.0, SIZE.1) };
        Self {
            title,
            is_shown: true,
            rays: 4,
            camera: framing.camera(&mesh.bounds()),
            mesh,
            texture: None,
            lights: vec![ambient(0.1)],
            has_shadows: false,
            color: [200, 180, 150],
            background: [40, 48, 60],
            specular: 0.0,
            opacity: 1.0,
            is_flat: false,
            clip: None,
        }
    }

    /// Writes the mesh and its texture for tercio.
    pub fn write(&self, name: &str, folder: &Path) -> Result<Files> {
        let stem = folder.join(name);
        let Some(texture) = &self.texture else {
            let mesh = stem.with_extension("ply");
            formats::write_ply(&self.mesh, &mesh)?;
            return Ok(Files { mesh, stem });
        };
        texture.write(folder.join(format!("{name}-texture.png")))?;
        let mesh = stem.with_extension("obj");
        std::fs::write(&mesh, obj(&self.mesh, name))?;
        let material = format!("newmtl textured\nKd 1 1 1\nmap_Kd {name}-texture.png\n");
        std::fs::write(stem.with_extension("mtl"), material)?;
        Ok(Files { mesh, stem })
    }
}

/// An OBJ with normals, texture coordinates and one material.
fn obj(mesh: &Mesh, name: &str) -> String {
    let mut text = format!("mtllib {name}.mtl\nusemtl textured\n");
    for [x, y, z] in &mesh.positions {
        text += &format!("v {x} {y} {z}\n");
    }
    for [u, v] in mesh.texcoords.iter().flatten() {
        text += &format!("vt {u} {v}\n");
    }
    for [x, y, z] in mesh.normals.iter().flatten().map(|n| n.decode()) {
        text += &format!("vn {x} {y} {z}\n");
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| v + 1);
        text += &format!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n");
    }
    text
}

/// The linear colour of a light. The largest component of the tint, in sRGB, is 255: so it can be written as tint and
/// strength.
fn tinted(tint: [u8; 3], strength: f32) -> [f32; 3] {
    tint.map(|c| srgb_to_linear(f64::from(c) / 255.0) as f32 * strength)
}

fn ambient(strength: f32) -> Light {
    Light::Ambient { color: [strength; 3] }
}

fn sunlight(x: f64, y: f64, z: f64, color: [f32; 3]) -> Light {
    Light::Directional { to_light: DVec3::new(x, y, z), space: LightSpace::World, color }
}

fn highlights() -> Scene {
    let mesh = meshes::model("builtin:teapot@60k");
    let mut scene =
        Scene::new("teapot, smooth normals, highlights, two directional lights", mesh, 25.0, 25.0);
    scene.lights.push(sunlight(-0.6, 0.8, 0.7, tinted([255, 250, 240], 0.6)));
    scene.lights.push(sunlight(1.0, 0.2, 0.3, tinted([150, 190, 255], 0.25)));
    scene.specular = 0.3;
    scene
}

fn facets() -> Scene {
    let mesh = meshes::model("builtin:gyroid@20k");
    let mut scene =
        Scene::new("gyroid, facets, highlights, orthographic camera, two lights", mesh, 35.0, 20.0);
    let framing = Framing { fov_y: None, ..Framing::new(SIZE.0, SIZE.1) }.with_view(View::Iso);
    scene.camera = framing.camera(&scene.mesh.bounds());
    scene.lights.push(sunlight(0.3, 0.9, 0.5, tinted([220, 240, 255], 0.5)));
    let position = DVec3::new(2.0, 0.5, 2.5);
    scene.lights.push(Light::Point {
        position,
        space: LightSpace::World,
        color: tinted([255, 200, 160], 0.45),
    });
    scene.is_flat = true;
    scene.specular = 0.3;
    scene
}

fn lamp_at_the_camera() -> Scene {
    let mesh = meshes::model("builtin:terrain@20k");
    let mut scene = Scene::new("terrain, highlights, lights that go with the camera", mesh, -40.0, 35.0);
    scene.is_shown = false;
    // The camera is not level: right and up are not those of the world.
    scene.camera.up += DVec3::new(0.3, 0.0, 0.1);
    let space = LightSpace::Camera;
    scene.lights.push(Light::Point {
        position: DVec3::new(-1.5, 0.5, -2.0),
        space,
        color: tinted([255, 190, 150], 0.6),
    });
    let (position, direction) = (DVec3::new(1.0, 0.5, -0.5), DVec3::new(-0.2, -0.15, -1.0));
    let angle = 12_f64.to_radians();
    scene.lights.push(Light::Spot { position, direction, space, angle, color: tinted([120, 230, 255], 0.5) });
    scene.specular = 0.2;
    scene
}

/// The scene of the shadows.
fn table(title: &'static str, light: Light) -> Scene {
    let mut scene = Scene::new(title, meshes::table(), 20.0, 28.0);
    let (center, size) = (scene.mesh.bounds().center(), scene.mesh.bounds().size().max_element());
    scene.camera = Framing::new(SIZE.0, SIZE.1).camera_at(
        center + DVec3::new(0.35, 0.45, 1.0) * size,
        center - DVec3::Y * (0.12 * size),
        None,
    );
    scene.has_shadows = true;
    scene.specular = 0.2;
    scene.lights.push(light);
    scene
}

/// A place above the scene of the shadows, to the left and in front, and the way from there to its middle.
fn above_table(x: f64, y: f64, z: f64) -> (DVec3, DVec3) {
    let bounds = meshes::table().bounds();
    let position = bounds.center() + DVec3::new(x, y, z) * bounds.size().max_element();
    (position, bounds.center() - position)
}

fn sun() -> Scene {
    let light = sunlight(-0.8, 1.0, 0.6, tinted([255, 250, 240], 0.7));
    Scene { is_shown: false, ..table("shadows of a directional light", light) }
}

fn lamp() -> Scene {
    let (position, _) = above_table(-0.25, 0.45, 0.3);
    let light = Light::Point { position, space: LightSpace::World, color: tinted([255, 250, 240], 0.7) };
    table("shadows of a point light", light)
}

fn spotlight(x: f64, y: f64, z: f64, degrees: f64) -> Light {
    let (position, direction) = above_table(x, y, z);
    let angle = degrees.to_radians();
    Light::Spot { position, direction, space: LightSpace::World, angle, color: tinted([255, 250, 240], 0.7) }
}

fn spot() -> Scene {
    table("shadows of a spot light of 25 degrees", spotlight(-0.3, 0.5, 0.4, 25.0))
}

fn wide_spot() -> Scene {
    let scene = table("shadows of a spot light of 55 degrees", spotlight(0.2, 0.3, 0.2, 55.0));
    Scene { is_shown: false, ..scene }
}

fn low_sun() -> Scene {
    let mesh = meshes::model("builtin:terrain@20k");
    let mut scene = Scene::new("terrain, shadows of a low sun", mesh, -40.0, 35.0);
    scene.is_shown = false;
    scene.has_shadows = true;
    scene.lights.push(sunlight(-1.0, 0.35, 0.2, tinted([255, 250, 240], 0.8)));
    scene
}

fn opacity() -> Scene {
    let mesh = meshes::model("builtin:teapot@60k");
    let mut scene = Scene::new("teapot, opacity 0.3", mesh, 25.0, 25.0);
    scene.lights.push(sunlight(-0.6, 0.8, 0.7, tinted([255, 250, 240], 0.8)));
    scene.opacity = 0.3;
    scene
}

fn floor() -> Scene {
    let mut scene = Scene::new("textured floor up to the horizon", meshes::floor(), 0.0, 0.0);
    scene.texture = Some(meshes::tiles());
    let framing = Framing { fov_y: Some(50.0), ..Framing::new(SIZE.0, SIZE.1) };
    scene.camera = framing.camera_at(DVec3::new(0.3, 1.0, 0.0), DVec3::new(0.9, 0.45, -3.0), None);
    scene.lights = vec![ambient(1.0)];
    // At the horizon a pixel shows several repetitions of the texture.
    scene.rays = 12;
    scene
}

fn cap() -> Scene {
    let mut scene = Scene::new("hollow ball, cut and capped", meshes::hollow_ball(), 25.0, 25.0);
    scene.is_shown = false;
    scene.lights.push(sunlight(-0.3, 0.6, 0.9, tinted([255, 250, 240], 0.8)));
    scene.specular = 0.2;
    scene.clip = Some((DVec3::new(-0.48, 0.36, -0.8), 0.1, [200, 85, 61]));
    scene
}

fn lamp_inside() -> Scene {
    let mut scene = cap();
    scene.is_shown = true;
    scene.title = "the same with a lamp inside, and its shadows";
    let position = DVec3::new(-0.15, 0.25, -0.2);
    scene.lights = vec![ambient(0.1), sunlight(0.4, 0.9, 0.5, tinted([255, 250, 240], 0.3))];
    scene.lights.push(Light::Point {
        position,
        space: LightSpace::World,
        color: tinted([255, 250, 240], 0.5),
    });
    scene.has_shadows = true;
    scene
}

fn fence() -> Scene {
    let mut scene = Scene::new("fence, cut out by its texture, and its shadow", meshes::fence(), 0.0, 0.0);
    scene.texture = Some(meshes::bars());
    let framing = Framing::new(SIZE.0, SIZE.1);
    scene.camera = framing.camera_at(DVec3::new(2.0, 3.5, 6.0), DVec3::new(0.2, 0.6, 0.0), None);
    scene.lights.push(sunlight(-0.5, 1.0, 0.9, tinted([255, 250, 240], 0.8)));
    scene.has_shadows = true;
    scene
}
