//! Numbers of 64 bits as `f32` and an offset: [`Doubles`].

use crate::Attribute;
use crate::loops::prelude::*;

/// Whole numbers up to this are all `f32`; up to [`WHOLE`] all `f64`.
const WHOLE_SINGLE: f64 = (1u32 << 24) as f64;

/// See [`WHOLE_SINGLE`].
const WHOLE: f64 = (1u64 << 53) as f64;

/// Rounding that is at most this part of the spread of the values cannot be seen: a smooth colour map has 4080 colours.
const UNSEEN: f64 = 1.0 / 65536.0;

/// What has to be known of numbers in `f64` to choose an offset for them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubles {
    least: f64,
    most: f64,
    /// The largest difference between a number and the nearest `f32`.
    rounding: f64,
    are_whole: bool,
}

impl Default for Doubles {
    fn default() -> Self {
        Self { least: f64::INFINITY, most: f64::NEG_INFINITY, rounding: 0.0, are_whole: true }
    }
}

impl Doubles {
    /// Of all numbers of a list.
    pub fn of(values: &[f64]) -> Self {
        let chunks = values.par_chunks(1 << 15);
        chunks
            .map(|chunk| chunk.iter().fold(Self::default(), |all, &v| all.with(v)))
            .reduce(Self::default, Self::and)
    }

    /// And this number. What is not finite does not count.
    #[inline]
    pub fn with(self, value: f64) -> Self {
        if !value.is_finite() {
            return self;
        }
        Self {
            least: self.least.min(value),
            most: self.most.max(value),
            rounding: self.rounding.max((value - f64::from(value as f32)).abs()),
            are_whole: self.are_whole && value.trunc() == value,
        }
    }

    /// Both.
    pub fn and(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            rounding: self.rounding.max(other.rounding),
            are_whole: self.are_whole && other.are_whole,
        }
    }

    /// The [offset](Attribute::offset): the least of the numbers, or 0 if `f32` holds the numbers themselves exactly or so well that
    /// no difference can be seen. Whole numbers are exact if any offset makes them so.
    pub fn offset(&self) -> f64 {
        let spread = self.most - self.least;
        let is_exact = self.are_whole && spread <= WHOLE_SINGLE;
        let is_better = self.rounding > spread * UNSEEN || (is_exact && self.rounding > 0.0);
        if is_better && (spread as f32).is_finite() { self.least } else { 0.0 }
    }

    /// The offset of values with this name. Those of a part of a model have none, with a warning where that is seen: one that each rank
    /// chose from its own values would make pictures depend on the number of ranks.
    pub fn offset_for(&self, name: &str, is_part: bool) -> (f64, Option<String>) {
        let offset = self.offset();
        if !is_part || offset == 0.0 {
            return (offset, None);
        }
        let is_seen = self.most > self.least;
        let text = || format!("values of {name:?} are rounded to 24 bits, as all are of a model in parts");
        (0.0, is_seen.then(text))
    }

    /// The warning that they are whole, and some of them are rounded in spite of the offset. Beyond 2^53 every `f64` is whole, so
    /// that only the type tells.
    pub fn warning(&self, name: &str, are_integers: bool) -> Option<String> {
        let is_exact = self.rounding == 0.0 || self.most - self.least <= WHOLE_SINGLE;
        let is_rounded = match self.most.abs().max(self.least.abs()) <= WHOLE {
            true => !is_exact,
            false => are_integers,
        };
        (self.are_whole && self.least <= self.most && is_rounded)
            .then(|| format!("whole numbers above 16777216 of {name:?} are rounded to 24 bits"))
    }
}

/// A number as it is stored with an offset.
#[inline]
pub(crate) fn stored(value: f64, offset: f64) -> f32 {
    // Without an offset nothing is added: -0 keeps its sign.
    if offset == 0.0 { value as f32 } else { (value - offset) as f32 }
}

/// Numbers as they are stored with an offset.
pub(crate) fn all_stored(values: &[f64], offset: f64) -> Vec<f32> {
    values.par_iter().with_min_len(1 << 12).map(|&value| stored(value, offset)).collect()
}

