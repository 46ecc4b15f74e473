//! Normal maps held against the tangent frame of a triangle in `f64`, for texture coordinates and instances that are
//! mirrored, rotated, sheared and scaled differently along their axes.

mod common;

use std::sync::Arc;

use common::*;
use glam::{DAffine3, DMat2, DMat3, DVec2, DVec3};
use tercio_mesh::{FileMaterial, Mesh, OctNormal};
use tercio_raster::{Outputs, Settings, Shading};
use tercio_scene::texture::Encoding;
use tercio_scene::{
    Background, Camera, InstanceMaterials, Light, LightSpace, Material, Scene, Texture, TextureMap, Wrap,
};

const SIZE: [u32; 2] = [32, 24];

/// Largest error of the cosine of an angle between the bumped normal and a light. Numbers of the renderer have 24 bits, and a
/// vertex normal 32: 0.004 degrees are 7e-5.
const ERROR: f64 = 1e-6;
const ERROR_OF_VERTEX_NORMALS: f64 = 1e-4;

/// A square in the plane z = 0, from -1 to 1, whose texture coordinates are those of the plane, transformed.
fn square(uv: DMat2) -> Mesh {
    let at = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    Mesh {
        positions: at.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        texcoords: Some(
            at.iter().map(|&[x, y]| (uv * DVec2::new(x.into(), y.into())).as_vec2().into()).collect(),
        ),
        materials: vec![FileMaterial::default()],
        triangle_materials: Some(vec![0, 0]),
        ..Mesh::default()
    }
}

/// A scene of a mesh with a normal map of one colour, and a light in which the linear colour of a point is the cosine of the
/// angle between the normal and the direction to the light, if that is positive.
fn lit(mesh: &Mesh, color: [u8; 3], map: TextureMap, scale: f32, place: DAffine3, to_light: DVec3) -> Scene {
    let mut scene = scene(mesh);
    scene.background = Background::Solid([0.0, 0.0, 0.0, 1.0]);
    let [r, g, b] = color;
    scene.textures = vec![Arc::new(Texture::from_rgba8(4, 4, &[[r, g, b, 255]; 16], Encoding::Linear))];
    scene.materials = vec![Material {
        base_color: [1.0; 3],
        specular: [0.0; 3],
        normal_map: Some(map),
        normal_scale: scale,
        ..Material::default()
    }];
    scene.lights = vec![Light::Directional { to_light, space: LightSpace::World, color: [1.0; 3] }];
    let materials = InstanceMaterials::new(&scene.instances[0].mesh, vec![0], &scene);
    scene.instances[0].materials = Some(materials);
    scene.instances[0].world_from_object = place;
    scene
}

/// The normal on the side of the viewer that a colour of the map stands for, in the world: its components are along the
/// directions in which u and v grow on the surface, and along the normal.
fn expected(
    color: [u8; 3],
    map: &TextureMap,
    scale: f32,
    uv: DMat2,
    place: DAffine3,
    normal: DVec3,
) -> DVec3 {
    let [x, y, z] = color.map(|c| f64::from(c) / 127.5 - 1.0);
    let map_scale = DVec2::from(map.scale.map(f64::from));
    // How the position on the square changes with u and v.
    let by_uv = (DMat2::from_diagonal(map_scale) * uv).inverse();
    let along = |axis: DVec2| {
        let in_world = place.matrix3 * DVec3::new(axis.x, axis.y, 0.0);
        (in_world - normal * in_world.dot(normal)).normalize()
    };
    let (along_u, along_v) = (along(by_uv.x_axis), along(by_uv.y_axis));
    ((along_u * x + along_v * y) * f64::from(scale) + normal * z).normalize()
}

/// Transformations of texture coordinates: as they are, mirrored in each way, rotated, stretched and sheared.
fn coordinates() -> Vec<(&'static str, DMat2)> {
    let of = |a: f64, b: f64, c: f64, d: f64| DMat2::from_cols(DVec2::new(a, b), DVec2::new(c, d));
    vec![
        ("plain", DMat2::IDENTITY),
        ("mirrored in u", of(-1.0, 0.0, 0.0, 1.0)),
        ("mirrored in v", of(1.0, 0.0, 0.0, -1.0)),
        ("rotated", DMat2::from_angle(0.7)),
        ("rotated and mirrored", DMat2::from_angle(-2.1) * of(1.0, 0.0, 0.0, -1.0)),
        ("stretched", of(0.3, 0.0, 0.0, 7.0)),
        ("sheared", of(1.0, 0.4, -0.6, 1.2)),
    ]
}

