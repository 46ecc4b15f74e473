//! A decoded picture, and what its numbers may mean.

use tercio_mesh::TextureChannel;
use tercio_mesh::loops::prelude::*;
use tercio_scene::Texture;
use tercio_scene::texture::Encoding;

use super::bump;

/// Differences of channels up to this, of 65535, do not make a texel coloured: compression adds as much to grey pictures.
const GREY: u16 = 16 * 257;

/// The rows of a picture, the upper row first: red, green, blue and alpha of each texel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// With 8 bits per channel.
    Eight(Vec<u8>),
    /// With 16 bits per channel.
    Sixteen(Vec<u16>),
}

/// A decoded picture.
#[derive(Clone, Debug)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Pixels,
    facts: Facts,
    /// Whether its file ends before the picture does, or at least before its end is said.
    pub ends_early: bool,
}

/// Least and largest values of each channel, of 65535, and the number of texels of some kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Facts {
    least: [u16; 4],
    largest: [u16; 4],
    coloured: u64,
    normals: u64,
}

impl Facts {
    const NONE: Self = Self { least: [u16::MAX; 4], largest: [0; 4], coloured: 0, normals: 0 };

    fn of(texel: [u16; 4]) -> Self {
        let [r, g, b, _] = texel;
        let coloured = r.max(g).max(b) - r.min(g).min(b) > GREY;
        let [x, y, z] = [r, g, b].map(|c| f32::from(c) / 32767.5 - 1.0);
        let normals = z > 0.0 && (0.64..1.44).contains(&(x * x + y * y + z * z));
        Self { least: texel, largest: texel, coloured: coloured.into(), normals: normals.into() }
    }

    fn with(self, other: Self) -> Self {
        Self {
            least: std::array::from_fn(|k| self.least[k].min(other.least[k])),
            largest: std::array::from_fn(|k| self.largest[k].max(other.largest[k])),
            coloured: self.coloured + other.coloured,
            normals: self.normals + other.normals,
        }
    }
}

impl Picture {
    /// # Panics
    /// If the number of pixels is not the product of width and height.
    pub fn new((width, height): (u32, u32), pixels: Pixels) -> Self {
        let mut picture = Self { width, height, pixels, facts: Facts::NONE, ends_early: false };
        picture.facts = match &picture.pixels {
            Pixels::Eight(p) => facts(p.as_chunks().0, |texel: [u8; 4]| texel.map(|c| u16::from(c) * 257)),
            Pixels::Sixteen(p) => facts(p.as_chunks().0, |texel: [u16; 4]| texel),
        };
        picture
    }

    /// Is the alpha of all texels 1?
    pub fn is_opaque(&self) -> bool {
        self.facts.least[3] == u16::MAX
    }

    /// Is the alpha of all texels 0?
    pub fn is_invisible(&self) -> bool {
        self.facts.largest[3] == 0
    }

    fn texels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Are more than a few texels not grey?
    fn is_coloured(&self) -> bool {
        self.facts.coloured * 64 >= self.texels()
    }

    /// Is its opacity in the alpha channel, not in the red one? So it is if alpha varies and the colours are constant or not
    /// grey: an opacity is neither.
    pub fn has_opacity_in_alpha(&self) -> bool {
        let Facts { least, largest, .. } = self.facts;
        let is_constant = least[..3] == largest[..3];
        least[3] != largest[3] && (is_constant || self.is_coloured())
    }

    /// Does it hold normals, not heights? So it does if it is coloured and nine tenths of the texels are directions away from
    /// the surface, about 1 long.
    pub fn holds_normals(&self) -> bool {
        self.is_coloured() && self.facts.normals * 10 >= self.texels() * 9
    }

    /// The texture.
    pub fn texture(&self, encoding: Encoding) -> Texture {
        let (width, height) = (self.width, self.height);
        match &self.pixels {
            Pixels::Eight(p) => Texture::from_rgba8(width, height, p.as_chunks().0, encoding),
            Pixels::Sixteen(p) => Texture::from_rgba16(width, height, p.as_chunks().0, encoding),
        }
    }

