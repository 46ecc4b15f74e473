use super::plane::{cross, dot, newell_normal, sub};
use super::*;
use proptest::prelude::*;

fn triangles(corners: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let mut out = Vec::new();
    Triangulator::default().triangulate(corners, |t| out.push(t));
    out
}

fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
    points.iter().map(|p| [p[0], p[1], 0.0]).collect()
}

fn area(corners: &[[f64; 3]], t: [usize; 3], unit: [f64; 3]) -> f64 {
    let [a, b, c] = t.map(|i| corners[i]);
    0.5 * dot(cross(sub(b, a), sub(c, a)), unit)
}

/// n - 2 triangles, all with the polygon's winding, whose areas add up to the polygon's.
fn check(corners: &[[f64; 3]], tolerance: f64) -> Result<(), TestCaseError> {
    let list = triangles(corners);
    prop_assert_eq!(list.len(), corners.len() - 2);
    let n = newell_normal(corners);
    let length = dot(n, n).sqrt();
    let unit = n.map(|x| x / length);
    let areas: Vec<f64> = list.iter().map(|&t| area(corners, t, unit)).collect();
    for (t, &a) in list.iter().zip(&areas) {
        prop_assert!(a > -tolerance * length, "{:?} has area {}", t, a);
    }
    let sum: f64 = areas.iter().sum();
    prop_assert!((sum - 0.5 * length).abs() <= 1e-9 * length, "{} != {}", sum, 0.5 * length);
    Ok(())
}

fn lift(points: &[[f64; 2]], u: [f64; 3], v: [f64; 3], o: [f64; 3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| std::array::from_fn(|k| o[k] + u[k] * p[0] + v[k] * p[1])).collect()
}

fn star(radii: &[f64]) -> Vec<[f64; 2]> {
    let turn = std::f64::consts::TAU / radii.len() as f64;
    radii
        .iter()
        .enumerate()
        .map(|(i, r)| [r * (i as f64 * turn).cos(), r * (i as f64 * turn).sin()])
        .collect()
}

/// Teeth along the x axis with collinear corners below them.
fn comb(heights: &[f64], below: usize) -> Vec<[f64; 2]> {
    let width = heights.len() as f64;
    let mut p: Vec<_> = (0..=below).map(|i| [width * i as f64 / below as f64, 0.0]).collect();
    for (i, h) in heights.iter().enumerate().rev() {
        p.extend([[i as f64 + 1.0, 1.0], [i as f64 + 0.5, 1.0 + h]]);
    }
    p.push([0.0, 1.0]);
    p
}

proptest! {
    #[test]
    fn stars_are_covered(
        radii in prop::collection::vec(0.05f64..1.0, 5..200),
        u in prop::array::uniform3(-1f64..1.0), v in prop::array::uniform3(-1f64..1.0),
        o in prop::array::uniform3(-10f64..10.0), backwards: bool,
    ) {
        let n = cross(u, v);
        prop_assume!(dot(n, n) > 1e-2);
        let mut p = star(&radii);
        check(&flat(&p), 0.0)?;
        if backwards {
            p.reverse();
        }
        check(&lift(&p, u, v, o), 1e-12)?;
    }

    #[test]
    fn combs_are_covered(
        heights in prop::collection::vec(0.01f64..100.0, 2..60), below in 1usize..40,
        u in prop::array::uniform3(-1f64..1.0), v in prop::array::uniform3(-1f64..1.0),
    ) {
        let n = cross(u, v);
        prop_assume!(dot(n, n) > 1e-2);
        let p = comb(&heights, below);
        check(&flat(&p), 0.0)?;
        check(&lift(&p, u, v, [0.0; 3]), 1e-12)?;
    }

    #[test]
    fn anything_ends_with_two_triangles_fewer_than_corners(
        p in prop::collection::vec(prop::array::uniform3(prop_oneof![
            (0i8..4).prop_map(f64::from), Just(f64::NAN), Just(f64::INFINITY), -1f64..1.0,
        ]), 3..60),
        finite in prop::collection::vec(prop::array::uniform3((0i8..3).prop_map(f64::from)), 3..200),
    ) {
        for p in [p, finite] {
            let list = triangles(&p);
            prop_assert_eq!(list.len(), p.len() - 2);
            for t in list {
                // Increasing up to rotation: the order of the ring.
                let falls = (0..3).filter(|&k| t[k] > t[(k + 1) % 3]).count();
                prop_assert_eq!(falls, 1);
            }
        }
    }
}

