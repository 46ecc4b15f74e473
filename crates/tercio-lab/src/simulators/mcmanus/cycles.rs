//! Raster cycles by size of region (document 003, section 3, table 1).

use serde::Serialize;

use crate::workloads::{BoxScene, PixelBox};

/// The raster cycles of a workload for one size of region.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RasterCycles {
    /// A: pixels along a side of a region.
    pub side: u32,
    /// R_A: polygons in all bins.
    pub cycles: u64,
    /// Polygons of the workload that the screen shows.
    pub polygons: u64,
    /// Polygons in the fullest bin.
    pub fullest: u64,
    /// Bins.
    pub regions: u64,
}

impl RasterCycles {
    /// The overlap factor R_A / polygons; 0 without polygons.
    pub fn overlap(&self) -> f64 {
        self.cycles as f64 / self.polygons.max(1) as f64
    }

    /// Seconds that `arrays` arrays with cycles of `seconds` take if the work is divided evenly (section 3).
    ///
    /// # Panics
    /// If there is no array.
    pub fn frame_time(&self, arrays: u64, seconds: f64) -> f64 {
        assert!(arrays > 0, "at least one array");
        self.cycles as f64 / arrays as f64 * seconds
    }
}

/// Counts the raster cycles of the visible polygons of a scene; parts outside the screen are in no bin.
///
/// # Panics
/// If the screen or the regions have no pixel.
pub fn raster_cycles(scene: &BoxScene, (width, height): (u32, u32), side: u32) -> RasterCycles {
    assert!(side > 0, "regions have pixels");
    let screen = PixelBox::screen(width, height);
    let (across, down) = (width.div_ceil(side) as usize, height.div_ceil(side) as usize);
    // Corners of the boxes in a grid of differences: its prefix sums are the numbers of polygons in the bins.
    let stride = across + 1;
    let mut bins = vec![0i64; stride * (down + 1)];
    let mut result =
        RasterCycles { side, cycles: 0, polygons: 0, fullest: 0, regions: (across * down) as u64 };
    for polygon in scene.boxes.iter().filter(|b| b.visible) {
        let Some(b) = polygon.pixels.intersection(&screen) else { continue };
        let region = |pixel: i32| pixel as usize / side as usize;
        let ([x0, x1], [y0, y1]) = ([region(b.x0), region(b.x1) + 1], [region(b.y0), region(b.y1) + 1]);
        result.polygons += 1;
        result.cycles += ((x1 - x0) * (y1 - y0)) as u64;
        for (x, y, sign) in [(x0, y0, 1), (x1, y1, 1), (x0, y1, -1), (x1, y0, -1)] {
            bins[y * stride + x] += sign;
        }
    }
    for y in 0..down {
        let mut row = 0;
        for x in 0..across {
            row += bins[y * stride + x];
            let above = if y > 0 { bins[(y - 1) * stride + x] } else { 0 };
            // From here on the cell has the sum of all differences above and left of it.
            bins[y * stride + x] = row + above;
            result.fullest = result.fullest.max((row + above) as u64);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workloads::BoundingBox;
    use proptest::prelude::*;

    fn scene(boxes: &[PixelBox]) -> BoxScene {
        BoxScene { boxes: boxes.iter().map(|&pixels| BoundingBox { visible: true, pixels }).collect() }
    }

    /// The scene of one square box at every position relative to the regions.
    fn everywhere(width: i32, side: i32) -> BoxScene {
        let places = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
        scene(
            &places
                .map(|[x, y]| PixelBox { x0: x, y0: y, x1: x + width - 1, y1: y + width - 1 })
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn boxes_of_figure_5() {
        // A = 2: a box of 7 pixels meets 16 regions wherever it lies; one of 8 meets 16, 20, 20 or 25.
        let overlap = |width, side| raster_cycles(&everywhere(width, side), (64, 64), side as u32).overlap();
        assert_eq!(overlap(7, 2), 16.0);
        let cycles: Vec<u64> = everywhere(8, 2)
            .boxes
            .iter()
            .map(|b| raster_cycles(&scene(&[b.pixels]), (64, 64), 2).cycles)
            .collect();
        assert_eq!(cycles, [16, 20, 20, 25]);
        // Equation 6 at N = 64, A = 2, and at other sizes: ((w + A - 1)/A)^2.
        for (width, side, expected) in [(8, 2, 20.25), (5, 16, 1.5625), (20, 8, 11.390625)] {
            assert_eq!(overlap(width, side), expected);
        }
    }

    #[test]
    fn the_whole_screen_and_single_pixels() {
        // The limits of table 1: one region for everything, and the area of the boxes at 1 x 1.
        let boxes =
            scene(&[PixelBox { x0: 3, y0: 4, x1: 10, y1: 6 }, PixelBox { x0: 0, y0: 0, x1: 511, y1: 0 }]);
        assert_eq!(raster_cycles(&boxes, (512, 512), 512).overlap(), 1.0);
        assert_eq!(raster_cycles(&boxes, (512, 512), 1).cycles, 24 + 512);
    }

    #[test]
    fn the_frame_time_of_section_3() {
        let run = RasterCycles { side: 512, cycles: 50_041, polygons: 50_041, fullest: 50_041, regions: 1 };
        assert!((run.frame_time(2, 1e-6) - 0.025_020_5).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn bins_are_counted(
            side in 1u32..20,
            boxes in prop::collection::vec((any::<bool>(), -9i32..50, -9i32..40, 0i32..30, 0i32..30), 0..30),
        ) {
            let boxes: Vec<_> = boxes.into_iter().map(|(visible, x, y, w, h)| BoundingBox {
                visible,
                pixels: PixelBox { x0: x, y0: y, x1: x + w, y1: y + h },
            }).collect();
            let (mut cycles, mut fullest) = (0, 0);
            for y in (0..40).step_by(side as usize) {
                for x in (0..50).step_by(side as usize) {
                    let region = PixelBox { x0: x, y0: y, x1: (x + side as i32).min(50) - 1, y1: (y + side as i32).min(40) - 1 };
                    let bin = boxes.iter().filter(|b| b.visible && b.pixels.intersection(&region).is_some()).count() as u64;
                    cycles += bin;
                    fullest = fullest.max(bin);
                }
            }
            let run = raster_cycles(&BoxScene { boxes }, (50, 40), side);
            prop_assert_eq!((run.cycles, run.fullest), (cycles, fullest));
        }
    }
}
