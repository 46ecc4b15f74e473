//! Rates of the renderer and where its time goes: chapter 8.

use crate::experiments::comparison::named;
use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Cell, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::models::eldridge::throughput;
use crate::models::registry::Value;
use crate::published;
use crate::units::{FrameRate, Percent, PolygonRate};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "eldridge-chapter-8",
        document: Document::Eldridge,
        place: "section 2.3, equations 8.1 to 8.17",
        title: "Benchmarks and accounting of the Princeton Engine",
        run: benchmarks,
    },
    Experiment {
        id: "eldridge-table-8-1",
        document: Document::Eldridge,
        place: "table 8.1, figure 8-1",
        title: "Rendering performance and where the time goes",
        run: phases,
    },
];

/// Names of the numbers of equations 8.1 to 8.17, and of those that the text has beside them.
const EQUATIONS: [&str; 2] = ["E8.#", "E8.2sum"];
const OF_TEXT: [&str; 9] =
    ["E2.budget", "E2.lines", "E8.17-460", "E8-12.1M", "E8-8th", "E8-233k", "E8-flops", "E8-5pc", "E8-115"];

fn benchmarks() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("equations", &[("number", ""), ("ours", ""), ("printed", ""), ("unit", "")]);
    for number in named(&EQUATIONS)? {
        let check = published::check(number);
        let unit = match &check.number.unit {
            Some(unit) => unit.clone(),
            None => crate::models::registry::find(&check.number.model)?.unit.to_owned(),
        };
        let ours = check.ours?.as_number();
        let printed = check.number.printed.as_ref().and_then(Value::as_number);
        table.push([check.number.place.as_str().into(), ours.into(), printed.into(), unit.as_str().into()]);
    }
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: Comparison::of_published(&[&EQUATIONS[..], &OF_TEXT[..]].concat())?.verdict(),
    })
}

/// The number in a cell.
fn number(cell: &Cell) -> f64 {
    if let Cell::Number(number) = cell { *number } else { f64::NAN }
}

fn phases() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "phases",
        &[
            ("scene", ""),
            ("frame rate", "frame/s"),
            ("polygon rate", "polygon/s"),
            ("visible polygons", ""),
            ("geometry", "%"),
            ("communication", "%"),
            ("rasterization", "%"),
            ("sum", "%"),
        ],
    );
    let scenes = ["Beethoven", "crocodile", "teapot"];
    let mut shares = [const { Vec::new() }; 3];
    for row in 0..9usize {
        let id = format!("E8.T1-{}", row + 1);
        let (rate, fps) = (facts.given(&id, "rate")?, facts.given(&id, "fps")?);
        let Some(Value::List(percent)) = facts.number(&id)?.given.get("phases") else {
            return Err(format!("{id} has no phases").into());
        };
        let percent: Vec<f64> = percent.iter().filter_map(Value::as_number).collect();
        let phases = percent.iter().map(|&p| Percent::new(p)).collect();
        let [visible, sum] = throughput::table_row(PolygonRate::new(rate), FrameRate::new(fps), phases);
        let numbers = [fps, rate, visible].into_iter().chain(percent.iter().copied()).chain([sum]);
        let cells = std::iter::once(scenes[row / 3].into()).chain(numbers.map(Into::into));
        table.push_row(cells.collect());
        for (share, &p) in shares.iter_mut().zip(&percent) {
            share.push((row as f64 + 1.0, p));
        }
    }
    let [geometry, communication, raster] = shares;
    let plot = Plot::new(
        "phases",
        "Share of each phase of a frame",
        Axis::categories(
            "row of table 8.1",
            1,
            (0..9).map(|row| format!("{} {}", scenes[row / 3], row % 3 + 1)),
        ),
        Axis::linear("percent of the frame"),
    )
    .with(Series::line_points("geometry", geometry).published())
    .with(Series::line_points("communication", communication).published())
    .with(Series::line_points("rasterization", raster).published());
    // Of 45 cells one in five is what two others leave; that of communication in row 6, and of geometry, have a formula.
    let mut comparison =
        Comparison::of_published(&["E8.T1-#", "E8.T1-#-rest", "E8.12-share", "E8.15-share"])?;
    comparison.add_read(4 * 9 - 2);
    let video_frames: Vec<_> = table.rows.iter().map(|row| 30.0 / number(&row[1])).collect();
    comparison.claim(
        "every picture takes whole video frames",
        video_frames.iter().all(|frames| frames.fract() == 0.0),
    );
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "45 numbers are printed: rates and shares, measured on the document's own machine and scenes. Rasterization is what the \
             other phases leave, idling included; only for row 6 section 8.2 has the numbers from which shares follow. Not printed are \
             the polygons of a picture and the sums of the shares, which are whole and 100."
                .into(),
        ],
        verdict: comparison.verdict(),
    })
}
