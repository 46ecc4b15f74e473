//! Document 004: F. A. Ortega, C. D. Hansen, Fast Data Parallel Polygon Rendering, 1993: rates, speed-ups, sizes.
//!
//! Its rates are polygons over time, truncated to whole numbers.

use crate::models;
use crate::models::registry::{Glossary, Model};
use crate::units::{Bytes, Count, Polygons, Ratio, Seconds};

/// Polygons a second as the tables print them, truncated to a whole number.
pub fn rate(polygons: Polygons, time: Seconds) -> Count {
    Count::new((polygons.get() / time.get()).floor())
}

/// The best rate of a table.
///
/// # Errors
/// No times.
pub fn best_rate(polygons: Polygons, times: Vec<Seconds>) -> Result<Count, String> {
    let rates = times.into_iter().map(|t| rate(polygons, t).get());
    rates.reduce(f64::max).map(Count::new).ok_or_else(|| "times: expected at least one, found none".into())
}

/// Time on the smallest partition over time on this one.
pub fn speed_up(smallest: Seconds, time: Seconds) -> Ratio {
    Ratio::new(smallest / time)
}

/// Maximum number of candidates.
const MOST_CANDIDATES: u64 = 100_000_000;

/// The number of polygons that explains most of the printed rates: a rate `r` truncated from `N / t` allows the whole
/// numbers r t <= N < (r + 1) t.
///
/// # Errors
/// Lists of different lengths, several numbers that explain equally many rates, or more than 10^8 candidates.
pub fn implied_polygons(times: Vec<Seconds>, rates: Vec<Count>) -> Result<Polygons, String> {
    if times.len() != rates.len() || times.is_empty() {
        return Err(format!("expected as many rates as times, found {} and {}", rates.len(), times.len()));
    }
    let explains =
        |n: f64| times.iter().zip(&rates).filter(|(t, r)| rate(Polygons::new(n), **t) == **r).count();
    // Every number that explains any rate is a candidate.
    let ranges = times
        .iter()
        .zip(&rates)
        .map(|(t, r)| ((r.get() * t.get()).floor() as u64, ((r.get() + 1.0) * t.get()).ceil() as u64));
    let (first, last) = ranges.fold((u64::MAX, 0), |(low, high), (l, h)| (low.min(l), high.max(h)));
    if last.saturating_sub(first) > MOST_CANDIDATES {
        return Err(format!(
            "t, rates: expected at most {MOST_CANDIDATES} numbers to try, found {first} to {last}"
        ));
    }
    let mut best = (0, Vec::new());
    for n in first..=last {
        let explained = explains(n as f64);
        match explained.cmp(&best.0) {
            std::cmp::Ordering::Greater => best = (explained, vec![n]),
            std::cmp::Ordering::Equal => best.1.push(n),
            std::cmp::Ordering::Less => {}
        }
    }
    match best.1[..] {
        [n] => Ok(Polygons::new(n as f64)),
        _ => Err(format!("{} numbers explain {} rates each", best.1.len(), best.0)),
    }
}

/// The smallest and the largest ratio of two tables, cell by cell.
///
/// # Errors
/// Lists of different lengths, or empty ones.
pub fn ratio_range(slow: Vec<Seconds>, fast: Vec<Seconds>) -> Result<[Ratio; 2], String> {
    if slow.len() != fast.len() || slow.is_empty() {
        return Err(format!("expected as many times in both lists, found {} and {}", slow.len(), fast.len()));
    }
    let ratios = slow.iter().zip(&fast).map(|(s, f)| *s / *f);
    let (low, high) = ratios.fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
    Ok([Ratio::new(low), Ratio::new(high)])
}

/// Bytes of `polygons` polygons with `vertices` vertices of `vertex` bytes (1).
pub fn step_bytes(polygons: Polygons, vertices: Count, vertex: Bytes) -> Bytes {
    vertex * (polygons.get() * vertices.get())
}

/// Bytes of a cube of cells (1).
pub fn volume_bytes(side: Count, cell: Bytes) -> Bytes {
    cell * side.get().powi(3)
}

/// Memory of one of `processors` (4).
pub fn memory_per_processor(memory: Bytes, processors: Count) -> Bytes {
    memory / processors.get()
}

/// Entries of the colour table from `first` to `last` that remain beside a grid of `side` by `side` colours (5).
///
/// # Errors
/// Fewer entries than colours.
pub fn spare_colors(first: Count, last: Count, side: Count) -> Result<Count, String> {
    let spare = last.get() - first.get() + 1.0 - side.get() * side.get();
    if spare < 0.0 { Err(format!("{} entries are missing", -spare)) } else { Ok(Count::new(spare)) }
}

