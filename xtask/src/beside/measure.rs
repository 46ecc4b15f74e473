//! How far two pictures differ, and where.

use std::fmt::{Display, Formatter};
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use tercio_scene::srgb_to_linear;
use tercio_testkit::Picture;

use super::{SIZE, level};

/// A pixel is at an edge if the ray tracer's picture differs by more than this many levels in the square of 3 x 3
/// pixels around it.
const EDGE: u8 = 16;

/// The picture of the ray tracer, from several rays per pixel.
pub struct Rays {
    /// Linear light, the mean of the rays of a pixel.
    pixels: Vec<[f64; 3]>,
}

impl Rays {
    /// Reads a PPM of 16 bits in linear light with `rays` samples along the edge of a pixel, and averages it.
    pub fn read(path: &Path, rays: u32) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
        let (width, height) = ((SIZE.0 * rays) as usize, (SIZE.1 * rays) as usize);
        let samples = width * height * 3;
        let header = bytes.len().checked_sub(samples * 2).context("POV-Ray's picture is too small")?;
        ensure!(bytes.starts_with(b"P6"), "POV-Ray's picture is no PPM");
        let (samples, _) = bytes[header..].as_chunks::<2>();
        let mut pixels = vec![[0.0; 3]; (SIZE.0 * SIZE.1) as usize];
        for (i, bytes) in samples.iter().enumerate() {
            let (x, y) = (i / 3 % width, i / 3 / width);
            let pixel = y / rays as usize * SIZE.0 as usize + x / rays as usize;
            pixels[pixel][i % 3] += f64::from(u16::from_be_bytes(*bytes));
        }
        let all = 65535.0 * f64::from(rays * rays);
        pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|sum| sum / all));
        Ok(Self { pixels })
    }

    /// As sRGB.
    pub fn encoded(&self) -> Picture {
        let rgba = self.pixels.iter().flat_map(|pixel| {
            let [r, g, b] = pixel.map(level);
            [r, g, b, 255]
        });
        Picture::new(SIZE.0, SIZE.1, rgba.collect())
    }
}

/// How two pictures differ on the pixels that show something, in levels of 255: the largest difference of the channels.
#[derive(Default)]
pub struct Measured {
    /// Pixels that show the scene, and those away from edges among them.
    covered: u64,
    away: Part,
    edges: Part,
    /// How far tercio's picture is moved, pixels to the left and up.
    shift: [f64; 2],
}

/// A part of the pixels.
#[derive(Default)]
struct Part {
    pixels: u64,
    sum: u64,
    largest: u8,
    /// A pixel with the largest difference.
    place: [u32; 2],
    /// Pixels that differ by more than 1, 2, 8 and 32 levels.
    above: [u64; 4],
}

impl Part {
    fn add(&mut self, difference: u8, place: [u32; 2]) {
        self.pixels += 1;
        self.sum += u64::from(difference);
        if difference > self.largest {
            (self.largest, self.place) = (difference, place);
        }
        for (count, least) in self.above.iter_mut().zip([1, 2, 8, 32]) {
            *count += u64::from(difference > least);
        }
    }

    fn mean(&self) -> f64 {
        self.sum as f64 / self.pixels.max(1) as f64
    }

    /// The share above the `i`-th limit, percent.
    fn share(&self, i: usize) -> f64 {
        100.0 * self.above[i] as f64 / self.pixels.max(1) as f64
    }
}

impl Measured {
    /// Compares two pictures of a scene before a background in sRGB.
    pub fn new(ours: &Picture, theirs: &Rays, background: [u8; 3]) -> Result<Self> {
        ensure!((ours.width, ours.height) == SIZE, "tercio's picture has another size");
        let expected = theirs.encoded();
        let at = |picture: &Picture, x: u32, y: u32| {
            let [r, g, b, _] = picture.pixel(x, y).unwrap_or_default();
            [r, g, b]
        };
        let mut measured = Self::default();
        for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
            let (a, b) = (at(ours, x, y), at(&expected, x, y));
            if a == background && b == background {
                continue;
            }
            measured.covered += 1;
            let difference = (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or_default();
            let part = if is_edge(&expected, x, y) { &mut measured.edges } else { &mut measured.away };
            part.add(difference, [x, y]);
        }
        measured.shift = shift(ours, theirs);
        Ok(measured)
    }

