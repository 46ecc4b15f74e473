//! Light from all around: a panorama, as ambient light and as what smooth surfaces mirror.
//!
//! Source of the diffuse part: Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps"
//! (2001). Of the mirrored part: Karis, "Real shading in Unreal Engine 4" (2013), section "Image-based lighting", with
//! sums in place of random samples; octahedral maps as in Engelhardt and Dachsbacher, "Octahedron environment maps" (2008).

mod mirrored;
mod panorama;

use std::fmt;

use glam::{DMat3, DVec3};

use mirrored::Mirrored;
pub use panorama::{Panorama, PanoramaError};

use crate::{Light, LightSpace};

/// The light of a panorama, prepared for shading. It is fixed in the world and infinitely far away.
#[derive(Clone, PartialEq)]
pub struct Environment {
    diffuse: [Polynomial; 3],
    mirrored: Mirrored,
    sources: Vec<Light>,
}

/// A polynomial of second degree of a unit vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Polynomial {
    /// The constant term.
    pub constant: f64,
    /// Factors of x, y and z.
    pub linear: [f64; 3],
    /// Factors of xx, xy, xz, yy, yz and zz.
    pub quadratic: [f64; 6],
}

impl Polynomial {
    /// Its value for a unit vector.
    pub fn at(&self, n: DVec3) -> f64 {
        let [x, y, z] = n.to_array();
        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
        let linear: f64 = self.linear.iter().zip([x, y, z]).map(|(f, c)| f * c).sum();
        let quadratic: f64 = self.quadratic.iter().zip(products).map(|(f, c)| f * c).sum();
        self.constant + linear + quadratic
    }
}

impl fmt::Debug for Environment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Environment").field("diffuse", &self.diffuse).finish_non_exhaustive()
    }
}

impl Environment {
    /// The light of a panorama, times a strength. The columns of `axes` are the world directions of the panorama's right,
    /// of its up, and of what is behind the viewer: the middle of the panorama lies in the direction of minus the third.
    /// They are orthonormal. Takes a few tenths of a second.
    ///
    /// # Errors
    /// [`PanoramaError::Strength`] unless the strength is 0 or above, and no light of the panorama above 1e6 after it.
    pub fn new(panorama: &Panorama, axes: DMat3, strength: f64) -> Result<Self, PanoramaError> {
        let brightest = strength * panorama.brightest();
        if !(strength >= 0.0 && brightest <= BRIGHTEST) {
            return Err(PanoramaError::Strength { strength, brightest });
        }
        let mut rest = panorama.scaled(strength);
        let source = |(direction, light): (DVec3, [f64; 3])| Light::Directional {
            to_light: axes * direction,
            space: LightSpace::World,
            color: light.map(|c| (c / std::f64::consts::PI) as f32),
        };
        let sources = (0..MOST_SOURCES).map_while(|_| rest.take_source()).map(source).collect();
        Ok(Self { diffuse: diffuse(&rest, axes), mirrored: Mirrored::new(&rest, axes), sources })
    }

    /// Small sources of light that are much brighter than what is around them, such as the sun, as directional lights:
    /// [`Environment::diffuse`] and [`Environment::mirrored`] are without them. Add them to the lights of the scene, where
    /// they cast shadows, too.
    pub fn sources(&self) -> &[Light] {
        &self.sources
    }

    /// The diffuse light of each channel, without that of the [sources](Environment::sources), for a normal in world space, per reflectance: the irradiance divided by pi, of the
    /// panorama's spherical harmonics up to the second degree. Not negative in 98 directions spread over the
    /// sphere: where it would be, the higher degrees have less weight.
    pub fn diffuse(&self) -> &[Polynomial; 3] {
        &self.diffuse
    }

    /// The light from around a direction in world space, a unit vector, as a surface mirrors it that is seen from the front
    /// and has this roughness, 0 to 1. The same on every machine.
    pub fn mirrored(&self, direction: [f32; 3], roughness: f32) -> [f32; 3] {
        self.mirrored.at(direction, roughness)
    }
}

/// Most small sources of light.
const MOST_SOURCES: usize = 4;

/// The brightest light.
const BRIGHTEST: f64 = 1e6;

/// The diffuse light of a panorama.
fn diffuse(panorama: &Panorama, axes: DMat3) -> [Polynomial; 3] {
    // Integrals of the light times the nine functions below.
    let mut sums = [[0.0; 9]; 3];
    panorama.for_each(|direction, solid_angle, color| {
        let values = harmonics(axes * direction);
        for (sums, c) in sums.iter_mut().zip(color) {
            let weighted = f64::from(c) * solid_angle;
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weighted * value);
        }
    });
    sums.map(|sums| {
        let mut weights = [1.0, 2.0 / 3.0, 0.25];
        loop {
            let polynomial = polynomial(&sums, weights);
            if DIRECTIONS.iter().all(|&d| polynomial.at(DVec3::from(d).normalize()) >= 0.0)
                || weights[1] < 0.01
            {
                return polynomial;
            }
            weights = [1.0, weights[1] * 0.97, weights[2] * 0.92];
        }
    })
}

/// Directions in which the diffuse light must not be negative, of any length: those of a cube's corners, edges and faces,
/// and between them.
static DIRECTIONS: [[f64; 3]; 98] = {
    let mut all = [[0.0; 3]; 98];
    let (mut count, mut i) = (0, 0);
    while i < 125 {
        let p = [(i % 5) as f64 - 2.0, (i / 5 % 5) as f64 - 2.0, (i / 25) as f64 - 2.0];
        let is_outside = p[0] * p[0] == 4.0 || p[1] * p[1] == 4.0 || p[2] * p[2] == 4.0;
        if is_outside {
            all[count] = p;
            count += 1;
        }
        i += 1;
    }
    all
};

/// The square roots of 1/(4 pi), 3/(4 pi), 15/(4 pi), 5/(16 pi) and 15/(16 pi).
const FACTORS: [f64; 5] = [
    0.282_094_791_773_878_14,
    0.488_602_511_902_919_9,
    1.092_548_430_592_079_2,
    0.315_391_565_252_520_05,
    0.546_274_215_296_039_6,
];

/// The real spherical harmonics up to the second degree.
fn harmonics(n: DVec3) -> [f64; 9] {
    let [x, y, z] = n.to_array();
    let [a, b, c, d, e] = FACTORS;
    [a, b * x, b * y, b * z, c * x * y, c * x * z, c * y * z, d * (3.0 * z * z - 1.0), e * (x * x - y * y)]
}

/// A weighted sum of harmonics, multiplied out.
fn polynomial(sums: &[f64; 9], [first, second, third]: [f64; 3]) -> Polynomial {
    let [a, b, c, d, e] = FACTORS;
    let axial = third * d * sums[7];
    let across = third * e * sums[8];
    Polynomial {
        constant: first * a * sums[0] - axial,
        linear: [1, 2, 3].map(|k| second * b * sums[k]),
        quadratic: [
            across,
            third * c * sums[4],
            third * c * sums[5],
            -across,
            third * c * sums[6],
            3.0 * axial,
        ],
    }
}

#[cfg(test)]
mod tests;
