//! Shadows: every path draws the bytes of the reference, and a point is in shadow where rays towards the light say so.

mod common;

use std::sync::Arc;

use common::*;
use glam::DVec3;
use tercio_mesh::Mesh;
use tercio_raster::{
    Outputs, RenderError, Renderer, SamplePattern, Sampling, Settings, Shading, ShadowArea, ShadowMaps,
};
use tercio_scene::{Camera, Light, LightSpace, Scene};
use tercio_testkit::ray_caster::RayCaster;

const WORLD: LightSpace = LightSpace::World;

fn every_light() -> Vec<Light> {
    let camera = LightSpace::Camera;
    vec![
        Light::Ambient { color: [0.1; 3] },
        Light::Directional { to_light: DVec3::new(0.3, 1.0, 0.2), space: WORLD, color: [0.5; 3] },
        Light::Directional { to_light: DVec3::new(-0.9, 0.3, 0.6), space: camera, color: [0.2, 0.1, 0.3] },
        Light::Point { position: DVec3::new(0.2, 0.1, 0.15), space: WORLD, color: [0.4, 0.3, 0.1] },
        Light::Spot {
            position: DVec3::new(1.0, 2.0, 1.5),
            direction: DVec3::new(-1.0, -2.0, -1.4),
            space: WORLD,
            angle: 0.3,
            color: [0.2, 0.9, 0.4],
        },
        Light::Wide { to_light: DVec3::Z, space: camera, color: [0.3; 3], highlight: true },
    ]
}

/// With the shadows of the scene's lights.
fn shadowed(scene: &Scene, camera: &Camera, settings: Settings, size: u32) -> Settings {
    let shadows = ShadowMaps::draw(scene, camera, &settings, (size, ShadowArea::Picture)).expect("shadows");
    Settings { shadows: Some(Arc::new(shadows)), ..settings }
}

#[test]
fn every_path_draws_the_shadows_of_the_reference() {
    let mesh = soup(2_000, 1);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mut scene = with_second_instance(scene(&mesh));
    scene.lights = every_light();
    for shading in [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Unlit, Shading::Physical] {
        let four = Sampling::of(SamplePattern::Sparse4);
        for settings in [everything(70, 50), Settings { sampling: four, ..everything(51, 38) }] {
            let settings = shadowed(&scene, &camera, Settings { shading, ..settings }, 128);
            check_all(&mesh, &scene, &camera, &settings, &format!("{shading:?}"));
        }
    }
    scene.instances[0].surface.opacity = 0.4;
    let inside = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    let settings = shadowed(&scene, &inside, everything(70, 50), 128);
    check_all(&mesh, &scene, &inside, &settings, "inside, not opaque");
}

#[test]
fn spot_lights_without_shadows() {
    let mesh = soup(2_000, 2);
    let mut scene = scene(&mesh);
    scene.lights = every_light();
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    check_all(&mesh, &scene, &camera, &everything(70, 50), "spot");
}

/// A mesh with its normals, scaled.
fn scaled(mesh: &Mesh, scale: f32) -> Mesh {
    let positions = mesh.positions.iter().map(|p| p.map(|c| c * scale)).collect();
    Mesh { positions, ..mesh.clone() }
}

/// Balls over a floor, a thin post, and a ring of blocks: convex and concave surfaces, contacts and gaps.
fn still_life() -> Mesh {
    let mut mesh = Mesh::default();
    let mut add = |part: Mesh, scale: [f32; 3], at: [f32; 3]| {
        let first = mesh.positions.len() as u32;
        let moved = part.positions.iter().map(|p| [0, 1, 2].map(|k| p[k] * scale[k] + at[k]));
        mesh.positions.extend(moved);
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    };
    add(sphere(24), [0.5; 3], [0.0, 0.5, 0.0]);
    add(sphere(16), [0.25; 3], [0.7, 0.25, 0.3]);
    add(sphere(20), [0.05, 0.8, 0.05], [-0.7, 0.7, 0.2]);
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let block = Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    };
    add(block.clone(), [1.6, 0.05, 1.6], [0.0, -0.05, 0.0]);
    for i in 0..5 {
        add(block.clone(), [0.08, 0.2, 0.08], [-0.9 + 0.35 * i as f32, 0.2, 0.9]);
    }
    mesh
}

