//! Scenes made from stated distributions, for documents whose scenes are lost.
//!
//! The numbers come from a PCG generator and exact arithmetic only, so that a seed gives the same scene on every
//! machine.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::polygons::SUBPIXELS;
use super::{BoundingBox, BoxScene, PixelBox, PolygonScene, ScreenPoint, ScreenPolygon};

/// Distribution of the centres of polygons along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Uniform over the screen.
    Uniform,
    /// Around the centre of the screen. The distribution is the sum of twelve uniform ones, which differs from a normal
    /// one only beyond three deviations and needs no function that machines round differently.
    Normal {
        /// Standard deviation in pixels.
        deviation: f64,
    },
}

/// The parameters of a generated scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Pixels across the screen.
    pub width: u32,
    /// Pixels down the screen.
    pub height: u32,
    /// Polygons of the model, culled ones included.
    pub polygons: u32,
    /// The share of polygons that is visible, chosen independently for each.
    pub visible: f64,
    /// Mean width and height of a polygon's box in pixels, at least 1; each polygon has the mean rounded down or up.
    pub size: [f64; 2],
    /// Distribution of boxes, horizontally and vertically. Those that would cross the border are moved inside.
    pub spread: [Spread; 2],
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Distribution {
    /// The boxes.
    ///
    /// # Panics
    /// If the screen has no pixel.
    pub fn boxes(&self) -> BoxScene {
        let mut random = Random::new(self.seed);
        BoxScene { boxes: (0..self.polygons).map(|_| self.next_box(&mut random)).collect() }
    }

    /// Triangles that fill the boxes of [`Distribution::boxes`] from side to side; depths are uniform in 0 to 1.
    /// Culled polygons show their back.
    ///
    /// # Panics
    /// If the screen has no pixel.
    pub fn triangles(&self) -> PolygonScene {
        let mut random = Random::new(self.seed);
        // The boxes are drawn first, so that they equal those of `boxes`.
        let boxes: Vec<_> = (0..self.polygons).map(|_| self.next_box(&mut random)).collect();
        let polygons = boxes.into_iter().map(|BoundingBox { visible, pixels }| {
            // One corner of the box, and one point on each of the two sides that do not meet there.
            let [left, right] = [pixels.x0 * SUBPIXELS, (pixels.x1 + 1) * SUBPIXELS - 1];
            let [top, bottom] = [pixels.y0 * SUBPIXELS, (pixels.y1 + 1) * SUBPIXELS - 1];
            let between = |a: i32, b: i32, t: f64| a + (f64::from(b - a) * t) as i32;
            let [x, y] = [between(left, right, random.unit()), between(top, bottom, random.unit())];
            let corners = match (random.unit() < 0.5, random.unit() < 0.5) {
                (false, false) => [[left, top], [right, y], [x, bottom]],
                (true, false) => [[right, top], [x, bottom], [left, y]],
                (false, true) => [[left, bottom], [x, top], [right, y]],
                (true, true) => [[right, bottom], [left, y], [x, top]],
            };
            let corners = corners.map(|[x, y]| ScreenPoint { x, y, depth: random.unit() as f32 });
            ScreenPolygon { front: visible, corners: corners.to_vec() }
        });
        PolygonScene { width: self.width, height: self.height, polygons: polygons.collect() }
    }

    fn next_box(&self, random: &mut Random) -> BoundingBox {
        let visible = random.unit() < self.visible;
        let screen = [self.width, self.height];
        let [x, y] = [0, 1].map(|axis| {
            let pixels = f64::from(screen[axis]);
            let size = self.size[axis].clamp(1.0, pixels);
            let extent =
                (size.floor() as i32 + i32::from(random.unit() < size.fract())).min(screen[axis] as i32);
            let middle = match self.spread[axis] {
                Spread::Uniform => random.unit() * pixels,
                Spread::Normal { deviation } => 0.5 * pixels + random.normal() * deviation,
            };
            let first =
                (middle - 0.5 * f64::from(extent)).floor().clamp(0.0, pixels - f64::from(extent)) as i32;
            [first, first + extent - 1]
        });
        BoundingBox { visible, pixels: PixelBox { x0: x[0], y0: y[0], x1: x[1], y1: y[1] } }
    }
}

/// Random numbers.
struct Random(Pcg64Mcg);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// Mean 0, deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distribution() -> Distribution {
        Distribution {
            width: 768,
            height: 512,
            polygons: 20_000,
            visible: 0.67,
            size: [3.8, 12.0],
            spread: [Spread::Normal { deviation: 30.0 }, Spread::Uniform],
            seed: 1,
        }
    }

    #[test]
    fn the_scene_has_the_stated_distributions() {
        let boxes = distribution().boxes().boxes;
        let count = boxes.len() as f64;
        let mean = |f: &dyn Fn(&BoundingBox) -> f64| boxes.iter().map(f).sum::<f64>() / count;
        let middle = |b: &BoundingBox| f64::from(b.pixels.x0 + b.pixels.x1 + 1) * 0.5;
        assert!((mean(&|b| f64::from(u8::from(b.visible))) - 0.67).abs() < 0.01);
        assert!((mean(&|b| b.pixels.width() as f64) - 3.8).abs() < 0.01);
        assert_eq!(mean(&|b| b.pixels.height() as f64), 12.0);
        assert!((mean(&middle) - 384.0).abs() < 1.0);
        assert!((mean(&|b| (middle(b) - 384.0).powi(2)).sqrt() - 30.0).abs() < 0.5);
        assert!((mean(&|b| f64::from(b.pixels.y0)) - 250.0).abs() < 3.0);
    }

    #[test]
    fn triangles_fill_their_boxes() {
        let distribution = Distribution { polygons: 500, ..distribution() };
        let (boxes, triangles) = (distribution.boxes(), distribution.triangles());
        assert_eq!(triangles.boxes(), boxes);
    }

    #[test]
    fn a_seed_is_a_scene() {
        let scene = distribution().boxes();
        assert_eq!(scene, distribution().boxes());
        assert_ne!(scene, Distribution { seed: 2, ..distribution() }.boxes());
        // The generator and the order of its use are part of the scene.
        assert_eq!(scene.boxes[0].pixels, PixelBox { x0: 402, y0: 317, x1: 405, y1: 328 });
    }
}
