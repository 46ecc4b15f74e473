//! Ranks that draw textured surfaces give the bytes of one renderer, with every organisation.

mod common;

use std::sync::Arc;

use common::*;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{FileMaterial, builtin};
use tercio_parallel::{Composition, Organisation, Ranks, Sharing};
use tercio_raster::{Renderer, Settings, TextureFilter};
use tercio_scene::texture::Encoding;
use tercio_scene::{AlphaMode, InstanceMaterials, Material, Scene, Texture, TextureMap, Wrap};

/// A texture without a pattern that repeats; where alpha is wanted, half of its texels are clear.
fn texture(edge: u32, has_alpha: bool) -> Arc<Texture> {
    let mut state = 1u32;
    let mut level = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let texel = |_| [level(), level(), level(), if has_alpha { level() / 128 * 170 } else { 255 }];
    let texels: Vec<[u8; 4]> = (0..edge * edge).map(texel).collect();
    Arc::new(Texture::from_rgba8(edge, edge, &texels, Encoding::Srgb))
}

/// A model whose triangles have these materials in turn, and its mirrored double.
fn textured(model: &str, textures: Vec<Arc<Texture>>, materials: Vec<Material>) -> Scene {
    let mut mesh = builtin::make(model).expect("a model");
    mesh.texcoords = Some(mesh.positions.iter().map(|p| [0.7 * p[0] + 0.2 * p[2], p[1] * 1.3]).collect());
    mesh.materials = vec![FileMaterial::default(); materials.len()];
    let number = |triangle: usize| (triangle * 7 % materials.len()) as u32;
    mesh.triangle_materials = Some((0..mesh.triangles.len()).map(number).collect());
    let options = PartitionOptions { max_triangles: 64, ..PartitionOptions::default() };
    let mut scene = Scene::from_mesh(Arc::new(partition(mesh, &options)));
    scene.textures = textures;
    scene.materials = materials;
    let of_mesh = (0..scene.materials.len() as u32).collect();
    scene.instances[0].materials = Some(InstanceMaterials::new(&scene.instances[0].mesh, of_mesh, &scene));
    with_second_instance(scene)
}

fn map(texture: u32) -> Option<TextureMap> {
    Some(TextureMap { texture, wrap: [Wrap::Repeat, Wrap::Mirror], scale: [1.5, 0.8], offset: [0.1, 0.3] })
}

/// The picture of ranks is that of one renderer, which is not that without textures.
fn check_all(scene: &Scene, settings: &Settings, what: &str) {
    let camera = camera(scene, 1.8, false);
    let expected = Renderer::new().render(scene, &camera, settings).expect("a picture");
    let mut plain = scene.clone();
    plain.instances.iter_mut().for_each(|instance| instance.materials = None);
    let untextured = Renderer::new().render(&plain, &camera, settings).expect("a picture");
    assert_ne!(expected.planes.color, untextured.planes.color, "{what}: textures are not seen");
    let check = |count: usize, sharing: Sharing| {
        let ranks = Ranks { count, threads: 1 + count % 2, sharing };
        check_against(&expected, scene, &camera, settings, ranks, what);
    };
    for organisation in ALL {
        [2, 3, 8].into_iter().for_each(|count| check(count, organisation.into()));
    }
    for composition in Composition::ALL {
        check(5, Sharing { composition, ..Organisation::SortLast.into() });
    }
}

#[test]
fn opaque_textures() {
    let base = Material { base_color: [0.9, 0.8, 0.7], ..Material::default() };
    let materials = vec![
        Material { base_color_map: map(0), ..base.clone() },
        Material { base_color_map: map(1), normal_map: map(0), ..base },
    ];
    let scene = textured("builtin:teapot@4k", vec![texture(32, false), texture(7, false)], materials);
    let all = |settings| Settings { outputs: EVERYTHING, ..settings };
    check_all(&scene, &all(Settings::one_sample(131, 93)), "one sample");
    check_all(&scene, &all(Settings::new(131, 93)), "four samples");
    for texture_filter in [TextureFilter::Nearest, TextureFilter::Anisotropic] {
        check_all(&scene, &Settings { texture_filter, ..Settings::new(90, 64) }, "another filter");
    }
}

/// Surfaces that are seen through where their texture is clear, or have holes there.
#[test]
fn textures_with_alpha() {
    let materials = vec![
        Material { base_color_map: map(0), ..Material::default() },
        Material { base_color_map: map(0), alpha_mode: AlphaMode::Cutout(0.5), ..Material::default() },
        Material { base_color_map: map(1), opacity_map: map(0), opacity: 0.8, ..Material::default() },
    ];
    let scene = textured("builtin:soup@1k", vec![texture(16, true), texture(9, false)], materials);
    assert!(scene.instances[0].is_translucent());
    check_all(&scene, &Settings { outputs: EVERYTHING, ..Settings::one_sample(90, 64) }, "one sample");
    check_all(&scene, &Settings { outputs: EVERYTHING, ..Settings::new(90, 64) }, "four samples");
    check_all(&scene, &Settings { layer_memory: 1, ..Settings::new(60, 45) }, "little memory");
}
