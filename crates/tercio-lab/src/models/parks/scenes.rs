//! The tables of cycles under figures 15 to 25: one scene on six machines.
//!
//! The scenes are lost, except for figure 15, whose counts are in appendix C ([`table_of_counts`]); what remains are
//! hand-lettered tables in a damaged scan. [`restored_table`] reads them: it takes the reading with the fewest misread
//! characters that the cost model allows, and leaves a cell open if several readings qualify.

use super::costs::{self, PIXEL, POLYGON, SEGMENT, VERTEX};
use crate::models;
use crate::models::registry::{Model, Outcome, Value};
use crate::units::{Count, Cycles, Pixels, Polygons, Segments, Vertices};

/// Columns of a table.
const MACHINES: usize = 6;
/// The uniprocessor's column.
const UNI: usize = 0;
/// Interlace and splitter with 4 processors.
const I4: usize = 1;
const S4: usize = 2;
/// Interlace, splitter and hybrid with 16 processors.
const I16: usize = 3;
const S16: usize = 4;
const H16: usize = 5;
/// Similar scenes differ by at most 4.5 % in the uniprocessor's time (4.4), as printed with one decimal.
const LARGEST_CHANGE: f64 = 0.0455;
/// And by at most 68 % in the splitter's with 16 processors: figures 18 and 19 differ most (4.4), 1.06 over .629.
const LARGEST_SPLITTER_CHANGE: f64 = 0.69;
/// Lower bound on the vertices per polygon on average; all distributions of appendix C have more.
const LEAST_VERTICES: f64 = 2.0;
/// Characters of a cell; longer cells have more readings than can be tried.
const LONGEST_CELL: usize = 6;
/// Half of the last printed digit, in millions of cycles.
const HALF_DIGIT: f64 = 0.005;

/// A table from counts [polygons, vertices, charged segments, pixels] of the slowest processors, in cycles rounded
/// to three digits as the figures print them.
pub fn table_of_counts(counts: Vec<[f64; 4]>) -> Vec<Cycles> {
    let cycles = |[n, v, s, p]: [f64; 4]| {
        costs::scene(Polygons::new(n), Vertices::new(v), Segments::new(s), Pixels::new(p)).get()
    };
    let three_digits = |c: f64| format!("{c:.2e}").parse().unwrap_or(c);
    counts.into_iter().map(cycles).map(three_digits).map(Cycles::new).collect()
}

/// Cycles read from a table; a cell that cannot be read is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings(pub Vec<Cycles>);

impl Outcome for Readings {
    const UNIT: &'static str = Cycles::UNIT;

    /// Unlike the result of a formula, a reading may be missing.
    fn into_value(self) -> Result<Value, String> {
        Ok(Value::List(self.0.into_iter().map(|c| Value::Number(c.get())).collect()))
    }
}

/// A table in cycles from the cells of the scan, in millions: `cells` in the order of the columns, `polygons` of the
/// scene; `similar` and `similar_splitter` are the millions that the uniprocessor and the splitter with 16 processors
/// take for the scene that the document compares with (0: none).
///
/// A cell that cannot be read, or that several readings fit, is NaN.
///
/// # Errors
/// Not six cells, or cells that no reading of up to three misread characters reconciles with the cost model.
pub fn restored_table(
    cells: Vec<String>,
    polygons: Count,
    similar: f64,
    similar_splitter: f64,
) -> Result<Readings, String> {
    let cells: [String; MACHINES] =
        cells.try_into().map_err(|c: Vec<_>| format!("expected {MACHINES} cells, found {}", c.len()))?;
    if let Some(cell) = cells.iter().find(|c| c.chars().count() > LONGEST_CELL) {
        return Err(format!("cells: expected at most {LONGEST_CELL} characters, found '{cell}'"));
    }
    let readings = cells.map(|cell| readings(&cell));
    let mut fewest = (usize::MAX, Vec::<[f64; MACHINES]>::new());
    let mut walk = vec![(0, 0, [f64::NAN; MACHINES])];
    while let Some((column, mistakes, table)) = walk.pop() {
        if mistakes > fewest.0 {
            continue;
        }
        if column == MACHINES {
            if possible(&table, polygons.get(), [similar, similar_splitter]) {
                if mistakes < fewest.0 {
                    fewest = (mistakes, Vec::new());
                }
                fewest.1.push(table);
            }
            continue;
        }
        for &(value, wrong) in &readings[column] {
            let mut next = table;
            next[column] = value;
            walk.push((column + 1, mistakes + wrong, next));
        }
    }
    let (first, others) = fewest.1.split_first().ok_or("no reading of the cells fits the cost model")?;
    let agreed = |column: usize| {
        let same = others.iter().all(|t| t[column] == first[column]);
        // Cells have at most thousandths of a million, so rounding to whole cycles loses nothing.
        Cycles::new(if same { (first[column] * 1e6).round() } else { f64::NAN })
    };
    Ok(Readings((0..MACHINES).map(agreed).collect()))
}

