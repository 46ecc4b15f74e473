//! Tile engines, bus and processors: sections 3.6, 4.4 to 4.6, on our own scenes.

use super::scenes::{LARGE, REMARK, SCREEN, SMALL, scene, scene_of_size};
use crate::experiments::facts::Facts;
use crate::experiments::sweep::sweep;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Fit, Plot, Scale, Series, Table,
};
use crate::machines::{Machine, load};
use crate::models::hybris::rates::block_bandwidth;
use crate::published::ToleranceSource;
use crate::simulators::hybris::front_end::Tiles;
use crate::simulators::hybris::heap::HeapLayout;
use crate::simulators::hybris::{FrontEnd, Scene, Sharing, simulate};
use crate::units::{Bytes, Count, Seconds};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "hybris-sec-3-6-fifos",
        document: Document::Hybris,
        place: "sections 3.6.2 to 3.6.5",
        title: "Cycles of a frame by the depth of the FIFOs, for one engine, 2x2 interleaved, and two engines",
        run: fifos,
    },
    Experiment {
        id: "hybris-sec-4-6-asic",
        document: Document::Hybris,
        place: "sections 4.4 and 4.6",
        title: "Cycles of a triangle in the ASIC's tile engine",
        run: asic,
    },
    Experiment {
        id: "hybris-sec-4-5-1-bus",
        document: Document::Hybris,
        place: "section 4.5.1",
        title: "Bandwidth of the bus by the size of a transfer, and a frame's way to the board",
        run: bus,
    },
    Experiment {
        id: "hybris-fig-4-12-simulated",
        document: Document::Hybris,
        place: "figure 4.12, section 4.6",
        title: "Two processors against one, simulated",
        run: two_processors,
    },
];

/// The machine with FIFOs of another depth.
fn with_fifos(mut machine: Machine, depth: u32) -> Machine {
    if let Some(engine) = &mut machine.tile_engine {
        for fifo in [&mut engine.fifo, &mut engine.fifo_after_broadcast] {
            fifo.value = Count::new(f64::from(depth)).get();
            fifo.text = depth.to_string();
        }
    }
    machine
}

/// What an experiment about tile engines ends with if its machine has none.
const NO_ENGINES: &str = "the machine has no tile engines";

fn fifos() -> Result<Findings, ExperimentError> {
    let scene = scene(SMALL)?;
    let engines = [
        ("one engine", "hybris-asic", Sharing::Tiles),
        ("2x2 interleaved", "hybris-asic-2x2", Sharing::Tiles),
        ("two engines, a checkerboard of tiles", "hybris-asic-two-engines", Sharing::Tiles),
        ("two engines, composition", "hybris-asic-two-engines", Sharing::Composition),
    ];
    let mut table = Table::new(
        "cycles",
        &[
            ("engine", ""),
            ("depth", ""),
            ("cycles", "cycle"),
            ("cycles a triangle", "cycle"),
            ("draw span busy", "%"),
            ("draw triangle stalled", "%"),
        ],
    );
    let mut plot = Plot::new(
        "cycles",
        "Cycles of a frame by the depth of the FIFOs",
        Axis::log2("entries of a FIFO"),
        Axis::linear("cycles"),
    );
    let mut comparison = Comparison::new();
    for (name, machine, sharing) in engines {
        let machine = load(machine)?;
        let mut points = Vec::new();
        let depths: Vec<_> = (0..8).map(|power| 1u32 << power).collect();
        let frames = sweep(&depths, |&d| Ok(simulate(&with_fifos(machine.clone(), d), &scene, sharing)?))?;
        for (depth, frame) in depths.into_iter().zip(frames) {
            let (back, _) = frame.engines().ok_or(NO_ENGINES)?;
            let total = back.total();
            let share = |stage: usize, of: u64| {
                let s = total.stages[stage];
                100.0 * of as f64 / (s.busy + s.stalled + s.starved).max(1) as f64
            };
            table.push([
                name.into(),
                f64::from(depth).into(),
                (back.cycles as f64).into(),
                (back.cycles as f64 / total.triangles.max(1) as f64).into(),
                share(3, total.stages[3].busy).into(),
                share(1, total.stages[1].stalled).into(),
            ]);
            points.push((f64::from(depth), back.cycles as f64));
        }
        let (first, last) = (points[0].1, points[points.len() - 1].1);
        comparison.claim(format!("{name}: deeper FIFOs help"), last < first);
        plot = plot.with(Series::line_points(name, points));
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            REMARK.into(),
            "An iteration of a stage takes a cycle (4.4); the depths of the ASIC's FIFOs are not given."
                .into(),
        ],
        verdict: comparison
            .qualitative("The document says that FIFOs even out the stages and prints no numbers."),
    })
}

