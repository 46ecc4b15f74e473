//! Whole models in folders of their own.

use std::fs;

use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};

use super::*;
use crate::{LoadOptions, texture_folders};

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