/// The share of pixels, of those that face the light, whose shade is not that of a ray towards the light, away from the edges
/// of shadows; and the share of pixels that are. `reach` is half the edge of what the map may have.
fn wrong_pixels(mesh: &Mesh, light: Light, camera: &Camera, size: u32, reach: f64) -> (f64, f64) {
    let mut scene = scene(mesh);
    scene.lights = vec![light];
    scene.instances[0].surface.specular = 0.0;
    let (width, height) = (240, 180);
    let outputs = Outputs { linear: true, ids: true, ..Outputs::NONE };
    let plain = Settings { outputs, shading: Shading::Flat, ..Settings::one_sample(width, height) };
    let dark = shadowed(&scene, camera, plain.clone(), size);
    let (plain, dark) = (draw(&scene, camera, &plain), draw(&scene, camera, &dark));
    let corners: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from))))
        .collect();
    let caster = RayCaster::new(corners.iter().map(|t| t.map(|p| p.to_array())).collect());
    let basis = camera.basis().expect("axes");
    let per_pixel = match camera.projection {
        tercio_scene::Projection::Perspective { fov_y } => 2.0 * (fov_y / 2.0).tan() / f64::from(height),
        tercio_scene::Projection::Orthographic { .. } => unreachable!("perspective cameras only"),
    };
    let radius = scene.bounds().radius();
    let is_lit = |point: DVec3, normal: DVec3| {
        let to_light = match light {
            Light::Directional { to_light, .. } => to_light.normalize() * (4.0 * radius),
            Light::Point { position, .. } | Light::Spot { position, .. } => position - point,
            _ => unreachable!("has no shadows"),
        };
        let from = point + normal * (1e-6 * radius);
        let hit = caster.first_hit(from.to_array(), to_light.to_array(), 0.0);
        hit.is_none_or(|hit| hit.distance > 1.0)
    };
    // Shadows end within about two texels, which are this long at the light's distance.
    let texel = 2.0 * reach / f64::from(size) * 2.5;
    let (mut seen, mut decided, mut wrong) = (0.0, 0.0, 0.0);
    for (i, face) in plain.planes.ids.iter().enumerate() {
        let Some(t) = corners.get(*face as usize) else { continue };
        let (x, y) = ((i as u32 % width) as f64 + 0.5, (i as u32 / width) as f64 + 0.5);
        let across = basis.right * (x - f64::from(width) / 2.0) - basis.up * (y - f64::from(height) / 2.0);
        let ray = basis.forward + across * per_pixel;
        let mut normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
        // On the plane of the triangle: corners on the screen, and depths with them, are rounded.
        let point = camera.eye + ray * (normal.dot(t[0] - camera.eye) / normal.dot(ray));
        if normal.dot(ray) > 0.0 {
            normal = -normal;
        }
        let bright = f64::from(plain.planes.linear[i][1]);
        // Facing the light, not at a grazing angle.
        if bright < 0.08 {
            continue;
        }
        seen += 1.0;
        let lit = is_lit(point, normal);
        // At a grazing angle, texels are longer on the surface.
        let tangent = normal.any_orthonormal_vector() * texel * (0.9 / bright);
        let other = normal.cross(tangent);
        let around = [
            tangent,
            -tangent,
            other,
            -other,
            tangent + other,
            tangent - other,
            -tangent + other,
            -tangent - other,
        ];
        if around.iter().any(|&by| is_lit(point + by, normal) != lit) {
            continue;
        }
        decided += 1.0;
        let share = f64::from(dark.planes.linear[i][1]) / bright;
        if (share - f64::from(u8::from(lit))).abs() > 0.05 {
            wrong += 1.0;
        }
    }
    assert!(seen > 5_000.0, "{seen} pixels face the light");
    (wrong / decided, decided / seen)
}

