//! Pictures of surfaces with materials and textures: every path draws the bytes of the reference.

mod common;

use std::sync::Arc;

use common::*;
use glam::DVec3;
use tercio_mesh::{FileMaterial, Mesh};
use tercio_raster::{
    Outputs, RenderError, Renderer, SamplePattern, SampleShading, Sampling, Settings, Shading, TextureFilter,
};
use tercio_scene::texture::Encoding;
use tercio_scene::{AlphaMode, Camera, InstanceMaterials, Light, Material, Scene, Texture, TextureMap, Wrap};

/// Noise of this size.
fn noise(width: u32, height: u32, is_opaque: bool, encoding: Encoding, seed: u64) -> Arc<Texture> {
    let mut random = Random(seed);
    let mut level = || (random.next() * 256.0) as u8;
    let pixels: Vec<[u8; 4]> = (0..width * height)
        .map(|_| [level(), level(), level(), if is_opaque { 255 } else { level() / 128 * 127 }])
        .collect();
    Arc::new(Texture::from_rgba8(width, height, &pixels, encoding))
}

/// Gives every vertex texture coordinates, most of them inside the picture, and every triangle one of `materials` materials of
/// the file, or none.
fn textured(mut mesh: Mesh, materials: usize, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let reach = |random: &mut Random| {
        let far = if random.next() < 0.1 { 30.0 } else { 1.5 };
        random.between(-far, far) as f32
    };
    let vertices = mesh.positions.len();
    mesh.texcoords = Some((0..vertices).map(|_| [reach(&mut random), reach(&mut random)]).collect());
    let material = FileMaterial { diffuse: [0.5; 3], ..FileMaterial::default() };
    mesh.materials = vec![material; materials];
    let mut of_triangle = || match (random.next() * (materials + 1) as f64) as usize {
        m if m < materials => m as u32,
        _ => Mesh::NO_MATERIAL,
    };
    mesh.triangle_materials = Some(mesh.triangles.iter().map(|_| of_triangle()).collect());
    mesh
}

/// A texture in some place and wrap mode.
fn map(texture: u32, seed: u64) -> Option<TextureMap> {
    let mut random = Random(seed);
    let mut wrap = || [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp][(random.next() * 3.0) as usize];
    let wrap = [wrap(), wrap()];
    let mut number = |from, to| random.between(from, to) as f32;
    let (scale, offset) = ([number(0.5, 2.0), number(-2.0, -0.5)], [number(-1.0, 1.0), number(-1.0, 1.0)]);
    Some(TextureMap { texture, wrap, scale, offset })
}

/// Materials with every kind of texture, some of them not opaque.
fn materials() -> Vec<Material> {
    let base = Material { base_color: [0.9, 0.7, 0.5], ..Material::default() };
    vec![
        Material { base_color_map: map(0, 1), ..base.clone() },
        Material { base_color_map: map(1, 2), specular_map: map(0, 3), shininess_log2: 8, ..base.clone() },
        Material { normal_map: map(2, 4), normal_scale: 0.7, roughness_map: map(3, 5), ..base.clone() },
        Material { metallic: 1.0, metallic_map: map(3, 6), occlusion_map: map(3, 7), ..base.clone() },
        Material { emissive: [0.3, 0.2, 0.9], emissive_map: map(0, 8), specular: [0.0; 3], ..base },
    ]
}

fn translucent_materials() -> Vec<Material> {
    let base = Material::default();
    vec![
        Material { base_color_map: map(4, 1), ..base.clone() },
        Material { base_color_map: map(4, 2), alpha_mode: AlphaMode::Cutout(0.5), ..base.clone() },
        Material { base_color_map: map(4, 3), alpha_mode: AlphaMode::Opaque, ..base.clone() },
        Material { opacity_map: map(3, 4), opacity: 0.8, ..base.clone() },
        Material { opacity: 0.4, ..base },
    ]
}

