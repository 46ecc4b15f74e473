//! Textures held against formulas in `f64` that share no code with the renderer: rays through the middles of pixels, a filter
//! of their own, and the mean of what a pixel covers.

mod common;

use std::sync::Arc;

use common::*;
use glam::{DVec2, DVec3};
use tercio_mesh::{FileMaterial, Mesh};
use tercio_raster::{Outputs, Settings, Shading, TextureFilter};
use tercio_scene::texture::Encoding;
use tercio_scene::{Background, Camera, InstanceMaterials, Material, Scene, Texture, TextureMap, Wrap};

type Color = [f64; 3];

/// A picture in linear light.
struct Picture {
    width: usize,
    height: usize,
    texels: Vec<Color>,
}

impl Picture {
    fn new(width: usize, height: usize, level: impl Fn(usize, usize) -> [u8; 3]) -> (Self, Texture) {
        let pixels: Vec<[u8; 3]> = (0..width * height).map(|i| level(i % width, i / width)).collect();
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let texels = pixels.iter().map(|p| p.map(linear)).collect();
        let rgba: Vec<[u8; 4]> = pixels.iter().map(|p| [p[0], p[1], p[2], 255]).collect();
        let texture = Texture::from_rgba8(width as u32, height as u32, &rgba, Encoding::Srgb);
        (Self { width, height, texels }, texture)
    }

    /// The next mipmap of a picture whose sizes are powers of two.
    fn half(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let (across, down) = (self.width / width, self.height / height);
        let mean = |x: usize, y: usize| {
            let mut sum = [0.0; 3];
            for (i, j) in (0..down).flat_map(|j| (0..across).map(move |i| (i, j))) {
                let from = self.texels[(y * down + j) * self.width + x * across + i];
                (0..3).for_each(|k| sum[k] += from[k] / (across * down) as f64);
            }
            sum
        };
        let texels = (0..width * height).map(|i| mean(i % width, i / width)).collect();
        Self { width, height, texels }
    }

    /// The repeated picture at a point, interpolated between four texels.
    fn at(&self, uv: DVec2) -> Color {
        let (x, y) = (uv.x * self.width as f64 - 0.5, (1.0 - uv.y) * self.height as f64 - 0.5);
        let texel = |i: f64, j: f64| {
            let (i, j) = (i.rem_euclid(self.width as f64), j.rem_euclid(self.height as f64));
            self.texels[j as usize * self.width + i as usize]
        };
        let (i, j) = (x.floor(), y.floor());
        let mix =
            |a: Color, b: Color, t: f64| -> Color { std::array::from_fn(|k| a[k] * (1.0 - t) + b[k] * t) };
        let upper = mix(texel(i, j), texel(i + 1.0, j), x - i);
        let lower = mix(texel(i, j + 1.0), texel(i + 1.0, j + 1.0), x - i);
        mix(upper, lower, y - j)
    }

    /// The repeated picture at a point: the texel there.
    fn nearest(&self, uv: DVec2) -> Color {
        let x = (uv.x.rem_euclid(1.0) * self.width as f64) as usize;
        let y = ((1.0 - uv.y).rem_euclid(1.0) * self.height as f64) as usize;
        self.texels[y.min(self.height - 1) * self.width + x.min(self.width - 1)]
    }
}

/// A square in the plane z = 0, from -1 to 1, with texture coordinates from 0 to `repeats`.
fn square(repeats: f32) -> Mesh {
    let at = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let material = FileMaterial { diffuse: [1.0; 3], ..FileMaterial::default() };
    Mesh {
        positions: at.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        texcoords: Some(at.iter().map(|p| p.map(|c: f32| (c + 1.0) * 0.5 * repeats)).collect()),
        materials: vec![material],
        triangle_materials: Some(vec![0, 0]),
        ..Mesh::default()
    }
}

fn textured(mesh: &Mesh, texture: Texture) -> Scene {
    let mut scene = scene(mesh);
    scene.background = Background::Solid([0.0, 0.0, 0.0, 1.0]);
    scene.textures = vec![Arc::new(texture)];
    scene.materials = vec![Material { base_color_map: Some(TextureMap::new(0)), ..Material::default() }];
    let materials = InstanceMaterials::new(&scene.instances[0].mesh, vec![0], &scene);
    scene.instances[0].materials = Some(materials);
    scene
}

/// Texture coordinates where the ray through a point of the picture meets the square's plane, if it meets the square.
fn seen(camera: &Camera, size: [u32; 2], at: [f64; 2], repeats: f64) -> Option<DVec2> {
    let (from, towards) = ray(camera, size, at);
    let hit = from - towards * (from.z / towards.z);
    let is_inside = hit.x.abs() < 1.0 && hit.y.abs() < 1.0 && (hit - from).dot(towards) > 0.0;
    is_inside.then(|| (DVec2::new(hit.x, hit.y) + 1.0) * 0.5 * repeats)
}

