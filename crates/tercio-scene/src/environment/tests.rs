use super::*;

fn of(f: impl Fn(DVec3) -> [f32; 3]) -> Panorama {
    let mut pixels = Vec::new();
    let black = Panorama::new(256, 128, vec![[0.0; 3]; 256 * 128]).unwrap();
    black.for_each(|direction, _, _| pixels.push(f(direction)));
    Panorama::new(256, 128, pixels).unwrap()
}

fn directions() -> impl Iterator<Item = DVec3> {
    DIRECTIONS.iter().map(|&d| DVec3::from(d).normalize())
}

#[test]
fn the_same_light_from_everywhere_is_that_light() {
    let small = |rows: usize| Panorama::new(2 * rows, rows, vec![[0.5, 1.0, 2.0]; 2 * rows * rows]).unwrap();
    for panorama in [of(|_| [0.5, 1.0, 2.0]), small(1), small(2), small(5)] {
        let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.5).unwrap();
        is_the_same_everywhere(&environment, panorama.height() > 100);
    }
}

fn is_the_same_everywhere(environment: &Environment, is_fine: bool) {
    for n in directions() {
        for (k, expected) in [0.75, 1.5, 3.0].into_iter().enumerate() {
            // Of a few pixels, the integral is coarse.
            assert!(!is_fine || (environment.diffuse()[k].at(n) - expected).abs() < 1e-4);
            for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
                let mirrored = environment.mirrored(n.as_vec3().to_array(), roughness)[k];
                assert!((f64::from(mirrored) - expected).abs() < 1e-5, "{n} {roughness}: {mirrored}");
            }
        }
    }
}

/// Diffuse light equals the integral over the hemisphere, by its definition: exactly for light of the second degree.
#[test]
fn diffuse_light_is_the_integral_over_the_hemisphere() {
    let panorama = of(|d| [1.0 + d.x, 1.0 + d.y * d.z, 0.2 + d.y.max(0.0)].map(|c| c as f32));
    let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.0).unwrap();
    for n in directions() {
        let mut sums = [0.0; 3];
        panorama.for_each(|direction, solid_angle, color| {
            let weight = n.dot(direction).max(0.0) * solid_angle / std::f64::consts::PI;
            (0..3).for_each(|k| sums[k] += weight * f64::from(color[k]));
        });
        let tolerances = [1e-3, 1e-3, 0.02];
        for k in 0..3 {
            let found = environment.diffuse()[k].at(n);
            assert!((found - sums[k]).abs() < tolerances[k], "{n}, channel {k}: {found}, not {}", sums[k]);
        }
    }
}

#[test]
fn a_large_light_leaves_no_negative_light() {
    let lamp = DVec3::new(0.3, 0.8, 0.2).normalize();
    let panorama = of(|d| if d.dot(lamp) > 0.8 { [1000.0, 10.0, 0.0] } else { [0.0; 3] });
    let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.0).unwrap();
    assert!(environment.sources().is_empty());
    for n in directions() {
        environment.diffuse().iter().for_each(|p| assert!(p.at(n) >= 0.0));
    }
    assert!(environment.diffuse()[0].at(lamp) > 3.0 * environment.diffuse()[0].at(-lamp));
}

/// Under a sun in an even sky, the light is that of the sky everywhere, and that of the sun by the cosine.
#[test]
fn suns_are_lights_of_their_own() {
    let suns = [DVec3::new(0.3, 0.8, 0.2).normalize(), DVec3::new(-1.0, 0.1, 0.5).normalize()];
    let radius = 0.035f64.cos();
    let panorama = of(|d| match () {
        () if d.dot(suns[0]) > radius => [4000.0, 3600.0, 3000.0],
        () if d.dot(suns[1]) > radius => [500.0, 600.0, 800.0],
        () => [0.15; 3],
    });
    let turn = DMat3::from_rotation_y(0.7);
    let environment = Environment::new(&panorama, turn, 2.0).unwrap();
    assert_eq!(environment.sources().len(), 2);
    let lights = |n: DVec3| {
        let mut sum = environment.diffuse().map(|p| p.at(n));
        for light in environment.sources() {
            let Light::Directional { to_light, color, .. } = light else { panic!("a directional light") };
            (0..3).for_each(|k| sum[k] += f64::from(color[k]) * to_light.dot(n).max(0.0));
        }
        sum
    };
    for n in directions() {
        let mut expected = [0.0; 3];
        panorama.for_each(|direction, solid_angle, color| {
            let weight = 2.0 * n.dot(turn * direction).max(0.0) * solid_angle / std::f64::consts::PI;
            (0..3).for_each(|k| expected[k] += weight * f64::from(color[k]));
        });
        // On the sun's horizon, a part of it is above.
        if suns.iter().any(|&sun| n.dot(turn * sun).abs() < 0.05) {
            continue;
        }
        let found = lights(n);
        for k in 0..3 {
            let off = (found[k] - expected[k]).abs();
            // The remainder where the suns were is not quite even.
            assert!(off < 0.002 + 0.03 * expected[k], "{n}, {k}: {found:?}, not {expected:?}");
        }
    }
    // What is mirrored has no sun.
    let toward = (turn * suns[0]).as_vec3().to_array();
    assert!(environment.mirrored(toward, 0.0).iter().all(|c| (c - 0.3).abs() < 1e-3));
}