fn lights() -> [Light; 4] {
    let color = [0.9; 3];
    let position = DVec3::new(1.3, 2.1, 1.0);
    [
        Light::Directional { to_light: DVec3::new(0.6, 1.0, 0.5), space: WORLD, color },
        Light::Point { position, space: WORLD, color },
        Light::Spot { position, direction: DVec3::new(-1.3, -2.0, -1.0), space: WORLD, angle: 0.7, color },
        Light::Spot { position, direction: DVec3::new(-1.3, -2.0, -1.0), space: WORLD, angle: 1.2, color },
    ]
}

#[test]
fn shadows_are_those_of_rays() {
    let camera = perspective([1.5, 2.2, 3.4], [0.0, 0.3, 0.0], 35.0);
    for light in lights() {
        let mesh = still_life();
        let (wrong, decided) = wrong_pixels(&mesh, light, &camera, 2048, mesh.bounds().radius());
        println!("{light:?}: {:.3} % wrong, {:.1} % decided", 100.0 * wrong, 100.0 * decided);
        assert!(wrong < 0.005, "{light:?}: {wrong}");
        assert!(decided > 0.8, "{light:?}: {decided}");
    }
}

/// What is small in a large scene has shadows when it is seen from near: the map then has only what is seen.
#[test]
fn small_things_on_a_large_floor_have_their_shadows() {
    let mut mesh = still_life();
    let first = mesh.positions.len() as u32;
    let corners = [[-1000.0, -1000.0], [1000.0, -1000.0], [1000.0, 1000.0], [-1000.0, 1000.0]];
    mesh.positions.extend(corners.map(|[x, z]| [x, -0.1, z]));
    mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| first + v)));
    let camera = perspective([1.5, 2.2, 3.4], [0.0, 0.3, 0.0], 35.0);
    for to_light in [DVec3::new(0.6, 1.0, 0.5), DVec3::new(-0.4, 1.0, 0.2)] {
        let light = Light::Directional { to_light, space: WORLD, color: [0.9; 3] };
        // The finest map, a 64th of that of the whole scene.
        let reach = mesh.bounds().radius() / 64.0;
        let (wrong, decided) = wrong_pixels(&mesh, light, &camera, 2048, reach);
        assert!(wrong < 0.005 && decided > 0.5, "{to_light}: {wrong} wrong, {decided} decided");
    }
}

/// Where coordinates are so large that a direction between neighbouring ones is rounded, the map is where the window is: below a roof
/// all is dark.
#[test]
fn windows_far_from_the_origin_have_all_that_is_seen() {
    let sheet = |y: f32, reach: f32| {
        [[-reach, -reach], [reach, -reach], [reach, reach], [-reach, reach]].map(|[x, z]| [x, y, z])
    };
    let mesh = Mesh {
        positions: [sheet(0.0, 1.0), sheet(0.05, 1.0)].concat(),
        triangles: vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]],
        ..Mesh::default()
    };
    let size = 1e9;
    for place in [0.0, 1e11, 3e11, 1e12, 1.2e12] {
        let mut scene = scene(&mesh);
        let at = DVec3::new(place, 0.0, place);
        scene.instances[0].world_from_object =
            glam::DAffine3::from_scale_rotation_translation(DVec3::splat(size), glam::DQuat::IDENTITY, at);
        scene.lights =
            vec![Light::Directional { to_light: DVec3::new(0.1, 1.0, 0.05), space: WORLD, color: [1.0; 3] }];
        // Between floor and roof, downwards, where a 64th of the scene is seen.
        let eye = at + DVec3::new(0.3, 0.045, 0.2) * size;
        let (target, up) = (eye - DVec3::Y * size, DVec3::Z);
        let projection = tercio_scene::Projection::Orthographic { height: 0.03 * size };
        let camera = Camera { eye, target, up, projection, near: None, shift: [0.0; 2] };
        let outputs = Outputs { linear: true, ..Outputs::NONE };
        let dark = shadowed(&scene, &camera, Settings { outputs, ..Settings::one_sample(400, 400) }, 2048);
        let dark = draw(&scene, &camera, &dark);
        assert!(dark.planes.linear.iter().all(|light| light[3] == 1.0 && light[1] < 1e-3), "at {place}");
    }
}