    /// The texture of normals of the heights: the mean of the channels is the height.
    pub fn normals_of_heights(&self) -> Texture {
        let height = |y: u32, x: u32| {
            let at = 4 * (y as usize * self.width as usize + x as usize);
            match &self.pixels {
                Pixels::Eight(p) => p[at..at + 3].iter().map(|&c| f32::from(c)).sum::<f32>() / (3.0 * 255.0),
                Pixels::Sixteen(p) => {
                    p[at..at + 3].iter().map(|&c| f32::from(c)).sum::<f32>() / (3.0 * 65535.0)
                }
            }
        };
        let normals = bump::normals(self.width, self.height, height);
        Texture::from_rgba16(self.width, self.height, &normals, Encoding::Linear)
    }

    /// The same colours with an alpha of 1.
    pub fn into_opaque(mut self) -> Self {
        match &mut self.pixels {
            Pixels::Eight(p) => p.as_chunks_mut::<4>().0.par_iter_mut().for_each(|texel| texel[3] = u8::MAX),
            Pixels::Sixteen(p) => {
                p.as_chunks_mut::<4>().0.par_iter_mut().for_each(|texel| texel[3] = u16::MAX)
            }
        }
        (self.facts.least[3], self.facts.largest[3]) = (u16::MAX, u16::MAX);
        self
    }

    /// A copy whose colours are multiplied by `gain` and added to `base` as they are in the file, between black and white.
    /// With a `channel`, all its colours are that channel, and it is opaque.
    pub fn adjusted(&self, channel: Option<TextureChannel>, gain: f32, base: f32) -> Self {
        let level = |c: u16| ((f32::from(c) * gain + base * 65535.0).clamp(0.0, 65535.0) + 0.5) as u16;
        let texel = |[r, g, b, a]: [u16; 4]| {
            let grey = |c: u16| [c, c, c, u16::MAX];
            let [r, g, b, a] = match channel {
                None => [r, g, b, a],
                Some(TextureChannel::Red) => grey(r),
                Some(TextureChannel::Green) => grey(g),
                Some(TextureChannel::Blue) => grey(b),
                Some(TextureChannel::Alpha) => grey(a),
                Some(TextureChannel::Luminance) => {
                    grey(((u32::from(r) + u32::from(g) + u32::from(b) + 1) / 3) as u16)
                }
            };
            [level(r), level(g), level(b), a]
        };
        let pixels: Vec<u16> = match &self.pixels {
            Pixels::Eight(p) => {
                let wide = p.as_chunks().0.par_iter().map(|t: &[u8; 4]| texel(t.map(|c| u16::from(c) * 257)));
                wide.flatten_iter().collect()
            }
            Pixels::Sixteen(p) => {
                p.as_chunks().0.par_iter().map(|t: &[u16; 4]| texel(*t)).flatten_iter().collect()
            }
        };
        Self::new((self.width, self.height), Pixels::Sixteen(pixels))
    }

    /// The texture whose red channel is the alpha of this picture.
    pub fn texture_of_alpha(&self) -> Texture {
        let (width, height) = (self.width, self.height);
        match &self.pixels {
            Pixels::Eight(p) => {
                let alpha: Vec<[u8; 4]> =
                    p.as_chunks().0.par_iter().map(|&[_, _, _, a]| [a, a, a, u8::MAX]).collect();
                Texture::from_rgba8(width, height, &alpha, Encoding::Linear)
            }
            Pixels::Sixteen(p) => {
                let alpha: Vec<[u16; 4]> =
                    p.as_chunks().0.par_iter().map(|&[_, _, _, a]| [a, a, a, u16::MAX]).collect();
                Texture::from_rgba16(width, height, &alpha, Encoding::Linear)
            }
        }
    }
}