/// The machine with another time for the set-up of a triangle in a tile.
fn with_set_up(mut machine: Machine, cycles: u32) -> Machine {
    if let Some(engine) = &mut machine.tile_engine {
        engine.set_up_triangle.value = f64::from(cycles);
        engine.set_up_triangle.text = format!("{cycles} cycles");
    }
    machine
}

/// Sizes of pictures that are tried: the document does not state its own.
const SIZES: [(u32, u32); 4] = [(320, 256), (640, 512), (1280, 1024), (1600, 1280)];

/// A picture of 5 by 4 in the middle of the widths that give the printed share; the largest one of the document's tiles if none
/// does.
fn size_of_share(fit: &Fit) -> (u32, u32) {
    let middle = fit.intervals().first().map(|[from, to]| (0.5 * (from + to) / 5.0).round() as u32);
    middle.map_or(SCREEN, |fifth| (5 * fifth, 4 * fifth))
}

/// The share of the large model's triangles that is set up in a picture of `size`.
fn share_set_up(size: (u32, u32)) -> Result<f64, ExperimentError> {
    let scene = scene_of_size(LARGE, size)?;
    let tiles = Tiles { width: size.0, height: size.1, edge: 32 };
    let counts = FrontEnd::run(&scene.partitions, tiles, HeapLayout::DOCUMENT).counts;
    Ok(counts.nodes as f64 / counts.triangles as f64)
}

