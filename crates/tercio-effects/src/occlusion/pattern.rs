//! The directions and distances in which each point looks for what occludes it.

use tercio_mesh::trig::sin_cos;

use crate::lanes::LANES;

/// Lines through each point.
pub const LINES: usize = 2;
/// Points that are looked at on each side of a line.
pub const STEPS: usize = 5;
/// Pixels along the edge of the pattern in which the directions of the lines alternate.
pub const PATTERN: usize = 4;
/// The largest number of pixels in a radius.
pub const MAX_RADIUS: f32 = 512.0;
/// Points on a line are at least this many pixels apart from the middle.
pub const MIN_DISTANCE: f32 = 1.5;

/// The directions and distances of one row of the pattern, by column, again and again.
pub struct Row {
    /// Cosine and sine of the angle of each line.
    pub lines: [[[f32; LANES]; 2]; LINES],
    /// Distances along a line, in radii.
    pub steps: [[f32; LANES]; STEPS],
}

impl Row {
    /// The directions and distances of one column, for all lanes.
    pub fn column(&self, column: usize) -> Self {
        Self {
            lines: self.lines.map(|line| line.map(|part| [part[column]; LANES])),
            steps: self.steps.map(|step| [step[column]; LANES]),
        }
    }
}

/// What an ordered pattern of 16 numbers has at a pixel: each of 0 to 15 once.
fn order(x: usize, y: usize) -> usize {
    const BAYER: [[usize; PATTERN]; PATTERN] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    BAYER[y % PATTERN][x % PATTERN]
}

/// All rows of the pattern.
pub fn rows() -> [Row; PATTERN] {
    let share = |x: usize, y: usize| (order(x, y) as f64 + 0.5) / (PATTERN * PATTERN) as f64;
    std::array::from_fn(|y| {
        let angle = |line: usize, x: usize| {
            sin_cos((line as f64 + share(x, y)) * std::f64::consts::PI / LINES as f64)
        };
        let step = |step: usize, x: usize| {
            // Another order than that of the directions.
            let part = (step as f64 + share(x + 2 * y + 1, x + y / 2)) / STEPS as f64;
            part as f32
        };
        Row {
            lines: std::array::from_fn(|l| {
                [std::array::from_fn(|x| angle(l, x).1 as f32), std::array::from_fn(|x| angle(l, x).0 as f32)]
            }),
            steps: std::array::from_fn(|s| std::array::from_fn(|x| step(s, x))),
        }
    })
}