/// The scene of a mesh with as many materials as given.
fn dressed(mesh: &Mesh, materials: Vec<Material>) -> Scene {
    let mut scene = scene(mesh);
    scene.textures = vec![
        noise(16, 16, true, Encoding::Srgb, 1),
        noise(37, 5, true, Encoding::Srgb, 2),
        noise(8, 21, true, Encoding::Linear, 3),
        noise(64, 32, true, Encoding::Linear, 4),
        noise(19, 16, false, Encoding::Srgb, 5),
    ];
    scene.materials = materials;
    let of_mesh = (0..mesh.materials.len() as u32).collect();
    let materials = InstanceMaterials::new(&scene.instances[0].mesh, of_mesh, &scene);
    scene.instances[0].materials = Some(materials);
    // Every kind of light.
    scene.lights.push(Light::headlight([0.3, 0.2, 0.4]));
    let (position, space) = (DVec3::new(1.0, 2.0, 0.5), tercio_scene::LightSpace::World);
    scene.lights.push(Light::Point { position, space, color: [0.2, 0.5, 0.3] });
    scene
}

/// As many mipmaps as there may be, and one.
fn with_extreme_sizes(mut scene: Scene) -> Scene {
    scene.textures[0] = noise(1 << 15, 1, true, Encoding::Srgb, 1);
    scene.textures[1] = noise(1, 1 << 15, true, Encoding::Srgb, 2);
    scene.textures[3] = noise(1, 1, true, Encoding::Linear, 4);
    scene
}

const FILTERS: [TextureFilter; 4] =
    [TextureFilter::Nearest, TextureFilter::Bilinear, TextureFilter::Trilinear, TextureFilter::Anisotropic];

fn camera() -> Camera {
    perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0)
}

#[test]
fn every_kind_of_texture_and_every_shading() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(2_500, 1), 5, 6) };
    let scene = dressed(&mesh, materials());
    for shading in [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Unlit, Shading::Physical] {
        for settings in [everything(75, 58), Settings { outputs: Outputs::ALL, ..Settings::new(55, 40) }] {
            let settings = Settings { shading, ..settings };
            check_all(&mesh, &scene, &camera(), &settings, &format!("{shading:?}"));
        }
    }
}

#[test]
fn textures_of_extreme_sizes() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(1_500, 8), 5, 9) };
    let scene = with_extreme_sizes(dressed(&mesh, materials()));
    for texture_filter in FILTERS {
        let settings = Settings { texture_filter, ..everything(60, 44) };
        check_all(&mesh, &scene, &camera(), &settings, &format!("{texture_filter:?}"));
    }
}

#[test]
fn every_filter_and_sampling() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(2_500, 2), 5, 7) };
    let scene = dressed(&mesh, materials());
    for texture_filter in FILTERS {
        for pattern in SamplePattern::ALL {
            for shading in [SampleShading::Pixel, SampleShading::Sample] {
                let sampling = Sampling { shading, ..Sampling::of(pattern) };
                let settings =
                    Settings { sampling, texture_filter, tile_size: Some(16), ..everything(50, 38) };
                let expected = draw_reference(&mesh, &scene, &camera(), &settings);
                assert_same(&expected, &draw(&scene, &camera(), &settings), &format!("{settings:?}"));
            }
        }
    }
}

#[test]
fn textures_that_are_not_opaque() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(2_000, 3), 5, 8) };
    let mut scene = dressed(&mesh, translucent_materials());
    for opacity in [1.0, 0.7] {
        scene.instances[0].surface.opacity = opacity;
        for settings in [everything(61, 44), Settings { outputs: Outputs::ALL, ..Settings::new(55, 40) }] {
            check_all(&mesh, &scene, &camera(), &settings, &format!("opacity {opacity}"));
        }
    }
}

