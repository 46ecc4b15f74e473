//! Unit vectors in 32 bits: the octahedral map, 16 bits per coordinate.
//!
//! Source: Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors" (2014).
//! The greatest error is 0.004 degrees, which no 8-bit picture can show.

/// A unit normal: octahedral coordinates as two signed 16-bit numbers, u in the low half.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct OctNormal(pub u32);

impl OctNormal {
    /// No normal: readers store it where the normal of a file is missing or invalid, until
    /// [`mend_normals`](super::mend_normals) replaces it. No encoded normal has these bits.
    pub const NONE: Self = Self(0x8000_8000);

    /// Encodes a vector of any length, as files hold normals; a zero or non-finite one becomes [`OctNormal::NONE`].
    #[inline]
    pub fn from_vector(normal: [f64; 3]) -> Self {
        let narrow = normal.map(|x| x as f32);
        let sum = narrow[0].abs() + narrow[1].abs() + narrow[2].abs();
        if (1e-30..1e30).contains(&sum) { Self::encode(narrow) } else { Self::from_odd_length(normal) }
    }

    /// As [`OctNormal::from_vector`], for lengths that overflow or underflow `f32`, or nearly.
    #[cold]
    fn from_odd_length(normal: [f64; 3]) -> Self {
        let largest = normal.iter().fold(0.0f64, |a, x| a.max(x.abs()));
        if !normal.iter().all(|x| x.is_finite()) || largest == 0.0 {
            return Self::NONE;
        }
        Self::encode(normal.map(|x| (x / largest) as f32))
    }

    /// Encodes a vector of any length; a zero or non-finite one becomes +z.
    #[inline]
    pub fn encode([x, y, z]: [f32; 3]) -> Self {
        let sum = x.abs() + y.abs() + z.abs();
        if !(sum > 0.0 && sum.is_finite()) {
            return Self(0);
        }
        let (mut u, mut v) = (x / sum, y / sum);
        if z < 0.0 {
            (u, v) = ((1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v));
        }
        // Rounded half away from zero; in `f64` the half is added exactly.
        let q = |t: f32| {
            let t = f64::from(t * 32767.0);
            (t + 0.5f64.copysign(t)) as i32 as i16 as u16 as u32
        };
        Self(q(u) | q(v) << 16)
    }

    /// The vector, not normalised: its coordinates' absolute values add up to 1.
    ///
    /// Its fixed sequence of operations is part of the definition of the picture; the renderer's kernels repeat it.
    #[inline]
    pub fn decode(self) -> [f32; 3] {
        let u = self.0 as u16 as i16 as f32 * (1.0 / 32767.0);
        let v = (self.0 >> 16) as u16 as i16 as f32 * (1.0 / 32767.0);
        let z = (1.0 - u.abs()) - v.abs();
        let fold = (-z).max(0.0);
        let x = if u >= 0.0 { u - fold } else { u + fold };
        let y = if v >= 0.0 { v - fold } else { v + fold };
        [x, y, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_decoded_normal_points_the_same_way(x in -1f32..1., y in -1f32..1., z in -1f32..1.) {
            let v = glam::DVec3::new(x.into(), y.into(), z.into());
            prop_assume!(v.length() > 1e-3);
            let d = OctNormal::encode([x, y, z]).decode();
            let d = glam::DVec3::new(d[0].into(), d[1].into(), d[2].into()).normalize();
            prop_assert!(d.angle_between(v) < 8e-5, "{v} {d}");
        }
    }

    #[test]
    fn a_normal_of_a_file_may_have_any_length_but_zero() {
        let plain = OctNormal::from_vector([1.0, -2.0, 3.0]);
        assert_eq!(plain, OctNormal::encode([1.0, -2.0, 3.0]));
        for length in [1e-300, 1e-46, 1e-38, 1e-30, 1e-10, 1e10, 1e30, 3e38, 1e39, 1e300] {
            assert_eq!(OctNormal::from_vector([length, -2.0 * length, 3.0 * length]), plain, "{length}");
        }
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        for broken in
            [[0.0, -0.0, 0.0], [nan, 0.0, 1.0], [1.0, nan, 0.0], [0.0, 0.0, -infinite], [infinite; 3]]
        {
            assert_eq!(OctNormal::from_vector(broken), OctNormal::NONE, "{broken:?}");
        }
    }

    #[test]
    fn a_zero_normal_points_up() {
        assert_eq!(OctNormal::encode([0.0; 3]).decode(), [0.0, 0.0, 1.0]);
    }
}
