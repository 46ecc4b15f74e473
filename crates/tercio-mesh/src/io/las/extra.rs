//! Extra bytes of points: the values that the record EXTRA_BYTES describes.

use std::ops::Range;

use super::header::{f64_at, u64_at};

/// Bytes of a description.
const DESCRIPTION: usize = 192;
/// Bytes of a value of the types from 1 on: unsigned and signed integers by turns, then floating-point numbers.
const SIZES: [usize; 10] = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8];

/// A number as the file has it, before scale and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Raw {
    Unsigned(u64),
    Signed(i64),
    Real(f64),
}

impl Raw {
    /// Of a type from 1 to 10, in as many bytes as it has.
    fn of(kind: u8, bytes: &[u8]) -> Self {
        let is_signed = matches!(kind, 2 | 4 | 6 | 8);
        let is_negative = is_signed && bytes.last().is_some_and(|b| b & 0x80 != 0);
        let mut all = if is_negative { [0xff; 8] } else { [0; 8] };
        all.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        match kind {
            9 => Self::Real(bytes.first_chunk().map_or(f64::NAN, |&b| f32::from_le_bytes(b).into())),
            10 => Self::Real(f64::from_le_bytes(all)),
            _ if is_signed => Self::Signed(i64::from_le_bytes(all)),
            _ => Self::Unsigned(u64::from_le_bytes(all)),
        }
    }

    /// The value of `no_data`, for which every type has 8 bytes.
    fn no_data(kind: u8, description: &[u8], at: usize) -> Option<Self> {
        Some(match kind {
            // Points have it rounded.
            9 => Self::Real(f64::from(f64_at(description, at)? as f32)),
            10 => Self::Real(f64_at(description, at)?),
            2 | 4 | 6 | 8 => Self::Signed(u64_at(description, at)?.cast_signed()),
            _ => Self::Unsigned(u64_at(description, at)?),
        })
    }
}

/// One value of every point.
#[derive(Debug)]
pub struct Dimension {
    /// That of an attribute.
    pub name: String,
    /// Its first byte in the record of a point.
    at: usize,
    /// The type, from 1 to 10.
    kind: u8,
    scale: f64,
    offset: f64,
    /// Values that are none.
    no_data: Option<Raw>,
}

impl Dimension {
    /// Are the values integers, however large?
    pub fn has_integers(&self) -> bool {
        self.kind <= 8 && self.scale == 1.0
    }

    /// The value of a point; NaN where it has none.
    #[inline]
    pub fn value(&self, record: &[u8]) -> f64 {
        let size = SIZES[usize::from(self.kind) - 1];
        let Some(bytes) = record.get(self.at..).and_then(|rest| rest.get(..size)) else { return f64::NAN };
        let raw = Raw::of(self.kind, bytes);
        if self.no_data == Some(raw) {
            return f64::NAN;
        }
        let number = match raw {
            Raw::Unsigned(number) => number as f64,
            Raw::Signed(number) => number as f64,
            Raw::Real(number) => number,
        };
        number * self.scale + self.offset
    }
}

/// What is described of the extra bytes of a point.
#[derive(Debug, Default)]
pub struct Extra {
    pub dimensions: Vec<Dimension>,
    /// Which bytes of the record of a point are part of a value.
    is_described: Vec<bool>,
    /// Where the first description that is wrong is, if there is one.
    pub mistake: Option<Mistake>,
}

/// Where in the record a mistake is, what was expected, and what was found.
pub type Mistake = (usize, String, String);

/// A value of each component.
type Dimensions = Vec<Dimension>;

