//! What is drawn of series: symbols, dashed lines, hatched bars.

use glam::{DVec2, dvec2};

/// Corners of symbols in a circle of radius 1, y downwards; the first is a circle.
const SYMBOLS: [&[[f64; 2]]; 10] = [
    &[],
    &[[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]],
    &[[0.0, -1.1], [1.0, 0.75], [-1.0, 0.75]],
    &[[0.0, -1.15], [1.0, 0.0], [0.0, 1.15], [-1.0, 0.0]],
    &[[0.0, 1.1], [-1.0, -0.75], [1.0, -0.75]],
    &[
        [-0.35, -1.0],
        [0.35, -1.0],
        [0.35, -0.35],
        [1.0, -0.35],
        [1.0, 0.35],
        [0.35, 0.35],
        [0.35, 1.0],
        [-0.35, 1.0],
        [-0.35, 0.35],
        [-1.0, 0.35],
        [-1.0, -0.35],
        [-0.35, -0.35],
    ],
    &[[-0.9, -1.0], [0.9, -1.0], [-0.9, 1.0], [0.9, 1.0]],
    &[
        [0.0, -1.2],
        [0.3, -0.4],
        [1.1, -0.37],
        [0.48, 0.15],
        [0.7, 0.97],
        [0.0, 0.5],
        [-0.7, 0.97],
        [-0.48, 0.15],
        [-1.1, -0.37],
        [-0.3, -0.4],
    ],
    &[[-1.0, -0.9], [1.0, 0.9], [1.0, -0.9], [-1.0, 0.9]],
    &[
        [0.0, -0.5],
        [0.6, -1.1],
        [1.1, -0.6],
        [0.5, 0.0],
        [1.1, 0.6],
        [0.6, 1.1],
        [0.0, 0.5],
        [-0.6, 1.1],
        [-1.1, 0.6],
        [-0.5, 0.0],
        [-1.1, -0.6],
        [-0.6, -1.1],
    ],
];

/// How many symbols there are.
#[cfg(test)]
pub(super) const COUNT: usize = SYMBOLS.len();

/// The outline of a symbol around `center`.
pub(super) fn symbol(kind: usize, center: DVec2, radius: f64) -> Vec<DVec2> {
    let corners = SYMBOLS[kind % SYMBOLS.len()];
    if corners.is_empty() {
        let corner = |i: u32| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 24.0);
        return (0..24).map(|i| center + radius * corner(i)).collect();
    }
    corners.iter().map(|&[x, y]| center + radius * dvec2(x, y)).collect()
}

/// The strokes of a line that is drawn with strokes and gaps of the lengths `pattern`.
pub(super) fn dashed(line: &[DVec2], pattern: &[f64]) -> Vec<Vec<DVec2>> {
    let mut strokes = Vec::new();
    let (mut part, mut left) = (0, pattern[0]);
    let mut stroke: Vec<DVec2> = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let length = from.distance(to);
            if length < left {
                left -= length;
                break;
            }
            from = from.lerp(to, left / length);
            if part % 2 == 0 {
                stroke.push(from);
                strokes.push(std::mem::take(&mut stroke));
            } else {
                stroke = vec![from];
            }
            part = (part + 1) % pattern.len();
            left = pattern[part];
        }
        if part % 2 == 0 {
            stroke.push(to);
        }
    }
    if stroke.len() > 1 && stroke.first() != stroke.last() {
        strokes.push(stroke);
    }
    strokes
}

/// Lines across the rectangle from `low` to `high`, of a direction and distance of the series `kind`.
pub(super) fn hatching(kind: usize, low: DVec2, high: DVec2) -> Vec<Vec<DVec2>> {
    let directions = [dvec2(1.0, -1.0), dvec2(1.0, 1.0), dvec2(1.0, 0.0), dvec2(0.0, 1.0)];
    let distance = if (kind / directions.len()).is_multiple_of(2) { 4.0 } else { 8.0 };
    let along = directions[kind % directions.len()].normalize();
    let across = along.perp();
    let reach = (high - low).abs().length();
    // The lines are those of the whole page, so that bars of a series look alike.
    let middle = 0.5 * (low + high);
    let steps = (0.5 * reach / distance).ceil() as i32;
    let first = (middle.dot(across) / distance).round() as i32;
    let line = |step: i32| {
        let place = middle + across * (f64::from(first + step) * distance - middle.dot(across));
        clipped(place - along * reach, place + along * reach, low.min(high), low.max(high))
    };
    (-steps..=steps).filter_map(line).collect()
}

/// The part of a line inside a rectangle: Liang and Barsky.
fn clipped(from: DVec2, to: DVec2, low: DVec2, high: DVec2) -> Option<Vec<DVec2>> {
    let (mut begin, mut end) = (0.0f64, 1.0f64);
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        let [enter, leave] = [low[axis] - from[axis], high[axis] - from[axis]];
        if step.abs() < 1e-9 {
            if enter > 0.0 || leave < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (enter / step, leave / step);
        (begin, end) = (begin.max(a.min(b)), end.min(a.max(b)));
    }
    (begin < end).then(|| vec![from.lerp(to, begin), from.lerp(to, end)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(lines: &[Vec<DVec2>]) -> f64 {
        lines.iter().flat_map(|l| l.windows(2)).map(|p| p[0].distance(p[1])).sum()
    }

    #[test]
    fn strokes_have_the_lengths_of_the_pattern_round_corners() {
        let line = [dvec2(0.0, 0.0), dvec2(30.0, 0.0), dvec2(30.0, 50.0)];
        let strokes = dashed(&line, &[6.0, 4.0]);
        assert_eq!(strokes.len(), 8);
        assert!(strokes.iter().all(|s| (length(std::slice::from_ref(s)) - 6.0).abs() < 1e-9), "{strokes:?}");
        assert!(dashed(&[], &[6.0, 4.0]).is_empty());
    }

    #[test]
    fn hatching_covers_a_bar_and_stays_inside() {
        let (low, high) = (dvec2(10.0, 200.0), dvec2(40.0, 80.0));
        for kind in 0..8 {
            let lines = hatching(kind, low, high);
            assert!(
                lines
                    .iter()
                    .flatten()
                    .all(|p| { (9.999..=40.001).contains(&p.x) && (79.999..=200.001).contains(&p.y) })
            );
            // Lines at this distance have the area over the distance as their length.
            let distance = if kind < 4 { 4.0 } else { 8.0 };
            let expected = 30.0 * 120.0 / distance;
            assert!((length(&lines) / expected - 1.0).abs() < 0.2, "{kind}: {} {expected}", length(&lines));
        }
    }
}
