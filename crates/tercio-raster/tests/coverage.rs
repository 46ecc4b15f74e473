//! Every sample belongs to exactly one triangle: compares coverage by integer edge functions with a simple oracle in
//! 128 bits.

mod common;

use common::*;
use proptest::prelude::*;
use tercio_raster::conventions::GUARD;
use tercio_raster::screen::{DepthPlane, Edges, PixelRect, ScreenTriangle};
use tercio_raster::view::ScreenVertex;

/// Edge in pixels of the window in which samples are tested.
const WINDOW: i32 = 20;
/// The largest coordinate: the guard band, relative to a corner of a picture of a thousand pixels.
const FAR: i32 = GUARD as i32 + 128_000;

type Point = [i32; 2];

fn triangle(corners: [Point; 3]) -> ScreenTriangle {
    with_depths(corners, [0.5; 3])
}

fn with_depths(corners: [Point; 3], depths: [f32; 3]) -> ScreenTriangle {
    let vertex = |k: usize| ScreenVertex { x: corners[k][0], y: corners[k][1], d: depths[k], inside: true };
    ScreenTriangle::new([vertex(0), vertex(1), vertex(2)], 0)
}

/// Twice the area, exactly.
fn area([a, b, c]: [Point; 3]) -> i128 {
    let [a, b, c] = [a, b, c].map(|p| p.map(i128::from));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn window() -> impl Iterator<Item = Point> {
    (0..WINDOW * WINDOW).map(|i| [i % WINDOW, i / WINDOW])
}

fn covered_by(corners: [Point; 3]) -> Vec<bool> {
    if area(corners) == 0 {
        return vec![false; (WINDOW * WINDOW) as usize];
    }
    let edges = Edges::new(&triangle(corners));
    window().map(|[x, y]| (0..3).all(|k| edges.at(k, x, y) >= 0)).collect()
}

fn near_window() -> impl Strategy<Value = Point> {
    let c = || -1000..256 * WINDOW + 1000;
    prop_oneof![
        [c(), c()],
        // On a sample, or on the border of a pixel.
        [0..2 * WINDOW, 0..2 * WINDOW].prop_map(|p| p.map(|c| c * 128)),
    ]
}

fn far_away() -> impl Strategy<Value = Point> {
    let c = || prop_oneof![-FAR..=FAR, Just(FAR), Just(-FAR), -20_000..20_000];
    [c(), c()]
}

fn point() -> impl Strategy<Value = Point> {
    prop_oneof![3 => near_window(), 1 => far_away()]
}

/// An edge through the window, of any length, and two further corners, some very near to it.
fn neighbours() -> impl Strategy<Value = ([Point; 2], Point, Point)> {
    let along = prop_oneof![Just(1), 1..50, 1..4000];
    let edge = (near_window(), [-2000..2000, -2000..2000], along.clone(), along).prop_map(
        |(m, d, s, t): (Point, Point, i32, i32)| {
            let at = |t: i32| [0, 1].map(|k: usize| (m[k] + d[k] * t).clamp(-FAR, FAR));
            [at(-s), at(t)]
        },
    );
    let corner = prop_oneof![point().prop_map(|p| (p, false)), [-3..4, -3..4].prop_map(|p| (p, true))];
    (edge, corner.clone(), corner).prop_map(|(edge, r, s): ([Point; 2], (Point, bool), (Point, bool))| {
        // The third corner of a sliver is a few sub-pixels from the middle of the edge.
        let middle = [0, 1].map(|k: usize| (edge[0][k] + edge[1][k]) / 2);
        let corner =
            |(p, sliver): (Point, bool)| if sliver { [middle[0] + p[0], middle[1] + p[1]] } else { p };
        (edge, corner(r), corner(s))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn edges_equal_the_oracle(corners in [point(), point(), point()]) {
        let found = covered_by(corners);
        for (p, found) in window().zip(found) {
            prop_assert_eq!(found, covers(corners, p) != 0, "pixel {:?} of {:?}", p, corners);
        }
    }

    #[test]
    fn triangles_that_share_an_edge_cover_each_sample_once(([p, q], r, s) in neighbours()) {
        // With both corners on the same side of the edge the triangles would overlap: then one of them is mirrored.
        let across = [0, 1].map(|k: usize| (p[k] + q[k] - s[k]).clamp(-FAR, FAR));
        let s = if area([p, q, r]).signum() == area([q, p, s]).signum() { s } else { across };
        prop_assume!(area([p, q, r]).signum() * area([q, p, s]).signum() > 0);
        let (one, other) = (covered_by([p, q, r]), covered_by([q, p, s]));
        let twice = one.iter().zip(&other).position(|(a, b)| *a && *b);
        prop_assert_eq!(twice, None, "covered twice: {:?}", [p, q, r, s]);
        // A convex quad covers the same samples with either diagonal.
        if area([r, s, q]).signum() * area([s, r, p]).signum() > 0 {
            let (third, fourth) = (covered_by([r, s, q]), covered_by([s, r, p]));
            for (i, pixel) in window().enumerate() {
                let (by_pq, by_rs) = (one[i] || other[i], third[i] || fourth[i]);
                prop_assert_eq!(by_pq, by_rs, "pixel {:?} of {:?}", pixel, [p, q, r, s]);
            }
        }
        for ((pixel, a), b) in window().zip(one).zip(other) {
            let expected = covers([p, q, r], pixel) != 0 || covers([q, p, s], pixel) != 0;
            prop_assert_eq!(a || b, expected, "pixel {:?} of {:?}", pixel, [p, q, r, s]);
        }
    }

    #[test]
    fn a_triangle_and_its_rotations_cover_the_same([a, b, c] in [point(), point(), point()]) {
        let expected = covered_by([a, b, c]);
        for turned in [[b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]] {
            prop_assert_eq!(&expected, &covered_by(turned), "{:?}", turned);
        }
    }

    #[test]
    fn depth_stays_between_the_corners(
        corners in [near_window(), near_window(), near_window()],
        depths in [0.001f32..1.0, 0.001f32..1.0, 0.001f32..1.0],
    ) {
        let twice = area(corners);
        prop_assume!(twice.abs() > 1 << 18);
        let plane = DepthPlane::new(&with_depths(corners, depths));
        let least = depths.into_iter().fold(f32::INFINITY, f32::min);
        let most = depths.into_iter().fold(0.0, f32::max);
        prop_assert_eq!(plane.range, [least, most]);
        prop_assert_eq!(plane.base, least, "interpolated from the farthest corner");
        for p in window().filter(|&p| covers(corners, p) != 0) {
            let s = p.map(|c| c * 256 + 128);
            let (dx, dy) = ((s[0] - plane.anchor[0]) as f32, (s[1] - plane.anchor[1]) as f32);
            let found = f64::from((dx * plane.dx + dy * plane.dy) + plane.base);
            let weight = |a: Point, b: Point| area([a, b, s]) as f64 / twice as f64;
            let [a, b, c] = corners;
            let exact = weight(b, c) * f64::from(depths[0])
                + weight(c, a) * f64::from(depths[1])
                + weight(a, b) * f64::from(depths[2]);
            // Two products of about 2^13 sub-pixels and a slope of at most 2^-5, each rounded to 2^-24.
            prop_assert!((found - exact).abs() < 1e-3, "{:?}: {} for {}", p, found, exact);
        }
    }
}

/// Is a sample in a triangle of a fan or on one of its inner edges, by the oracle's own arithmetic?
fn inside_fan(center: Point, rim: &[Point], pixel: Point) -> bool {
    let s = pixel.map(|c| c * 256 + 128);
    (0..rim.len()).any(|i| {
        let (a, b) = (rim[i], rim[(i + 1) % rim.len()]);
        area([center, a, s]) >= 0 && area([b, center, s]) >= 0 && area([a, b, s]) > 0
    })
}

#[test]
fn fans_around_a_sample_cover_each_sample_once() {
    let mut random = Random(7);
    let (mut fans, mut once) = (0, 0);
    while fans < 3000 {
        let center = [0; 2].map(|_| (random.between(4.0, 16.0) as i32) * 256 + 128);
        let blades = random.between(3.0, 14.0) as usize;
        let reach = [600.0, 3000.0, 8.0e6][fans % 3];
        let mut turns: Vec<f64> = (0..blades).map(|_| random.between(0.0, std::f64::consts::TAU)).collect();
        turns.sort_by(f64::total_cmp);
        // Every other fan has its rim on samples too, so that spokes run through samples.
        let step = if fans % 2 == 0 { 256.0 } else { 1.0 };
        let rim: Vec<Point> = turns
            .iter()
            .map(|turn| {
                let radius = reach * random.between(0.3, 1.0);
                let at = |c: i32, d: f64| c + ((radius * d / step).round() * step) as i32;
                [at(center[0], turn.cos()), at(center[1], turn.sin())]
            })
            .collect();
        let blade = |i: usize| [center, rim[i], rim[(i + 1) % blades]];
        if (0..blades).any(|i| area(blade(i)) <= 0) {
            continue;
        }
        fans += 1;
        let covers: Vec<_> = (0..blades).map(|i| covered_by(blade(i))).collect();
        for (i, pixel) in window().enumerate() {
            let times = covers.iter().filter(|c| c[i]).count();
            let is_center = pixel.map(|c| c * 256 + 128) == center;
            let inside = inside_fan(center, &rim, pixel) || is_center;
            assert!(times <= 1 && (times == 1 || !inside), "{times} times {pixel:?}: {center:?}, {rim:?}");
            once += times;
        }
    }
    assert!(once > 100_000, "the fans cover too few samples: {once}");
}

#[test]
fn no_tile_with_a_covered_sample_is_left_out() {
    let mut random = Random(8);
    let (mut kept, mut left_out, mut needless) = (0, 0, 0);
    for round in 0..200_000 {
        let reach = [700.0, 5000.0, 60_000.0, f64::from(FAR)][round % 4];
        let corners: [Point; 3] = std::array::from_fn(|_| {
            [0; 2].map(|_| (2560.0 + random.between(-reach, reach)).clamp(-8.0e6, 8.0e6) as i32)
        });
        let t = triangle(corners);
        let Some(rect) = t.samples(WINDOW as u32, WINDOW as u32).filter(|_| area(corners) != 0) else {
            continue;
        };
        let (x, y) = (random.between(0.0, 3.0) as i32 * 8, random.between(0.0, 3.0) as i32 * 8);
        let tile = PixelRect {
            x0: rect.x0.max(x),
            x1: rect.x1.min(x + 7),
            y0: rect.y0.max(y),
            y1: rect.y1.min(y + 7),
        };
        if tile.x0 > tile.x1 || tile.y0 > tile.y1 {
            continue;
        }
        let any = (tile.y0..=tile.y1).any(|y| (tile.x0..=tile.x1).any(|x| covers(corners, [x, y]) != 0));
        match (!Edges::new(&t).leave_out(tile), any) {
            (false, true) => panic!("{corners:?} covers a sample of {tile:?}"),
            (false, false) => left_out += 1,
            (true, true) => kept += 1,
            (true, false) => needless += 1,
        }
    }
    assert!(kept > 1000 && left_out > 1000, "too few tiles are kept ({kept}) or left out ({left_out})");
    assert!(
        needless < left_out,
        "{needless} tiles are kept without a covered sample, only {left_out} left out"
    );
}