/// Numbers, stored, and their offset.
pub(crate) fn store(values: &[f64]) -> (Vec<f32>, f64) {
    let offset = Doubles::of(values).offset();
    (all_stored(values, offset), offset)
}

impl Attribute {
    /// A value as the file has it.
    pub fn full(&self, value: f32) -> f64 {
        self.offset + f64::from(value)
    }

    /// Stores values with another offset.
    pub fn set_offset(&mut self, offset: f64) {
        if self.offset == offset {
            return;
        }
        let old = std::mem::replace(&mut self.offset, offset);
        self.values
            .par_iter_mut()
            .with_min_len(1 << 12)
            .for_each(|value| *value = stored(old + f64::from(*value), offset));
    }

    /// Gives attributes of the same name one offset, so that their values can be joined.
    pub(crate) fn agree(all: &mut [&mut Self]) {
        if all.windows(2).all(|pair| pair[0].offset == pair[1].offset) {
            return;
        }
        let of_one = |a: &Self| {
            let values = a.values.par_iter().with_min_len(1 << 12);
            values
                .fold(Doubles::default, |all, &v| all.with(a.full(v)))
                .reduce(Doubles::default, Doubles::and)
        };
        let doubles = all.iter().map(|a| of_one(a)).fold(Doubles::default(), Doubles::and);
        all.iter_mut().for_each(|a| a.set_offset(doubles.offset()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AttributeDomain;

    #[test]
    fn an_offset_only_where_it_is_seen() {
        let offset = |values: &[f64]| store(values).1;
        // What f32 holds, and what it rounds unseen.
        assert_eq!(offset(&[]), 0.0);
        assert_eq!(offset(&[f64::NAN, 1e9, 3e9]), 0.0);
        assert_eq!(offset(&[0.1, 0.2, 0.9]), 0.0);
        assert_eq!(offset(&[-1e300, 1e300]), 0.0);
        assert_eq!(offset(&[1.0, 5e9, 7e9 + 1.0]), 0.0);
        // Whole numbers that become exact, and those that are near each other.
        assert_eq!(offset(&[16_777_217.0, 16_877_219.0]), 16_777_217.0);
        assert_eq!(offset(&[1e9 + 0.004, 1e9, f64::INFINITY]), 1e9);
        assert_eq!(offset(&[1013.25, 1013.2501]), 1013.25);
    }

    #[test]
    fn values_come_back() {
        let values: Vec<f64> = (0..1000).map(|i| 1e9 + 0.001 * f64::from(i)).collect();
        let (singles, offset) = store(&values);
        for (value, single) in values.iter().zip(singles) {
            assert!((offset + f64::from(single) - value).abs() < 2e-7, "{value}");
        }
    }

    #[test]
    fn integers_that_stay_rounded_are_told() {
        let is_told =
            |values: &[f64], are_integers| Doubles::of(values).warning("id", are_integers).is_some();
        let of = |values: &[f64]| is_told(values, true);
        assert!(!of(&[]) && !of(&[16_777_217.0]) && !of(&[0.5, 16_777_217.0]) && !of(&[0.0, 33_554_432.0]));
        assert!(
            of(&[0.0, 33_554_433.0]) && of(&[1e17, 1e17 + 16.0]) && !is_told(&[1e17, 1e17 + 16.0], false)
        );
    }

    #[test]
    fn joined_attributes_have_one_offset() {
        let attribute = |values: &[f64]| {
            let (values, offset) = store(values);
            Attribute { name: "id".into(), domain: AttributeDomain::Vertex, values, offset, component: None }
        };
        let (mut a, mut b) = (attribute(&[16_777_217.0, 16_777_219.0]), attribute(&[5.0, 6.0]));
        Attribute::agree(&mut [&mut a, &mut b]);
        assert_eq!(a.offset, b.offset);
        let full = |a: &Attribute| a.values.iter().map(|&v| a.full(v)).collect::<Vec<_>>();
        assert_eq!(full(&b), [5.0, 6.0]);
    }
}