#[test]
fn quads_are_cut_inside_and_short() {
    // Convex, diagonal 1-3 shorter.
    assert_eq!(triangles(&flat(&[[-3., 0.], [0., -1.], [3., 0.], [0., 1.]])), [[0, 1, 3], [1, 2, 3]]);
    // A dart, with its reflex corner at each index in turn.
    let dart = [[0., 0.], [1., -2.], [0., 3.], [-1., -2.]];
    for turn in 0..4 {
        let mut p = dart;
        p.rotate_left(turn);
        check(&flat(&p), 0.0).unwrap();
    }
    // A triangle with an extra corner on an edge keeps its two real triangles.
    for turn in 0..4 {
        let mut p = [[0., 0.], [1., 0.], [2., 0.], [0., 2.]];
        p.rotate_left(turn);
        let p = flat(&p);
        assert!(triangles(&p).iter().all(|&t| area(&p, t, [0., 0., 1.]) > 0.0));
    }
}

#[test]
fn a_square_with_a_run_on_each_side_has_no_flat_triangle() {
    let mut p = Vec::new();
    for k in 0..10 {
        p.push([k as f64, 0.]);
    }
    for k in 0..10 {
        p.push([10., k as f64]);
    }
    for k in 0..10 {
        p.push([10. - k as f64, 10.]);
    }
    for k in 0..10 {
        p.push([0., 10. - k as f64]);
    }
    let p = flat(&p);
    assert!(triangles(&p).iter().all(|&t| area(&p, t, [0., 0., 1.]) > 0.0));
    check(&p, 0.0).unwrap();
}

#[test]
fn a_hole_reached_by_a_bridge_stays_open() {
    // Outer square, bridge to the inner one and back: the positions of the bridge occur twice.
    let p =
        [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]];
    for turn in 0..p.len() {
        let mut p = p;
        p.rotate_left(turn);
        let p = flat(&p);
        check(&p, 0.0).unwrap();
        let sum: f64 = triangles(&p).iter().map(|&t| area(&p, t, [0., 0., 1.])).sum();
        assert_eq!(sum, 12.0);
    }
}

#[test]
fn repeated_corners_cost_only_flat_triangles() {
    let p = flat(&[[0., 0.], [2., 0.], [2., 0.], [2., 2.], [1., 0.5], [1., 0.5], [0., 2.], [0., 0.]]);
    check(&p, 1e-300).unwrap();
    let flat_ones = triangles(&p).iter().filter(|&&t| area(&p, t, [0., 0., 1.]) == 0.0).count();
    assert_eq!(flat_ones, 3);
}

#[test]
fn polygons_of_a_hundred_thousand_corners_do_not_hang() {
    let mut noise = 1u32;
    let mut random = || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise >> 8) / f64::from(1 << 24)
    };
    let n = 100_000;
    let radii: Vec<f64> = (0..n).map(|_| 0.1 + 0.9 * random()).collect();
    check(&flat(&star(&radii)), 1e-12).unwrap();
    let heights: Vec<f64> = (0..n / 2).map(|_| 1.0 + 1e5 * random()).collect();
    check(&lift(&comb(&heights, 10), [1., 1., 0.], [-1., 1., 0.], [0.; 3]), 1e-12).unwrap();
    // A spiral has two ears at any time.
    let half = n / 2;
    let arm = |i: usize, r: f64| {
        let t = i as f64 * 0.02;
        [(t + r) * t.cos(), (t + r) * t.sin()]
    };
    let spiral: Vec<_> = (0..half).map(|i| arm(i, 2.0)).chain((0..half).rev().map(|i| arm(i, 0.0))).collect();
    check(&flat(&spiral), 1e-12).unwrap();
    // Random points: the polygon crosses itself everywhere.
    let mess: Vec<_> = (0..n).map(|_| [random(), random(), random()]).collect();
    assert_eq!(triangles(&mess).len(), n - 2);
    assert_eq!(triangles(&vec![[1.0; 3]; n]).len(), n - 2);
    let line: Vec<_> = (0..n).map(|_| [random(), 0.0, 0.0]).collect();
    assert_eq!(triangles(&line).len(), n - 2);
}

