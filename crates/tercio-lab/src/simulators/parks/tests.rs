use proptest::prelude::*;

use super::listing::listing;
use super::polygon::Span;
use super::split::{Piece, clip};
use super::*;
use crate::workloads::{PixelBox, PolygonScene, ScreenPolygon};

const SCREEN: (u32, u32) = (512, 512);

fn polygon(corners: &[[i32; 2]]) -> Polygon {
    Polygon::new(corners.iter().copied()).unwrap()
}

fn run(machine: Machine, polygons: &[Polygon]) -> SceneRun {
    simulate(&machine, &Costs::pdp11(), SCREEN, polygons).unwrap()
}

#[test]
fn polygons_of_figure_2() {
    // Polygons A, B and C of the example in section 2.1.
    let a = polygon(&[[4, 5], [10, 5], [7, 14]]);
    let b = polygon(&[[8, 15], [8, 6], [14, 6], [14, 15]]);
    let c = polygon(&[[21, 10], [17, 15], [13, 10], [17, 6]]);
    assert_eq!(a.span(5), Some(Span { y: 5, first: 4, last: 10 }));
    assert_eq!(a.span(14), Some(Span { y: 14, first: 7, last: 7 }));
    // The left side runs through (5, 8), the right one through (9, 8).
    assert_eq!(a.span(8), Some(Span { y: 8, first: 5, last: 9 }));
    assert_eq!((b.span(6), b.span(16)), (Some(Span { y: 6, first: 8, last: 14 }), None));
    let scene = run(Machine::UNIPROCESSOR, &[a, b, c]);
    let one = &scene.processors[0];
    assert_eq!((one.polygons(), one.vertices(), one.segments()), (3, 11, 10 + 10 + 10));
    assert_eq!(one.pixels_per_polygon.counts().filter(|c| c.0 == 70).count(), 1, "B is 7 x 10 pixels");
}

#[test]
fn points_and_lines_have_pixels() {
    let point = polygon(&[[5, 5], [5, 5]]);
    let line = polygon(&[[1, 1], [4, 3], [1, 1]]);
    assert_eq!((point.corners().len(), line.corners().len()), (1, 2));
    assert_eq!(point.span(5), Some(Span { y: 5, first: 5, last: 5 }));
    let spans: Vec<_> = (1..=3).filter_map(|y| line.span(y)).map(|s| (s.first, s.last)).collect();
    assert_eq!(spans, [(1, 1), (2, 2), (4, 4)]);
}

#[test]
fn a_chunk_covered_by_two_polygons_is_appendix_c_4() {
    let everything = polygon(&[[0, 0], [511, 0], [511, 511], [0, 511]]);
    let lower = polygon(&[[0, 0], [511, 0], [511, 301], [0, 301]]);
    let scene = run(Machine { chunks: 4, interlace: 1 }, &[everything, lower]);
    let micro = &scene.processors[1];
    assert_eq!((micro.polygons(), micro.vertices(), micro.segments(), micro.pixels()), (2, 8, 256, 32768));
    assert_eq!(micro.polygons_per_pixel, Distribution::from_iter([(2, 16384)]));
    // Printed: 731408.375, in single precision.
    assert!((scene.cycles[1] - 731_408.4).abs() < 1e-6);
    let text = listing(micro, &Costs::pdp11());
    // The printed share of pixels, 94.082603 %, carries the error of single precision.
    for line in
        ["[4]=2", "[128]=256", "[2]=16384", "(0.349244%)", "(94.082595%)", "total scene time 731408.4"]
    {
        assert!(text.contains(line), "{line} in\n{text}");
    }
}

#[test]
fn examples_of_section_4_3() {
    let costs = Costs::pdp11();
    let square = costs.total(
        &run(Machine::UNIPROCESSOR, &[polygon(&[[0, 0], [127, 0], [127, 127], [0, 127]])]).processors[0],
    );
    let point = costs.total(&run(Machine::UNIPROCESSOR, &[polygon(&[[9, 9]])]).processors[0]);
    assert_eq!((square / point).floor(), 573.0);
    assert!((point - 637.3).abs() < 1e-9);
}

