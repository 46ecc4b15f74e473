//! Joins pieces of lines that meet end to end.

use glam::DVec2;

/// A point closer than this to the line through its neighbours is left out, in pixels.
const STRAIGHT: f64 = 1e-9;

/// Lines end where more pieces than this meet.
const MOST_MEETING: usize = 64;

/// A place on the screen, as a key.
type Key = [u64; 2];

fn key(p: DVec2) -> Key {
    // Both zeros are the same place.
    (p + 0.0).to_array().map(f64::to_bits)
}

/// Lines through all pieces, each of which is in one of them once. Where more than two pieces meet, a line goes straight on.
/// Pieces are joined only where their ends are the same number.
pub fn join(pieces: &[[DVec2; 2]]) -> Vec<Vec<DVec2>> {
    let mut ends: Vec<(Key, u32)> =
        (0u32..).zip(pieces.iter().flatten()).map(|(number, &p)| (key(p), number)).collect();
    ends.sort_unstable();
    let mut used = vec![false; pieces.len()];
    let mut lines = Vec::new();
    for first in 0..pieces.len() {
        if used[first] {
            continue;
        }
        used[first] = true;
        let mut line = pieces[first].to_vec();
        follow(pieces, &ends, &mut used, &mut line);
        if line.first() != line.last() {
            line.reverse();
            follow(pieces, &ends, &mut used, &mut line);
        }
        lines.push(straightened(&line));
    }
    lines
}

/// Continues a line at its end.
fn follow(pieces: &[[DVec2; 2]], ends: &[(Key, u32)], used: &mut [bool], line: &mut Vec<DVec2>) {
    while let [.., before, last] = line[..] {
        let along = (last - before).normalize_or_zero();
        let at = key(last);
        let from = ends.partition_point(|end| end.0 < at);
        let here = &ends[from..from + ends[from..].partition_point(|end| end.0 == at)];
        // A star: which two of its pieces are one line is of no interest, and looking for them at each would take quadratic time.
        if here.len() > MOST_MEETING {
            return;
        }
        let mut best: Option<(f64, u32)> = None;
        for &(_, end) in here.iter().filter(|end| !used[end.1 as usize / 2]) {
            let other = pieces[end as usize / 2][1 - end as usize % 2];
            let turn = along.dot((other - last).normalize_or_zero());
            if best.is_none_or(|(most, _)| turn > most) {
                best = Some((turn, end));
            }
        }
        let Some((_, end)) = best else { return };
        used[end as usize / 2] = true;
        line.push(pieces[end as usize / 2][1 - end as usize % 2]);
        if line.first() == line.last() {
            return;
        }
    }
}

/// A line without points inside of straight parts.
fn straightened(line: &[DVec2]) -> Vec<DVec2> {
    let mut kept: Vec<DVec2> = Vec::with_capacity(line.len());
    for &p in line {
        if let [.., a, b] = kept[..] {
            let (whole, part) = (p - a, b - a);
            if whole.perp_dot(part).abs() <= STRAIGHT * whole.length() && part.dot(p - b) > 0.0 {
                kept.pop();
            }
        }
        kept.push(p);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    #[test]
    fn pieces_become_lines() {
        let square = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let sides: Vec<[DVec2; 2]> = (0..4).map(|k| [square[k], square[(k + 1) % 4]]).collect();
        let lines = join(&sides);
        assert_eq!((lines.len(), lines[0].len()), (1, 5));
        assert_eq!(lines[0].first(), lines[0].last());
        // A cross: two straight lines, whatever the order.
        let middle = at(0.5, 0.5);
        let cross =
            [[middle, at(0.0, 0.5)], [at(0.5, 1.0), middle], [middle, at(1.0, 0.5)], [middle, at(0.5, -0.0)]];
        let lines = join(&cross);
        assert_eq!(lines, [[at(0.0, 0.5), at(1.0, 0.5)], [at(0.5, 0.0), at(0.5, 1.0)]].map(|l| l.to_vec()));
        // A star of many pieces stays as it is.
        let star: Vec<[DVec2; 2]> = (0..100).map(|k| [middle, at(f64::from(k), 9.0)]).collect();
        assert_eq!(join(&star).len(), star.len());
        assert_eq!(join(&[[middle, middle]]), [vec![middle, middle]]);
        assert!(join(&[]).is_empty());
    }
}