/// The filter of the renderer, from its description: the axes of the ellipse that a pixel covers, up to 16 points along the
/// longer one, and two mipmaps. Also how close the number of points is to another one.
fn filtered(levels: &[Picture], uv: DVec2, right: DVec2, down: DVec2, anisotropic: bool) -> (Color, f64) {
    let size = DVec2::new(levels[0].width as f64, levels[0].height as f64);
    let j = glam::DMat2::from_cols(right * size, down * size);
    // Singular values and the direction of the larger one.
    let square = j * j.transpose();
    let (trace, determinant) = (square.x_axis.x + square.y_axis.y, square.determinant());
    let larger = trace / 2.0 + (trace * trace / 4.0 - determinant).max(0.0).sqrt();
    let (major, minor) = (larger.sqrt(), j.determinant().abs() / larger.sqrt());
    if major <= 1.0 {
        return (levels[0].at(uv), 1.0);
    }
    let ratio = major / minor.max(1.0);
    let count = if anisotropic { (ratio + 0.5).floor().clamp(1.0, 16.0) } else { 1.0 };
    let undecided = if anisotropic && ratio < 16.0 { ((ratio + 0.5).fract() - 0.5).abs() } else { 0.0 };
    let axis = {
        // (A - smaller * I) maps everything onto the larger axis.
        let smaller = trace - larger;
        let (a, b) = (square.x_axis - DVec2::X * smaller, square.y_axis - DVec2::Y * smaller);
        let longer = if a.length() > b.length() { a } else { b };
        longer.normalize_or_zero() * major / size
    };
    let width = (major / count).max(1.0);
    let level = width.log2().floor();
    let (fraction, level) = (width / level.exp2() - 1.0, level as usize);
    let last = levels.len() - 1;
    let mut sum = [0.0; 3];
    for i in 0..count as usize {
        let t = (i as f64 + 0.5) / count - 0.5;
        let at = uv + axis * if count > 1.0 { t } else { 0.0 };
        let (a, b) = (levels[level.min(last)].at(at), levels[(level + 1).min(last)].at(at));
        (0..3).for_each(|k| sum[k] += (a[k] + (b[k] - a[k]) * fraction) / count);
    }
    (sum, 0.5 - undecided)
}

/// Cameras that see the square from the front, at an angle, grazing, rolled, and from near.
fn cameras() -> Vec<Camera> {
    let mut cameras = vec![
        perspective([0.1, 0.05, 3.0], [0.0; 3], 40.0),
        perspective([1.2, 1.5, 1.0], [0.1, 0.0, 0.0], 50.0),
        perspective([0.3, -1.6, 0.12], [0.0, 0.2, 0.0], 45.0),
        perspective([0.1, 0.1, 0.3], [0.0, 0.05, 0.0], 30.0),
        orthographic([0.4, -2.0, 0.6], [0.0; 3], 2.0),
    ];
    let rolled = Camera { up: DVec3::new(0.7, 0.5, 0.4), ..cameras[2] };
    cameras.push(rolled);
    cameras
}

fn noise(seed: u64) -> impl Fn(usize, usize) -> [u8; 3] {
    move |x, y| {
        let mut random = Random(seed + (x * 4096 + y) as u64 * 7919);
        [0; 3].map(|_: u8| (random.next() * 256.0) as u8)
    }
}

fn unlit(texture_filter: TextureFilter) -> Settings {
    let outputs = Outputs { linear: true, ..Outputs::NONE };
    Settings { shading: Shading::Unlit, outputs, texture_filter, ..Settings::one_sample(120, 90) }
}