fn asic() -> Result<Findings, ExperimentError> {
    let published: f64 = 27e6 / 4.2e6;
    let facts = Facts::load()?;
    let machine = load("hybris-asic")?;
    let reaches = facts.number("H4-vis")?.expected.as_number().ok_or("a number is expected")?;
    let printed_share = format!("{reaches:.2}");
    let shares = sweep(&SIZES, |&size| Ok((f64::from(size.0), share_set_up(size)?)))?;
    let mut sizes = Table::new("sizes", &[("width", "px"), ("share set up", "%")]);
    for &(width, share) in &shares {
        sizes.push([width.into(), (100.0 * share).into()]);
    }
    let share = Fit::new(
        "share of the triangles that reaches the engine",
        "width of the picture in pixels",
        &printed_share,
        shares,
    );
    // The rate is that of the same picture.
    let size = size_of_share(&share);
    let scene = scene_of_size(LARGE, size)?;
    let mut table = Table::new(
        "triangles",
        &[
            ("set-up", "cycle"),
            ("triangles", ""),
            ("set up", ""),
            ("share set up", "%"),
            ("cycles", "cycle"),
            ("cycles a triangle set up", "cycle"),
            ("frames a second", "frame/s"),
        ],
    );
    let mut points = Vec::new();
    let mut of_picture = 0.0;
    let set_ups: Vec<_> = (1..=8).collect();
    let frames =
        sweep(&set_ups, |&n| Ok(simulate(&with_set_up(machine.clone(), n), &scene, Sharing::Tiles)?))?;
    for (cycles, frame) in set_ups.into_iter().zip(frames) {
        let c = frame.front_end;
        let share = c.nodes as f64 / c.triangles as f64;
        let (back, seconds) = frame.engines().ok_or(NO_ENGINES)?;
        let a_triangle = back.cycles as f64 / c.nodes.max(1) as f64;
        table.push([
            f64::from(cycles).into(),
            (c.triangles as f64).into(),
            (c.nodes as f64).into(),
            (100.0 * share).into(),
            (back.cycles as f64).into(),
            a_triangle.into(),
            (1.0 / seconds).into(),
        ]);
        points.push((f64::from(cycles), a_triangle));
        of_picture = share;
    }
    let mut comparison = Comparison::new();
    comparison.fit(share);
    let says = format!(
        "a picture of {}x{} has a share of {of_picture:.4}, in print {printed_share}",
        size.0, size.1
    );
    comparison.claim(says, format!("{of_picture:.2}") == printed_share);
    comparison.claim("a cycle an iteration is faster than published", points[0].1 < published);
    // 27 MHz over 4.2 million triangles a second.
    let rates = points.iter().map(|p| (p.0, 27.0 / p.1)).collect();
    let number = format!("4.2 million triangles a second in the picture of {}x{}", size.0, size.1);
    comparison.fit(Fit::new(number, "cycles of set-up", "4.2", rates));
    let plot = Plot::new(
        "cycles",
        "Cycles of a triangle by those of its set-up",
        Axis::linear("cycles of Set-up Triangle"),
        Axis::linear("cycles a triangle"),
    )
    .with(Series::line_points("simulated", points.clone()))
    .with(Series::line("section 4.6", points.iter().map(|p| (p.0, published)).collect()).published());
    Ok(Findings {
        tables: vec![table, sizes, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            format!(
                "The document's model is not part of this program: a teapot of as many triangles takes its place, seen so that it \
                 fills 80 % of the picture. The size of the picture is not stated. Both numbers are held against one size, {}x{}, \
                 in which the printed share of the triangles reaches the engine.",
                size.0, size.1
            ),
            format!(
                "The document's 4.2 million triangles a second at 27 MHz are {published:.2} cycles a triangle that \
                 reaches the engine. With a cycle an iteration, as 4.4 has it, the triangles of such a model need \
                 {:.2}: they cover about a pixel. The published rate is that of an engine whose set-up takes six \
                 cycles, such as one multiplier that six parameters share; the document names set-up with serial \
                 multipliers as an option (3.6.2) and floating point as the limit of this design (4.4).",
                points[0].1
            ),
        ],
        verdict: comparison
            .qualitative("Model and size of the picture of the document's simulation are not available."),
    })
}

fn bus() -> Result<Findings, ExperimentError> {
    let machine = load("hybris-fpga")?;
    let transfer = machine.need(machine.transfer.as_ref(), "transfer")?;
    let bandwidth = transfer.bandwidth.get().get() / 1e6;
    let rate = |block: f64| {
        let overhead = Seconds::new(transfer.overhead.value);
        block_bandwidth(Bytes::new(block), overhead, transfer.bandwidth.get()).get() / 1e6
    };
    let mut rates = Table::new("rates", &[("block", "B"), ("bandwidth", "MB/s")]);
    let blocks = (10..=23).map(|power| f64::from(1u32 << power));
    blocks.for_each(|block| rates.push([block.into(), rate(block).into()]));
    let scene = scene(SMALL)?;
    let mut frames = Table::new(
        "frames",
        &[("block", "B"), ("bytes", "B"), ("transfers", ""), ("bus", "ms"), ("tile engine", "ms")],
    );
    let mut times = Vec::new();
    for block in [4096.0, 2e6] {
        let frame = simulate(&with_block(machine.clone(), block), &scene, Sharing::Tiles)?;
        let bus = frame.transfer.ok_or("the machine has a bus")?;
        let (_, engine_seconds) = frame.engines().ok_or(NO_ENGINES)?;
        frames.push([
            block.into(),
            (bus.bytes as f64).into(),
            (bus.transfers as f64).into(),
            (bus.seconds * 1e3).into(),
            (engine_seconds * 1e3).into(),
        ]);
        times.push((bus.seconds, engine_seconds));
    }
    let plot = Plot::new(
        "rates",
        "Bandwidth by the size of a transfer",
        Axis::log2("bytes of a transfer"),
        Axis::log10("MB/s"),
    )
    .with(Series::formula(
        "fixed cost and bandwidth",
        Scale::Log2,
        [10, 23].map(|power| f64::from(1u32 << power)),
        rate,
    ))
    .with(Series::points("section 4.5.1", vec![(4096.0, 10.0), (2e6, 100.0)]).published());
    let mut comparison = Comparison::new();
    // The fixed cost of a transfer is inferred from the rate of small blocks, and the bus has 102 MB/s.
    comparison.add_constructed(
        "MB/s in blocks of 4 KiB",
        rate(4096.0),
        10.0,
        0.5,
        ToleranceSource::LastDigit,
    );
    comparison.claim("blocks of 2 MB reach over 98 % of the bus", rate(2e6) >= 0.98 * bandwidth);
    let slower = times[0].0 > times[0].1;
    comparison.claim("in single buffers the bus is slower than the tile engine", slower);
    Ok(Findings {
        tables: vec![rates, frames],
        plots: vec![plot],
        remarks: vec![
            REMARK.into(),
            "The fixed cost of a transfer, 369 microseconds, is inferred from the two rates that the document gives: \
             10 MB/s in blocks of 4 KiB and over 100 MB/s in large ones. That blocks of 2 MB then reach 98 % of the \
             bus is what it says of them."
                .into(),
        ],
        verdict: comparison.verdict(),
    })
}

