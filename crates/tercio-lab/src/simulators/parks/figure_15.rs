//! "Runway with one shuttle": the scene of document 002, figure 15, rebuilt from the statistics of its appendix C.
//!
//! The scene itself is lost, but C.1, C.2, C.4 and C.5 describe it well enough to make a scene with the same
//! statistics. The two large polygons are fully determined: 210 lines without a polygon leave a landscape of 302 lines;
//! 352 segments of full width minus those 302 leave a runway with 50 such lines at its lower end; its other 230 lines
//! shrink by one pixel per side, as the widths in C.1 and its 49 lines in micro 7 (C.5) show. The third largest has 73
//! lines, 49 of them in micro 7; it is given approximately the widths that C.5 lists. The 245 small ones have the
//! numbers of vertices and lines of C.1, C.2 and C.5, paired by us; their widths are fitted to the number of pixels.
//! Their positions inside their quarter are our choice.
//!
//! So counts of the uniprocessor, of splitter-16's micros 1 and 7 and of splitter-4's micro 1 are those of the document
//! by construction (the last one except for one pixel); interlace and hybrid agree only as far as they do not depend on
//! the positions of small polygons.

use super::polygon::Polygon;
use crate::workloads::{PolygonScene, ScreenPolygon};

/// Pixels of the document's screen, both ways.
pub const SCREEN: u32 = 512;
/// Pixels of the whole scene, C.1.
const PIXELS: u64 = 251_224;
/// Pixels of micro 7, C.5.
const MICRO_7_PIXELS: u64 = 20_970;

/// Small polygons of one kind.
#[derive(Clone, Copy)]
struct Kind {
    count: usize,
    vertices: usize,
    lines: i32,
}

const fn kind(count: usize, vertices: usize, lines: i32) -> Kind {
    Kind { count, vertices, lines }
}

/// Those in micro 7 (C.5): 17, 29 and 2 with 2, 3 and 4 vertices; 20, 18 and 10 with 1, 2 and 3 lines.
const IN_MICRO_7: [Kind; 5] = [kind(17, 2, 1), kind(3, 3, 1), kind(18, 3, 2), kind(8, 3, 3), kind(2, 4, 3)];
/// Of the polygons above, those that touch the lower right quarter with one vertex (C.2).
const TOUCHING: [Kind; 1] = [kind(21, 3, 3)];
/// The other polygons of C.1.
const ABOVE: [Kind; 12] = [
    kind(2, 1, 1),
    kind(9, 2, 1),
    kind(28, 2, 2),
    kind(49, 3, 2),
    kind(37, 3, 3),
    kind(17, 3, 4),
    kind(6, 4, 4),
    kind(7, 4, 5),
    kind(11, 4, 6),
    kind(2, 4, 11),
    kind(4, 4, 14),
    kind(4, 5, 15),
];

/// A small polygon whose `width` is still to be fitted.
struct Small {
    kind: Kind,
    at: [i32; 2],
    width: i32,
}

impl Small {
    /// Least width at which the corners are distinct.
    fn least_width(kind: Kind) -> i32 {
        match (kind.vertices, kind.lines) {
            (1, _) => 1,
            (vertices, 1) => vertices as i32,
            (5, _) => 3,
            _ => 2,
        }
    }

    /// The polygon; its lowest line has one pixel if it has three vertices and more than one line.
    fn polygon(&self) -> Polygon {
        let ([x, y], right, top) = (self.at, self.width - 1, self.kind.lines - 1);
        let corners: &[[i32; 2]] = match (self.kind.vertices, self.kind.lines) {
            (1, _) => &[[0, 0]],
            (2, _) => &[[0, 0], [right, top]],
            (3, 1) => &[[0, 0], [1, 0], [right, 0]],
            (3, _) => &[[0, 0], [right, top], [0, top]],
            (4, _) => &[[0, 0], [right, 0], [right, top], [0, top]],
            _ => &[[0, 0], [right, 0], [right, top - 1], [right - 1, top], [0, top]],
        };
        placed(corners, [x, y])
    }

    fn pixels(&self) -> u64 {
        pixels(&self.polygon(), i32::MAX)
    }
}

fn placed(corners: &[[i32; 2]], [x, y]: [i32; 2]) -> Polygon {
    let corners = corners.iter().map(|c| [c[0] + x, c[1] + y]);
    Polygon::new(corners).unwrap_or_else(|| unreachable!("a polygon has corners"))
}

/// Pixels of a polygon below a line.
fn pixels(polygon: &Polygon, end: i32) -> u64 {
    let [low, high] = polygon.lines();
    let spans = (low..=high.min(end - 1)).filter_map(|y| polygon.span(y));
    spans.map(|s| (s.last - s.first + 1) as u64).sum()
}

