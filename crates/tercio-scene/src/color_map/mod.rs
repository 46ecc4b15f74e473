//! Colours for numbers: [`ColorMap`], [`Scale`], and [`DataColors`], which is all that a surface with data and its scalar bar
//! need to know.
//!
//! ```
//! use tercio_scene::color_map::{ColorMap, DataColors};
//!
//! let map = ColorMap::named("viridis").expect("a known name");
//! let colors = DataColors::new("pressure", map, [100.0, 300.0]);
//! assert_eq!(colors.color(100.0), [68, 1, 84, 255]);
//! assert_eq!(colors.color(f64::NAN), colors.nan);
//! assert_eq!(colors.value_at(0.5), 200.0);
//! ```

mod data_colors;
mod named;
mod parse;
mod scale;

use std::collections::HashSet;

pub use data_colors::{Category, DataColors, Isolines};
pub use parse::ColorMapError;
pub use scale::Scale;

/// Colours of the numbers from 0 to 1; sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorMap {
    name: String,
    /// Positions, which ascend from 0 to 1, and sRGB colours, 0 to 1. At least one.
    points: Vec<(f64, [f64; 3])>,
    is_categorical: bool,
    special: Special,
    annotations: Vec<Annotation>,
}

/// What a colour of a categorical map of ParaView is for.
#[derive(Clone, Debug, PartialEq)]
pub struct Annotation {
    /// The value of the data; `None` if it is no number.
    pub value: Option<f64>,
    /// What it is called; may be empty.
    pub label: String,
}

/// Colours of what is not in the range, sRGB with linear alpha, if a map has its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Special {
    /// Of what is not a number.
    pub nan: Option<[u8; 4]>,
    /// Of values below the range.
    pub below: Option<[u8; 4]>,
    /// Of values above it.
    pub above: Option<[u8; 4]>,
}

impl ColorMap {
    /// A map that is linear in sRGB between `points`: positions, and sRGB components of 0 to 1. Positions are brought to 0 to 1,
    /// so that only their ratios count.
    ///
    /// # Errors
    /// If there is no point, a number is not finite, a component is not within 0 to 1, or positions do not ascend. Two points may
    /// have the same position, for a step.
    pub fn from_points(name: &str, points: &[(f64, [f64; 3])]) -> Result<Self, ColorMapError> {
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(ColorMapError::Empty);
        };
        let is_color = |c: &[f64; 3]| c.iter().all(|c| (0.0..=1.0).contains(c));
        if let Some((_, wrong)) = points.iter().find(|(_, color)| !is_color(color)) {
            return Err(ColorMapError::Component(*wrong));
        }
        let ascends = points.windows(2).all(|p| p[0].0 <= p[1].0);
        let length = last.0 - first.0;
        if !ascends || !length.is_finite() || (points.len() > 1 && length <= 0.0) {
            return Err(ColorMapError::Order);
        }
        let place = |at: f64| if points.len() == 1 { 0.0 } else { (at - first.0) / length };
        let points = points.iter().map(|&(at, color)| (place(at), color)).collect();
        let (special, annotations) = (Special::default(), Vec::new());
        Ok(Self { name: name.to_owned(), points, is_categorical: false, special, annotations })
    }

    /// A map with evenly spaced 8-bit sRGB colours. If it is categorical, each of them has an equal share of 0 to 1; otherwise
    /// they are interpolated.
    ///
    /// # Errors
    /// If there is no colour.
    pub fn from_colors(name: &str, colors: &[[u8; 3]], is_categorical: bool) -> Result<Self, ColorMapError> {
        let color = |c: [u8; 3]| c.map(|c| f64::from(c) / 255.0);
        let points: Vec<_> = colors.iter().enumerate().map(|(i, &c)| (i as f64, color(c))).collect();
        Ok(Self { is_categorical, ..Self::from_points(name, &points)? })
    }

    /// The name that it is known by.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Is it a list of colours that are not interpolated?
    pub fn is_categorical(&self) -> bool {
        self.is_categorical
    }

    /// Its colours of what is not in the range: those that a file of ParaView has.
    pub fn special(&self) -> Special {
        self.special
    }

    /// The values that its first colours are for, one by one: those that a categorical map of ParaView names.
    pub fn annotations(&self) -> &[Annotation] {
        &self.annotations
    }

    /// Annotations without effect: of what is no number, or of a value that another one before them names.
    pub fn idle_annotations(&self) -> impl Iterator<Item = &Annotation> {
        let mut named = HashSet::new();
        // -0 is 0.
        let mut is_new = move |value: f64| named.insert((value + 0.0).to_bits());
        self.annotations.iter().filter(move |annotation| !annotation.value.is_some_and(&mut is_new))
    }

    /// Whether it says for which values its colours are: values that it does not name have none of them.
    pub fn names_values(&self) -> bool {
        self.annotations.iter().any(|annotation| annotation.value.is_some())
    }

    /// The number of colours between which it interpolates, or of categories.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Never: a map has at least one colour.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The same colours in the opposite order; `_r` is appended to its name, or removed.
    pub fn reversed(mut self) -> Self {
        self.points.reverse();
        self.points.iter_mut().for_each(|(at, _)| *at = 1.0 - *at);
        (self.special.below, self.special.above) = (self.special.above, self.special.below);
        match self.name.strip_suffix("_r") {
            Some(name) => self.name = name.to_owned(),
            None => self.name.push_str("_r"),
        }
        self
    }

    /// The sRGB colour, components of 0 to 1, of a number of 0 to 1. Numbers below and above have the colours of the ends; NaN
    /// that of 0.
    pub fn at(&self, position: f64) -> [f64; 3] {
        let t = if position > 0.0 { position.min(1.0) } else { 0.0 };
        if self.is_categorical {
            let last = self.points.len() - 1;
            return self.category(((t * self.points.len() as f64) as usize).min(last));
        }
        // The first point beyond the position; that before it is at or below the position.
        let next = self.points.partition_point(|(at, _)| *at <= t);
        match (self.points.get(next.wrapping_sub(1)), self.points.get(next)) {
            (Some(a), Some(b)) => {
                let share = (t - a.0) / (b.0 - a.0);
                [0, 1, 2].map(|k| a.1[k] + (b.1[k] - a.1[k]) * share)
            }
            (Some(only), None) | (None, Some(only)) => only.1,
            (None, None) => unreachable!("a map has a colour"),
        }
    }

    /// The sRGB colour of a category by its number. A categorical map repeats its colours after the last; of another one, places
    /// are taken so that neighbouring numbers are far from each other, and any number of them is spread evenly.
    pub fn category(&self, number: usize) -> [f64; 3] {
        if self.is_categorical {
            return self.points[number % self.points.len()].1;
        }
        /// The golden section.
        const STEP: f64 = 0.618_033_988_749_894_9;
        let place = number as f64 * STEP;
        self.at(place - place.floor())
    }
}

/// An 8-bit sRGB colour from components of 0 to 1.
fn rounded(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (c * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests;