fn facts<C: Copy + Sync>(pixels: &[[C; 4]], texel: impl Fn([C; 4]) -> [u16; 4] + Sync + Send) -> Facts {
    let of_chunk =
        |chunk: &[[C; 4]]| chunk.iter().fold(Facts::NONE, |all, &pixel| all.with(Facts::of(texel(pixel))));
    pixels.par_chunks(1 << 14).map(of_chunk).reduce(|| Facts::NONE, Facts::with)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[[u8; 4]]) -> Picture {
        Picture::new((pixels.len() as u32, 1), Pixels::Eight(pixels.concat()))
    }

    #[test]
    fn opacity_is_in_alpha_where_the_colours_cannot_be_it() {
        assert!(picture(&[[255, 255, 255, 0], [255; 4]]).has_opacity_in_alpha());
        assert!(picture(&[[9, 200, 3, 0], [10, 150, 0, 255]]).has_opacity_in_alpha());
        assert!(!picture(&[[0, 0, 0, 0], [255; 4]]).has_opacity_in_alpha());
        assert!(!picture(&[[0, 0, 0, 255], [255; 4]]).has_opacity_in_alpha());
        assert!(!picture(&[[7, 200, 0, 128], [255, 0, 0, 128]]).has_opacity_in_alpha());
        let texture = picture(&[[255, 255, 255, 3], [255; 4]]).texture_of_alpha();
        assert_eq!(texture.levels()[0].texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [3 * 257, 65535]);
    }

    #[test]
    fn normals_are_told_from_heights_and_photographs() {
        assert!(picture(&[[128, 128, 255, 255], [200, 128, 230, 255]]).holds_normals());
        assert!(!picture(&[[128, 128, 128, 255], [200, 200, 200, 255]]).holds_normals());
        // Grey of this level would be a direction, too.
        assert!(!picture(&[[200; 4]]).holds_normals());
        assert!(!picture(&[[120, 80, 40, 255], [200, 150, 90, 255]]).holds_normals());
    }

    #[test]
    fn numbers_are_scaled_and_channels_taken() {
        let picture = picture(&[[0, 51, 102, 204], [255, 128, 7, 0]]);
        let texels = |channel, gain, base| {
            picture.adjusted(channel, gain, base).texture(Encoding::Linear).levels()[0].texels.to_vec()
        };
        let grey = |level: u16| [level * 257, level * 257, level * 257, 65535];
        assert_eq!(texels(Some(TextureChannel::Red), 1.0, 0.0), [grey(0), grey(255)]);
        assert_eq!(texels(Some(TextureChannel::Green), 1.0, 0.0), [grey(51), grey(128)]);
        assert_eq!(texels(Some(TextureChannel::Blue), 1.0, 0.0), [grey(102), grey(7)]);
        assert_eq!(texels(Some(TextureChannel::Alpha), 1.0, 0.0), [grey(204), grey(0)]);
        assert_eq!(texels(Some(TextureChannel::Luminance), 1.0, 0.0), [grey(51), grey(130)]);
        // Alpha stays as it is, and what is beyond black and white is cut off.
        let scaled = texels(None, 2.0, -0.2);
        assert_eq!(scaled[0], [0, 51 * 257, 153 * 257, 204 * 257]);
        assert_eq!((scaled[1][0], scaled[1][2], scaled[1][3]), (65535, 0, 0));
        assert_eq!(texels(None, f32::MAX, f32::MAX)[0][0], 65535);
    }

    #[test]
    fn alpha_is_removed_from_all_texels() {
        let hidden = picture(&[[200, 100, 50, 0], [10, 20, 30, 0]]);
        assert!(hidden.is_invisible() && !hidden.is_opaque());
        let opaque = hidden.into_opaque();
        assert!(opaque.is_opaque() && !opaque.is_invisible());
        let expected = picture(&[[200, 100, 50, 255], [10, 20, 30, 255]]).texture(Encoding::Srgb);
        assert_eq!(opaque.texture(Encoding::Srgb).levels(), expected.levels());
        let wide = Picture::new((1, 1), Pixels::Sixteen(vec![1, 2, 3, 4])).into_opaque();
        assert_eq!(wide.texture(Encoding::Linear).levels()[0].texels, [[1, 2, 3, 65535]]);
    }
}