/// Small polygons of these kinds in rows of `row`, from `first` in steps of `step` pixels.
fn spread(kinds: &[Kind], first: [i32; 2], step: [i32; 2], row: i32) -> Vec<Small> {
    let all = kinds.iter().flat_map(|&kind| std::iter::repeat_n(kind, kind.count));
    let places = (0..).map(|i| [first[0] + i % row * step[0], first[1] + i / row * step[1]]);
    all.zip(places).map(|(kind, at)| Small { kind, at, width: Small::least_width(kind) }).collect()
}

/// Widens polygons in turn until together they have `target` pixels. Those of one line take the remainder.
fn fit(polygons: &mut [Small], target: u64, widest: i32) {
    let mut sum: u64 = polygons.iter().map(Small::pixels).sum();
    loop {
        let before = sum;
        for polygon in polygons.iter_mut().filter(|p| p.kind.vertices > 1 && p.width < widest) {
            let old = polygon.pixels();
            polygon.width += 1;
            let new = polygon.pixels();
            if sum - old + new > target {
                polygon.width -= 1;
            } else {
                sum = sum - old + new;
            }
        }
        if sum == before {
            return;
        }
    }
}

/// The scene, y upwards: landscape, runway, the third largest, then the small ones.
pub fn polygons() -> Vec<Polygon> {
    polygons_moved([0, 0])
}

/// The same with the small polygons moved by some pixels inside their quarters: their places are not known. Those that
/// touch a quarter from above are moved only sideways.
pub fn polygons_moved([dx, dy]: [i32; 2]) -> Vec<Polygon> {
    let landscape = placed(&[[0, 0], [511, 0], [511, 301], [0, 301]], [0, 0]);
    let runway = placed(&[[0, 0], [511, 0], [511, 49], [281, 279], [230, 279], [0, 49]], [0, 0]);
    let third = placed(&[[0, 0], [111, 42], [51, 72], [0, 72]], [400, 207]);

    let in_micro_7 = MICRO_7_PIXELS - 128 * 128 - (1..=49).sum::<u64>() - pixels(&third, 256);
    let mut low = spread(&IN_MICRO_7, [386 + dx, 130 + dy], [15, 11], 8);
    fit(&mut low, in_micro_7, 14);

    let large: u64 = [&landscape, &runway, &third].iter().map(|p| pixels(p, i32::MAX)).sum();
    let mut high = spread(&TOUCHING, [258 + dx, 255], [5, 0], 21);
    high.extend(spread(&ABOVE, [389 + dx, 261 + dy], [9, 17], 13));
    fit(&mut high, PIXELS - large - in_micro_7, 8);

    let small = low.iter().chain(&high).map(Small::polygon);
    [landscape, runway, third].into_iter().chain(small).collect()
}

/// The scene as a workload, y downwards.
pub fn scene() -> PolygonScene {
    let down = |&[x, y]: &[i32; 2]| [x, SCREEN as i32 - 1 - y];
    let polygons = polygons();
    let polygons = polygons.iter().map(|p| {
        let corners: Vec<[i32; 2]> = p.corners().iter().map(down).collect();
        ScreenPolygon::at_pixels(&corners)
    });
    PolygonScene { width: SCREEN, height: SCREEN, polygons: polygons.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulators::parks::{Costs, Distribution, Machine, ProcessorRun, simulate};

    fn counts(run: &ProcessorRun) -> (u64, u64, u64, u64) {
        (run.polygons(), run.vertices(), run.segments(), run.pixels())
    }

    fn run(chunks: u32, interlace: u32) -> Vec<ProcessorRun> {
        let size = (SCREEN, SCREEN);
        simulate(&Machine { chunks, interlace }, &Costs::pdp11(), size, &polygons()).unwrap().processors
    }

    #[test]
    fn the_uniprocessor_of_appendix_c_1() {
        let one = &run(1, 1)[0];
        assert_eq!(counts(one), (248, 731, 1411, 251_224));
        let vertices = [(1, 2), (2, 54), (3, 153), (4, 34), (5, 4), (6, 1)];
        assert_eq!(one.vertices_per_polygon, Distribution::from_iter(vertices));
        let lines = [
            (1, 31),
            (2, 95),
            (3, 68),
            (4, 23),
            (5, 7),
            (6, 11),
            (11, 2),
            (14, 4),
            (15, 4),
            (73, 1),
            (280, 1),
            (302, 1),
        ];
        assert_eq!(one.segments_per_polygon, Distribution::from_iter(lines));
        assert!(one.pixels_per_segment.counts().any(|c| c == (512, 352)));
    }

    #[test]
    fn splitters_of_appendix_c_2_4_and_5() {
        let sixteen = run(4, 1);
        assert_eq!(counts(&sixteen[1]), (2, 8, 256, 32_768));
        assert_eq!(counts(&sixteen[7]), (51, 140, 312, 20_970));
        // C.2 has 113,134 pixels.
        assert_eq!(counts(&run(2, 1)[1]), (72, 163, 668, 113_133));
    }

    #[test]
    fn the_workload_is_the_scene() {
        assert_eq!(Polygon::of_scene(&scene()), polygons());
    }
}