/// The machine with transfers of another size.
fn with_block(mut machine: Machine, block: f64) -> Machine {
    if let Some(transfer) = &mut machine.transfer {
        transfer.block.value = block;
        transfer.block.text = format!("{block} B");
    }
    machine
}

fn two_processors() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let (single, dual) = (load("hybris-single-cpu")?, load("hybris-dual-cpu")?);
    let mut table = Table::new(
        "speed-ups",
        &[
            ("model", ""),
            ("one processor", "ms"),
            ("two processors", "ms"),
            ("waiting", "ms"),
            ("speed-up", ""),
            ("published", ""),
        ],
    );
    let mut sizes = Table::new("sizes", &[("model", ""), ("width", "px"), ("speed-up", "")]);
    let mut comparison = Comparison::new();
    for (model, id, name) in [(SMALL, "H4.5", "bunny"), (LARGE, "H4.5b", "Buddha")] {
        let scene: Scene = scene(model)?;
        let time = |machine: &Machine| {
            let frame = simulate(machine, &scene, Sharing::Tiles)?;
            frame.software.ok_or_else(|| ExperimentError::from("the machine is charged for software"))
        };
        let (one, two) = (time(&single)?, time(&dual)?);
        let (speed_up, published) = (one.seconds() / two.seconds(), facts.printed(id)?);
        table.push([
            format!("{model} for the {name}").as_str().into(),
            (one.seconds() * 1e3).into(),
            (two.seconds() * 1e3).into(),
            (two.waiting() * 1e3).into(),
            speed_up.into(),
            published.into(),
        ]);
        let by_size = sweep(&SIZES, |&size| {
            let scene = scene_of_size(model, size)?;
            let [one, two] = [&single, &dual].map(|machine| simulate(machine, &scene, Sharing::Tiles));
            let [one, two] = [one?.software, two?.software].map(|s| s.map_or(f64::NAN, |s| s.seconds()));
            Ok((f64::from(size.0), one / two))
        })?;
        by_size.iter().for_each(|p| sizes.push([name.into(), p.0.into(), p.1.into()]));
        let number = format!("speed-up {published} of the {name}");
        comparison.fit(Fit::new(
            number,
            "width of the picture in pixels",
            &format!("{published:.2}"),
            by_size,
        ));
    }
    Ok(Findings {
        tables: vec![table, sizes, comparison.intervals()],
        plots: Vec::new(),
        remarks: vec![
            REMARK.into(),
            "The costs of an operation are fitted to the two frame rates of one processor; the serial part of 1/120 s \
             is the document's. What two processors then gain is predicted: halves of the partitions, the barrier, \
             odd and even tiles. Caches and the shared memory, which the document names for the bunny's superlinear \
             and the Buddha's lower speed-up, are not simulated."
                .into(),
        ],
        verdict: comparison.qualitative("The document's models and the size of its pictures are not available."),
    })
}
