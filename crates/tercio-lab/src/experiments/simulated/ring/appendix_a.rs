//! The examples of appendix A as runs: the screen map of figure A-2, the routes of figures.

use super::super::super::{Comparison, ExperimentError, Findings, Table};
use crate::simulators::ring::destinations::Route;
use crate::simulators::ring::{Algorithm, Machine, simulate};
use crate::workloads::{BoundingBox, BoxScene, PixelBox, ScreenMap};

/// Figure A-2 as printed.
const PRINTED: &str =
    "0 (0, 0) (383, 255)\n1 (0, 255) (383, 511)\n2 (384, 0) (767, 255)\n3 (384, 256) (767, 511)\n";
/// Processors of figures.
const N: u32 = 16;

/// Figure A-2.
pub fn screen_map() -> Result<Findings, ExperimentError> {
    let printed = ScreenMap::parse(PRINTED);
    let map = ScreenMap::parse(&PRINTED.replace("(0, 255)", "(0, 256)"))?;
    let mut counts = [0u64; 4];
    for (x, y) in (0..512).flat_map(|y| (0..768).map(move |x| (x, y))) {
        let owner = map.owner(x, y).ok_or_else(|| format!("pixel {x}, {y} has no owner"))?;
        counts[owner as usize] += 1;
    }
    let mut table = Table::new("pixels", &[("processor", ""), ("pixels", "")]);
    for (processor, &pixels) in counts.iter().enumerate() {
        table.push([(processor as f64).into(), (pixels as f64).into()]);
    }
    let mut comparison = Comparison::new();
    comparison.claim("every pixel has one owner, and each owner a quadrant", counts == [384 * 256; 4]);
    comparison.correct(
        "the second line of the map has to begin with row 256; as printed row 255 of the left half has two owners.",
        printed.is_err(),
    );
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: comparison.verdict(),
    })
}

/// The box of neighbouring columns, which are processors here.
fn columns(first: i32, last: i32) -> Result<PixelBox, ExperimentError> {
    PixelBox::new([first, 0], [last, 0]).ok_or_else(|| "a box has pixels".into())
}

/// Figure A-6: from processor 1 to 8, 9 and 10, in strides of 4 and 1.
pub fn strides() -> Result<Findings, ExperimentError> {
    let machine = Machine { processors: N, ..Machine::princeton_engine() };
    let algorithm = Algorithm { strides: vec![4, 1], ..Algorithm::sort_middle(&machine) };
    // Polygon b belongs to processor b: the first one is not visible.
    let hidden = BoundingBox { visible: false, pixels: columns(0, 0)? };
    let sent = BoundingBox { visible: true, pixels: columns(8, 10)? };
    let scene = BoxScene { boxes: vec![hidden, sent] };
    let run = simulate(&machine, &algorithm, &ScreenMap::columns(N, 1, N), &scene)?;
    let mut table = Table::new("stages", &[("stride", "processor"), ("descriptors", ""), ("passes", "")]);
    for stage in &run.stages {
        let numbers = [f64::from(stage.stride), stage.descriptors as f64, stage.passes as f64];
        table.push(numbers.map(Into::into));
    }
    let received: Vec<u32> = (0..N).filter(|&p| run.received[p as usize] == 1).collect();
    let mut comparison = Comparison::of_published(&["EA-fig6a", "EA-fig6b"])?;
    comparison.claim("processors 8, 9 and 10 have the polygon, once each", received == [8, 9, 10]);
    comparison.claim("no other processor has it", run.copies == 3 && run.checks.passed());
    comparison.claim("processor 1 alone sends in the first stage, 5 and 9 in the second", {
        let descriptors: Vec<_> = run.stages.iter().map(|s| s.descriptors).collect();
        descriptors == [1, 2]
    });
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: comparison.verdict(),
    })
}

/// Figure A-7: with groups a region has a processor in each of them, and the nearest one to the right is the destination.
pub fn groups() -> Result<Findings, ExperimentError> {
    let machine = Machine { processors: N, ..Machine::princeton_engine() };
    let mut table = Table::new("distances", &[("group", "processor"), ("region", ""), ("most passes", "")]);
    let mut comparison = Comparison::new();
    for g in [1, 2, 4, 8] {
        let algorithm = Algorithm { group: g, ..Algorithm::sort_middle(&machine) };
        let map = ScreenMap::columns(g, 1, g);
        let mut nearest = true;
        for region in 0..g {
            let pixels = columns(region as i32, region as i32)?;
            let mut most = 0;
            for source in 0..N {
                let mut route = Route::default();
                route.find(&machine, &algorithm, &map, u64::from(source), &pixels);
                let offsets: Vec<u32> = route.stops.iter().map(|s| s.0).collect();
                // By trying every processor of the region.
                let tried = (0..N / g).map(|k| (region + k * g + N - source) % N).min();
                nearest &= route.source == source && offsets.iter().copied().eq(tried);
                most = most.max(offsets.into_iter().max().unwrap_or(0));
            }
            nearest &= most < g;
            table.push([f64::from(g).into(), f64::from(region).into(), f64::from(most).into()]);
        }
        comparison.claim(
            format!(
                "groups of {g}: the only destination is the nearest processor, at most {} passes away",
                g - 1
            ),
            nearest,
        );
    }
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: vec!["16 processors; every sender and every region, against trying all processors.".into()],
        verdict: comparison.qualitative("The vector that the figure draws is lost; its rule is stated."),
    })
}
