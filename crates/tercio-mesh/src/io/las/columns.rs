//! What points become.

use super::header::{Header, f64_at, u16_at};
use crate::doubles::{Doubles, all_stored, store};
use crate::strokes::Colors;
use crate::{Attribute, AttributeDomain};

/// A name that no attribute has: with a number if one has it, as further descriptions of the same extra bytes, or of what all points have.
fn unused(attributes: &[Attribute], name: &str) -> String {
    let is_used = |name: &str| attributes.iter().any(|a| a.name == name);
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !is_used(name)).unwrap_or_default()
}

/// Points, by what they have.
pub struct Columns<'a> {
    header: &'a Header,
    positions: Vec<[i32; 3]>,
    colors: Vec<[u16; 3]>,
    intensity: Vec<u16>,
    returns: Vec<[u8; 2]>,
    classes: Vec<u8>,
    sources: Vec<u16>,
    times: Vec<f64>,
    nir: Vec<u16>,
    /// Values of extra bytes, by dimension.
    extra: Vec<Vec<f64>>,
}

impl<'a> Columns<'a> {
    pub fn new(header: &'a Header) -> Self {
        Self {
            header,
            positions: Vec::new(),
            colors: Vec::new(),
            intensity: Vec::new(),
            returns: Vec::new(),
            classes: Vec::new(),
            sources: Vec::new(),
            times: Vec::new(),
            nir: Vec::new(),
            extra: header.extra.dimensions.iter().map(|_| Vec::new()).collect(),
        }
    }

    /// Bytes of memory for every point, also of what it becomes.
    pub fn bytes_of_a_point(&self) -> u64 {
        let layout = &self.header.layout;
        let if_there = |place: Option<usize>, bytes: u64| place.map_or(0, |_| bytes);
        let extra = 12 * self.extra.len() as u64;
        19 + 20 + if_there(layout.rgb, 11) + if_there(layout.gps, 12) + if_there(layout.nir, 6) + extra
    }

    /// Adds the record of a point.
    #[inline]
    pub fn add(&mut self, record: &[u8]) {
        let number = |at: usize| u16_at(record, at).unwrap_or(0);
        let byte = |at: usize| record.get(at).copied().unwrap_or(0);
        let axis = |k: usize| {
            let bytes: Option<[u8; 4]> = record.get(4 * k..).and_then(|r| r.first_chunk().copied());
            bytes.map_or(0, i32::from_le_bytes)
        };
        self.positions.push([axis(0), axis(1), axis(2)]);
        self.intensity.push(number(12));
        let returns = byte(14);
        let layout = &self.header.layout;
        if layout.is_new {
            self.returns.push([returns & 15, returns >> 4]);
            self.classes.push(byte(16));
            self.sources.push(number(20));
        } else {
            self.returns.push([returns & 7, returns >> 3 & 7]);
            self.classes.push(byte(15) & 31);
            self.sources.push(number(18));
        }
        if let Some(at) = layout.gps {
            self.times.push(f64_at(record, at).unwrap_or(0.0));
        }
        if let Some(at) = layout.rgb {
            self.colors.push([number(at), number(at + 2), number(at + 4)]);
        }
        if let Some(at) = layout.nir {
            self.nir.push(number(at));
        }
        for (dimension, values) in self.header.extra.dimensions.iter().zip(&mut self.extra) {
            values.push(dimension.value(record));
        }
    }

    /// Adds the points of other columns behind these.
    pub fn append(&mut self, other: Self) {
        self.positions.extend(other.positions);
        self.colors.extend(other.colors);
        self.intensity.extend(other.intensity);
        self.returns.extend(other.returns);
        self.classes.extend(other.classes);
        self.sources.extend(other.sources);
        self.times.extend(other.times);
        self.nir.extend(other.nir);
        self.extra.iter_mut().zip(other.extra).for_each(|(all, more)| all.extend(more));
    }

    /// The positions, in the coordinates of the file. They are not kept.
    pub fn points(&mut self) -> Vec<[f64; 3]> {
        let (scale, offset) = (self.header.scale, self.header.offset);
        let point = |p: [i32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) * scale[k] + offset[k]);
        std::mem::take(&mut self.positions).into_iter().map(point).collect()
    }

    /// The colours, unless all of them are 0. They are not kept.
    pub fn colors(&mut self) -> Option<Colors> {
        let colors = std::mem::take(&mut self.colors);
        let most = colors.iter().flatten().copied().max().unwrap_or(0);
        // The specification has 16 bits; many programs write 8 of them.
        let shift = if most > 255 { 8 } else { 0 };
        let byte = |level: u16| (level >> shift) as u8;
        let color = |[r, g, b]: [u16; 3]| Some([byte(r), byte(g), byte(b), 255]);
        (most > 0).then(|| colors.into_iter().map(color).collect())
    }

    /// All other values, and warnings of those that are rounded.
    pub fn attributes(self) -> (Vec<Attribute>, Vec<String>) {
        let (times, of_times) = store(&self.times);
        let of_u16 = |values: &[u16]| values.iter().map(|&v| f32::from(v)).collect::<Vec<f32>>();
        let of_returns = |k: usize| self.returns.iter().map(|r| f32::from(r[k])).collect();
        let all = [
            ("intensity", of_u16(&self.intensity)),
            ("return_number", of_returns(0)),
            ("number_of_returns", of_returns(1)),
            ("classification", self.classes.iter().map(|&c| f32::from(c)).collect()),
            ("point_source_id", of_u16(&self.sources)),
            ("gps_time", times),
            ("nir", of_u16(&self.nir)),
        ];
        let layout = &self.header.layout;
        let is_there = [true, true, true, true, true, layout.gps.is_some(), layout.nir.is_some()];
        let domain = AttributeDomain::Vertex;
        let attribute = |(name, values): (&str, _)| Attribute {
            name: name.into(),
            domain,
            values,
            offset: 0.0,
            component: None,
        };
        let all = all.into_iter().zip(is_there).filter(|(_, is)| *is).map(|(all, _)| attribute(all));
        let mut all: Vec<Attribute> = all.collect();
        all.iter_mut().filter(|a| a.name == "gps_time").for_each(|a| a.offset = of_times);
        let mut warnings = Vec::new();
        // One after the other, so that no more than one is there twice.
        for (dimension, values) in self.header.extra.dimensions.iter().zip(self.extra) {
            let doubles = Doubles::of(&values);
            let (name, offset) = (unused(&all, &dimension.name), doubles.offset());
            warnings.extend(doubles.warning(&name, dimension.has_integers()));
            all.push(Attribute {
                name,
                domain,
                values: all_stored(&values, offset),
                offset,
                component: None,
            });
        }
        (all, warnings)
    }
}
