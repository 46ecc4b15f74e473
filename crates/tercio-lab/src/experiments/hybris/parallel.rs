//! Four engines, and an engine of four scan lines: figures 3.23 and 3.26.

use super::scenes::{REMARK, SCREEN, SMALL, scene, scene_of_size};
use crate::experiments::sweep::sweep;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::machines::load;
use crate::published::ToleranceSource;
use crate::simulators::hybris::back_end::{BackEnd, BackEndSettings, Sharing, run};
use crate::simulators::hybris::front_end::{FrontEndCounts, Tiles};
use crate::simulators::hybris::heap::HeapLayout;
use crate::simulators::hybris::samples::{Pattern, scaled, sparse_work};
use crate::simulators::hybris::tile_engine::{EngineCounts, EngineSettings, TileWork, run_tile};
use crate::simulators::hybris::{FrontEnd, Scene, Triangle};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "hybris-fig-3-23",
        document: Document::Hybris,
        place: "figure 3.23, section 3.6.4",
        title: "Four engines: tiles of their own, pairs of engines, or all on one tile",
        run: four_engines,
    },
    Experiment {
        id: "hybris-fig-3-26",
        document: Document::Hybris,
        place: "figure 3.26, sections 3.6.5 and 3.6.6",
        title: "Four scan lines at a time, and samples of a pixel",
        run: scan_lines,
    },
];

/// Pixels along a tile's edge, and samples along that of its buffer.
const EDGE: u32 = 32;

/// The engine of the ASIC, with the queues of the interleaved one.
fn engine(rows: usize, columns: usize) -> Result<EngineSettings, ExperimentError> {
    let machine = load("hybris-asic-2x2")?;
    let engine = EngineSettings::of(machine.need(machine.tile_engine.as_ref(), "tile-engine")?);
    Ok(EngineSettings { rows, columns, ..engine })
}

fn front(scene: &Scene, edge: u32) -> (FrontEnd, Tiles) {
    let tiles = Tiles { width: scene.width, height: scene.height, edge };
    (FrontEnd::run(&scene.partitions, tiles, HeapLayout::DOCUMENT), tiles)
}

/// Models of more and more triangles in the same picture.
const TRIANGLES: [&str; 6] = ["500", "2k", "8k", "32k", "128k", "512k"];

fn four_engines() -> Result<Findings, ExperimentError> {
    const WAYS: [(&str, usize, Sharing); 5] = [
        ("tiles of their own", 4, Sharing::Tiles),
        ("pairs, figure 3.23", 4, Sharing::Hybrid),
        ("all on one tile", 4, Sharing::Composition),
        ("two engines, tiles", 2, Sharing::Tiles),
        ("two engines, one tile", 2, Sharing::Composition),
    ];
    let engine = engine(1, 1)?;
    let frames = sweep(&TRIANGLES, |count| {
        let (front, tiles) = front(&scene(&format!("builtin:teapot@{count}"))?, EDGE);
        let fronts = [front];
        let of = |engines, sharing| {
            let back = run(&fronts, tiles, BackEndSettings { engine, engines, sharing, output: 1024 });
            back.ok_or_else(|| format!("{engines} engines make no groups for {sharing:?}"))
        };
        let one = of(1, Sharing::Tiles)?;
        let a_tile = one.total().triangles as f64 / one.tiles_used.max(1) as f64;
        let ways: Result<Vec<BackEnd>, _> =
            WAYS.iter().map(|&(_, engines, sharing)| of(engines, sharing)).collect();
        Ok((a_tile, one, ways?))
    })?;
    let mut table = Table::new(
        "speed-ups",
        &[
            ("triangles", ""),
            ("triangles a tile", ""),
            ("engines", ""),
            ("cycles", "cycle"),
            ("speed-up", ""),
            ("busiest over mean", ""),
        ],
    );
    let mut curves = vec![Vec::new(); WAYS.len()];
    let mut same = true;
    for (count, (a_tile, one, ways)) in TRIANGLES.iter().zip(&frames) {
        for (((name, ..), back), curve) in WAYS.iter().zip(ways).zip(&mut curves) {
            let back: &BackEnd = back;
            let speed_up = one.cycles as f64 / back.cycles as f64;
            same &= back.total().pixels == one.total().pixels;
            table.push([
                (*count).into(),
                (*a_tile).into(),
                (*name).into(),
                (back.cycles as f64).into(),
                speed_up.into(),
                back.imbalance().into(),
            ]);
            curve.push((*a_tile, speed_up));
        }
    }
    let mut comparison = Comparison::new();
    comparison.claim("all draw the pixels of one engine", same);
    let composed = &curves[2];
    let (few, many) = (composed[0].1, composed[composed.len() - 1].1);
    comparison.claim(
        format!("engines on one tile need many triangles a tile: {few:.2} times as fast with the fewest, {many:.2} with the most"),
        few < many,
    );
    let over_two = |k: usize| curves[1][k].1 / curves[3][k].1.max(curves[4][k].1);
    let least = (0..TRIANGLES.len()).map(over_two).fold(f64::MAX, f64::min);
    let mut plot = Plot::new(
        "speed-ups",
        "Several engines against one",
        Axis::log10("triangles a tile"),
        Axis::linear("speed-up"),
    );
    for ((name, ..), curve) in WAYS.iter().zip(curves) {
        plot = plot.with(Series::line_points(*name, curve));
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            REMARK.into(),
            "The same teapot is divided into more and more triangles. Composition itself takes no cycles, as in the figure's \
             pipeline of composers; tiles are copied out once."
                .into(),
            format!("Two pairs are at least {least:.2} times as fast as two engines that share in either way."),
        ],
        verdict: comparison.qualitative("The figure is a block diagram, and the document prints no speeds of it."),
    })
}

