//! Samples of a pixel: a grid of n by n sub-pixels of which all are drawn, or one in every row and column.
//!
//! A scene is projected to n times the resolution; of every sub-row the tile engine draws all sub-pixels, or only those at
//! the place that the pattern gives this row (document 001, 3.6.6, figures 3.25 and 3.26).

use super::tile_engine::TileWork;
use super::triangle::PixelBox;
use super::{Partition, Scene, Triangle};

/// One sample in every row and column of a pixel: the column of each row's.
pub type Pattern<'a> = &'a [u32];

/// All patterns of `n` samples, in the order of their digits.
pub fn patterns(n: u32) -> Vec<Vec<u32>> {
    let mut all: Vec<Vec<u32>> = vec![Vec::new()];
    for _ in 0..n {
        let longer = |p: &Vec<u32>| {
            let free = (0..n).filter(|c| !p.contains(c));
            free.map(|c| p.iter().copied().chain([c]).collect()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// The scene at `n` times the resolution.
pub fn scaled(scene: &Scene, n: u32) -> Scene {
    let of =
        |p: &Partition| Partition { triangles: p.triangles.iter().map(|t| larger(t, n)).collect(), ..*p };
    Scene {
        width: scene.width * n,
        height: scene.height * n,
        partitions: scene.partitions.iter().map(of).collect(),
    }
}

fn larger(t: &Triangle, n: u32) -> Triangle {
    let n = n as i32;
    Triangle { x: t.x.map(|x| x * n), y: t.y.map(|y| y * n) }
}

/// The part of a triangle in a tile, at the samples of a pattern only. Triangle and tile are at the full resolution; the
/// spans are columns of pixels.
pub fn sparse_work(triangle: &Triangle, tile: PixelBox, pattern: Pattern<'_>) -> TileWork {
    let n = pattern.len().max(1) as i32;
    TileWork::new(triangle, tile).with_spans(|row, first, end| {
        let column = pattern[row.rem_euclid(n) as usize] as i32;
        // The first pixel whose sample is not left of a sub-pixel.
        let pixel = |x: i32| (x - column + n - 1).div_euclid(n);
        (pixel(first), pixel(end))
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Whether a point is inside, by the signs of its distances from the sides; none may be zero.
    fn inside(t: &Triangle, [x, y]: [i64; 2]) -> bool {
        let side = |k: usize| {
            let [ax, ay, bx, by] = [t.x[k], t.y[k], t.x[(k + 1) % 3], t.y[(k + 1) % 3]].map(i64::from);
            ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).signum()
        };
        side(0) == side(1) && side(1) == side(2)
    }

    proptest! {
        /// The pixels drawn are those whose sample is in the triangle, one after the other.
        #[test]
        fn samples_are_tested_one_by_one(
            corners in prop::array::uniform3((-1000i32..5000, -1000i32..5000)),
            which in 0usize..24,
        ) {
            // Samples are at even coordinates: none is a corner.
            let corners = corners.map(|(x, y)| (2 * x + 1, 2 * y + 1));
            let pattern = &patterns(4)[which];
            let triangle = Triangle::new(corners);
            let tile = PixelBox { x0: 0, x1: 32, y0: 0, y1: 32 };
            let mut count = 0;
            for row in 0..32i32 {
                for pixel in 0..8i32 {
                    let column = 4 * pixel + pattern[(row % 4) as usize] as i32;
                    // A sub-pixel is sampled at its lower right corner.
                    let at = [i64::from(column + 1) * 256, i64::from(row + 1) * 256];
                    let on_side = (0..3).any(|k| {
                        let [ax, ay, bx, by] =
                            [triangle.x[k], triangle.y[k], triangle.x[(k + 1) % 3], triangle.y[(k + 1) % 3]].map(i64::from);
                        (bx - ax) * (at[1] - ay) == (by - ay) * (at[0] - ax)
                    });
                    prop_assume!(!on_side);
                    count += u64::from(inside(&triangle, at));
                }
            }
            prop_assert_eq!(sparse_work(&triangle, tile, pattern).pixels(), count);
        }
    }

    #[test]
    fn patterns_are_permutations() {
        assert_eq!(patterns(2), [[0, 1], [1, 0]]);
        let all = patterns(4);
        assert_eq!(all.len(), 24);
        assert!(all.iter().all(|p| (0..4).all(|c| p.contains(&c))));
        assert_eq!(patterns(6).len(), 720);
    }

    #[test]
    fn all_patterns_together_are_the_full_grid() {
        let triangle = Triangle::new([(700, 300), (2100, 7300), (7000, 2500)]);
        let tile = PixelBox { x0: 0, x1: 32, y0: 0, y1: 32 };
        // The four shifts of a pattern have every sub-pixel once.
        let shifts = (0..4).map(|s| [0, 1, 2, 3].map(|r| (2 * r + r / 2 + s) % 4));
        let sum: u64 = shifts.map(|p| sparse_work(&triangle, tile, &p).pixels()).sum();
        assert_eq!(sum, TileWork::new(&triangle, tile).pixels());
    }
}