    /// The first two lines of a table of [`Measured::row`]s.
    pub fn heading() -> String {
        "| scene | pixels at edges | away from edges: mean | more than 1 | more than 2 | more than 8 | largest | at \
         edges: mean | moved by, pixels |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n"
            .into()
    }

    /// A row of the table.
    pub fn row(&self, title: &str) -> String {
        let at_edges = 100.0 * self.edges.pixels as f64 / self.covered.max(1) as f64;
        let away = &self.away;
        format!(
            "| {title} | {at_edges:.0} % | {:.3} | {:.2} % | {:.2} % | {:.3} % | {} | {:.2} | {:.3}, {:.3} |",
            away.mean(),
            away.share(0),
            away.share(1),
            away.share(2),
            away.largest,
            self.edges.mean(),
            self.shift[0],
            self.shift[1]
        )
    }
}

impl Display for Measured {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (away, edges) = (&self.away, &self.edges);
        write!(
            f,
            "away from edges {} pixels, mean {:.3}, largest {} at {:?}, above 32: {}; at edges {}, mean {:.2}, largest \
             {} at {:?}, above 32: {}",
            away.pixels,
            away.mean(),
            away.largest,
            away.place,
            away.above[3],
            edges.pixels,
            edges.mean(),
            edges.largest,
            edges.place,
            edges.above[3]
        )
    }
}

fn is_edge(picture: &Picture, x: u32, y: u32) -> bool {
    let around = |v: u32, end: u32| v.saturating_sub(1)..=(v + 1).min(end - 1);
    let (mut low, mut high) = ([255; 3], [0; 3]);
    for (i, j) in around(y, SIZE.1).flat_map(|j| around(x, SIZE.0).map(move |i| (i, j))) {
        let pixel = picture.pixel(i, j).unwrap_or_default();
        for k in 0..3 {
            low[k] = pixel[k].min(low[k]);
            high[k] = pixel[k].max(high[k]);
        }
    }
    (0..3).any(|k| high[k] - low[k] > EDGE)
}

/// The movement that explains most of the difference, by least squares: a picture moved by d differs by the product of
/// d with its gradient. Large differences, where other things are visible, do not count.
fn shift(ours: &Picture, theirs: &Rays) -> [f64; 2] {
    const LARGEST: f64 = 0.1;
    let width = SIZE.0 as usize;
    let light = |i: usize| theirs.pixels[i].iter().sum::<f64>() / 3.0;
    let our_light = |i: usize| {
        let channels = &ours.rgba[i * 4..i * 4 + 3];
        channels.iter().map(|c| srgb_to_linear(f64::from(*c) / 255.0)).sum::<f64>() / 3.0
    };
    let (mut xx, mut xy, mut yy, mut xd, mut yd) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for i in (1..SIZE.1 as usize - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x)) {
        let (x, y) = (0.5 * (light(i + 1) - light(i - 1)), 0.5 * (light(i + width) - light(i - width)));
        let difference = our_light(i) - light(i);
        if difference.abs() > LARGEST {
            continue;
        }
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        (xd, yd) = (xd + x * difference, yd + y * difference);
    }
    let determinant = xx * yy - xy * xy;
    [(xd * yy - yd * xy) / determinant, (yd * xx - xd * xy) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth picture whose middle is at a place.
    fn hill(x: f64, y: f64) -> Rays {
        let at = |i: u32| {
            let (dx, dy) = (f64::from(i % SIZE.0) - x, f64::from(i / SIZE.0) - y);
            [(-(dx * dx + dy * dy) / 5000.0).exp(); 3]
        };
        Rays { pixels: (0..SIZE.0 * SIZE.1).map(at).collect() }
    }

    #[test]
    fn a_moved_picture_is_recognised() {
        let moved = shift(&hill(319.7, 240.2).encoded(), &hill(320.0, 240.0));
        assert!((moved[0] - 0.3).abs() < 0.01 && (moved[1] + 0.2).abs() < 0.01, "{moved:?}");
    }

    #[test]
    fn the_same_picture_does_not_differ() {
        let rays = hill(320.0, 240.0);
        let measured = Measured::new(&rays.encoded(), &rays, [0; 3]).expect("pictures of one size");
        assert_eq!((measured.away.sum, measured.edges.sum), (0, 0));
        assert!(measured.away.pixels > 0);
    }
}
