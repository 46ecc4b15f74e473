//! The colours of data: what a surface and its scalar bar share.

use super::{ColorMap, Scale, rounded};

/// How values become colours. Colours are sRGB with linear alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct DataColors {
    /// What the values are: the title of a scalar bar.
    pub title: String,
    /// The colours of the range.
    pub map: ColorMap,
    /// How the range is spread over the map.
    pub scale: Scale,
    /// The values at the ends of the map; finite, the first is below the second; both above 0 for a logarithm.
    pub range: [f64; 2],
    /// Number of bands of one colour each, evenly spaced on the scale; `None` for a smooth transition.
    pub bands: Option<u32>,
    /// Values between which there is one colour each, that of the middle of the interval on the scale; the first and the last interval
    /// end where the range does. Of a categorical map they have the colours one by one. None for a smooth transition; without effect
    /// beside `bands`. A renderer may be off by 1/8160 of the range.
    pub levels: Vec<f64>,
    /// Lines of equal value.
    pub isolines: Option<Isolines>,
    /// The colour of what is not a number.
    pub nan: [u8; 4],
    /// The colour of values below the range; that of its lower end if there is none.
    pub below: Option<[u8; 4]>,
    /// The colour of values above the range; that of its upper end if there is none.
    pub above: Option<[u8; 4]>,
    /// Opacities, 0 to 1, evenly spaced over the map and linear between them; none for 1 everywhere.
    pub opacities: Vec<f32>,
    /// Values that are names rather than quantities, in ascending order, each with its own colour; other values have the colour of
    /// NaN. Range, scale, bands, and the colours below and above are not used then.
    pub categories: Vec<Category>,
    /// What a renderer subtracts from values, ranges and the rest of this before it rounds them to `f32`: not 0 for values that
    /// differ by little against their size. All numbers here are full ones. A scale that is not linear is taken for linear then.
    pub offset: f64,
}

/// A category: a value with a label.
#[derive(Clone, Debug, PartialEq)]
pub struct Category {
    /// The value of the data.
    pub value: f64,
    /// What it is called.
    pub label: String,
    /// Its colour.
    pub color: [u8; 4],
}

/// Lines of equal value on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolines {
    /// Their values.
    pub values: Vec<f64>,
    /// Their colour.
    pub color: [u8; 4],
    /// Their width in pixels.
    pub width: f32,
}

impl DataColors {
    /// The colour of what is not a number, if no other is asked for: a gray that no usual map has at one of its ends.
    pub const NAN: [u8; 4] = [160, 160, 160, 255];

    /// A linear, smooth, opaque map of a range.
    pub fn new(title: &str, map: ColorMap, range: [f64; 2]) -> Self {
        Self {
            title: title.to_owned(),
            map,
            scale: Scale::default(),
            range,
            bands: None,
            levels: Vec::new(),
            isolines: None,
            nan: Self::NAN,
            below: None,
            above: None,
            opacities: Vec::new(),
            categories: Vec::new(),
            offset: 0.0,
        }
    }

    /// The full value of one that is less [`DataColors::offset`].
    pub fn full(&self, value: f32) -> f64 {
        self.offset + f64::from(value)
    }

    /// The place of a value in the colour map: 0 at the lower end of the range to 1 at the upper one, less and more beyond; NaN
    /// for NaN.
    pub fn position(&self, value: f64) -> f64 {
        if value.is_nan() {
            return f64::NAN;
        }
        if self.scale == Scale::Log && value <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let [low, high] = self.range.map(|end| self.scale.forward(end));
        (self.scale.forward(value) - low) / (high - low)
    }

    /// The value at a place in the colour map: the inverse of [`DataColors::position`].
    pub fn value_at(&self, position: f64) -> f64 {
        let [low, high] = self.range.map(|end| self.scale.forward(end));
        match position {
            0.0 => self.range[0],
            1.0 => self.range[1],
            _ => self.scale.back(low + (high - low) * position),
        }
    }

    /// Number of areas of one colour each in the range: bands, or the colours of a categorical map; `None` for a smooth transition.
    pub fn steps(&self) -> Option<u32> {
        let is_categorical = self.map.is_categorical() && self.levels.is_empty();
        self.bands.or_else(|| is_categorical.then(|| self.map.len() as u32))
    }