fn noise() -> impl FnMut() -> f64 {
    let mut noise = 1u32;
    move || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise >> 8) / f64::from(1 << 24)
    }
}

/// Shapes that are difficult in different ways, of about `n` corners.
fn shapes(n: usize) -> Vec<Vec<[f64; 2]>> {
    let mut random = noise();
    let teeth = n / 4;
    let mut comb = vec![[0.0, -1.0], [2.0 * teeth as f64, -1.0]];
    for i in (0..teeth).map(|i| 2.0 * i as f64).rev() {
        comb.extend([[i + 1.0, 0.0], [i + 1.0, 100.0], [i, 100.0], [i, 0.0]]);
    }
    let mut interleaved = Vec::new();
    for i in (0..teeth).map(|i| 4.0 * i as f64) {
        interleaved.extend([[i, 0.0], [i + 1.0, 1000.0], [i + 2.0, 1000.0], [i + 3.0, 0.0]]);
    }
    for i in (0..teeth).map(|i| 4.0 * i as f64).rev() {
        interleaved.extend([[i + 2.4, 0.5], [i + 1.9, 999.0]]);
    }
    let saw = |i: usize, by: f64| [i as f64 * 0.01, (i % 2) as f64 * 1000.0 + by];
    let half = n / 2;
    let sawtooth = (0..half).map(|i| saw(i, 0.0)).chain((0..half).rev().map(|i| saw(i, 0.5)));
    let arm = |i: usize, r: f64| {
        let t = i as f64 * 0.02;
        [(t + r) * t.cos(), (t + r) * t.sin()]
    };
    let spiral = (0..half).map(|i| arm(i, 0.05)).chain((0..half).rev().map(|i| arm(i, 0.0)));
    let turn = std::f64::consts::TAU * (half as f64 / (2 * half + 1) as f64);
    let crossing = (0..2 * half + 1).map(|i| [(i as f64 * turn).cos(), (i as f64 * turn).sin()]);
    let rim = |i: usize| [(i as f64 / n as f64 * 6.2).cos(), (i as f64 / n as f64 * 6.2).sin()];
    let hub = (0..n).map(|i| if i % 2 == 0 { [0.0; 2] } else { rim(i) });
    let cells = (0..n).map(|_| [(random() * 9.0).floor(), (random() * 9.0).floor()]).collect();
    let radii: Vec<f64> = (0..n).map(|_| 0.05 + 0.95 * random()).collect();
    let mess = (0..n).map(|_| [random(), random()]).collect();
    vec![
        comb,
        interleaved,
        sawtooth.collect(),
        spiral.collect(),
        star(&radii),
        crossing.collect(),
        hub.collect(),
        cells,
        mess,
        (0..n).map(|i| [i as f64, 0.0]).collect(),
        one_convex_corner_behind(n),
    ]
}