/// Places of the instance: scaled differently along its axes, rotated, and mirrored.
fn places() -> Vec<(&'static str, DAffine3)> {
    let rotated = DMat3::from_axis_angle(DVec3::new(0.3, 1.0, -0.2).normalize(), 0.6);
    let sheared =
        DMat3::from_cols(DVec3::new(1.0, 0.2, 0.1), DVec3::new(0.5, 0.8, 0.0), DVec3::new(0.3, -0.2, 2.0));
    let of = |matrix3: DMat3| DAffine3 { matrix3, translation: DVec3::new(0.1, -0.2, 0.3) };
    vec![
        ("in place", DAffine3::IDENTITY),
        ("scaled", of(DMat3::from_diagonal(DVec3::new(2.0, 0.5, 3.0)))),
        ("rotated after scaling", of(rotated * DMat3::from_diagonal(DVec3::new(1.5, 0.6, 0.2)))),
        ("mirrored", of(rotated * DMat3::from_diagonal(DVec3::new(-1.2, 0.7, 1.0)))),
        ("sheared", of(sheared)),
    ]
}

/// Draws the middle of the square, and expects the light of the formula. `normal` is that of the surface without a texture, on
/// either side; the camera looks at the surface from its side and from the other one.
fn check(mesh: &Mesh, uv: DMat2, place: DAffine3, normal: DVec3, error: f64, what: &str) -> f64 {
    let (mut worst, mut lit_ones, mut all) = (0.0f64, 0, 0);
    let plane = (place.matrix3.x_axis).cross(place.matrix3.y_axis).normalize();
    let normal = if normal.dot(plane) < 0.0 { -normal } else { normal };
    let settings = Settings {
        outputs: Outputs { linear: true, ..Outputs::NONE },
        shading: Shading::Phong,
        ..Settings::one_sample(SIZE[0], SIZE[1])
    };
    for side in [1.0, -1.0] {
        // Nearly along the normal, so that no bumped normal points away from the viewer.
        let eye = place.translation + (plane * side + place.matrix3.x_axis.normalize() * 0.1) * 5.0;
        let camera =
            Camera { up: place.matrix3.y_axis, ..orthographic(eye.into(), place.translation.into(), 0.2) };
        let seen = normal * side;
        for (color, scale) in [([170, 100, 220], 1.0), ([90, 128, 200], 0.5), ([128, 60, 240], -1.5)] {
            for map_scale in [[1.0, 1.0], [-2.0, 0.5]] {
                let map = TextureMap { scale: map_scale, wrap: [Wrap::Repeat; 2], ..TextureMap::new(0) };
                let expected = expected(color, &map, scale, uv, place, seen);
                // Three lights tell all directions apart.
                for axis in [plane * side, place.matrix3.x_axis.normalize(), place.matrix3.y_axis.normalize()]
                {
                    let to_light = (axis * 0.5 + plane * side).normalize();
                    let scene = lit(mesh, color, map, scale, place, to_light);
                    let frame = draw(&scene, &camera, &settings);
                    let cosine = expected.dot(to_light).clamp(0.0, 1.0);
                    for linear in &frame.planes.linear {
                        let found = (f64::from(linear[0]) - cosine).abs();
                        worst = worst.max(found);
                        let of = format!("{what}, side {side}, {color:?} times {scale}, map {map_scale:?}");
                        assert!(found <= error, "{of}: {} in place of {cosine}", linear[0]);
                    }
                    (lit_ones, all) = (lit_ones + u32::from(cosine > 0.1), all + 1);
                }
            }
        }
    }
    assert!(lit_ones * 4 > all * 3, "{what}: {lit_ones} of {all} cases are lit");
    worst
}

#[test]
fn a_normal_map_tilts_in_the_frame_of_its_coordinates() {
    let mut worst = 0.0f64;
    for (name, uv) in coordinates() {
        for (place_name, place) in places() {
            let normal = place.matrix3.x_axis.cross(place.matrix3.y_axis).normalize();
            let what = format!("{name}, {place_name}");
            worst = worst.max(check(&square(uv), uv, place, normal, ERROR, &what));
        }
    }
    println!("worst error {worst:e}");
}

/// The frame of a surface with vertex normals is perpendicular to these.
#[test]
fn vertex_normals_are_tilted_in_place_of_the_planes() {
    let mut worst = 0.0f64;
    let own = DVec3::new(0.2, -0.1, 1.0).normalize();
    for (name, uv) in coordinates() {
        for (place_name, place) in places() {
            let encoded = OctNormal::encode(own.as_vec3().into());
            let mesh = Mesh { normals: Some(vec![encoded; 4]), ..square(uv) };
            let normal = (place.matrix3.inverse().transpose() * own).normalize();
            let what = format!("vertex normals, {name}, {place_name}");
            worst = worst.max(check(&mesh, uv, place, normal, ERROR_OF_VERTEX_NORMALS, &what));
        }
    }
    println!("worst error {worst:e}");
}