/// Corners are snapped to 1/256 pixel, which moves a texture by at most as much: in a texture of noise, whose texels are at
/// least as wide as half a pixel after filtering, by some 1 % of the contrast.
#[test]
fn textures_equal_a_filter_in_double_precision() {
    let repeats = 3.0;
    for (size, seed) in [([64, 64], 1), ([256, 128], 2), ([8, 1024], 3)] {
        let (picture, texture) = Picture::new(size[0], size[1], noise(seed));
        let scene = textured(&square(repeats as f32), texture);
        let mut levels = vec![picture];
        while levels.last().is_some_and(|l| l.width > 1 || l.height > 1) {
            levels.push(levels[levels.len() - 1].half());
        }
        for (number, camera) in cameras().iter().enumerate() {
            for filter in [TextureFilter::Trilinear, TextureFilter::Anisotropic] {
                let settings = unlit(filter);
                let frame = draw(&scene, camera, &settings);
                let (mut compared, mut sum, mut worst) = (0, 0.0, 0.0f64);
                for (i, linear) in frame.planes.linear.iter().enumerate() {
                    let at = [(i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5];
                    let uv = |dx: f64, dy: f64| seen(camera, [120, 90], [at[0] + dx, at[1] + dy], repeats);
                    // The middle of a pixel that the square covers, with a margin for snapping.
                    let around = [uv(0.0, 0.0), uv(0.01, 0.0), uv(-0.01, 0.0), uv(0.0, 0.01), uv(0.0, -0.01)];
                    let [Some(middle), Some(r), Some(l), Some(d), Some(u)] = around else { continue };
                    let (right, down) = ((r - l) / 0.02, (d - u) / 0.02);
                    let anisotropic = filter == TextureFilter::Anisotropic;
                    let (expected, decided) = filtered(&levels, middle, right, down, anisotropic);
                    if decided < 0.02 {
                        continue;
                    }
                    for k in 0..3 {
                        let error = (f64::from(linear[k]) - expected[k]).abs();
                        sum += error;
                        worst = worst.max(error);
                        compared += 1;
                    }
                }
                let mean = sum / f64::from(compared);
                let what =
                    format!("{size:?}, camera {number}, {filter:?}: {compared}, mean {mean}, worst {worst}");
                println!("{what}");
                assert!(compared > 2000, "{what}");
                assert!(mean < 0.002 && worst < 0.03, "{what}");
            }
        }
    }
}

/// What a pixel covers, as the mean of 24 x 24 rays.
#[test]
fn a_pixel_shows_the_mean_of_what_it_covers() {
    let repeats = 4.0;
    let checkered =
        |x: usize, y: usize| if (x / 8 + y / 8).is_multiple_of(2) { [255, 220, 30] } else { [10, 40, 200] };
    let (picture, _) = Picture::new(64, 64, checkered);
    for (number, camera) in cameras().iter().enumerate() {
        let mut errors = Vec::new();
        for filter in [TextureFilter::Nearest, TextureFilter::Trilinear, TextureFilter::Anisotropic] {
            let (_, texture) = Picture::new(64, 64, checkered);
            let frame = draw(&textured(&square(repeats as f32), texture), camera, &unlit(filter));
            let (mut sum, mut pixels) = (0.0, 0.0);
            for (i, linear) in frame.planes.linear.iter().enumerate().step_by(7) {
                const N: usize = 24;
                let rays: Option<Vec<DVec2>> = (0..N * N)
                    .map(|ray| {
                        let inside = |n: usize| (n as f64 + 0.5) / N as f64;
                        let at = [(i % 120) as f64 + inside(ray % N), (i / 120) as f64 + inside(ray / N)];
                        seen(camera, [120, 90], at, repeats)
                    })
                    .collect();
                let Some(rays) = rays else { continue };
                for k in 0..3 {
                    let mean = rays.iter().map(|&uv| picture.nearest(uv)[k]).sum::<f64>() / rays.len() as f64;
                    sum += (f64::from(linear[k]) - mean).abs() / 3.0;
                }
                pixels += 1.0;
            }
            errors.push(sum / pixels);
        }
        let [nearest, trilinear, anisotropic] = errors[..] else { unreachable!() };
        println!("camera {number}: {nearest:.4}, {trilinear:.4}, {anisotropic:.4}");
        assert!(anisotropic < 0.04, "camera {number}: {anisotropic}");
        assert!(anisotropic <= trilinear + 0.002, "camera {number}: {anisotropic}, {trilinear}");
        let grazing = [2, 5].contains(&number);
        assert!(
            !grazing || anisotropic < 0.5 * trilinear.min(nearest),
            "camera {number}: {anisotropic}, {trilinear}"
        );
    }
}

/// The same texture with its coordinates scaled and shifted by its map, and wrapped in each way.
#[test]
fn a_map_scales_and_shifts_coordinates_and_wraps_them() {
    let (picture, _) = Picture::new(16, 16, noise(9));
    let camera = orthographic([0.0, 0.0, 3.0], [0.0; 3], 2.2);
    let camera = Camera { up: DVec3::Y, ..camera };
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let (_, texture) = Picture::new(16, 16, noise(9));
        let mut scene = textured(&square(1.0), texture);
        let map = TextureMap { texture: 0, wrap: [wrap; 2], scale: [3.0, -2.0], offset: [-1.25, 1.5] };
        scene.materials[0].base_color_map = Some(map);
        let frame = draw(&scene, &camera, &unlit(TextureFilter::Nearest));
        let (mut compared, mut wrong) = (0, 0);
        for (i, linear) in frame.planes.linear.iter().enumerate() {
            let at = [(i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5];
            let Some(uv) = seen(&camera, [120, 90], at, 1.0) else { continue };
            let uv = DVec2::new(uv.x * 3.0 - 1.25, uv.y * -2.0 + 1.5);
            let wrapped = |c: f64| match wrap {
                Wrap::Repeat => c.rem_euclid(1.0),
                Wrap::Mirror if c.floor() as i64 % 2 == 0 => c - c.floor(),
                Wrap::Mirror => 1.0 - (c - c.floor()),
                Wrap::Clamp => c.clamp(0.0, 1.0 - 1e-9),
            };
            let v = 1.0 - wrapped(uv.y);
            let texel = [(wrapped(uv.x) * 16.0) as usize, ((v * 16.0) as usize).min(15)];
            let expected = picture.texels[texel[1] * 16 + texel[0]];
            compared += 1;
            wrong += u32::from((0..3).any(|k| (f64::from(linear[k]) - expected[k]).abs() > 1e-4));
        }
        // Snapping moves edges of texels across the middles of a few pixels.
        assert!(compared > 5000 && wrong * 50 < compared, "{wrap:?}: {wrong} of {compared}");
    }
}