#[test]
fn a_texture_replaces_colours_of_the_mesh_but_not_their_alpha() {
    let mesh = textured(soup(2_000, 4), 5, 9);
    let faces = (0..mesh.triangles.len()).map(|t| [t as u8, 200, 90, 255 - (t as u8) / 3]).collect();
    let of_faces = Mesh { vertex_colors: None, face_colors: Some(faces), ..mesh.clone() };
    for mesh in [mesh, of_faces] {
        for materials in [materials(), translucent_materials()] {
            let mut scene = dressed(&mesh, materials);
            for use_mesh_colors in [true, false] {
                scene.instances[0].surface.use_mesh_colors = use_mesh_colors;
                check_all(&mesh, &scene, &camera(), &everything(60, 44), "own colours");
            }
        }
    }
}

#[test]
fn physically_based_shading_without_materials() {
    let mesh = soup(2_000, 5);
    let plain = Mesh { vertex_colors: None, ..mesh.clone() };
    for mesh in [&mesh, &plain, &textured(plain.clone(), 3, 1)] {
        let mut scene = scene(mesh);
        scene.instances[0].surface.metallic = 0.6;
        scene.instances[0].surface.roughness = 0.2;
        let settings = Settings { shading: Shading::Physical, ..everything(60, 44) };
        check_all(mesh, &scene, &camera(), &settings, "no materials");
    }
}

#[test]
fn triangles_that_are_clipped_are_textured_too() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(3_000, 6), 5, 10) };
    let scene = dressed(&mesh, materials());
    let inside = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    let flat = orthographic([0.5, 1.0, 3.0], [0.0; 3], 1.0);
    for camera in [inside, flat] {
        for settings in [everything(71, 57), Settings { outputs: Outputs::ALL, ..Settings::new(55, 40) }] {
            check_all(&mesh, &scene, &camera, &settings, "inside");
        }
    }
}

#[test]
fn a_second_instance_with_and_without_materials() {
    let mesh = Mesh { vertex_colors: None, ..textured(soup(1_500, 7), 5, 11) };
    let mut scene = with_second_instance(dressed(&mesh, materials()));
    check_all(&mesh, &scene, &camera(), &everything(70, 50), "two instances");
    scene.instances[1].materials = None;
    check_all(&mesh, &scene, &camera(), &everything(70, 50), "one without materials");
}

#[test]
fn coordinates_that_are_not_finite_or_huge() {
    let mut mesh = Mesh { vertex_colors: None, ..textured(soup(1_000, 8), 5, 12) };
    let special = [f32::NAN, f32::INFINITY, -1e38, 1e38, 1e20, -1e9, 1e-40];
    for (v, uv) in mesh.texcoords.iter_mut().flatten().enumerate() {
        uv[v % 2] = special[v % special.len()];
    }
    let scene = dressed(&mesh, materials());
    check_all(&mesh, &scene, &camera(), &everything(70, 50), "not finite");
}

#[test]
fn a_material_that_refers_to_no_texture_is_refused() {
    let mesh = textured(soup(10, 9), 5, 13);
    let mut scene = dressed(&mesh, materials());
    scene.materials[0].base_color_map = Some(TextureMap::new(5));
    let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
    assert!(matches!(error, RenderError::Setting { what: "texture of a material", .. }), "{error}");
    for (material, wrong) in [
        (
            Material { alpha_mode: AlphaMode::Cutout(1.5), ..Material::default() },
            "cut-off of a material's alpha",
        ),
        (
            Material { alpha_mode: AlphaMode::Cutout(f32::NAN), ..Material::default() },
            "cut-off of a material's alpha",
        ),
        (Material { shininess_log2: 11, ..Material::default() }, "logarithm of a material's shininess"),
        (Material { normal_scale: -1e7, ..Material::default() }, "absolute scale of a material's normals"),
    ] {
        scene.materials[0] = material;
        let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
        assert!(matches!(error, RenderError::Setting { what, .. } if what == wrong), "{error}");
    }
    scene.materials[0] = Material { emissive: [f32::NAN; 3], ..Material::default() };
    let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
    assert!(matches!(error, RenderError::Setting { what: "colour of a material", .. }), "{error}");
    scene.materials.clear();
    let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
    assert!(matches!(error, RenderError::Setting { what: "materials of an instance", .. }), "{error}");
}
