//! Whole models in folders of their own.

use std::fs;

use glam::DVec3;
use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
use tercio_scene::texture::Encoding;
use tercio_scene::{Camera, Light, LightSpace, Projection};

use super::*;
use crate::{LoadOptions, Renderer, Settings, texture_folders};

const SQUARE: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n";

/// A square with two materials.
struct Model(tempfile::TempDir);

impl Model {
    fn new(library: &str) -> Self {
        let model = Self(tempfile::tempdir().expect("a temporary folder"));
        fs::write(model.0.path().join("m.obj"), SQUARE).expect("room");
        fs::write(model.0.path().join("m.mtl"), library).expect("room");
        model
    }

    /// A picture whose texels have the colours in turn, two in a row.
    fn with(self, name: &str, texels: &[[u8; 4]]) -> Self {
        let rows = (texels.len() / 2).max(1) as u32;
        let image = RgbaImage::from_fn(2, rows, |x, y| Rgba(texels[(2 * y + x) as usize % texels.len()]));
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("room");
        DynamicImage::from(image).save_with_format(path, ImageFormat::Png).expect("room");
        self
    }

    fn load(&self, options: &TextureOptions) -> (Scene, TextureReport) {
        let path = self.0.path().join("m.obj");
        let model = LoadOptions::default().load(&path).expect("a model");
        let folders = texture_folders(&path, &model.report);
        let mut scene = Scene::from_mesh(model.mesh);
        let report = options.load(&mut scene, 0, &folders);
        (scene, report)
    }
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREY: [u8; 4] = [99, 99, 99, 255];

#[test]
fn a_picture_is_one_texture_for_each_meaning() {
    let library = "newmtl a\nmap_Kd a.png\nmap_Ks a.png\nmap_Pr a.png\nnewmtl b\nmap_Kd ./a.png\nmap_Bump b.png\nNs 100\n";
    let model = Model::new(library).with("a.png", &[RED]).with("b.png", &[GREY]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!(report.warnings, [""; 0]);
    assert_eq!((report.materials, report.textures, report.files.len()), (2, 3, 2));
    assert_eq!(scene.textures.len(), 3);
    assert_eq!(report.bytes, scene.textures.iter().map(|t| t.bytes() as u64).sum::<u64>());
    let [a, b] = &scene.materials[..] else { panic!("{} materials", scene.materials.len()) };
    assert_eq!(a.base_color_map, a.specular_map);
    assert_ne!(a.base_color_map, a.roughness_map);
    assert_eq!(b.base_color_map.map(|map| map.texture), Some(0));
    assert!(b.normal_map.is_some() && a.normal_map.is_none());
    let encodings: Vec<_> = scene.textures.iter().map(|t| t.encoding()).collect();
    assert_eq!(encodings, [Encoding::Srgb, Encoding::Linear, Encoding::Linear]);
    let materials = scene.instances[0].materials.as_ref().expect("materials");
    assert_eq!([materials.of_triangle(0), materials.of_triangle(1)], [Some(0), Some(1)]);
    assert!(!materials.is_translucent());
}

#[test]
fn plain_colours_stay_as_they_are() {
    let (scene, report) =
        Model::new("newmtl a\nKd 1 0 0\nd 0.5\nnewmtl b\n").load(&TextureOptions::default());
    assert!(scene.instances[0].materials.is_none() && scene.materials.is_empty());
    assert_eq!(TextureReport { milliseconds: 0.0, ..report }, TextureReport::default());
    let (scene, report) = Model::new("newmtl a\nKs 1 1 1\nnewmtl b\n").load(&TextureOptions::default());
    assert_eq!((report.materials, report.textures), (2, 0));
    assert!(scene.instances[0].materials.is_some());
}

/// The alpha of vertices, materials and textures is multiplied, whichever of them has the colour that is seen.
#[test]
fn every_alpha_counts() {
    let (eye, target) = (DVec3::new(0.5, 0.5, 2.0), DVec3::new(0.5, 0.5, 0.0));
    let projection = Projection::Orthographic { height: 0.6 };
    let camera = Camera { eye, target, up: DVec3::Y, projection, near: None, shift: [0.0; 2] };
    let mut settings = Settings::one_sample(8, 8);
    (settings.outputs.linear, settings.shading) = (true, tercio_raster::Shading::Unlit);
    for (texture, of_texture) in [("", 1.0), ("map_Kd red.png", 1.0), ("map_Kd half.png", 128.0 / 255.0)] {
        for (material, of_material) in [("", 1.0), ("d 0.5", 0.5), ("Tr 0.75", 0.25)] {
            for (color, of_vertices) in [("", 1.0), (" 1 0 0", 1.0), (" 1 0 0 0.2", 0.2)] {
                let library = format!("newmtl a\nKd 1 0 0\n{material}\n{texture}\n");
                let library = format!("{library}{}", library.replace("newmtl a", "newmtl b"));
                let model =
                    Model::new(&library).with("red.png", &[RED]).with("half.png", &[[255, 0, 0, 128]; 2]);
                let line = |line: &str| match line.starts_with("v ") {
                    true => format!("{line}{color}\n"),
                    false => format!("{line}\n"),
                };
                let text: String = SQUARE.lines().map(line).collect();
                fs::write(model.0.path().join("m.obj"), text).expect("room");
                let (scene, report) = model.load(&TextureOptions::default());
                assert_eq!(report.warnings.len(), 0, "{:?}", report.warnings);
                let check = |mut scene: Scene, alpha: f64| {
                    scene.background = tercio_scene::Background::Solid([1.0; 4]);
                    let frame = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
                    for linear in &frame.planes.linear {
                        let expected = [1.0, 1.0 - alpha, 1.0 - alpha];
                        let far = (0..3).any(|k| (f64::from(linear[k]) - expected[k]).abs() > 1e-3);
                        assert!(
                            !far,
                            "{texture:?}, {material:?}, {color:?}: {linear:?} in place of {expected:?}"
                        );
                    }
                };
                check(scene, of_texture * of_material * of_vertices);
                let plain = TextureOptions { is_plain: true, ..TextureOptions::default() };
                let (scene, report) = model.load(&plain);
                assert_eq!((report.textures, report.warnings.len()), (0, 0));
                check(scene, of_material * of_vertices);
            }
        }
    }
}

#[test]
fn what_is_missing_or_broken_is_one_warning() {
    let library = "newmtl a\nmap_Kd no.png\nmap_Ks folder.png\nmap_Ke text.png\nmap_Bump gone.png\nnewmtl b\nmap_Kd a.png\n";
    let model = Model::new(library).with("a.png", &[RED]);
    fs::create_dir(model.0.path().join("folder.png")).expect("room");
    fs::write(model.0.path().join("text.png"), "hello").expect("room");
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!(report.warnings.len(), 1, "{:?}", report.warnings);
    let begin = "did not draw 4 textures: \"no.png\" (not found), \"folder.png\" (not a file), \"text.png\" (expected a PNG,";
    assert!(
        report.warnings[0].starts_with(begin) && report.warnings[0].ends_with(", …"),
        "{:?}",
        report.warnings
    );
    assert_eq!(report.textures, 1);
    assert!(scene.materials[0].base_color_map.is_none() && scene.materials[1].base_color_map.is_some());
}

#[test]
fn nothing_is_looked_for_without_a_folder() {
    let model = Model::new("newmtl a\nmap_Kd a.png\nmap_Ks b.png\nnewmtl b\n").with("a.png", &[RED]);
    let mut scene =
        Scene::from_mesh(LoadOptions::default().load(model.0.path().join("m.obj")).expect("a model").mesh);
    let report = TextureOptions::default().load(&mut scene, 0, &[]);
    assert_eq!(report.warnings, ["did not look for 2 textures: the model comes without a folder"]);
    assert!(scene.instances[0].materials.is_none());
}

#[test]
fn other_extensions_are_said() {
    let model = Model::new("newmtl a\nmap_Kd a.tif\nnewmtl b\n").with("textures/A.png", &[RED]);
    let (_, report) = model.load(&TextureOptions::default());
    assert_eq!(
        report.warnings,
        ["took textures with another extension than is named: \"A.png\" for \"a.tif\""]
    );
    assert_eq!(report.textures, 1);
}

#[test]
fn pictures_that_exceed_the_limit_are_left_out() {
    let library = "newmtl a\nmap_Kd a.png\nmap_Ks b.png\nnewmtl b\nmap_Kd c.png\n";
    let texels = [RED; 20_000];
    let model = Model::new(library).with("a.png", &[RED]).with("b.png", &texels).with("c.png", &[GREY]);
    let limit =
        |memory_limit| TextureOptions { memory_limit: Some(memory_limit), ..TextureOptions::default() };
    let (_, report) = model.load(&limit((1 << 24) + 10_000));
    assert_eq!((report.textures, report.warnings.len()), (2, 1), "{:?}", report.warnings);
    assert!(
        report.warnings[0].starts_with("did not draw 1 texture: \"b.png\" (needs"),
        "{:?}",
        report.warnings
    );
    let (_, report) = model.load(&limit(0));
    assert_eq!((report.textures, report.warnings.len()), (0, 1));
    // Enough for one after the other, not for all at the same time.
    let (_, report) = model.load(&limit((1 << 24) + (1 << 22)));
    assert_eq!((report.textures, report.warnings.len()), (3, 0), "{:?}", report.warnings);
}

#[test]
fn alpha_is_drawn_once_and_as_requested() {
    let library = "newmtl a\nmap_Kd a.png\nmap_d a.png\nnewmtl b\nd 0.5\n";
    let model = Model::new(library).with("a.png", &[[200, 0, 0, 0], [0, 200, 0, 255]]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!((report.textures, report.warnings.len()), (1, 0));
    assert!(scene.materials[0].opacity_map.is_none());
    assert!(scene.instances[0].materials.as_ref().is_some_and(|m| m.is_translucent()));

    let cutout = TextureOptions { alpha_mode: AlphaMode::Cutout(0.5), ..TextureOptions::default() };
    let (scene, _) = model.load(&cutout);
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Cutout(0.5));
    assert_eq!(scene.materials[1].alpha_mode, AlphaMode::Blend);

    let ignored = TextureOptions { alpha_mode: AlphaMode::Opaque, ..TextureOptions::default() };
    let (scene, _) = model.load(&ignored);
    assert!(scene.textures.iter().all(|texture| texture.is_opaque()));
    assert_eq!((scene.materials[0].opacity_map, scene.materials[1].opacity), (None, 0.5));
}

#[test]
fn an_alpha_of_0_everywhere_is_not_meant() {
    let model = Model::new("newmtl a\nmap_Kd a.png\nnewmtl b\n").with("a.png", &[[200, 0, 0, 0]]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!(report.warnings, ["ignored the alpha, which is 0 everywhere, of 1 texture: \"a.png\""]);
    assert!(scene.textures[0].is_opaque());
    assert!(scene.textures[0].levels()[0].texels[0][0] > 30_000);
}

#[test]
fn bumps_become_normals_unless_they_are() {
    let flat = [128, 128, 255, 255];
    let library = "newmtl a\nbump -bm 0.5 heights.png\nnewmtl b\nbump normals.png\n";
    let model = Model::new(library).with("heights.png", &[GREY]).with("normals.png", &[flat]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!((report.textures, report.warnings.len()), (2, 0));
    assert_eq!([scene.materials[0].normal_scale, scene.materials[1].normal_scale], [0.5, 1.0]);
    assert_eq!(scene.textures[0].levels()[0].texels[0], [32768, 32768, 65535, 65535]);
    assert_eq!(scene.textures[1].levels()[0].texels[0], flat.map(|c| u16::from(c) * 257));

    let both = Model::new("newmtl a\nbump b.png\nnorm a.png\nnewmtl b\n").with("a.png", &[flat]);
    let (scene, report) = both.load(&TextureOptions::default());
    assert_eq!(report.warnings, ["did not draw the bumps of 1 material with normals, which replace them"]);
    assert!(scene.materials[0].normal_map.is_some());
}

#[test]
fn bumps_are_drawn_where_the_normals_are_missing_or_broken() {
    let library = "newmtl a\nbump b.png\nnorm gone.png\nnewmtl b\nbump -bm 0.5 b.png\nnorm text.png\n";
    let model = Model::new(library).with("b.png", &[GREY]);
    fs::write(model.0.path().join("text.png"), "hello").expect("room");
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!((report.textures, report.files.len(), report.warnings.len()), (1, 2, 1));
    assert!(report.warnings[0].starts_with("did not draw 2 textures: \"gone.png\""), "{:?}", report.warnings);
    assert_eq!(scene.materials.iter().filter(|m| m.normal_map.is_some()).count(), 2);
    assert_eq!(scene.materials[1].normal_scale, 0.5);
    // A bump map that is missing, too, is part of the same warning.
    let (scene, report) =
        Model::new("newmtl a\nbump b.png\nnorm c.png\nnewmtl b\n").load(&TextureOptions::default());
    let expected = "did not draw 2 textures: \"c.png\" (not found), \"b.png\" (not found)";
    assert_eq!((report.warnings.as_slice(), scene.materials.len()), ([expected.to_owned()].as_slice(), 0));
}

#[test]
fn numbers_and_channels_are_taken_as_stated() {
    let library = "newmtl a\nmap_Kd -mm 0.2 0.5 a.png\nmap_Ks a.png\nmap_d -imfchan g a.png\nnewmtl b\nmap_Kd a.png\n\
         map_Bump -imfchan b -mm 0 2 n.png\n";
    let flat = [128, 128, 255, 255];
    let model = Model::new(library).with("a.png", &[[255, 51, 0, 255]]).with("n.png", &[flat]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!((report.textures, report.warnings.len()), (4, 0), "{:?}", report.warnings);
    let texel = |map: Option<tercio_scene::TextureMap>| {
        let texture = &scene.textures[map.expect("a texture").texture as usize];
        texture.levels()[0].texels[0]
    };
    let [a, b] = &scene.materials[..] else { panic!("{} materials", scene.materials.len()) };
    let stated = Texture::from_rgba16(1, 1, &[[45875, 19661, 13107, 65535]], Encoding::Srgb);
    assert_eq!(texel(a.base_color_map), stated.levels()[0].texels[0]);
    // The alpha is a channel of the diffuse texture, but another one.
    assert_eq!(texel(a.opacity_map)[0], 51 * 257);
    assert_eq!(
        (a.specular_map.map(|map| map.texture), texel(b.base_color_map)[0]),
        (b.base_color_map.map(|map| map.texture), 65535)
    );
    // A channel of normals is a height.
    assert_eq!((texel(b.normal_map), b.normal_scale), ([32768, 32768, 65535, 65535], 2.0));
}

#[test]
fn opacity_in_the_alpha_of_a_picture_is_scaled_as_stated() {
    for (statement, expected) in [("map_d al.png", 200 * 257), ("map_d -mm 0 0.5 al.png", 25700)] {
        let model = Model::new(&format!("newmtl a\n{statement}\nnewmtl b\n"))
            .with("al.png", &[[0, 0, 0, 200], [0; 4]]);
        let (scene, report) = model.load(&TextureOptions::default());
        assert_eq!(report.warnings.len(), 0, "{:?}", report.warnings);
        let map = scene.materials[0].opacity_map.expect("a texture");
        assert_eq!(scene.textures[map.texture as usize].levels()[0].texels[0][0], expected, "{statement}");
    }
}

#[test]
fn a_picture_has_a_limited_number_of_uses() {
    let library: String = (0..100).map(|i| format!("newmtl m{i}\nmap_Kd -mm 0 {i} a.png\n")).collect();
    let model = Model::new("").with("a.png", &[RED]);
    let faces: String = (0..100).map(|i| format!("usemtl m{i}\nf 1/1 2/2 3/3\n")).collect();
    let square = SQUARE.split("usemtl").next().expect("a beginning");
    fs::write(model.0.path().join("m.mtl"), library).expect("room");
    fs::write(model.0.path().join("m.obj"), format!("{square}{faces}")).expect("room");
    let (_, report) = model.load(&TextureOptions::default());
    assert_eq!(report.textures, 64);
    assert_eq!(
        report.warnings,
        ["did not draw 1 texture: \"a.png\" (more than 64 ways to use it are not drawn)"]
    );
}

#[test]
fn materials_without_light_emit_their_colour() {
    let library = "newmtl a\nillum 0\nmap_Kd a.png\nmap_Ks gone.png\nnewmtl b\nillum 0\nKd 1 0 0\n";
    let model = Model::new(library).with("a.png", &[[255, 0, 0, 128]]);
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!((report.textures, report.warnings.len()), (2, 0), "{:?}", report.warnings);
    let [a, b] = &scene.materials[..] else { panic!("{} materials", scene.materials.len()) };
    assert_eq!((a.base_color, b.base_color, b.emissive), ([0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]));
    // The alpha is that of the diffuse texture, and the light has none.
    let is_opaque = |map: Option<tercio_scene::TextureMap>| {
        scene.textures[map.expect("a texture").texture as usize].is_opaque()
    };
    assert!(!is_opaque(a.base_color_map) && is_opaque(a.emissive_map));
    let unlit = TextureOptions { is_unlit: true, ..TextureOptions::default() };
    let (scene, _) = model.load(&unlit);
    assert_eq!((scene.materials[0].base_color, scene.materials[1].emissive), ([1.0; 3], [0.0; 3]));
    // Colours of the vertices take the place of those of materials without textures.
    let text = fs::read_to_string(model.0.path().join("m.obj")).expect("a model");
    let colored = text.replace("v 0 0 0\n", "v 0 0 0 1 1 1\n").replace("v 1 0 0\n", "v 1 0 0 1 1 1\n");
    let colored = colored.replace("v 1 1 0\n", "v 1 1 0 1 1 1\n").replace("v 0 1 0\n", "v 0 1 0 1 1 1\n");
    fs::write(model.0.path().join("m.obj"), colored).expect("room");
    let (scene, report) = model.load(&TextureOptions::default());
    assert_eq!(
        report.warnings,
        ["drew 1 material without light (illum 0) with the lit colours of the model"]
    );
    assert_eq!((scene.materials[0].base_color, scene.materials[1].emissive), ([0.0; 3], [0.0; 3]));
}

#[test]
fn textures_of_a_prepared_model_are_beside_it_or_beside_its_origin() {
    let model = Model::new("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n").with("a.png", &[RED]);
    let elsewhere = Model::new("").with("b.png", &[GREY]);
    let path = model.0.path().join("m.obj");
    let prepared = elsewhere.0.path().join("m.tercio");
    let loaded = crate::load(&path).expect("a model");
    let mut file = fs::File::create(&prepared).expect("room");
    loaded.write_prepared(path.to_str().expect("text"), &mut file).expect("room");
    let again = crate::load(&prepared).expect("a prepared model");
    let folders = texture_folders(&prepared, &again.report);
    assert_eq!(folders, [elsewhere.0.path(), model.0.path()]);
    let mut scene = Scene::from_mesh(again.mesh);
    let report = TextureOptions::default().load(&mut scene, 0, &folders);
    assert_eq!((report.textures, report.warnings.len()), (2, 0), "{:?}", report.warnings);
}

#[test]
fn textures_are_nowhere_without_texture_coordinates() {
    let model = Model::new("newmtl a\nmap_Kd a.png\nnewmtl b\n").with("a.png", &[RED]);
    let plain = SQUARE.lines().filter(|line| !line.starts_with("vt")).collect::<Vec<_>>().join("\n");
    let plain = ["/1", "/2", "/3", "/4"].iter().fold(plain, |text, index| text.replace(index, ""));
    fs::write(model.0.path().join("m.obj"), plain).expect("room");
    let (scene, report) = model.load(&TextureOptions::default());
    assert!(scene.textures.is_empty() && scene.materials.is_empty() && report.warnings.is_empty());
    let loaded = crate::load(model.0.path().join("m.obj")).expect("a model");
    assert_eq!(loaded.report.read.not_drawn.textures, 1);
}

/// A ramp of heights on a square, drawn: every pixel is lit as a plane with the slope of the ramp.
#[test]
fn a_ramp_of_heights_is_lit_as_its_slope() {
    // White is 4 texels higher than black.
    let slope = 4.0 * 4.0 / 255.0;
    let uvs = [("plain", 1.0, 0.0), ("mirrored", -1.0, 0.0), ("turned", 0.0, 1.0)];
    for (name, du_dx, du_dy) in uvs {
        let model = Model::new(
            "newmtl a\nmap_Bump -bm 3 b.png\nKs 0 0 0\nnewmtl b\nmap_Bump -bm 3 b.png\nKs 0 0 0\n",
        );
        // u grows along x, against it or along y; v is the direction to its left, or to its right if mirrored.
        let (dv_dx, dv_dy) = if name == "turned" { (-1.0, 0.0) } else { (0.0, 1.0) };
        let text = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]: [f64; 2]| format!("vt {} {}", du_dx * x + du_dy * y, dv_dx * x + dv_dy * y));
        let faces = &SQUARE[SQUARE.find("usemtl").expect("faces")..];
        let vertices = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        fs::write(model.0.path().join("m.obj"), format!("{vertices}{}\n{faces}", text.join("\n")))
            .expect("room");
        let ramp = RgbaImage::from_fn(60, 8, |x, _| {
            let level = 4 * x as u8 + 8;
            Rgba([level, level, level, 255])
        });
        DynamicImage::from(ramp)
            .save_with_format(model.0.path().join("b.png"), ImageFormat::Png)
            .expect("room");
        let (mut scene, report) = model.load(&TextureOptions::default());
        assert_eq!((report.textures, report.warnings.len()), (1, 0), "{:?}", report.warnings);
        // Along u, the surface rises; so its normal leans against it.
        let normal = DVec3::new(-3.0 * slope * du_dx, -3.0 * slope * du_dy, 1.0).normalize();
        let (eye, target) = (DVec3::new(0.5, 0.5, 2.0), DVec3::new(0.5, 0.5, 0.0));
        let projection = Projection::Orthographic { height: 0.6 };
        let camera = Camera { eye, target, up: DVec3::Y, projection, near: None, shift: [0.0; 2] };
        for to_light in [[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]] {
            let to_light = DVec3::from(to_light).normalize();
            scene.lights = vec![Light::Directional { to_light, space: LightSpace::World, color: [1.0; 3] }];
            scene.materials.iter_mut().for_each(|m| m.base_color = [1.0; 3]);
            let mut settings = Settings::one_sample(24, 24);
            settings.outputs.linear = true;
            let frame = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
            let expected = normal.dot(to_light);
            for linear in &frame.planes.linear {
                // Normals have 16 bits a component.
                let error = (f64::from(linear[0]) - expected).abs();
                assert!(error < 1e-4, "{name}, light {to_light}: {} in place of {expected}", linear[0]);
            }
        }
    }
}
