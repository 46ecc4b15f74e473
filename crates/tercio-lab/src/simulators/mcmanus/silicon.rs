//! Performance against silicon (document 003, sections 5 and 6).

use super::RasterCycles;
use crate::models::mcmanus;

/// The area of a renderer: an array of pixel processors with a geometry engine that feeds it (equation 1). Areas are
/// in square inches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaModel {
    /// One pixel processor.
    pub pixel_processor: f64,
    /// Geometry engine for each polygon a second.
    pub geometry_per_rate: f64,
    /// Fixed area of every renderer.
    pub fixed: f64,
}

impl AreaModel {
    /// Equation 1, fitted by the document to microprocessors of 1995 with their memory and a controller.
    pub const PUBLISHED: Self = Self {
        pixel_processor: mcmanus::PIXEL_PROCESSOR,
        geometry_per_rate: mcmanus::GEOMETRY_SLOPE,
        fixed: mcmanus::GEOMETRY_BASE,
    };
}

/// A renderer for one size of region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Renderer {
    /// A: pixels along a side of a region.
    pub side: u32,
    /// P: polygons a second.
    pub rate: f64,
    /// Area of the pixel processors, square inches.
    pub array: f64,
    /// G: area of the geometry engine, square inches.
    pub geometry: f64,
}

impl Renderer {
    /// R: its area in square inches.
    pub fn area(&self) -> f64 {
        self.array + self.geometry
    }

    /// Seconds for a workload of these raster cycles on `renderers` renderers, and the silicon they take: a point of
    /// figure 3.
    ///
    /// # Panics
    /// If there is no renderer.
    pub fn point(&self, cycles: &RasterCycles, renderers: u64, cycle_seconds: f64) -> [f64; 2] {
        [self.area() * renderers as f64, cycles.frame_time(renderers, cycle_seconds)]
    }
}

/// Renderers that draw a workload with `rate` raster cycles a second, one for each size of region.
pub fn renderers(workload: &[RasterCycles], model: &AreaModel, rate: f64) -> Vec<Renderer> {
    let renderer = |run: &RasterCycles| {
        let polygons = if run.cycles > 0 { rate * run.polygons as f64 / run.cycles as f64 } else { 0.0 };
        Renderer {
            side: run.side,
            rate: polygons,
            array: model.pixel_processor * f64::from(run.side) * f64::from(run.side),
            geometry: model.geometry_per_rate * polygons + model.fixed,
        }
    };
    workload.iter().map(renderer).collect()
}

/// The renderer with the least area for each polygon a second (section 5.2); the first of equal ones.
pub fn best(renderers: &[Renderer]) -> Option<&Renderer> {
    renderers
        .iter()
        .filter(|r| r.rate > 0.0)
        .min_by(|a, b| (a.area() / a.rate).total_cmp(&(b.area() / b.rate)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1.
    const TABLE_1: [(u32, u64); 10] = [
        (1, 1_196_367),
        (2, 418_132),
        (4, 182_325),
        (8, 103_069),
        (16, 73_077),
        (32, 60_400),
        (64, 54_714),
        (128, 52_020),
        (256, 50_754),
        (512, 50_041),
    ];
    /// Table 2: polygons a second, geometry engine, array, total.
    const TABLE_2: [(f64, f64, f64, f64); 10] = [
        (41_828.0, 1.399, 0.00087, 1.400),
        (119_678.0, 1.457, 0.00348, 1.460),
        (274_460.0, 1.572, 0.01394, 1.586),
        (485_510.0, 1.730, 0.05574, 1.786),
        (684_770.0, 1.878, 0.22298, 2.101),
        (828_493.0, 1.986, 0.89190, 2.878),
        (914_592.0, 2.050, 3.56762, 5.618),
        (961_957.0, 2.085, 14.27047, 16.355),
        (985_952.0, 2.103, 57.08186, 59.185),
        (1_000_000.0, 2.114, 228.32742, 230.441),
    ];

    fn published() -> Vec<RasterCycles> {
        TABLE_1
            .map(|(side, cycles)| RasterCycles { side, cycles, polygons: 50_041, fullest: 0, regions: 0 })
            .to_vec()
    }

    #[test]
    fn table_2_follows_from_table_1() {
        let renderers = renderers(&published(), &AreaModel::PUBLISHED, 1e6);
        for (r, (rate, geometry, array, total)) in renderers.iter().zip(TABLE_2) {
            // Two rates are off by one in their last digit; areas are rounded to three or five digits.
            assert!((r.rate - rate).abs() <= 1.0, "{r:?}");
            assert!((r.geometry - geometry).abs() <= 5.1e-4, "{r:?}");
            assert!((r.array - array).abs() <= 6e-6, "{r:?}");
            assert!((r.area() - total).abs() <= 1.1e-3, "{r:?}");
        }
        assert_eq!(best(&renderers).map(|r| r.side), Some(16));
    }

    #[test]
    fn without_overhead_the_smallest_array_is_best() {
        // Figure 2.
        let model = AreaModel { geometry_per_rate: 0.0, fixed: 0.0, ..AreaModel::PUBLISHED };
        assert_eq!(best(&renderers(&published(), &model, 1e6)).map(|r| r.side), Some(1));
    }

    #[test]
    fn an_empty_workload_has_no_best_array() {
        let nothing = RasterCycles { side: 4, cycles: 0, polygons: 0, fullest: 0, regions: 1 };
        assert_eq!(best(&renderers(&[nothing], &AreaModel::PUBLISHED, 1e6)), None);
    }
}