impl Extra {
    /// Parses the record EXTRA_BYTES. The extra bytes of a point are behind `first` bytes of the `bytes` that it has. They are not
    /// needed to draw the points, so a wrong description is no error: it and those after it, whose places depend on it, count as
    /// none. Programs that leave out extra bytes are known to keep their descriptions.
    pub fn parse(record: &[u8], first: usize, bytes: usize) -> Self {
        let mut extra = Self { is_described: vec![false; bytes], ..Self::default() };
        let mut at = first;
        let (descriptions, rest) = record.as_chunks::<DESCRIPTION>();
        for (number, description) in descriptions.iter().enumerate() {
            match Self::described(description, number, at, first..bytes) {
                Ok((dimensions, end)) => {
                    if !dimensions.is_empty() {
                        extra.is_described[at..end].fill(true);
                    }
                    extra.dimensions.extend(dimensions);
                    at = end;
                }
                Err((place, expected, found)) => {
                    extra.mistake = Some((number * DESCRIPTION + place, expected, found));
                    return extra;
                }
            }
        }
        if !rest.is_empty() {
            let expected = format!("descriptions of extra bytes of {DESCRIPTION} bytes each");
            extra.mistake = Some((0, expected, format!("{} bytes", record.len())));
        }
        extra
    }

    /// What the description with this number describes, and where its bytes end, which begin at `at`; those of all descriptions
    /// are in a range.
    fn described(
        description: &[u8; DESCRIPTION],
        number: usize,
        at: usize,
        all: Range<usize>,
    ) -> Result<(Dimensions, usize), Mistake> {
        let [_, _, stated, options, ..] = *description;
        let (kind, components) = match stated {
            // Not documented: only how many there are.
            0 => (1, usize::from(options)),
            1..=30 => ((stated - 1) % 10 + 1, usize::from((stated - 1) / 10) + 1),
            _ => return Err((2, "a data type of 0 to 30".into(), stated.to_string())),
        };
        let size = SIZES[usize::from(kind) - 1];
        let end = at + size * components;
        if end > all.end {
            let expected = format!("descriptions of at most {} extra bytes", all.len());
            return Err((0, expected, format!("one of the bytes {} to {}", at - all.start, end - all.start)));
        }
        let of_stated = if stated == 0 { 0 } else { components };
        let dimension = |component: usize| {
            let dimension = Dimension::parse(description, number, kind, component, components)?;
            Ok(Dimension { at: at + size * component, ..dimension })
        };
        Ok(((0..of_stated).map(dimension).collect::<Result<_, Mistake>>()?, end))
    }

    /// How many of the bytes of a point are part of a value.
    pub fn bytes(&self) -> usize {
        self.is_described.iter().filter(|is| **is).count()
    }

    /// So many bytes from one on, divided into those that are all part of values, or all none: how many, and whether they are.
    pub fn runs(&self, from: usize, count: usize) -> impl Iterator<Item = (usize, bool)> {
        let bytes = self.is_described.get(from..).and_then(|rest| rest.get(..count));
        let none = if bytes.is_none() { Some((count, false)) } else { None };
        let runs = bytes.unwrap_or_default().chunk_by(|a, b| a == b);
        runs.map(|run| (run.len(), run.first() == Some(&true))).chain(none)
    }
}

impl Dimension {
    /// A component of what the description with this number describes.
    fn parse(
        description: &[u8],
        number: usize,
        kind: u8,
        component: usize,
        components: usize,
    ) -> Result<Self, Mistake> {
        let options = description.get(3).copied().unwrap_or(0);
        let place = |begin: usize| begin + 8 * component;
        let optional = |bit: u8, begin: usize, otherwise: f64| match options >> bit & 1 {
            0 => otherwise,
            _ => f64_at(description, place(begin)).unwrap_or(otherwise),
        };
        let (scale, offset) = (optional(3, 112, 1.0), optional(4, 136, 0.0));
        if !scale.is_finite() || scale == 0.0 {
            return Err((place(112), "a scale other than 0".into(), scale.to_string()));
        }
        if !offset.is_finite() {
            return Err((place(136), "a finite offset".into(), offset.to_string()));
        }
        let no_data = if options & 1 == 0 { None } else { Raw::no_data(kind, description, place(40)) };
        let name = description.get(4..36).unwrap_or_default();
        let name = name.split(|&b| b == 0).next().unwrap_or_default().trim_ascii();
        let mut name = String::from_utf8_lossy(name).into_owned();
        if name.is_empty() {
            name = format!("extra_{}", number + 1);
        }
        let name = crate::Attribute::component_name(&name, component, components);
        Ok(Self { name, at: 0, kind, scale, offset, no_data })
    }
}
