//! The reference formulas for textures: what a pixel's footprint on a texture covers, and the filter.

use tercio_scene::{Texture, TextureMap, Wrap};

use crate::conventions::MAX_ANISOTROPY;
use crate::settings::TextureFilter;

/// A point on a surface in texture coordinates, v upwards, and how these change from pixel to pixel.
pub struct TexturePoint {
    pub uv: [f32; 2],
    /// By one pixel to the right.
    pub right: [f32; 2],
    /// By one pixel downwards.
    pub down: [f32; 2],
}

/// Where a texture is sampled for a pixel: at points along a line, each with the same mipmaps.
struct Probes {
    count: u32,
    /// The line, in texture coordinates.
    axis: [f32; 2],
    /// The larger of the mipmaps.
    level: usize,
    /// The share of the next one.
    fraction: f32,
}

/// The colour of a texture at a point, premultiplied if it is one; 0 to 1.
pub fn sample(texture: &Texture, map: &TextureMap, filter: TextureFilter, point: &TexturePoint) -> [f32; 4] {
    let uv = [0, 1].map(|k| point.uv[k] * map.scale[k] + map.offset[k]);
    let [right, down] = [point.right, point.down].map(|d| [0, 1].map(|k| d[k] * map.scale[k]));
    let scaled = |sum: [f32; 4], count: f32| sum.map(|c| c / (65535.0 * count));
    if filter == TextureFilter::Nearest {
        return scaled(nearest(texture, map, uv), 1.0);
    }
    let probes = probes(texture, filter, right, down);
    let mut sum = [0.0; 4];
    for i in 0..probes.count {
        let t = (i as f32 + 0.5) / probes.count as f32 - 0.5;
        let uv = [0, 1].map(|k| uv[k] + probes.axis[k] * t);
        let mut color = bilinear(texture, probes.level, map, uv);
        if probes.fraction > 0.0 {
            let smaller = bilinear(texture, probes.level + 1, map, uv);
            color = lerp(color, smaller, probes.fraction);
        }
        sum = std::array::from_fn(|k| sum[k] + color[k]);
    }
    scaled(sum, probes.count as f32)
}

/// The ellipse that a pixel covers has the axes of the matrix of derivatives, as `major` and `minor`.
fn probes(texture: &Texture, filter: TextureFilter, right: [f32; 2], down: [f32; 2]) -> Probes {
    let largest = texture.level(0);
    let last = texture.level_count() - 1;
    let size = [largest.width as f32, largest.height as f32];
    let mut probes = Probes { count: 1, axis: [0.0; 2], level: 0, fraction: 0.0 };
    if filter == TextureFilter::Bilinear {
        return probes;
    }
    // In texels.
    let [a, b] = [right, down].map(|d| [d[0] * size[0], d[1] * size[1]]);
    let (e, f, g) = (a[0] * a[0] + b[0] * b[0], a[0] * a[1] + b[0] * b[1], a[1] * a[1] + b[1] * b[1]);
    let half = (e - g) * 0.5;
    let square = (e + g) * 0.5 + (half * half + f * f).sqrt();
    let is_finite = square < 1e30;
    if !is_finite {
        probes.level = last;
        return probes;
    }
    let major = square.sqrt();
    if major <= 1.0 {
        return probes;
    }
    let mut width = major;
    if filter == TextureFilter::Anisotropic {
        let minor = (a[0] * b[1] - a[1] * b[0]).abs() / major;
        // No more probes than texels.
        let ratio = major / if minor > 1.0 { minor } else { 1.0 };
        probes.count = ((ratio + 0.5) as u32).clamp(1, MAX_ANISOTROPY);
        width = major / probes.count as f32;
    }
    if probes.count > 1 {
        let [x, y] = if e >= g { [square - g, f] } else { [f, square - e] };
        let unit = major / (x * x + y * y).sqrt();
        probes.axis = [x * unit / size[0], y * unit / size[1]];
    }
    if width > 1.0 {
        // log2 of the width, linear between powers of two.
        let exponent = (width.to_bits() >> 23) - 127;
        probes.level = exponent as usize;
        probes.fraction = width / (1u32 << exponent.min(31)) as f32 - 1.0;
    }
    if probes.level >= last {
        (probes.level, probes.fraction) = (last, 0.0);
    }
    probes
}

fn lerp(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// A texture coordinate, brought into the range from 0 to 1.
fn wrapped(wrap: Wrap, c: f32) -> f32 {
    let c = if c.is_finite() { c } else { 0.0 };
    match wrap {
        Wrap::Repeat => c - c.floor(),
        Wrap::Mirror => {
            let c = c - 2.0 * (c * 0.5).floor();
            if c > 1.0 { 2.0 - c } else { c }
        }
        Wrap::Clamp => c.clamp(0.0, 1.0),
    }
}

/// The index of a texel that may be one outside the picture.
fn index(wrap: Wrap, i: i32, size: u32) -> usize {
    let size = size as i32;
    let wrapped = match wrap {
        Wrap::Repeat if i < 0 => i + size,
        Wrap::Repeat if i >= size => i - size,
        Wrap::Repeat => i,
        Wrap::Mirror | Wrap::Clamp => i.clamp(0, size - 1),
    };
    wrapped as usize
}

fn bilinear(texture: &Texture, level: usize, map: &TextureMap, [u, v]: [f32; 2]) -> [f32; 4] {
    let level = texture.level(level);
    let x = wrapped(map.wrap[0], u) * level.width as f32 - 0.5;
    let y = (1.0 - wrapped(map.wrap[1], v)) * level.height as f32 - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let texel = |right: i32, down: i32| {
        let x = index(map.wrap[0], left as i32 + right, level.width);
        let y = index(map.wrap[1], top as i32 + down, level.height);
        level.texels[y * level.width as usize + x].map(f32::from)
    };
    let upper = lerp(texel(0, 0), texel(1, 0), x - left);
    let lower = lerp(texel(0, 1), texel(1, 1), x - left);
    lerp(upper, lower, y - top)
}

fn nearest(texture: &Texture, map: &TextureMap, [u, v]: [f32; 2]) -> [f32; 4] {
    let level = texture.level(0);
    let x = wrapped(map.wrap[0], u) * level.width as f32;
    let y = (1.0 - wrapped(map.wrap[1], v)) * level.height as f32;
    let [x, y] = [(x, level.width), (y, level.height)].map(|(c, size)| (c as u32).min(size - 1) as usize);
    level.texels[y * level.width as usize + x].map(f32::from)
}