/// The possible readings of a cell, in millions, with the number of misread characters: as scanned, with one character
/// read as one that looks like it, and, as the last resort, unknown (two mistakes).
fn readings(cell: &str) -> Vec<(f64, usize)> {
    let parse = |text: &str| {
        let dotted = text.replace(',', ".");
        // The columns of 16 processors begin with a point, which is the first character to fade.
        let dotted = if dotted.contains('.') { dotted } else { format!(".{dotted}") };
        dotted.parse::<f64>().ok()
    };
    let mut all: Vec<_> = parse(cell).map(|value| (value, 0)).into_iter().collect();
    for (at, found) in cell.char_indices() {
        for like in look_alikes(found).chars() {
            let mut text = cell.to_owned();
            text.replace_range(at..at + found.len_utf8(), like.encode_utf8(&mut [0; 4]));
            all.extend(parse(&text).map(|value| (value, 1)));
        }
    }
    // An illegible cell costs nothing; discarding a legible one costs more than one mistake.
    let illegible = if all.is_empty() { 0 } else { 2 };
    all.push((f64::NAN, illegible));
    all
}

/// Hand-lettered digits that the scan takes for `found`.
fn look_alikes(found: char) -> &'static str {
    match found {
        '0' => "68",
        '1' => "7",
        '3' => "58",
        '4' => "9",
        '5' => "36",
        '6' => "05",
        '7' => "1",
        '8' => "0357",
        '9' => "4",
        '$' => "358",
        _ => "",
    }
}

/// Whether a table is plausible; NaN cells are not tested.
fn possible(table: &[f64; MACHINES], polygons: f64, [similar, similar_splitter]: [f64; 2]) -> bool {
    let at_least = |high: usize, low: f64| !(table[high] + HALF_DIGIT < low);
    let at_most = |low: usize, high: f64| !(table[low] - HALF_DIGIT > high);
    // Dividing a screen divides the work evenly at best, and no part has more than the whole.
    let dividing = at_least(I4, table[UNI] / 4.0)
        && at_least(S4, table[UNI] / 4.0)
        && at_most(I4, table[UNI])
        && at_most(S4, table[UNI])
        && at_least(I16, table[I4] / 4.0)
        && at_least(S16, table[S4] / 4.0)
        && at_least(H16, table[S4] / 4.0)
        && at_most(I16, table[I4])
        && at_most(S16, table[S4])
        && at_most(H16, table[S4])
        && [I16, S16, H16].into_iter().all(|column| at_most(column, table[UNI]));
    let changes =
        |column: usize, from: f64, limit: f64| from > 0.0 && (table[column] / from - 1.0).abs() > limit;
    dividing
        && !changes(UNI, similar, LARGEST_CHANGE)
        && !changes(S16, similar_splitter, LARGEST_SPLITTER_CHANGE)
        && interlace_law(table, polygons)
}