    /// The values between which a band has one colour, from the lower end of the range to the upper one; empty for a smooth
    /// transition.
    pub fn boundaries(&self) -> Vec<f64> {
        match self.steps() {
            Some(n) => (0..=n).map(|i| self.value_at(f64::from(i) / f64::from(n))).collect(),
            None if self.levels.is_empty() => Vec::new(),
            None => {
                let [low, high] = self.range;
                // An end may be a number of a file: 0.3 is 0.300000012 in `f32`. A level of 0.3 is there, too.
                let written = |end: f64| -> f64 {
                    let single = (end - self.offset) as f32;
                    format!("{single:e}").parse().map_or(end, |shortest: f64| shortest + self.offset)
                };
                let ends = [written(low), written(high)];
                let is_within = |level: &f64| low < *level && *level < high && !ends.contains(level);
                let within = self.levels.iter().copied().filter(is_within);
                let mut all: Vec<f64> = [low, high].into_iter().chain(within).collect();
                all.sort_by(f64::total_cmp);
                all.dedup();
                all
            }
        }
    }

    /// The place in the map whose colour is that of a place in the range, both 0 to 1, if there are no [steps](Self::steps).
    pub fn color_places(&self) -> impl Fn(f64) -> f64 {
        let borders: Vec<f64> = match self.steps() {
            Some(_) => Vec::new(),
            None => self.boundaries().into_iter().map(|value| self.position(value)).collect(),
        };
        let (count, is_categorical) = (self.map.len(), self.map.is_categorical());
        move |place: f64| {
            let Some(last) = borders.len().checked_sub(2) else { return place };
            let interval = borders.partition_point(|border| *border <= place).saturating_sub(1).min(last);
            match is_categorical {
                true => ((interval % count) as f64 + 0.5) / count as f64,
                false => (borders[interval] + borders[interval + 1]) / 2.0,
            }
        }
    }

    /// The colour of a place in the map, 0 to 1, with bands and opacities: what a scalar bar shows there.
    pub fn color_at(&self, position: f64) -> [u8; 4] {
        let t = if position > 0.0 { position.min(1.0) } else { 0.0 };
        let t = match self.steps() {
            Some(n) => self.band_color_place((t * f64::from(n)).min(f64::from(n) - 1.0).floor(), n),
            None => self.color_places()(t),
        };
        let [r, g, b] = rounded(self.map.at(t));
        [r, g, b, (self.opacity_at(t) * 255.0 + 0.5) as u8]
    }

    /// The place in the map whose colour a band has: the first band has that of the lower end, the last that of the upper end; a
    /// categorical map has its colours one by one.
    pub fn band_color_place(&self, band: f64, bands: u32) -> f64 {
        let bands = f64::from(bands);
        match (self.map.is_categorical(), bands > 1.0) {
            (true, _) => (band + 0.5) / bands,
            (false, true) => band / (bands - 1.0),
            (false, false) => 0.5,
        }
    }

    /// The opacity at a place in the map, 0 to 1.
    pub fn opacity_at(&self, position: f64) -> f64 {
        let Some(last) = self.opacities.len().checked_sub(1) else { return 1.0 };
        let place = position.clamp(0.0, 1.0) * last as f64;
        let (below, share) = (place.floor() as usize, place - place.floor());
        let [a, b] = [below, below + 1].map(|i| f64::from(self.opacities[i.min(last)]));
        a + (b - a) * share
    }

    /// The colour of a value.
    pub fn color(&self, value: f64) -> [u8; 4] {
        if !self.categories.is_empty() {
            let found = self.categories.binary_search_by(|category| category.value.total_cmp(&value));
            return found.map_or(self.nan, |i| self.categories[i].color);
        }
        let position = self.position(value);
        match (self.below, self.above) {
            _ if position.is_nan() => self.nan,
            (Some(below), _) if position < 0.0 => below,
            (_, Some(above)) if position > 1.0 => above,
            _ => self.color_at(position),
        }
    }

    /// May any value be drawn less than opaque?
    pub fn is_translucent(&self) -> bool {
        let ends = [Some(self.nan), self.below, self.above].into_iter().flatten();
        let of_categories = self.categories.iter().map(|category| category.color);
        self.opacities.iter().any(|&o| o < 1.0) || ends.chain(of_categories).any(|color| color[3] < 255)
    }
}