/// Steps of the two loops (4): the first runs once per scan line of the tallest polygon, for every layer of polygons on
/// the processors; the second once per pixel of the longest segment, for every layer of each buffer of segments.
pub fn loop_steps(
    tallest: Count,
    polygons: Polygons,
    processors: Count,
    longest: Vec<Count>,
    buffer: Count,
) -> Count {
    let layers = (polygons.get() / processors.get()).ceil();
    let buffer_layers = (buffer.get() / processors.get()).ceil();
    Count::new(tallest.get() * layers + longest.into_iter().sum::<Count>().get() * buffer_layers)
}

pub(crate) const MODELS: &[Model] = models! {
    "ortega.rate", "tables 1 to 4", "polygons a second, truncated to a whole number":
        rate["N": Polygons, "t": Seconds] -> Count;
    "ortega.best-rate", "6", "best rate of a table":
        best_rate["N": Polygons, "t": Vec<Seconds>] -> Result<Count, String>;
    "ortega.speed-up", "fig 3, 4", "speed-up over the smallest partition":
        speed_up["t0": Seconds, "t": Seconds] -> Ratio;
    "ortega.implied-polygons", "tables 1 to 4", "number of polygons that explains most printed rates":
        implied_polygons["t": Vec<Seconds>, "rates": Vec<Count>] -> Result<Polygons, String>;
    "ortega.ratio-range", "6", "smallest and largest ratio of two tables' times":
        ratio_range["slow": Vec<Seconds>, "fast": Vec<Seconds>] -> Result<[Ratio; 2], String>;
    "ortega.step-bytes", "1", "bytes of the polygons of a time step":
        step_bytes["polygons": Polygons = 250_000.0, "vertices": Count = 3.0, "vertex": Bytes = 24.0] -> Bytes;
    "ortega.volume-bytes", "1", "bytes of a cube of cells":
        volume_bytes["side": Count = 256.0, "cell": Bytes = 8.0] -> Bytes;
    "ortega.memory-per-processor", "4", "memory of one processor":
        memory_per_processor["memory": Bytes, "processors": Count] -> Bytes;
    "ortega.spare-colors", "5", "entries of the colour table that are left":
        spare_colors["first": Count = 30.0, "last": Count = 255.0, "side": Count = 15.0] -> Result<Count, String>;
    "ortega.loop-steps", "4", "steps of the loops over heights and segments":
        loop_steps["tallest": Count, "N": Polygons, "processors": Count, "longest": Vec<Count>, "buffer": Count]
            -> Count;
};

pub(crate) const GLOSSARY: Glossary = Glossary {
    group: "ortega",
    document: Some("004"),
    symbols: &[
        ("N", "polygons"),
        ("buffer", "segments that are collected before they are split into pixels"),
        ("cell", "bytes of a cell"),
        ("fast", "times of the faster table, cell by cell"),
        ("first", "first entry of the colour table that is free"),
        ("last", "last entry"),
        ("longest", "pixels of the longest segment of each full buffer"),
        ("memory", "memory of the machine"),
        ("polygons", "polygons of a time step"),
        ("processors", "processors"),
        ("rates", "polygons a second as printed"),
        ("side", "cells, or colours, along an edge"),
        ("slow", "times of the slower table, cell by cell"),
        ("t", "time of the picture, or times of several"),
        ("t0", "time on the smallest partition"),
        ("tallest", "scan lines of the tallest polygon"),
        ("vertex", "bytes of a vertex"),
        ("vertices", "vertices of a polygon"),
    ],
    assumptions: &[
        (&["ortega.rate", "ortega.best-rate", "ortega.implied-polygons"], "rates are truncated, not rounded"),
        (&["ortega.speed-up"], "the smallest partition counts as 1"),
        (
            &["ortega.loop-steps"],
            "every pass takes all layers of virtual processors, whether they have work or not",
        ),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_implied_number_is_found_again() {
        let times = [1.894, 1.04, 0.571, 0.463].map(Seconds::new).to_vec();
        let mut rates: Vec<_> = times.iter().map(|t| rate(Polygons::new(228_288.0), *t)).collect();
        assert_eq!(implied_polygons(times.clone(), rates.clone()), Ok(Polygons::new(228_288.0)));
        // A misprint does not hide it.
        rates[0] = rates[0] + Count::new(100.0);
        assert_eq!(implied_polygons(times, rates), Ok(Polygons::new(228_288.0)));
    }

    #[test]
    fn one_cell_implies_many_numbers() {
        let found = implied_polygons(vec![Seconds::new(37.326)], vec![Count::new(5839.0)]);
        assert_eq!(found.unwrap_err(), "37 numbers explain 1 rates each");
    }
}