/// Cycles and pixels of all tiles, one after the other.
fn draw(
    (front, tiles): &(FrontEnd, Tiles),
    engine: EngineSettings,
    pattern: Option<Pattern<'_>>,
) -> Result<EngineCounts, ExperimentError> {
    let all: Vec<_> = (0..tiles.count()).collect();
    let counts = sweep(&all, |&tile| {
        let pixels = tiles.pixels(tile);
        let of = |&node: &u32| {
            let triangle: &Triangle = &front.nodes[node as usize];
            match pattern {
                Some(pattern) => sparse_work(triangle, pixels, pattern),
                None => TileWork::new(triangle, pixels),
            }
        };
        let work: Vec<_> = front.heap.bucket(tile).iter().map(of).collect();
        Ok(if work.is_empty() { EngineCounts::default() } else { run_tile(engine, &work) })
    })?;
    Ok(counts.into_iter().fold(EngineCounts::default(), EngineCounts::plus))
}

/// Pixels a cycle with triangles that fill the tile.
fn pixels_a_cycle(engine: EngineSettings) -> f64 {
    let edge = EDGE as i32;
    let tile = Tiles { width: EDGE, height: EDGE, edge: EDGE }.pixels(0);
    let all =
        Triangle::new([(0, 0), (0, 4 * edge), (4 * edge, 0)].map(|(x, y)| (x * 256 - 256, y * 256 - 256)));
    let counts = run_tile(engine, &vec![TileWork::new(&all, tile); 100]);
    counts.pixels as f64 / counts.cycles as f64
}

/// The pattern of four samples that are most even (figure 3.25 has lost its places).
const PATTERN: [u32; 4] = [1, 3, 0, 2];

