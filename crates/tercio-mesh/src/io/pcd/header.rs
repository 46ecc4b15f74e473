//! The header.

use crate::ReadError;
use crate::error::{Place, printable};
use crate::io::input::Input;
use crate::io::text::Cursor;

/// Most fields beside the coordinates, and most components of all of them: a header of a few bytes can state any number, and each
/// component is an attribute.
const MOST: usize = 4096;

/// A field of a point.
#[derive(Clone, Debug)]
pub struct Field {
    pub name: String,
    /// Bytes of a number.
    pub size: usize,
    /// I for signed, U for unsigned, F for real numbers.
    pub kind: u8,
    pub count: usize,
    /// Bytes of a point before it.
    pub before: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Data {
    Ascii,
    Binary,
    Compressed,
}

impl Data {
    pub fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ASCII",
            Self::Binary => "binary",
            Self::Compressed => "compressed binary",
        }
    }
}

pub struct Header {
    pub fields: Vec<Field>,
    pub points: u64,
    pub data: Data,
    /// Where the points begin, and the line.
    pub end: usize,
    pub line: u64,
    /// The line with DATA, which ends the header.
    last_line: u64,
}

impl Header {
    /// Bytes of a point.
    pub fn stride(&self) -> usize {
        self.fields.last().map_or(0, |f| f.before + f.size * f.count)
    }

    /// The field of a coordinate.
    ///
    /// # Errors
    /// There is none with one component.
    pub fn axis(&self, input: &Input, name: &str) -> Result<usize, ReadError> {
        self.fields.iter().position(|f| f.name == name && f.count == 1).ok_or_else(|| {
            let found = self.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(" ");
            self.malformed(input, "the fields x, y and z", format!("{found:?}"))
        })
    }

    /// The error of something in the header.
    fn malformed(&self, input: &Input, expected: &str, found: String) -> ReadError {
        let place = Place::Line(self.last_line);
        ReadError::Malformed { file: input.name.clone(), place, expected: expected.into(), found }
    }

    pub fn parse(input: &Input) -> Result<Self, ReadError> {
        let mut cursor = Cursor::new(input.bytes(), 1);
        let (mut names, mut sizes, mut kinds, mut counts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut width, mut height, mut points) = (None, 1, None);
        loop {
            cursor.skip_space();
            let before = cursor.clone();
            let words: Vec<&[u8]> =
                cursor.rest_of_line().split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
            let wrong = |expected: &str| Err(before.expected(&input.name, expected));
            let Some((&word, values)) = words.split_first() else { return wrong("a line with DATA") };
            if values.len() > MOST + 3 {
                return wrong("at most 4099 fields");
            }
            let number = || std::str::from_utf8(values.first()?).ok()?.parse::<u64>().ok();
            let numbers = || -> Option<Vec<usize>> {
                let number = |w: &&[u8]| std::str::from_utf8(w).ok()?.parse().ok().filter(|&n| n <= MOST);
                values.iter().map(number).collect()
            };
            match word {
                b"VERSION" | b"VIEWPOINT" => {}
                [b'#', ..] => {}
                b"FIELDS" => names = values.iter().map(|w| String::from_utf8_lossy(w).into_owned()).collect(),
                b"SIZE" => match numbers() {
                    Some(n) => sizes = n,
                    None => return wrong("SIZE with bytes of the fields"),
                },
                b"TYPE" => kinds = values.iter().map(|w| w.first().copied().unwrap_or(b' ')).collect(),
                b"COUNT" => match numbers() {
                    Some(n) => counts = n,
                    None => return wrong("COUNT with components of the fields"),
                },
                b"WIDTH" | b"HEIGHT" | b"POINTS" => {
                    let Some(n) = number() else { return wrong("a number of points") };
                    match word {
                        b"WIDTH" => width = Some(n),
                        b"HEIGHT" => height = n,
                        _ => points = Some(n),
                    }
                }
                b"DATA" => {
                    let data = match values.first() {
                        Some(&b"ascii") => Data::Ascii,
                        Some(&b"binary") => Data::Binary,
                        Some(&b"binary_compressed") => Data::Compressed,
                        _ => return wrong("DATA ascii, binary or binary_compressed"),
                    };
                    if counts.is_empty() {
                        counts = vec![1; names.len()];
                    }
                    let lengths = [sizes.len(), kinds.len(), counts.len()];
                    let Some(points) = points.or(width.map(|w: u64| w.saturating_mul(height))) else {
                        return wrong("POINTS before DATA");
                    };
                    if names.is_empty() || lengths != [names.len(); 3] {
                        return wrong("as many sizes, types and counts as fields before DATA");
                    }
                    let mut fields = Vec::new();
                    let mut before_field = 0;
                    for (i, name) in names.into_iter().enumerate() {
                        let (size, kind, count) = (sizes[i], kinds[i], counts[i]);
                        let is_known = match kind {
                            b'F' => matches!(size, 4 | 8),
                            b'I' | b'U' => matches!(size, 1 | 2 | 4 | 8),
                            _ => false,
                        };
                        if !is_known {
                            let kind = printable(&[kind]);
                            return wrong(&format!(
                                "a type of 1 to 8 bytes for field {name:?}, not {kind} of {size}"
                            ));
                        }
                        // A field without components is in no point.
                        if count > 0 {
                            fields.push(Field { name, size, kind, count, before: before_field });
                            before_field += size * count;
                        }
                    }
                    let beside = fields.iter().filter(|f| !matches!(f.name.as_str(), "x" | "y" | "z"));
                    let values: usize = beside.map(|f| f.count).sum();
                    if values > MOST {
                        let expected = format!("at most {MOST} components of fields beside x, y and z");
                        return wrong(&format!("{expected}, not {values}"));
                    }
                    let (end, line) = (cursor.offset(), cursor.line());
                    return Ok(Self { fields, points, data, end, line, last_line: before.line() });
                }
                _ => {
                    return wrong(
                        "a line of the header of PCD (FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, POINTS, DATA)",
                    );
                }
            }
        }
    }
}