#[test]
fn totals_of_appendix_c() {
    // Counts and printed totals of C.1 to C.8; the segments of C.3, C.6, C.7 and C.8 are the charged ones.
    let costs = Costs::pdp11();
    let y = Distribution::from_iter([
        (0, 14),
        (1, 134),
        (2, 71),
        (3, 16),
        (6, 2),
        (7, 4),
        (8, 4),
        (37, 1),
        (140, 1),
        (151, 1),
    ]);
    assert_eq!((y.points(), y.sum()), (248, 724));
    assert!((y.variance() - 172.348_328).abs() < 1e-5 && (y.deviation() - 13.128_15).abs() < 1e-6);
    for (polygons, vertices, segments, pixels, printed) in [
        (248, 731, 1411, 251_224, 5_766_526.5),
        (72, 163, 668, 113_134, 2_543_412.5),
        (248, 731, 738, 62_745, 1_702_129.0),
        (2, 8, 256, 32_768, 731_408.375),
        (51, 140, 312, 20_970, 541_457.062_5),
        (248, 731, 442, 15_865, 670_881.312_5),
        (248, 731, 434, 15_588, 663_800.312_5),
        (72, 163, 360, 28_295, 713_129.125),
    ] {
        let cycles = costs.cycles(polygons, vertices, segments, pixels);
        // Single precision: the largest difference is 4.2 cycles of 5.8 million.
        assert!((cycles - printed).abs() <= 8e-7 * printed, "{cycles} {printed}");
    }
}

#[test]
fn a_polygon_without_a_line_is_charged_one() {
    // One pixel, four processors: one draws it, the others are charged for polygon, vertex and one segment.
    let scene = run(Machine { chunks: 1, interlace: 2 }, &[polygon(&[[3, 2]])]);
    let counts: Vec<_> =
        scene.processors.iter().map(|p| (p.segments(), p.charged_segments(), p.pixels())).collect();
    // Processor 1 has odd columns of even lines; processor 0 has the line but not the pixel.
    assert_eq!(counts, [(1, 1, 0), (1, 1, 1), (0, 1, 0), (0, 1, 0)]);
    assert_eq!(scene.slowest(), (1, scene.cycles[1]));
}

#[test]
fn fifty_seven_processors() {
    let machines = Machine::PUBLISHED.map(|(_, machine)| machine);
    assert_eq!(machines.iter().map(Machine::processors).sum::<u32>(), 57);
    // 106.p431 is micro 7: column 3, row 1 from below.
    let place = Machine { chunks: 4, interlace: 1 }.places(512, 512).unwrap()[7];
    assert_eq!(place.chunk, PixelBox { x0: 384, y0: 128, x1: 511, y1: 255 });
    // 106.h1011 is micro 3 of the lower right quadrant.
    let place = Machine { chunks: 2, interlace: 2 }.places(512, 512).unwrap()[4 + 3];
    assert_eq!((place.chunk.x0, place.chunk.y0, place.phase), (256, 0, [1, 1]));
}

#[test]
fn clipping_makes_corners() {
    let chunk = PixelBox { x0: 10, y0: 10, x1: 19, y1: 19 };
    let vertices = |corners: &[[i32; 2]]| clip(&polygon(corners), &chunk).map(|p| p.vertices);
    assert_eq!(vertices(&[[0, 0], [40, 0], [40, 40], [0, 40]]), Some(4), "covers it");
    assert_eq!(vertices(&[[12, 12], [15, 12], [13, 15]]), Some(3), "lies inside");
    assert_eq!(vertices(&[[15, 5], [15, 15]]), Some(2), "a line over the lower border");
    assert_eq!(vertices(&[[15, 15], [25, 12], [25, 18]]), Some(3), "a corner inside, two cuts");
    assert_eq!(vertices(&[[8, 14], [15, 7], [22, 14], [15, 21]]), Some(8), "a diamond over all four borders");
    assert_eq!(vertices(&[[15, 3], [17, 10], [13, 10]]), Some(2), "its upper side on the first line");
    assert_eq!(vertices(&[[20, 10], [25, 12], [25, 18]]), None, "right of it");
}

