//! Textures: pictures on surfaces, with their mipmaps.

use std::sync::{LazyLock, OnceLock};

use tercio_mesh::checksum;
use tercio_mesh::loops::prelude::*;

use crate::color::srgb_to_linear;

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// sRGB colours and linear alpha.
    Srgb,
    /// Linear numbers: directions, heights, roughness, and the like. Alpha is a fourth number, which does not weight the
    /// others.
    Linear,
}

/// One picture of a [`Texture`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level<'a> {
    /// Texels in a row; at least 1.
    pub width: u32,
    /// Rows; at least 1.
    pub height: u32,
    /// The texels, row by row, the upper row first: linear numbers as shares of 65535. Colours are premultiplied by their
    /// alpha.
    pub texels: &'a [[u16; 4]],
}

/// The most pictures of a [`Texture`]: edges are at most [`MAX_EDGE`].
pub const MAX_LEVELS: usize = MAX_EDGE.ilog2() as usize + 1;

/// The sizes of the pictures of a [`Texture`], the largest first, as vectors; what is beyond the last one has its size.
#[derive(Clone, Copy, Debug)]
pub struct LevelTable {
    /// Texels in a row.
    pub width: [i32; MAX_LEVELS],
    /// Rows.
    pub height: [i32; MAX_LEVELS],
    /// The first texel in [`Texture::texels`].
    pub first: [i32; MAX_LEVELS],
}

/// A picture and its mipmaps: pictures of half the size (rounded down), a quarter, and so on, down to a single texel. A texel
/// is the mean of the area that it covers in the picture before.
#[derive(Clone, Debug)]
pub struct Texture {
    texels: Vec<[u16; 4]>,
    table: LevelTable,
    level_count: usize,
    encoding: Encoding,
    is_opaque: bool,
    /// [`Texture::checksum`], once it was asked for.
    checksum: OnceLock<u64>,
}

/// Most texels along an edge, so that coordinates of texels are exact enough in `f32`.
pub const MAX_EDGE: u32 = 1 << 15;

impl Texture {
    /// From the rows of a picture with 8 bits per channel (red, green, blue, alpha), the upper row first.
    ///
    /// # Panics
    /// If width or height is 0 or above [`MAX_EDGE`], or the number of pixels is not their product.
    pub fn from_rgba8(width: u32, height: u32, pixels: &[[u8; 4]], encoding: Encoding) -> Self {
        static LINEAR: LazyLock<[u16; 256]> =
            LazyLock::new(|| std::array::from_fn(|i| decode_srgb(i as f64 / 255.0)));
        let linear = &*LINEAR;
        Self::new(width, height, pixels, encoding, |&[r, g, b, a]| {
            let a = u16::from(a) * 257;
            match encoding {
                Encoding::Linear => [u16::from(r) * 257, u16::from(g) * 257, u16::from(b) * 257, a],
                Encoding::Srgb => {
                    let [r, g, b] = [r, g, b].map(|c| premultiplied(linear[usize::from(c)], a));
                    [r, g, b, a]
                }
            }
        })
    }

    /// From the rows of a picture with 16 bits per channel; see [`Texture::from_rgba8`].
    ///
    /// # Panics
    /// Likewise.
    pub fn from_rgba16(width: u32, height: u32, pixels: &[[u16; 4]], encoding: Encoding) -> Self {
        Self::new(width, height, pixels, encoding, |&[r, g, b, a]| match encoding {
            Encoding::Linear => [r, g, b, a],
            Encoding::Srgb => {
                let [r, g, b] = [r, g, b].map(|c| premultiplied(decode_srgb(f64::from(c) / 65535.0), a));
                [r, g, b, a]
            }
        })
    }