/// Far from the origin, numbers have no room for a distance of 1.
#[test]
fn shadows_far_from_the_origin() {
    let (mesh, scale) = (still_life(), 1e18f64);
    let mut scene = scene(&mesh);
    scene.instances[0].world_from_object = glam::DAffine3::from_scale(DVec3::splat(scale));
    scene.lights = vec![lights()[0]];
    let mut camera = perspective([1.5, 2.2, 3.4], [0.0, 0.3, 0.0], 35.0);
    (camera.eye, camera.target) = (camera.eye * scale, camera.target * scale);
    let outputs = Outputs { linear: true, ..Outputs::NONE };
    let large = shadowed(&scene, &camera, Settings { outputs, ..Settings::one_sample(120, 90) }, 512);
    let large = draw(&scene, &camera, &large);
    scene.instances[0].world_from_object = glam::DAffine3::IDENTITY;
    let camera = perspective([1.5, 2.2, 3.4], [0.0, 0.3, 0.0], 35.0);
    let small = shadowed(&scene, &camera, Settings { outputs, ..Settings::one_sample(120, 90) }, 512);
    let small = draw(&scene, &camera, &small);
    let differ = |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).any(|k| (a[k] - b[k]).abs() > 0.05);
    let differing = large.planes.linear.iter().zip(&small.planes.linear).filter(differ).count();
    assert!(differing < 120 * 90 / 200, "{differing} pixels differ");
}

/// A curved scan alone does not shadow what faces the light, whatever its size.
#[test]
fn curved_surfaces_have_no_acne_at_any_scale() {
    for scale in [1e-6f32, 1.0, 1e6] {
        let mesh = scaled(&sphere(40), scale);
        let s = f64::from(scale);
        let mut camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
        (camera.eye, camera.target) = (camera.eye * s, camera.target * s);
        let mut scene = scene(&mesh);
        for (size, to_light) in [(256, DVec3::new(1.0, 1.0, 1.0)), (2048, DVec3::new(-1.0, 0.5, 2.0))] {
            let to_light = to_light.normalize();
            scene.lights = vec![Light::Directional { to_light, space: WORLD, color: [1.0; 3] }];
            let outputs = Outputs { linear: true, normals: true, ..Outputs::NONE };
            let plain = Settings { outputs, ..Settings::one_sample(200, 200) };
            let dark = shadowed(&scene, &camera, plain.clone(), size);
            let (plain, dark) = (draw(&scene, &camera, &plain), draw(&scene, &camera, &dark));
            let (mut facing, mut darker) = (0, 0);
            for (i, normal) in plain.planes.normals.iter().enumerate() {
                let cosine = DVec3::from(normal.map(f64::from)).dot(to_light);
                if plain.planes.linear[i][3] > 0.0 && cosine > 0.15 {
                    facing += 1;
                    let [before, after] = [&plain, &dark].map(|frame| frame.planes.linear[i][1]);
                    darker += u32::from(after < 0.99 * before);
                }
            }
            assert!(facing > 3_000, "{facing} pixels");
            assert_eq!(darker, 0, "scale {scale}, {size} texels, of {facing}");
        }
    }
}