/// Crosses itself so that it has one convex corner at a time, next to the corner that was just removed, always on the
/// side that a search in the order of the ring reaches last.
fn one_convex_corner_behind(n: usize) -> Vec<[f64; 2]> {
    let (m, tip, height) = (n / 2, -4000.0, 50.0);
    let bow = |y: f64| 10.0 + 0.001 * y * y;
    let ys: Vec<f64> = (0..m).map(|k| -height + 2.0 * height * k as f64 / (m - 1) as f64).collect();
    // Each ear from the tip to two corners of the arc has one of these inside.
    let inside = ys.windows(2).rev().map(|y| {
        let y = (y[0] + y[1]) / 2.0;
        let x = 5.0 - 1e-5 * y * y;
        [x, y * (x - tip) / (bow(y) - tip)]
    });
    let inside: Vec<[f64; 2]> = inside.collect();
    let low = inside.last().map_or(0.0, |p| p[0]);
    let mut shape =
        vec![[tip, 0.0], [tip - 1.0, 1.0], [4.4, -60.0], [4.45, -61.5], [3.5, -61.6], [3.5, 60.0]];
    shape.extend([[4.0, 60.5], [4.5, 60.4], [4.9, 59.0]]);
    shape.extend(inside);
    shape.extend([[low - 0.01, -55.0], [low - 1.0, -56.0], [low - 1.5, 61.0], [20.0, 62.0], [20.5, -56.0]]);
    shape.extend([[19.0, -57.0], [13.4, -57.0]]);
    shape.extend(ys.iter().map(|&y| [bow(y), y]));
    shape
}

#[test]
fn a_tree_finds_what_the_grid_finds() {
    for (k, shape) in shapes(700).into_iter().enumerate() {
        let corners = flat(&shape);
        let cut = |many: usize, tests: u64| {
            let (mut t, mut out) = (Triangulator::default(), Vec::new());
            t.begin(&corners, many);
            t.grid_tests_left = t.grid_tests_left.min(tests);
            t.cut(corners.len(), &mut |triangle| out.push(triangle));
            out
        };
        let by_grid = cut(usize::MAX, u64::MAX);
        // The search for imperfect ears takes another path: those are the shapes that cross or touch themselves.
        let is_simple = [0, 2, 3, 4].contains(&k);
        for tests in [0, 300, 3000] {
            let by_tree = cut(0, tests);
            assert_eq!(by_tree.len(), by_grid.len(), "shape {k}");
            assert!(!is_simple || by_tree == by_grid, "shape {k} is cut in another way");
        }
    }
}

#[test]
fn a_tree_query_is_right_and_fast() {
    let mut random = noise();
    for spread in [8.0, 1e6] {
        let n = 4000;
        let points: Vec<[f64; 2]> =
            (0..n).map(|_| [(random() * spread).floor(), (random() * spread).floor()]).collect();
        let mut tree = Tree::default();
        tree.fill(&points);
        let live: Vec<bool> = (0..n).map(|_| random() < 0.3).collect();
        // Every corner is set; those that are not blockers are unset again.
        for (i, &live) in (0..).zip(&live) {
            tree.set(i, true);
            if !live {
                tree.set(i, false);
            }
        }
        let mut point_tests = 0;
        for _ in 0..2000 {
            let thin = 0.02 * random();
            let a = [random() * spread, random() * spread].map(f64::floor);
            let b = [random() * spread, random() * spread].map(f64::floor);
            let c = [
                a[0] + (b[0] - a[0]) * 0.5 + thin * (a[1] - b[1]),
                a[1] + (b[1] - a[1]) * 0.5 + thin * (b[0] - a[0]),
            ];
            for demand in [Demand::Clear, Demand::Touching] {
                let expected =
                    points.iter().zip(&live).any(|(&q, &live)| live && demand.contains_blocker([a, b, c], q));
                assert_eq!(
                    tree.contains_blocker([a, b, c], demand, &mut point_tests),
                    expected,
                    "{a:?} {b:?} {c:?}"
                );
            }
        }
        assert!(point_tests < 4000 * 200, "{point_tests} tests");
    }
}

#[test]
fn the_work_of_a_corner_does_not_grow_with_the_polygon() {
    let n = 32_000;
    for (k, shape) in shapes(n).into_iter().enumerate() {
        let mut t = Triangulator::default();
        t.triangulate(&flat(&shape), |_| {});
        let corners = shape.len() as u64;
        let point_tests = POINT_TESTS_PER_CORNER * corners - t.point_tests_left;
        let steps = STEPS_PER_CORNER * corners - t.steps_left;
        assert!(point_tests <= 200 * corners, "shape {k}: {point_tests} tests of points");
        assert!(steps <= 16 * corners, "shape {k}: {steps} steps");
    }
}
