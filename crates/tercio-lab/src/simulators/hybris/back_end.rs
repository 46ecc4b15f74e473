//! The back end: all tiles of a frame on one or two tile engines.

use serde::Serialize;
use tercio_mesh::loops::prelude::*;

use super::FrontEnd;
use super::front_end::Tiles;
use super::tile_engine::{EngineCounts, EngineSettings, TileWork, run_tile};

/// How two or more engines share a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// Each has tiles of its own, in the colours of a checkerboard (document 001, 3.6.3).
    Tiles,
    /// All work on the same tile, each on every n-th triangle; their pictures are composited (3.6.4).
    Composition,
    /// Pairs have tiles of their own, and the two of a pair every other triangle (figure 3.23): for an even number of engines.
    Hybrid,
}

impl Sharing {
    /// In how many groups `engines` are, and how many work on the same tile. `None` if there are no such groups: no engines, or of
    /// an odd number pairs.
    pub fn groups(self, engines: usize) -> Option<(usize, usize)> {
        match self {
            _ if engines == 0 => None,
            Self::Tiles => Some((engines, 1)),
            Self::Composition => Some((1, engines)),
            Self::Hybrid => engines.is_multiple_of(2).then_some((engines / 2, 2)),
        }
    }
}

/// A frame's back end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BackEnd {
    /// Cycles from the first triangle to the last pixel in the frame buffer.
    pub cycles: u64,
    /// Tiles with at least one triangle; the others are not drawn.
    pub tiles_used: u64,
    /// The work of each engine.
    pub engines: Vec<EngineCounts>,
    /// Cycles in which a finished tile was copied out.
    pub output_cycles: u64,
}

impl BackEnd {
    /// The busiest engine's drawing time over the mean, 1 if they are even.
    pub fn imbalance(&self) -> f64 {
        let most = self.engines.iter().map(|e| e.cycles).max().unwrap_or(0);
        let sum: u64 = self.engines.iter().map(|e| e.cycles).sum();
        if sum == 0 { 1.0 } else { most as f64 * self.engines.len() as f64 / sum as f64 }
    }

    /// The work of all engines together.
    pub fn total(&self) -> EngineCounts {
        self.engines.iter().fold(EngineCounts::default(), |sum, e| sum.plus(*e))
    }
}

/// Configuration of the back end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BackEndSettings {
    /// An engine.
    pub engine: EngineSettings,
    /// Number of engines.
    pub engines: usize,
    /// How they share a frame.
    pub sharing: Sharing,
    /// Pixels copied from a finished tile in a cycle.
    pub output: u64,
}

/// Draws the heaps of some front ends: every tile reads all of them, in their order. `None` if so many engines cannot share a frame
/// so ([`Sharing::groups`]).
pub fn run(front_ends: &[FrontEnd], tiles: Tiles, settings: BackEndSettings) -> Option<BackEnd> {
    let engines = settings.engines;
    let groups = settings.sharing.groups(engines)?;
    // How long each engine draws its triangles of a tile: a list of (engine, counts) for each used tile.
    let drawn: Vec<(usize, Vec<(usize, EngineCounts)>)> = (0..tiles.count())
        .into_par_iter()
        .filter_map(|tile| {
            let work = tile_work(front_ends, tiles, tile);
            (!work.is_empty()).then(|| (tile, draw(tile, &work, tiles, settings.engine, groups)))
        })
        .collect();
    let mut sums = vec![EngineCounts::default(); engines];
    let mut clock = Clock::new(engines);
    for (tile, parts) in &drawn {
        let pixels = tiles.pixels(*tile);
        let area = (pixels.x1 - pixels.x0) as u64 * (pixels.y1 - pixels.y0) as u64;
        let output = area.div_ceil(settings.output.max(1));
        let engines: Vec<_> = parts.iter().map(|p| (p.0, p.1.cycles)).collect();
        clock.tile(&engines, output);
        for (engine, counts) in parts {
            sums[*engine] = sums[*engine].plus(*counts);
        }
    }
    Some(BackEnd {
        cycles: clock.now(),
        tiles_used: drawn.len() as u64,
        engines: sums,
        output_cycles: clock.output_cycles,
    })
}

/// The triangles of one tile.
pub fn tile_work(front_ends: &[FrontEnd], tiles: Tiles, tile: usize) -> Vec<TileWork> {
    let pixels = tiles.pixels(tile);
    let of = |f: &FrontEnd| -> Vec<_> {
        f.heap.bucket(tile).iter().map(|&n| TileWork::new(&f.nodes[n as usize], pixels)).collect()
    };
    front_ends.iter().flat_map(of).collect()
}