fn scan_lines() -> Result<Findings, ExperimentError> {
    let plain = scene_of_size(SMALL, SCREEN)?;
    let (two, four) = (scaled(&plain, 2), scaled(&plain, 4));
    // A buffer of 32 by 32 samples holds 16 by 16 pixels of four samples, or 8 by 8 of sixteen.
    let one = front(&plain, EDGE);
    let ordered = front(&two, EDGE);
    let sparse = front(&four, 2 * EDGE);
    let full = front(&four, EDGE);
    let (single, square, lines) = (engine(1, 1)?, engine(2, 2)?, engine(4, 1)?);
    type Way<'a> = (&'static str, &'static str, &'a (FrontEnd, Tiles), EngineSettings, Option<Pattern<'a>>);
    let ways: [Way<'_>; 8] = [
        ("1", "one", &one, single, None),
        ("1", "2x2, figure 3.24", &one, square, None),
        ("1", "four lines, figure 3.26", &one, lines, None),
        ("2x2", "2x2, figure 3.24", &ordered, square, None),
        ("2x2", "four lines, figure 3.26", &ordered, lines, None),
        ("4 sparse", "one", &sparse, single, Some(&PATTERN)),
        ("4 sparse", "four lines, figure 3.26", &sparse, lines, Some(&PATTERN)),
        ("4x4", "2x2, figure 3.24", &full, square, None),
    ];
    let mut table = Table::new(
        "cycles",
        &[
            ("samples a pixel", ""),
            ("engine", ""),
            ("triangles set up", ""),
            ("sub-pixel triangles", "%"),
            ("samples drawn", ""),
            ("cycles", "cycle"),
            ("cycles over one sample, one engine", ""),
        ],
    );
    let drawn = ways.iter().map(|w| draw(w.2, w.3, w.4)).collect::<Result<Vec<_>, _>>()?;
    let culled = |c: &FrontEndCounts| 100.0 * c.sub_pixel as f64 / c.triangles as f64;
    for ((samples, name, front, ..), counts) in ways.iter().zip(&drawn) {
        table.push([
            (*samples).into(),
            (*name).into(),
            (front.0.counts.nodes as f64).into(),
            culled(&front.0.counts).into(),
            (counts.pixels as f64).into(),
            (counts.cycles as f64).into(),
            (counts.cycles as f64 / drawn[0].cycles as f64).into(),
        ]);
    }
    let [_, plain_square, plain_lines, ordered_square, _, sparse_one, sparse_lines, full_square] = &drawn[..]
    else {
        return Err("there are eight ways".into());
    };
    let mut comparison = Comparison::new();
    // "Increases the effective bandwidth of the tile pixel memory four times, allowing four pixel span processors to work
    // with no performance penalty"; figure 3.26 has four as well.
    for (name, engine) in [("2x2", square), ("four lines", lines)] {
        // "No penalty" is a bound: the pipeline fills in a few of 25,600 cycles.
        let name = format!("pixels a cycle in triangles that fill a tile, {name}");
        comparison.add(name, pixels_a_cycle(engine), 4.0, 0.004, ToleranceSource::Bound);
    }
    let ratio = plain_lines.cycles as f64 / plain_square.cycles as f64;
    let share = sparse_lines.pixels as f64 / full_square.pixels as f64;
    comparison.claim(
        format!("sparse samples are a quarter of those of 4x4 ({share:.4} of them)"),
        (share - 0.25).abs() < 0.0025,
    );
    comparison.claim(
        format!(
            "sparse samples on four lines take {:.2} of the cycles of one engine, and {:.2} of those of 4x4 samples",
            sparse_lines.cycles as f64 / sparse_one.cycles as f64,
            sparse_lines.cycles as f64 / full_square.cycles as f64
        ),
        sparse_lines.cycles < sparse_one.cycles && sparse_lines.cycles < full_square.cycles,
    );
    comparison.claim(
        format!(
            "fewer triangles fall between samples: {:.1}, {:.1} and {:.1} % at 1, 2 and 4 a pixel's side",
            culled(&one.0.counts),
            culled(&ordered.0.counts),
            culled(&sparse.0.counts)
        ),
        one.0.counts.sub_pixel > ordered.0.counts.sub_pixel
            && ordered.0.counts.sub_pixel > sparse.0.counts.sub_pixel,
    );
    let names = ways.map(|w| format!("{}, {}", w.0, w.1.split(',').next().unwrap_or(w.1)));
    let points = (1..).zip(&drawn).map(|(k, c)| (f64::from(k), c.cycles as f64)).collect();
    let plot = Plot::new(
        "cycles",
        "Cycles of a frame by samples a pixel and engine",
        Axis::categories("samples, engine", 1, names),
        Axis::linear("cycles"),
    )
    .with(Series::points("simulated", points));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            REMARK.into(),
            format!(
                "Tile buffers have 32x32 samples, so that a tile with four samples a pixel has 16x16 pixels. Four samples \
                 cost the 2x2 engine {:.2}, four lines {:.2} times the cycles of one sample on the 2x2 engine. Without \
                 samples four lines take {ratio:.2} of the cycles of 2x2.",
                ordered_square.cycles as f64 / plain_square.cycles as f64,
                sparse_lines.cycles as f64 / plain_square.cycles as f64
            ),
        ],
        verdict: comparison
            .qualitative("The figure is a block diagram; only the number of processors is printed."),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_scene_are_counted_one_by_one() {
        let plain = scene_of_size("builtin:teapot@2k", (160, 128)).unwrap();
        let full = scaled(&plain, 4);
        let engine = engine(4, 1).unwrap();
        let drawn = draw(&front(&full, 64), engine, Some(&PATTERN)).unwrap();
        let facing = full.partitions.iter().flat_map(|p| &p.triangles).filter(|t| t.area() < 0);
        let mut count = 0;
        for t in facing {
            for row in 0..full.height as i32 {
                let (first, end) = t.span(row);
                let column = PATTERN[row as usize % 4] as i32;
                count +=
                    (first.max(0)..end.min(full.width as i32)).filter(|x| x % 4 == column).count() as u64;
            }
        }
        assert_eq!(drawn.pixels, count);
        assert!(count > 10_000);
    }

    #[test]
    fn four_processors_draw_four_pixels_a_cycle() {
        // 100 tiles of 1,024 pixels, and a few cycles until the first pixel.
        for (rows, columns, processors) in [(1, 1, 1.0), (2, 2, 4.0), (4, 1, 4.0)] {
            let rate = pixels_a_cycle(engine(rows, columns).unwrap());
            assert!(rate <= processors && rate > 0.999 * processors, "{rows} {columns} {rate}");
        }
    }
}
