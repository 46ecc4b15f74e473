//! The line-locked renderer of chapters 7 and 8: every procedure takes whole video lines, every picture whole frames.

use super::super::super::{Comparison, ExperimentError, Findings, Fit, Table};
use super::{by_clumping, frame, record};

/// Lines of a video frame, and frames a second (8.1).
const VIDEO: (f64, f64) = (525.0, 30.0);
const PROCESSORS: u32 = 1024;
/// Passes of a descriptor in a line (8.2).
const PASSES_A_LINE: f64 = 5.0;

/// A picture of chapter 7 or 8.
struct Picture {
    name: &'static str,
    polygons: u32,
    visible: u32,
    /// Polygons in the column of the busiest processor, as printed.
    peak: &'static str,
    /// Textured: 11 lines a polygon and 4 pixels a line; shaded: 7 and 8.
    textured: bool,
    /// Pictures a second, as printed.
    rate: &'static str,
    /// Its input that is not stated. Another number of visible polygons is another view, in which columns are clumped otherwise.
    clumping: &'static str,
}

const fn picture(
    name: &'static str,
    [polygons, visible]: [u32; 2],
    peak: &'static str,
    textured: bool,
    rate: &'static str,
    clumping: &'static str,
) -> Picture {
    Picture { name, polygons, visible, peak, textured, rate, clumping }
}

const PICTURES: [Picture; 5] = [
    picture(
        "Beethoven, figure 7-1",
        [5_030, 3_700],
        "224",
        false,
        "10",
        "deviation of Beethoven's columns, figure 7-1",
    ),
    picture(
        "crocodile, figure 7-2",
        [34_404, 10_600],
        "364",
        false,
        "6",
        "deviation of the crocodile's columns, figure 7-2",
    ),
    picture(
        "textured crocodile, figure 7-3",
        [34_404, 10_200],
        "370",
        true,
        "5",
        "deviation of the textured crocodile's columns, figure 7-3",
    ),
    picture(
        "teapot, figure 7-4",
        [9_408, 4_100],
        "260",
        false,
        "10",
        "deviation of the teapot's columns, figure 7-4",
    ),
    picture(
        "textured crocodile, section 8.2",
        [34_404, 10_400],
        "360",
        true,
        "6",
        "deviation of the crocodile's columns, section 8.2",
    ),
];

/// Lines of geometry, communication and rasterization.
fn lines(of: &Picture, passes_a_polygon: f64) -> [f64; 3] {
    let (geometry, pixels) = if of.textured { (11.0, 4.0) } else { (7.0, 8.0) };
    let peak: f64 = of.peak.parse().unwrap_or(f64::NAN);
    [
        f64::from(of.polygons.div_ceil(PROCESSORS)) * geometry,
        f64::from(of.visible) * passes_a_polygon / PASSES_A_LINE,
        // Two normalizations a line, and chunks of 4 pixels a polygon.
        peak * (0.5 + 4.0 / pixels),
    ]
}

/// Pictures a second: framebuffers are exchanged between video frames.
fn rate(of: &Picture, passes_a_polygon: f64) -> f64 {
    VIDEO.1 / (lines(of, passes_a_polygon).iter().sum::<f64>() / VIDEO.0).ceil()
}

