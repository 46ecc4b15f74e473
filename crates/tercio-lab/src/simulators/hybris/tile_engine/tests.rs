use proptest::prelude::*;

use super::*;
use crate::simulators::hybris::Triangle;
use crate::simulators::hybris::triangle::PixelBox;

const PLAIN: EngineSettings =
    EngineSettings { set_up_triangle: 1, fifo: 4, fifo_after_broadcast: 2, rows: 1, columns: 1 };
const INTERLEAVED: EngineSettings = EngineSettings { rows: 2, columns: 2, ..PLAIN };

/// A rectangle of pixels as input of the engine.
fn rectangle(x: i32, y: i32, width: i32, height: usize) -> TileWork {
    TileWork { first_row: y, spans: vec![Span { first: x, end: x + width }; height] }
}

#[test]
fn one_triangle_by_hand() {
    // Set-up in cycle 1, first row in 2, its span clipped in 3, its first pixel in 4; then a pixel per cycle.
    for (width, height) in [(1, 1), (5, 1), (5, 7), (32, 32)] {
        let counts = run_tile(PLAIN, &[rectangle(0, 0, width, height)]);
        assert_eq!(counts.cycles, 3 + (width as usize * height) as u64, "{width}x{height}");
        assert_eq!(counts.stages[3].busy, counts.pixels);
    }
}

#[test]
fn triangles_of_one_pixel_come_out_one_a_cycle() {
    let work = vec![rectangle(3, 3, 1, 1); 100];
    assert_eq!(run_tile(PLAIN, &work).cycles, 3 + 100);
    // A set-up of three cycles is then the bottleneck.
    let slow = EngineSettings { set_up_triangle: 3, ..PLAIN };
    assert_eq!(run_tile(slow, &work).cycles, 3 * 100 + 3);
}

#[test]
fn four_draw_spans_share_a_large_triangle() {
    // Two rows at a time, two pixels of each: there is a broadcast queue before each pair, one cycle each.
    let counts = run_tile(INTERLEAVED, &[rectangle(0, 0, 32, 32)]);
    assert_eq!(counts.cycles, 3 + 2 + 16 * 16);
    // A single pixel uses only one of the four; nothing is gained.
    let counts = run_tile(INTERLEAVED, &[rectangle(0, 0, 1, 1)]);
    assert_eq!(counts.cycles, 3 + 2 + 1);
}

#[test]
fn four_rows_are_drawn_at_a_time() {
    let lines = EngineSettings { rows: 4, columns: 1, ..PLAIN };
    // Eight rows of 32 pixels each; one broadcast on the way, that of the triangle.
    assert_eq!(run_tile(lines, &[rectangle(0, 0, 32, 32)]).cycles, 3 + 1 + 8 * 32);
    // One row uses one stage of four.
    assert_eq!(run_tile(lines, &[rectangle(0, 0, 32, 1)]).cycles, 3 + 1 + 32);
    assert_eq!(run_tile(lines, &[rectangle(0, 0, 1, 32)]).cycles, 3 + 1 + 8);
}

#[test]
fn a_full_queue_stalls_and_an_empty_one_starves() {
    // A large triangle first: its rows wait for pixels, the small ones after it wait for its rows.
    let mut work = vec![rectangle(0, 0, 32, 32)];
    work.extend(vec![rectangle(0, 0, 1, 1); 10]);
    let counts = run_tile(EngineSettings { fifo: 1, ..PLAIN }, &work);
    assert_eq!(counts.cycles, 3 + 1024 + 10);
    assert!(counts.stages[0].stalled > 900 && counts.stages[1].stalled > 900, "{counts:?}");
    assert_eq!(counts.stages[3].stalled, 0);
    assert_eq!(counts.stages[3].starved, 3);
    assert_eq!(counts.fifo_peaks[0], 1);
}

#[test]
fn rows_without_pixels_are_dropped_before_draw_span() {
    let counts = run_tile(PLAIN, &[rectangle(0, 0, 0, 5), rectangle(0, 0, 2, 1)]);
    // Five rows pass Draw Triangle in cycles 2 to 6, the sixth in 7, its pixels are drawn in 9 and 10.
    assert_eq!((counts.cycles, counts.stages[3].busy), (10, 2));
}

#[test]
fn a_triangle_is_cut_at_the_tile() {
    let triangle = Triangle::new([(0, 0), (0, 64 * 256), (64 * 256, 0)]);
    let tile = PixelBox { x0: 32, x1: 64, y0: 0, y1: 32 };
    let work = TileWork::new(&triangle, tile);
    // Row r ends before pixel 63 - r.
    assert_eq!((work.rows(), work.pixels()), (32, (0..32).map(|r| 63 - r - 32).sum::<u64>()));
}

fn any_work() -> impl Strategy<Value = Vec<TileWork>> {
    let one =
        (0..32i32, 0..32i32, prop::collection::vec((0..32i32, 0..9i32), 0..12)).prop_map(|(_, y, rows)| {
            TileWork {
                first_row: y,
                spans: rows.iter().map(|&(x, w)| Span { first: x, end: x + w }).collect(),
            }
        });
    prop::collection::vec(one, 0..40)
}

proptest! {
    /// Every stage's cycles are accounted for, all work is done, and no engine is faster than its busiest stage.
    #[test]
    fn cycles_are_accounted_for(work in any_work(), fifo in 1usize..6, rows in 1usize..5, columns in 1usize..3) {
        let settings = EngineSettings { fifo, rows, columns, ..PLAIN };
        let counts = run_tile(settings, &work);
        let all_rows: u64 = work.iter().map(TileWork::rows).sum();
        for (k, instances) in [1, rows, rows, rows * columns].into_iter().enumerate() {
            let s = counts.stages[k];
            prop_assert_eq!(s.busy + s.stalled + s.starved, counts.cycles * instances as u64);
        }
        prop_assert_eq!(counts.stages[0].busy, work.len() as u64);
        prop_assert_eq!(counts.stages[2].busy, all_rows);
        prop_assert!(counts.stages[3].busy >= counts.pixels);
        let least = all_rows.div_ceil(rows as u64).max(counts.pixels.div_ceil((rows * columns) as u64));
        prop_assert!(counts.cycles >= least.max(work.len() as u64));
        prop_assert!(counts.fifo_peaks[0] <= fifo);
    }

    /// More room in the queues never makes the plain engine slower, and unlimited room hides all but one stage.
    #[test]
    fn deeper_queues_are_never_slower(work in any_work()) {
        let cycles = |fifo| run_tile(EngineSettings { fifo, ..PLAIN }, &work).cycles;
        let mut last = cycles(1);
        for fifo in [2, 3, 5, 9, 1000] {
            let now = cycles(fifo);
            prop_assert!(now <= last);
            last = now;
        }
    }
}