/// Where a floor meets a wall and both are lit, the texels beyond the corner show the other one, which is nearer to the
/// light than the plane of the first, continued.
#[test]
fn lit_inward_corners_have_no_dark_line() {
    let corner = |x: f32, y: f32, z: f32| [x, y, z];
    let mesh = Mesh {
        positions: vec![
            corner(-1.0, 0.0, 0.0),
            corner(1.0, 0.0, 0.0),
            corner(1.0, 0.0, 1.0),
            corner(-1.0, 0.0, 1.0),
            corner(1.0, 1.0, 0.0),
            corner(-1.0, 1.0, 0.0),
        ],
        triangles: vec![[3, 2, 1], [3, 1, 0], [0, 1, 4], [0, 4, 5]],
        ..Mesh::default()
    };
    let mut scene = scene(&mesh);
    scene.instances[0].surface.specular = 0.0;
    let camera = perspective([0.3, 0.8, 1.2], [0.0, 0.05, 0.1], 20.0);
    for to_light in [DVec3::new(0.2, 1.0, 1.0), DVec3::new(-0.3, 0.7, 1.0), DVec3::new(0.1, 1.0, 0.6)] {
        scene.lights = vec![Light::Directional { to_light, space: WORLD, color: [1.0; 3] }];
        let outputs = Outputs { linear: true, ..Outputs::NONE };
        let plain = Settings { outputs, shading: Shading::Flat, ..Settings::one_sample(200, 150) };
        for size in [512, 2048] {
            let dark = shadowed(&scene, &camera, plain.clone(), size);
            let (plain, dark) = (draw(&scene, &camera, &plain), draw(&scene, &camera, &dark));
            let lit = plain.planes.linear.iter().zip(&dark.planes.linear).filter(|(plain, _)| plain[1] > 0.1);
            let (mut count, mut darker, mut least) = (0.0, 0.0, 1.0f32);
            for (plain, dark) in lit {
                let left = dark[1] / plain[1];
                (count, least) = (count + 1.0, least.min(left));
                darker += f64::from(u8::from(left < 0.95));
            }
            assert!(count > 10_000.0, "{count}");
            // Without room for the other side of the corner, 2 % of the pixels at 512 texels, down to 55 % of the light.
            let what = format!("{to_light}, {size} texels: {darker} of {count} pixels, down to {least}");
            assert!(darker < 0.006 * count && least > 0.6, "{what}");
        }
    }
}

#[test]
fn shadows_of_other_lights_are_refused() {
    let mesh = soup(10, 3);
    let (mut scene, camera) = (scene(&mesh), perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0));
    scene.lights = every_light();
    let settings = shadowed(&scene, &camera, everything(10, 10), 16);
    let moved = perspective([0.5, 1.0, 2.0], [0.0; 3], 40.0);
    let error = Renderer::new().render(&scene, &moved, &settings).unwrap_err();
    assert!(matches!(error, RenderError::Setting { what: "shadows", .. }), "{error}");
    scene.lights.pop();
    let error = Renderer::new().render(&scene, &camera, &settings).unwrap_err();
    assert!(matches!(error, RenderError::Setting { what: "shadows", .. }), "{error}");
}

/// Maps of what a picture shows are those of no other picture; maps of the scene are.
#[test]
fn maps_of_a_picture_are_for_it_alone() {
    let mesh = scaled(&sphere(20), 100.0);
    let mut scene = scene(&mesh);
    // From behind the camera, so that a narrow view is narrow for the light, too.
    scene.lights =
        vec![Light::Directional { to_light: DVec3::new(0.1, 0.2, 1.0), space: WORLD, color: [1.0; 3] }];
    let near = perspective([0.0, 0.0, 110.0], [0.0; 3], 5.0);
    let other = perspective([0.0, 1.0, 110.0], [0.0; 3], 5.0);
    for (area, is_refused) in [(ShadowArea::Picture, true), (ShadowArea::Scene, false)] {
        let settings = Settings::one_sample(40, 30);
        let maps = Arc::new(ShadowMaps::draw(&scene, &near, &settings, (128, area)).expect("shadows"));
        let with =
            |width, height| Settings { shadows: Some(maps.clone()), ..Settings::one_sample(width, height) };
        assert!(Renderer::new().render(&scene, &near, &with(40, 30)).is_ok());
        for (camera, settings) in [(&other, with(40, 30)), (&near, with(80, 30))] {
            let result = Renderer::new().render(&scene, camera, &settings);
            let is_error = matches!(result, Err(RenderError::Setting { what: "shadows", .. }));
            assert_eq!(is_error, is_refused, "{area:?}");
        }
    }
}