    fn new<P: Sync>(
        width: u32,
        height: u32,
        pixels: &[P],
        encoding: Encoding,
        texel: impl Fn(&P) -> [u16; 4] + Sync + Send,
    ) -> Self {
        let edges = 1..=MAX_EDGE;
        assert!(edges.contains(&width) && edges.contains(&height), "{width}x{height} texels");
        assert_eq!(pixels.len() as u64, u64::from(width) * u64::from(height), "texels of {width}x{height}");
        let (mut sizes, mut count) = (vec![[width, height]], pixels.len());
        while let Some(&[width, height]) = sizes.last().filter(|size| **size != [1, 1]) {
            let smaller = [(width / 2).max(1), (height / 2).max(1)];
            count += smaller[0] as usize * smaller[1] as usize;
            sizes.push(smaller);
        }
        let mut texels = vec![[0; 4]; count];
        const CHUNK: usize = 1 << 14;
        let chunks = texels[..pixels.len()].par_chunks_mut(CHUNK).zip(pixels.par_chunks(CHUNK));
        chunks.for_each(|(to, from)| to.iter_mut().zip(from).for_each(|(to, from)| *to = texel(from)));
        let is_opaque = texels[..pixels.len()].par_iter().with_min_len(CHUNK).all(|t| t[3] == u16::MAX);
        let zero = [0; MAX_LEVELS];
        let mut table = LevelTable { width: zero, height: zero, first: zero };
        let mut first = 0;
        for number in 0..MAX_LEVELS {
            let [width, height] = sizes[number.min(sizes.len() - 1)];
            (table.width[number], table.height[number]) = (width as i32, height as i32);
            table.first[number] = first as i32;
            if number + 1 < sizes.len() {
                let (before, after) = texels.split_at_mut(first + width as usize * height as usize);
                Level { width, height, texels: &before[first..] }.shrink(after);
                first = before.len();
            }
        }
        Self { texels, table, level_count: sizes.len(), encoding, is_opaque, checksum: OnceLock::new() }
    }

    /// The picture and its mipmaps, the largest first.
    pub fn levels(&self) -> Vec<Level<'_>> {
        (0..self.level_count).map(|number| self.level(number)).collect()
    }

    /// The number of pictures, at most [`MAX_LEVELS`].
    pub fn level_count(&self) -> usize {
        self.level_count
    }

    /// The picture (0) or one of its mipmaps; the last one if there are fewer.
    pub fn level(&self, number: usize) -> Level<'_> {
        let number = number.min(self.level_count - 1);
        let [width, height, first] =
            [self.table.width, self.table.height, self.table.first].map(|of| of[number] as usize);
        Level {
            width: width as u32,
            height: height as u32,
            texels: &self.texels[first..first + width * height],
        }
    }

    /// The texels of all pictures, the largest first.
    pub fn texels(&self) -> &[[u16; 4]] {
        &self.texels
    }

    /// The sizes of all pictures, and where their texels are.
    pub fn table(&self) -> &LevelTable {
        &self.table
    }

    /// What its numbers mean.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Is the alpha of all texels 1?
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// A hash of its texels and what their numbers mean: equal for equal textures, almost certainly different for others.
    pub fn checksum(&self) -> u64 {
        *self.checksum.get_or_init(|| {
            // Smaller levels follow from the first one.
            let Level { width, height, texels } = self.level(0);
            let texels = checksum::of(bytemuck::cast_slice(texels));
            let all = [u64::from(width), u64::from(height), self.encoding as u64, texels];
            checksum::of(bytemuck::cast_slice(&all))
        })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.texels[..])
    }

    /// Bytes that a texture of this size takes.
    pub fn needed_bytes(width: u32, height: u32) -> u64 {
        // Each level has at most a quarter of the texels of the one before; if it is a single row or column, half.
        let texels = u64::from(width) * u64::from(height);
        8 * (texels + texels / 3 + u64::from(width.max(height)))
    }
}

fn decode_srgb(srgb: f64) -> u16 {
    (srgb_to_linear(srgb) * 65535.0 + 0.5) as u16
}

fn premultiplied(c: u16, alpha: u16) -> u16 {
    ((u32::from(c) * u32::from(alpha) + 32767) / 65535) as u16
}

/// The texels of a row or column of `from` that number `to` of `count` smaller ones covers: the first one, and the weights of
/// it and of up to two more, in shares of `from`.
fn covered(to: u32, from: u32, count: u32) -> (u32, [u64; 3]) {
    let (begin, end) = (u64::from(to) * u64::from(from), u64::from(to + 1) * u64::from(from));
    let count = u64::from(count);
    let first = begin / count;
    let weight = |k: u64| {
        let (left, right) = ((first + k) * count, (first + k + 1) * count);
        right.min(end).saturating_sub(left.max(begin))
    };
    (first as u32, [weight(0), weight(1), weight(2)])
}

