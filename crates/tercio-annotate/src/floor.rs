//! A grid on the floor, below a model.

use glam::DVec3;

use crate::layout::Layout;
use crate::number;
use crate::outline::Outline;
use crate::overlay::{Overlay, Paint};
use crate::project::Projector;

/// The lines of the grid are at multiples of this many units, about a tenth of the larger side of the floor.
pub fn step(size: f64) -> Option<f64> {
    let wanted = size * 0.1;
    if !wanted.is_normal() {
        return None;
    }
    let exponent = number::exponent_of(wanted);
    let lengths = [(1, exponent), (2, exponent), (5, exponent), (1, exponent + 1)];
    let length = |(digit, exponent): (i32, i32)| format!("{digit}e{exponent}").parse().ok();
    lengths.into_iter().filter_map(length).find(|&length: &f64| length >= wanted)
}

/// Adds a grid at the lower end of a box on the axis that points upwards: behind the picture if it is seen from above, onto it if
/// from below. All of the model is on the same side of it, so that this hides exactly what the model hides. It reaches a cell
/// beyond the box, or to its border if it `is_in_box`. Returns the distance of its lines.
pub fn add(
    layout: &mut Layout,
    behind: &mut Overlay,
    projector: &Projector,
    [min, max]: [DVec3; 2],
    up: DVec3,
    is_in_box: bool,
) -> Option<f64> {
    let axis = (0..3).max_by(|&a, &b| up[a].abs().total_cmp(&up[b].abs())).unwrap_or(1);
    let is_turned = up[axis] < 0.0;
    let lower = if is_turned { max[axis] } else { min[axis] };
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    let size = (max - min)[a].max((max - min)[b]);
    let Some(step) = step(size) else {
        layout.leave_out("grid");
        return None;
    };
    let from_below = projector.sees(axis, lower, is_turned);
    // Whole cells, and one more on each side.
    let whole = |k: usize| [(min[k] / step).floor() - 1.0, (max[k] / step).ceil() + 1.0];
    let inside = |k: usize| [(min[k] / step).ceil(), (max[k] / step).floor()];
    let lines = [a, b].map(|k| if is_in_box { inside(k) } else { whole(k) });
    let ends = [a, b].map(|k| if is_in_box { [min[k], max[k]] } else { whole(k).map(|end| end * step) });
    let (mut color, width) = (layout.color, layout.line);
    color[3] *= 0.35;
    let overlay = if from_below { &mut layout.overlay } else { behind };
    for (k, other) in [(0, 1), (1, 0)] {
        let (across, along) = ([a, b][k], [a, b][other]);
        let count = (lines[k][1] - lines[k][0]).max(0.0) as usize;
        for number in 0..=count.min(64) {
            let [mut p, mut q] = [min; 2];
            (p[axis], q[axis]) = (lower, lower);
            p[across] = (lines[k][0] + number as f64) * step;
            q[across] = p[across];
            (p[along], q[along]) = (ends[other][0], ends[other][1]);
            if let Some([p, q]) = projector.line(p, q) {
                overlay.fill(Outline::stroke(p, q, width), Paint::Solid(color));
            }
        }
    }
    Some(step)
}