/// Whether one scene can have the interlace's three times: with k by k processors a time is F + s/k + p/k^2 + z_k,
/// where F is the cost of polygons and vertices, s of segments, p of pixels, and z_k at most one segment per polygon
/// for those without a scan line. True if a time is unknown or unreadable.
fn interlace_law(table: &[f64; MACHINES], polygons: f64) -> bool {
    /// Steps of the search over z_4; the digits of the tables are coarser.
    const STEPS: u32 = 100;
    let (uni, i4, i16) = (table[UNI] * 1e6, table[I4] * 1e6, table[I16] * 1e6);
    if !(uni + i4 + i16).is_finite() {
        return true;
    }
    let least_fixed = polygons * (POLYGON.get() + LEAST_VERTICES * VERTEX.get());
    let least_segments = polygons * SEGMENT.get();
    let slack = HALF_DIGIT * 1e6;
    (0..=STEPS).any(|step| {
        let charge = least_segments * f64::from(step) / f64::from(STEPS);
        let i16 = i16 - charge;
        // uni - i4 = s/2 + 3p/4, i4 - i16 = s/4 + 3p/16
        let (first, second) = (2.0 * (uni - i4), 4.0 * (i4 - i16));
        let pixels = (first - second) / 0.75;
        let segments = first - 1.5 * pixels;
        let fixed = uni - pixels - segments;
        let least_pixels = segments / SEGMENT.get() * PIXEL.get();
        fixed >= least_fixed - slack && segments >= least_segments - slack && pixels >= least_pixels - slack
    })
}

/// Figures in which the splitter with 4 processors is faster than the interlace, from both columns (4.3).
///
/// # Errors
/// Lists of different lengths.
pub fn splitter_wins(
    figures: Vec<Count>,
    interlace: Vec<f64>,
    splitter: Vec<f64>,
) -> Result<Vec<Count>, String> {
    if figures.len() != interlace.len() || figures.len() != splitter.len() {
        return Err("expected a time of both machines for each figure".into());
    }
    let wins = |i: &usize| interlace[*i] > splitter[*i];
    Ok((0..figures.len()).filter(wins).map(|i| figures[i]).collect())
}

/// Processors simulated for a scene (appendix C): those of all machines.
pub fn processors(machines: Vec<Count>) -> Count {
    machines.into_iter().sum()
}

pub(crate) const MODELS: &[Model] = models! {
    "parks.scene-table", "fig 15", "cycles of six machines from counts [N, V, S, P] of their slowest processors":
        table_of_counts["counts": Vec<[f64; 4]>] -> Vec<Cycles>;
    "parks.restored-table", "fig 16 to 25", "cycles of six machines as read from the damaged scan by the cost model":
        restored_table["cells": Vec<String>, "polygons": Count, "similar": f64 = 0.0,
            "similar_splitter": f64 = 0.0] -> Result<Readings, String>;
    "parks.splitter-wins", "4.3", "figures in which the splitter with 4 is faster than the interlace":
        splitter_wins["figures": Vec<Count>, "interlace": Vec<f64>, "splitter": Vec<f64>]
            -> Result<Vec<Count>, String>;
    "parks.processors", "app. C", "processors of all machines":
        processors["machines": Vec<Count>] -> Count;
};

#[cfg(test)]
mod tests {
    use super::*;

    fn read(cells: [&str; MACHINES], polygons: f64, [uni, splitter]: [f64; 2]) -> Vec<f64> {
        let cells = cells.map(str::to_owned).to_vec();
        restored_table(cells, Count::new(polygons), uni, splitter)
            .unwrap()
            .0
            .iter()
            .map(|c| c.get() / 1e6)
            .collect()
    }

    #[test]
    fn readable_cells_stay() {
        let table = read(["6.80", "2.01", "1.97", ".703", ".658", ".634"], 86.0, [6.71, 0.653]);
        assert_eq!(table, [6.80, 2.01, 1.97, 0.703, 0.658, 0.634]);
    }

    #[test]
    fn a_misread_digit_is_found_by_the_law_of_the_interlace() {
        let table = read(["3.75", "1.57", "?", ".761", "1.06", ".94"], 498.0, [3.91, 0.629]);
        assert_eq!(table[I4], 1.37);
    }

    #[test]
    fn what_several_readings_fit_stays_open() {
        let table = read(["5.83", "1.95", "5.01", ".459", "1.14", "j e L"], 492.0, [5.49, 0.905]);
        assert!(table[UNI].is_nan() && table[H16].is_nan());
        assert_eq!(table[S4..=S16], [3.01, 0.959, 1.14]);
    }
}