#[test]
fn backs_are_left_out_and_lines_are_counted_from_below() {
    let back = ScreenPolygon { front: false, ..ScreenPolygon::at_pixels(&[[0, 0], [3, 0], [0, 3]]) };
    let front = ScreenPolygon::at_pixels(&[[7, 0]]);
    let scene = PolygonScene { width: 512, height: 512, polygons: vec![back, front] };
    assert_eq!(Polygon::of_scene(&scene), [polygon(&[[7, 511]])]);
}

#[test]
fn screens_that_cannot_be_divided_are_refused() {
    let error = |chunks, interlace, screen| {
        simulate(&Machine { chunks, interlace }, &Costs::pdp11(), screen, &[]).unwrap_err().to_string()
    };
    assert_eq!(error(3, 2, SCREEN), "expected a screen of 6 equal parts a side, found 512x512 pixels");
    assert!(error(0, 1, SCREEN).starts_with("expected 1 to 64 chunks"));
}

fn convex() -> impl Strategy<Value = Polygon> {
    // Corners in order round an ellipse stay convex except for rounding.
    let ellipse = (0i32..64, 0i32..64, 0i32..40, 0i32..40, prop::collection::btree_set(0u32..16, 1..7));
    ellipse.prop_map(|(x, y, w, h, angles)| {
        let corner = |angle: u32| {
            let (sin, cos) = (f64::from(angle) * std::f64::consts::TAU / 16.0).sin_cos();
            [x + (f64::from(w) * cos) as i32, y + (f64::from(h) * sin) as i32]
        };
        Polygon::new(angles.into_iter().map(corner)).unwrap()
    })
}

proptest! {
    #[test]
    fn every_machine_draws_the_same_pixels(
        polygons in prop::collection::vec(convex(), 1..12), chunks in 0u32..3, interlace in 0u32..3,
    ) {
        let machine = Machine { chunks: 1 << chunks, interlace: 1 << interlace };
        let run = |machine| simulate(&machine, &Costs::pdp11(), (64, 64), &polygons).unwrap();
        let (one, many) = (run(Machine::UNIPROCESSOR), run(machine));
        let pixels = |run: &SceneRun| run.processors.iter().map(ProcessorRun::pixels).sum::<u64>();
        prop_assert_eq!(pixels(&one), pixels(&many));
        // The number of polygons at every pixel is the same, too.
        let mut depth = Distribution::default();
        for (value, times) in many.processors.iter().flat_map(|p| p.polygons_per_pixel.counts()) {
            depth.add(value, times);
        }
        prop_assert_eq!(&one.processors[0].polygons_per_pixel, &depth);
        for processor in &many.processors {
            prop_assert_eq!(processor.polygons_per_pixel.sum(), processor.pixels());
            prop_assert_eq!(processor.pixels_per_polygon.sum(), processor.pixels());
        }
    }

    #[test]
    fn a_piece_has_at_most_four_corners_more(polygon in convex(), x in 0i32..50, y in 0i32..50) {
        let chunk = PixelBox { x0: x, y0: y, x1: x + 13, y1: y + 9 };
        if let Some(Piece { vertices, spans }) = clip(&polygon, &chunk) {
            prop_assert!(vertices >= 1 && vertices as usize <= polygon.corners().len() + 4);
            prop_assert!(spans.windows(2).all(|s| s[0].y + 1 == s[1].y), "lines without a gap");
            if spans.len() > 1 {
                prop_assert!(vertices >= 2);
            }
        }
    }
}