impl Level<'_> {
    /// Writes the next mipmap, whose texels are the first of `to`.
    fn shrink(&self, to: &mut [[u16; 4]]) {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        // The weights of a texel add up to the area of this level.
        let area = u64::from(self.width) * u64::from(self.height);
        let columns: Vec<_> = (0..width).map(|x| covered(x, self.width, width)).collect();
        let texels = &mut to[..width as usize * height as usize];
        texels.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            let (first_row, rows) = covered(y as u32, self.height, height);
            for (texel, (first_column, columns)) in row.iter_mut().zip(&columns) {
                let mut sum = [area / 2; 4];
                for (y, of_row) in (first_row..).zip(rows).filter(|(_, weight)| *weight > 0) {
                    for (x, of_column) in (*first_column..).zip(columns).filter(|(_, weight)| **weight > 0) {
                        let from = self.texels[y as usize * self.width as usize + x as usize];
                        (0..4).for_each(|k| sum[k] += of_row * of_column * u64::from(from[k]));
                    }
                }
                *texel = sum.map(|c| (c / area) as u16);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn colours_are_linear_and_premultiplied() {
        let pixels = [[255, 188, 0, 255], [255, 188, 0, 128]];
        let texture = Texture::from_rgba8(2, 1, &pixels, Encoding::Srgb);
        let linear = (srgb_to_linear(188.0 / 255.0) * 65535.0).round() as u16;
        let half = |c: u16| (f64::from(c) * 128.0 / 255.0).round() as u16;
        let expected = [[65535, linear, 0, 65535], [half(65535), half(linear), 0, half(65535)]];
        assert_eq!(texture.levels()[0].texels, expected);
        assert!(!texture.is_opaque());
        let wide = pixels.map(|p| p.map(|c| u16::from(c) * 257));
        assert_eq!(Texture::from_rgba16(2, 1, &wide, Encoding::Srgb).levels(), texture.levels());
        let data = Texture::from_rgba8(2, 1, &pixels, Encoding::Linear);
        assert_eq!(data.levels()[0].texels, wide);
    }

    #[test]
    fn an_even_picture_has_the_means_of_four() {
        let pixels: Vec<[u8; 4]> = (0..16).map(|i| [10 * i, 0, 255, 255]).collect();
        let texture = Texture::from_rgba8(4, 4, &pixels, Encoding::Linear);
        assert_eq!(texture.levels().len(), 3);
        let mean = |i: f64| (257.0 * 10.0 * i).round() as u16;
        let reds: Vec<u16> = texture.levels()[1].texels.iter().map(|t| t[0]).collect();
        assert_eq!(reds, [mean(2.5), mean(4.5), mean(10.5), mean(12.5)]);
        assert_eq!(texture.levels()[2].texels, [[mean(7.5), 0, 65535, 65535]]);
    }

    proptest! {
        #[test]
        fn every_level_has_the_mean_of_the_picture(
            width in 1u32..40, height in 1u32..40, seed in proptest::array::uniform32(0u16..),
        ) {
            let count = (width * height) as usize;
            let pixels: Vec<[u16; 4]> = (0..count)
                .map(|i| [seed[i % 32].rotate_left((i / 32) as u32), seed[(i * 7) % 31], i as u16, 65535])
                .collect();
            let texture = Texture::from_rgba16(width, height, &pixels, Encoding::Linear);
            let levels = texture.levels();
            let mean = |level: &Level, k: usize| {
                level.texels.iter().map(|t| f64::from(t[k])).sum::<f64>() / level.texels.len() as f64
            };
            for (number, level) in levels.iter().enumerate() {
                prop_assert_eq!(level.texels.len() as u32, level.width * level.height);
                for k in 0..4 {
                    let error = mean(level, k) - mean(&levels[0], k);
                    prop_assert!(error.abs() <= 0.5 * number as f64 + 1e-6, "level {number}: {error}");
                }
            }
            let last = levels.last().map(|l| (l.width, l.height));
            prop_assert_eq!(last, Some((1, 1)));
            prop_assert!(texture.bytes() as u64 <= Texture::needed_bytes(width, height));
        }
    }
}