/// What is mirrored equals sums over the panorama with the weights of the lobe; for a mirror, the panorama itself.
#[test]
fn mirrored_light_is_the_blurred_panorama() {
    let color = |d: DVec3| [0.5 + 0.5 * d.x, 0.5 + 0.4 * (3.0 * d.y).sin(), 0.3 + 0.7 * d.z.max(0.0)];
    let panorama = of(|d| color(d).map(|c| c as f32));
    let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.0).unwrap();
    for around in directions() {
        for (roughness, tolerance) in [(0.0, 0.01), (0.125, 0.02), (0.25, 0.02), (0.5, 0.03), (1.0, 0.03)] {
            let (mut sums, mut total) = ([0.0; 3], 0.0);
            let a: f64 = roughness * roughness;
            panorama.for_each(|direction, solid_angle, _| {
                let half = (direction + around).normalize_or_zero();
                let spread = half.dot(around).powi(2) * (a * a - 1.0) + 1.0;
                let weight = direction.dot(around).max(0.0) * solid_angle / (spread * spread).max(1e-12);
                total += weight;
                (0..3).for_each(|k| sums[k] += weight * color(direction)[k]);
            });
            let expected = if a == 0.0 { color(around) } else { sums.map(|s| s / total) };
            let found = environment.mirrored(around.as_vec3().to_array(), roughness as f32);
            for k in 0..3 {
                let off = (f64::from(found[k]) - expected[k]).abs();
                assert!(off < tolerance, "{around}, roughness {roughness}: {found:?}, not {expected:?}");
            }
        }
    }
}

/// The light of a turned panorama is that of the other one in turned directions.
#[test]
fn it_turns_with_its_axes() {
    let panorama = of(|d| [0.5 + 0.5 * d.x, 0.5 + 0.5 * d.y, 0.5 + 0.5 * d.z].map(|c| c as f32));
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.4);
    let [plain, turned] = [DMat3::IDENTITY, turn].map(|axes| Environment::new(&panorama, axes, 1.0).unwrap());
    for n in directions() {
        for k in 0..3 {
            let off = plain.diffuse()[k].at(n) - turned.diffuse()[k].at(turn * n);
            assert!(off.abs() < 1e-4, "{n}: {off}");
            let at = |e: &Environment, n: DVec3| e.mirrored(n.as_vec3().to_array(), 0.4)[k];
            let off = at(&plain, n) - at(&turned, turn * n);
            // A texel of the map is 1.4 degrees wide.
            assert!(off.abs() < 0.005, "{n}: {off}");
        }
    }
}

#[test]
fn the_middle_of_a_panorama_is_before_the_viewer_and_its_right_half_on_the_right() {
    let (width, height) = (64, 32);
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels[16 * width + 32] = [1.0, 0.0, 0.0];
    pixels[16 * width + 48] = [0.0, 1.0, 0.0];
    pixels[..width].fill([0.0, 0.0, 1.0]);
    let panorama = Panorama::new(width, height, pixels).unwrap();
    let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.0).unwrap();
    // All three are small sources of light.
    let sources = environment.sources().iter().map(|light| match light {
        Light::Directional { to_light, color, .. } => (*to_light, *color),
        _ => panic!("a directional light"),
    });
    for (number, expected) in [-DVec3::Z, DVec3::X, DVec3::Y].into_iter().enumerate() {
        let of_color = sources.clone().find(|(_, color)| color[number] > 0.0).expect("a source");
        // A pixel is 6 degrees wide.
        assert!(of_color.0.dot(expected) > 0.99, "{of_color:?}");
    }
}

#[test]
fn gradients() {
    let panorama = Panorama::gradient([0.0, 0.0, 1.0], [1.0; 3], [0.2, 0.1, 0.0]).unwrap();
    let environment = Environment::new(&panorama, DMat3::IDENTITY, 1.0).unwrap();
    let near = |d: [f32; 3], expected: [f32; 3]| {
        let found = environment.mirrored(d, 0.0);
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 0.03), "{d:?}: {found:?}");
    };
    near([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    near([0.0, -1.0, 0.0], [0.2, 0.1, 0.0]);
    near([1.0, 0.0, 0.0], [1.0; 3]);
}

#[test]
fn what_is_no_panorama_is_refused() {
    let shape = Panorama::new(4, 3, vec![[0.0; 3]; 12]).unwrap_err();
    assert_eq!(shape, PanoramaError::Shape { width: 4, height: 3 });
    assert!(Panorama::new(0, 0, Vec::new()).is_err());
    for value in [f32::NAN, f32::INFINITY, -1.0, 2e6] {
        let mut pixels = vec![[0.5; 3]; 8];
        pixels[6][1] = value;
        let error = Panorama::new(4, 2, pixels).unwrap_err().to_string();
        assert!(error.contains("column 2 of row 1"), "{error}");
    }
    let fine = Panorama::new(2, 1, vec![[1.0; 3]; 2]).unwrap();
    for strength in [-1.0, f64::NAN, f64::INFINITY, 2e6] {
        let error = Environment::new(&fine, DMat3::IDENTITY, strength).unwrap_err();
        assert!(matches!(error, PanoramaError::Strength { .. }), "{error}");
    }
}
