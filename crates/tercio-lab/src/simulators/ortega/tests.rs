use proptest::prelude::*;

use super::scan::{lines, segments};
use super::*;
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{PolygonScene, ScreenPoint, ScreenPolygon};

fn scene(polygons: &[&[[i32; 2]]]) -> PolygonScene {
    let polygons = polygons.iter().map(|corners| ScreenPolygon::at_pixels(corners)).collect();
    PolygonScene { width: 32, height: 16, polygons }
}

fn square(x: i32, y: i32, side: i32) -> [[i32; 2]; 4] {
    [[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
}

fn spans(polygon: &ScreenPolygon, line: i32) -> Vec<(i32, u32)> {
    let mut list = Vec::new();
    segments(polygon, 0, line, &mut list);
    list.iter().map(|s| (s.first, s.length)).collect()
}

#[test]
fn segments_come_in_pairs() {
    // A W: two segments on its upper lines, one below the junction of its arms.
    let w = ScreenPolygon::at_pixels(&[[0, 0], [4, 0], [6, 4], [8, 0], [12, 0], [8, 8], [4, 8]]);
    assert_eq!(lines(&w), (0, 8));
    assert_eq!((spans(&w, 0), spans(&w, 6)), (vec![(0, 4), (8, 4)], vec![(3, 6)]));
}

#[test]
fn neighbours_share_no_pixel() {
    let [a, b] = [[[0, 0], [8, 0], [3, 7]], [[8, 0], [9, 7], [3, 7]]].map(|c| ScreenPolygon::at_pixels(&c));
    for line in 0..7 {
        let (a, b) = (spans(&a, line)[0], spans(&b, line)[0]);
        assert_eq!(a.0 + a.1 as i32, b.0, "line {line}");
    }
}

#[test]
fn loops_run_over_the_tallest_polygon_and_the_longest_segment() {
    // Squares of 2, 3 and 6 pixels, on two processors.
    let (small, middle, large) = (square(1, 1, 2), square(10, 3, 3), square(20, 5, 6));
    let scene = scene(&[&small, &middle, &large]);
    let (run, _) = simulate(&Machine { processors: 2, buffer: 1000 }, &scene);
    let expected = Run {
        polygons: 3,
        line_passes: 6,
        line_steps: 6 * 2,
        lines: 2 + 3 + 6,
        segments: 11,
        flushes: 1,
        pixel_passes: 6,
        pixel_steps: 6 * 6,
        pixels: 4 + 9 + 36,
        ..Run::default()
    };
    assert_eq!(run, expected);
    assert_eq!(run.line_utilization(), 11.0 / 18.0);
    // A buffer of 5 is emptied after passes 2, 5 (with 2 + 1 + 1 segments still below 5) and at the end.
    let (run, _) = simulate(&Machine { processors: 2, buffer: 5 }, &scene);
    assert_eq!((run.flushes, run.pixel_passes, run.pixel_steps), (2, 12, 6 * 3 + 6 * 3));
}

#[test]
fn one_large_polygon_lengthens_both_loops() {
    // Section 6: polygons over 3/4 of the picture lengthen the serial part of the algorithm.
    let small = Distribution {
        width: 512,
        height: 512,
        polygons: 2000,
        visible: 1.0,
        size: [4.0, 4.0],
        spread: [Spread::Uniform; 2],
        seed: 7,
    };
    let mut scene = small.triangles();
    let machine = Machine { processors: 512, buffer: 4096 };
    let (before, _) = simulate(&machine, &scene);
    scene.polygons.push(ScreenPolygon::at_pixels(&square(20, 20, 450)));
    let (after, _) = simulate(&machine, &scene);
    assert_eq!((before.line_passes, after.line_passes), (4, 450));
    assert!(after.line_steps > 100 * before.line_steps && after.pixel_passes > 50 * before.pixel_passes);
}

#[test]
fn pixels_that_begin_together_collide() {
    // Two segments start at pixel 4 and one at pixel 5 of one line: only those in lockstep collide.
    let at = |x: i32, width: i32| [[x, 2], [x + width, 2], [x + width, 3], [x, 3]];
    let scene = scene(&[&at(4, 3), &at(4, 9), &at(5, 9)]);
    let (run, _) = simulate(&Machine { processors: 64, buffer: 64 }, &scene);
    assert_eq!((run.pixels, run.collisions), (21, 3));
}

#[test]
fn pixels_outside_the_picture_are_clipped() {
    let (run, picture) = simulate(&Machine { processors: 4, buffer: 1 }, &scene(&[&square(-2, -3, 6)]));
    assert_eq!((run.pixels, run.clipped, run.line_passes), (4 * 3, 36 - 12, 6));
    assert_eq!(picture.pixels.iter().flatten().count(), 12);
    let (nothing, _) = simulate(&Machine { processors: 4, buffer: 1 }, &scene(&[]));
    assert_eq!(nothing, Run::default());
}

proptest! {
    #[test]
    fn loops_and_picture_are_those_of_the_definition(
        polygons in prop::collection::vec(
            prop::collection::vec((-900i32..9000, -900i32..5000, 0f32..1.0), 1..6), 0..12),
        processors in 1u64..9, buffer in 1u64..40,
    ) {
        let corner = |(x, y, depth)| ScreenPoint { x, y, depth };
        let polygons = polygons.into_iter()
            .map(|c| ScreenPolygon { front: true, corners: c.into_iter().map(corner).collect() });
        let scene = PolygonScene { width: 32, height: 16, polygons: polygons.collect() };
        let (run, picture) = simulate(&Machine { processors, buffer }, &scene);

        // Pass by pass, pixel by pixel, as in section 4.
        let mut plain = Run { polygons: scene.polygons.len() as u64, ..Run::default() };
        let mut nearest: Vec<Option<(f64, u32)>> = vec![None; 32 * 16];
        let mut list: Vec<Segment> = Vec::new();
        let highest = scene.polygons.iter().map(|p| lines(p).1).max().unwrap_or(0);
        for pass in 0..highest {
            plain.line_passes += 1;
            plain.line_steps += plain.polygons.div_ceil(processors);
            for (number, polygon) in (0..).zip(&scene.polygons) {
                let (first, count) = lines(polygon);
                if pass < count {
                    plain.lines += 1;
                    segments(polygon, number, first + pass as i32, &mut list);
                }
            }
            if (list.len() as u64) < buffer && pass + 1 < highest || list.is_empty() {
                continue;
            }
            plain.flushes += 1;
            plain.segments += list.len() as u64;
            for step in 0..list.iter().map(|s| s.length).max().unwrap_or(0) {
                plain.pixel_passes += 1;
                plain.pixel_steps += (list.len() as u64).div_ceil(processors);
                let mut aimed = std::collections::BTreeSet::new();
                for s in list.iter().filter(|s| step < s.length) {
                    let x = s.first + step as i32;
                    if !(0..32).contains(&x) || !(0..16).contains(&s.y) {
                        plain.clipped += 1;
                        continue;
                    }
                    plain.pixels += 1;
                    plain.collisions += u64::from(!aimed.insert((x, s.y)));
                    let candidate = (s.depth + s.depth_step * f64::from(step), s.polygon);
                    let place = &mut nearest[(s.y * 32 + x) as usize];
                    *place = Some(place.map_or(candidate, |old| if candidate > old { candidate } else { old }));
                }
            }
            list.clear();
        }
        prop_assert_eq!(run, plain);
        prop_assert_eq!(picture.pixels, nearest);
    }
}