fn draw(
    tile: usize,
    work: &[TileWork],
    tiles: Tiles,
    engine: EngineSettings,
    (groups, parts): (usize, usize),
) -> Vec<(usize, EngineCounts)> {
    let (column, row) = tiles.place(tile);
    let first = (column + row) as usize % groups * parts;
    (0..parts)
        .map(|part| {
            let own: Vec<_> = work.iter().skip(part).step_by(parts).cloned().collect();
            (first + part, run_tile(engine, &own))
        })
        .collect()
}

/// The times at which engines and the bus to the frame buffer are free.
struct Clock {
    /// End of each engine's last drawing.
    drawn: Vec<u64>,
    /// End of copying each engine's last tile but one, and of its last: each engine has two tile buffers.
    copied: Vec<[u64; 2]>,
    /// End of the last copy.
    bus: u64,
    output_cycles: u64,
}

impl Clock {
    fn new(engines: usize) -> Self {
        Self { drawn: vec![0; engines], copied: vec![[0; 2]; engines], bus: 0, output_cycles: 0 }
    }

    /// Adds a tile that takes the given cycles of each of these engines; it is copied out once, when all are done.
    /// Tiles are copied in their order.
    fn tile(&mut self, engines: &[(usize, u64)], output: u64) {
        let start = |&(e, _): &(usize, u64)| self.drawn[e].max(self.copied[e][0]);
        let ends: Vec<u64> = engines.iter().map(|part| start(part) + part.1).collect();
        let ready = ends.iter().copied().max().unwrap_or(0);
        let done = ready.max(self.bus) + output;
        for (&(e, _), end) in engines.iter().zip(ends) {
            self.drawn[e] = end;
            self.copied[e] = [self.copied[e][1], done];
        }
        self.bus = done;
        self.output_cycles += output;
    }

    fn now(&self) -> u64 {
        self.drawn.iter().copied().max().unwrap_or(0).max(self.bus)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copying_overlaps_drawing_of_the_next_tile() {
        let mut clock = Clock::new(1);
        clock.tile(&[(0, 100)], 40);
        assert_eq!(clock.now(), 140);
        clock.tile(&[(0, 100)], 40);
        assert_eq!(clock.now(), 240);
        // Drawing is faster than copying: the third tile waits for the first one's buffer.
        let mut clock = Clock::new(1);
        (0..3).for_each(|_| clock.tile(&[(0, 10)], 100));
        assert_eq!(clock.now(), 10 + 3 * 100);
    }

    /// Each of 8 tiles in a row with the same 8 triangles, which any sharing of four engines divides evenly.
    #[test]
    fn four_engines_share_even_tiles_evenly() {
        use crate::simulators::hybris::heap::HeapLayout;
        use crate::simulators::hybris::{Partition, Triangle};
        let tiles = Tiles { width: 256, height: 32, edge: 32 };
        let at = |x: i32| Triangle::new([(x, 0), (x, 30), (x + 30, 0)].map(|(x, y)| (x * 256, y * 256)));
        let triangles = (0..8).flat_map(|tile| [at(tile * 32); 8]).collect();
        let front =
            FrontEnd::run(&[Partition { vertices: 3, outside: 0, triangles }], tiles, HeapLayout::DOCUMENT);
        let engine =
            EngineSettings { set_up_triangle: 1, fifo: 1, fifo_after_broadcast: 1, rows: 1, columns: 1 };
        let run = |engines, sharing| {
            run(
                std::slice::from_ref(&front),
                tiles,
                BackEndSettings { engine, engines, sharing, output: 1 << 20 },
            )
        };
        assert_eq!((run(3, Sharing::Hybrid), run(0, Sharing::Tiles)), (None, None), "no pairs, no engines");
        let run = |engines, sharing| run(engines, sharing).expect("groups");
        // A tile of k triangles takes 3 cycles to fill the pipeline, and a cycle a pixel or an empty row.
        let one = run(1, Sharing::Tiles);
        let of_triangle = (one.total().cycles / 8 - 3) / 8;
        assert_eq!(one.total().cycles, 8 * (3 + 8 * of_triangle));
        for (sharing, most) in [
            (Sharing::Tiles, 2 * (3 + 8 * of_triangle)),
            (Sharing::Hybrid, 4 * (3 + 4 * of_triangle)),
            (Sharing::Composition, 8 * (3 + 2 * of_triangle)),
        ] {
            let four = run(4, sharing);
            assert!(four.engines.iter().all(|e| e.cycles == most), "{sharing:?} {four:?}");
            assert_eq!(four.total().pixels, one.total().pixels);
        }
    }

    #[test]
    fn two_engines_draw_at_the_same_time_and_copy_in_turn() {
        let mut clock = Clock::new(2);
        clock.tile(&[(0, 100)], 10);
        clock.tile(&[(1, 100)], 10);
        assert_eq!(clock.now(), 120);
        let mut composed = Clock::new(2);
        composed.tile(&[(0, 60), (1, 40)], 10);
        assert_eq!(composed.now(), 70);
    }
}