/// The rate of section 8.2: whole frames for the counts of the document.
pub fn renderer() -> Result<Findings, ExperimentError> {
    /// Passes a polygon (8.2).
    const PASSES: f64 = 0.6;
    let columns = [
        ("picture", ""),
        ("geometry", "line"),
        ("communication", "line"),
        ("rasterization", "line"),
        ("video frames", ""),
        ("pictures a second", ""),
        ("printed", ""),
        ("polygons a second", ""),
    ];
    let mut table = Table::new("lines", &columns);
    for of in &PICTURES {
        let [geometry, communication, raster] = lines(of, PASSES);
        let rate = rate(of, PASSES);
        table.push([
            of.name.into(),
            geometry.into(),
            communication.into(),
            raster.into(),
            (VIDEO.1 / rate).into(),
            rate.into(),
            of.rate.parse::<f64>()?.into(),
            (rate * f64::from(of.visible)).into(),
        ]);
    }
    let peak = &PICTURES[4];
    let mut comparison = Comparison::new();
    comparison.add_printed("polygons a second", rate(peak, PASSES) * f64::from(peak.visible), "62400");
    for of in &PICTURES {
        comparison.add_printed(format!("pictures a second, {}", of.name), rate(of, PASSES), of.rate);
    }
    // Table 8.1, whole percents of five video frames. The rest, idling included, counts as rasterization.
    let share = |phase: usize| 100.0 * lines(peak, PASSES)[phase] / (VIDEO.0 * VIDEO.1 / rate(peak, PASSES));
    let rest = 100.0 - share(0) - share(1);
    let shares =
        [("geometry", share(0), "13"), ("communication", share(1), "69"), ("rasterization", rest, "18")];
    for (name, ours, printed) in shares {
        comparison.add_printed(format!("percent of {name}, table 8.1"), ours, printed);
    }
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: vec![
            "Numbers of polygons, of passes and of slices are the document's; that a picture takes whole lines a procedure \
             and whole video frames is what makes its rate. Phases add up, as they run one after the other."
                .into(),
            "0.6 passes a polygon are stated of the scene of section 8.2. The four pictures of figures 7-1 to 7-4 would be \
             faster with them than they are printed."
                .into(),
            format!(
                "Table 8.1 prints 13 % of geometry and 69 % of communication for the textured crocodile. The lines of the \
                 text are {:.1} % (34 polygons of 11 lines on a processor; 13 % are 341 of these 374 lines) and {:.1} % \
                 (69 % are 0.87 passes a polygon).",
                share(0),
                share(1)
            ),
        ],
        verdict: comparison.verdict(),
    })
}

/// The pictures of figures 7-1 to 7-4: which passes a polygon give their rates, which clumping their busiest column.
pub fn pictures() -> Result<Findings, ExperimentError> {
    let mut rates =
        Table::new("rates", &[("picture", ""), ("passes a polygon", ""), ("pictures a second", "")]);
    let mut peaks = Table::new("peaks", &[("picture", ""), ("deviation", "column"), ("busiest", "")]);
    let mut comparison = Comparison::new();
    for of in &PICTURES[..4] {
        let passes = (8..=40).map(|i| 0.05 * f64::from(i));
        let points: Vec<_> = passes.map(|p| (p, rate(of, p))).collect();
        record(&mut rates, of.name, &points);
        let number = format!("{} pictures a second, {}", of.rate, of.name);
        comparison.fit(Fit::new(number, "passes a polygon", of.rate, points));
        let busiest = by_clumping(of.polygons, of.visible, |scene| {
            let received = frame(scene, PROCESSORS, |_| ())?.received;
            Ok(f64::from(received.into_iter().max().unwrap_or(0)))
        })?;
        record(&mut peaks, of.name, &busiest);
        let number =
            format!("{} slices on the busiest processor, {} ({} visible)", of.peak, of.name, of.visible);
        comparison.fit(Fit::new(number, of.clumping, of.peak, busiest));
    }
    Ok(Findings {
        tables: vec![rates, peaks, comparison.intervals()],
        plots: Vec::new(),
        remarks: vec![
            "Scenes of ours with the document's numbers of polygons and visible ones, columns normally distributed: their \
             deviation is swept. The rate of a picture depends on the passes a polygon, which the document states for one \
             scene only (0.6). That value lies in none of the intervals; simulated rings without strides need about \
             0.95 (figure 4-2)."
                .into(),
        ],
        verdict: comparison.qualitative("Scenes and passes are not given."),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_more_than_a_frame_costs_a_whole_frame() {
        let of = |visible| picture("", [1024, visible], "0", false, "", "");
        // 7 lines of geometry and a line for 5 passes: 525 lines with 2,590 polygons of one pass.
        assert_eq!(rate(&of(2_590), 1.0), 30.0);
        assert_eq!(rate(&of(2_591), 1.0), 15.0);
    }

    #[test]
    fn more_passes_or_slices_would_not_give_the_printed_rate() {
        let peak = &PICTURES[4];
        assert_eq!(rate(peak, 0.6), 6.0);
        assert_ne!(rate(peak, 0.87), 6.0);
        assert_ne!(rate(&Picture { peak: "800", ..*peak }, 0.6), 6.0);
    }
}
