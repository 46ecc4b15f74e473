//! Arrays of points and cells.

use super::Parser;
use super::arrays::Type;
use crate::ReadError;
use crate::io::vtk::TIME_NAMES;
use crate::io::vtk::dataset::{Array, Use};
use crate::io::vtk::numbers::Scalar;

/// Most components of an array.
const MOST_COMPONENTS: u64 = 1 << 16;

/// Arrays that were read.
#[derive(Default)]
pub struct Data<'a> {
    points: Vec<Array<'a>>,
    cells: Vec<Array<'a>>,
    now: Option<(Domain, u64)>,
    /// The time of the file.
    pub time: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Domain {
    Points,
    Cells,
}

impl<'a> Data<'a> {
    pub fn finish(self) -> [Vec<Array<'a>>; 2] {
        [self.points, self.cells]
    }

    /// Reads what follows a keyword, if it is one of arrays.
    pub fn read(&mut self, parser: &mut Parser<'_, 'a>, keyword: &str) -> Result<bool, ReadError> {
        match keyword {
            "POINT_DATA" => {
                self.now = Some((Domain::Points, parser.count("the number of points with data")?))
            }
            "CELL_DATA" => self.now = Some((Domain::Cells, parser.count("the number of cells with data")?)),
            "METADATA" => self.metadata(parser, self.last()),
            "FIELD" => self.field(parser)?,
            "LOOKUP_TABLE" => {
                let name = name(parser.word("the name of a lookup table")?);
                let colors = parser.count("the number of colours of a lookup table")?;
                let kind = if parser.binary { Scalar::U8 } else { Scalar::F32 };
                parser.numbers("a lookup table", colors.saturating_mul(4), Type::Numbers(kind))?;
                parser.job.warn(format!("the lookup table {name:?} is not applied"));
            }
            "SCALARS" => {
                let name = name(parser.word("the name of an array")?);
                let kind = parser.scalar_type()?;
                let components =
                    if parser.cursor.line_is_over() { 1 } else { parser.count("a number of components")? };
                let mut ahead = parser.cursor.clone();
                ahead.skip_space();
                if ahead.word().eq_ignore_ascii_case(b"LOOKUP_TABLE") {
                    parser.cursor = ahead;
                    parser.word("the name of a lookup table")?;
                }
                self.array(parser, name, components, kind, |array| {
                    // As VTK draws them.
                    if array.numbers.scalar == Scalar::U8 && matches!(array.components, 3 | 4) {
                        array.r#use = Use::Colors;
                    }
                })?;
            }
            "COLOR_SCALARS" => {
                let name = name(parser.word("the name of an array")?);
                let components = parser.count("a number of components")?;
                self.array(parser, name, components, Type::Colors, |array| array.r#use = Use::Colors)?;
            }
            "TEXTURE_COORDINATES" => {
                let name = name(parser.word("the name of an array")?);
                let components = parser.count("a number of components")?;
                let kind = parser.scalar_type()?;
                self.array(parser, name, components, kind, |array| {
                    array.r#use = if components >= 2 { Use::Texcoords } else { Use::Attribute };
                })?;
            }
            "VECTORS" | "NORMALS" | "TENSORS" | "TENSORS6" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => {
                let name = name(parser.word("the name of an array")?);
                let kind = parser.scalar_type()?;
                let components = match keyword {
                    "VECTORS" | "NORMALS" => 3,
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    _ => 1,
                };
                self.array(parser, name, components, kind, |array| {
                    if keyword == "NORMALS" {
                        array.r#use = Use::Normals;
                    }
                })?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Reads an array with a tuple for each of the points or cells.
    fn array(
        &mut self,
        parser: &mut Parser<'_, 'a>,
        name: String,
        components: u64,
        kind: Type,
        set: impl FnOnce(&mut Array),
    ) -> Result<(), ReadError> {
        let Some((domain, tuples)) = self.now else {
            return Err(parser.expected(format!("POINT_DATA or CELL_DATA before array {name:?}")));
        };
        let components = checked(parser, components)?;
        let numbers = parser.numbers(&format!("array {name:?}"), tuples.saturating_mul(components), kind)?;
        let components = components as usize;
        let mut array = Array {
            r#use: Use::of(&name, components, numbers.scalar),
            name,
            components,
            numbers,
            names: Vec::new(),
        };
        set(&mut array);
        self.push(domain, array);
        Ok(())
    }

    fn push(&mut self, domain: Domain, mut array: Array<'a>) {
        if domain == Domain::Cells && array.r#use != Use::Colors {
            array.r#use = Use::Attribute;
        }
        match domain {
            Domain::Points => self.points.push(array),
            Domain::Cells => self.cells.push(array),
        }
    }

    /// The array that was read last, by its domain and number.
    fn last(&self) -> Option<(Domain, usize)> {
        let (domain, _) = self.now?;
        let arrays = if domain == Domain::Points { &self.points } else { &self.cells };
        Some((domain, arrays.len().checked_sub(1)?))
    }

    /// Reads a block that ends with an empty line: the names of the components of an array, which may be one of those that were read.
    fn metadata(&mut self, parser: &mut Parser, of: Option<(Domain, usize)>) {
        let array = match of {
            Some((Domain::Points, number)) => self.points.get_mut(number),
            Some((Domain::Cells, number)) => self.cells.get_mut(number),
            None => None,
        };
        let (mut names, most) = (Vec::new(), array.as_ref().map_or(0, |array| array.components));
        parser.cursor.skip_line();
        let mut left = 0;
        while !parser.cursor.line_is_over() {
            let mut line = parser.cursor.clone();
            let word = line.word();
            if left > 0 {
                names.push(name(word));
                left -= 1;
            } else if word == b"COMPONENT_NAMES" {
                left = most;
            }
            parser.cursor.skip_line();
        }
        if let Some(array) = array.filter(|_| !names.is_empty()) {
            array.names = names;
        }
    }

    /// Reads a field: arrays of any length, of which those before the first data belong to the whole file.
    fn field(&mut self, parser: &mut Parser<'_, 'a>) -> Result<(), ReadError> {
        parser.word("the name of a field")?;
        let mut left = parser.count("the number of arrays of a field")?;
        let mut before = self.last();
        while left > 0 {
            parser.cursor.skip_space();
            let word = parser.word("the name of an array")?;
            match word {
                b"METADATA" => {
                    // Of an array before this one that was not kept nothing is read.
                    self.metadata(parser, self.last().filter(|last| Some(*last) != before));
                    before = self.last();
                    continue;
                }
                b"NULL_ARRAY" => before = self.last(),
                _ => {
                    before = self.last();
                    let name = name(word);
                    let components = parser.count("a number of components")?;
                    let components = checked(parser, components)?;
                    let tuples = parser.count("a number of tuples")?;
                    let kind = parser.scalar_type()?;
                    let count = tuples.saturating_mul(components);
                    let what = format!("array {name:?}");
                    if kind == Type::Text {
                        parser.skip_strings(&what, count)?;
                    } else {
                        let place = parser.place();
                        let numbers = parser.numbers(&what, count, kind)?;
                        if self.now.is_none() && count > 0 && TIME_NAMES.contains(&&*name) {
                            self.time = Some(numbers.double(0));
                        }
                        if let Some((domain, wanted)) = self.now {
                            if tuples != wanted {
                                let expected = format!("{wanted} tuples of {what}");
                                return Err(parser.job.malformed(place, expected, tuples.to_string()));
                            }
                            let components = components as usize;
                            let r#use = Use::of(&name, components, numbers.scalar);
                            self.push(domain, Array { name, components, numbers, r#use, names: Vec::new() });
                        }
                    }
                }
            }
            left -= 1;
        }
        Ok(())
    }
}

fn checked(parser: &Parser, components: u64) -> Result<u64, ReadError> {
    if (1..=MOST_COMPONENTS).contains(&components) {
        return Ok(components);
    }
    let expected = format!("1 to {MOST_COMPONENTS} components of an array");
    Err(parser.job.malformed(parser.place(), expected, components.to_string()))
}

/// A name, in which special characters are written as in addresses of the web.
fn name(word: &[u8]) -> String {
    let mut bytes = Vec::with_capacity(word.len());
    let mut rest = word;
    while let Some((&first, tail)) = rest.split_first() {
        let code = tail.get(..2).filter(|_| first == b'%').and_then(|c| std::str::from_utf8(c).ok());
        match code.and_then(|c| u8::from_str_radix(c, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_are_decoded() {
        assert_eq!(super::name(b"a%20b%25%zz%2"), "a b%%zz%2");
    }
}
