//! The header: which elements follow, how many instances of each, and the properties of an instance.

use super::malformed;
use crate::error::{Place, ReadError, counted, printable};
use crate::io::input::Input;
use crate::io::text::parse_integer;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// The name in a header.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

/// One property of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) shape: Shape,
}

/// One element: a table of `count` instances.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Header line of the element.
    pub(super) line: u64,
}

impl Element {
    /// The scalar property of that name.
    pub(super) fn scalar(&self, name: &str) -> Option<(usize, Scalar)> {
        self.properties.iter().enumerate().find_map(|(i, p)| match p.shape {
            Shape::One(scalar) if p.name == name => Some((i, scalar)),
            _ => None,
        })
    }

    /// The list property of one of these names.
    pub(super) fn list(&self, names: &[&str]) -> Option<usize> {
        self.properties
            .iter()
            .position(|p| matches!(p.shape, Shape::List { .. }) && names.contains(&p.name.as_str()))
    }

    /// The fewest bytes that an instance takes: with all lists empty.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |p: &Property| match (encoding, p.shape) {
            // One digit and a separator.
            (Encoding::Ascii, _) => 2,
            (_, Shape::One(scalar) | Shape::List { count: scalar, .. }) => scalar.size() as u64,
        };
        self.properties.iter().map(least).sum()
    }
}

/// A whole header.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Files of `comment TextureFile NAME`, as MeshLab writes them.
    pub(super) textures: Vec<String>,
    /// Offset of the first byte after the header.
    pub(super) body: usize,
    /// Number of the line that begins there.
    pub(super) body_line: u64,
    /// Lines end in a lone carriage return, as on the classic Mac OS.
    pub(super) carriage_returns: bool,
    pub(super) warnings: Vec<String>,
}

/// What follows on a line after this many bytes is ignored.
const LONGEST_LINE: usize = 1 << 16;

/// Cuts off the line at the front of `bytes`; returns the line and the offset of the next one.
fn cut_line<'b>(input: &Input, bytes: &'b [u8], at: usize, line_end: u8) -> (&'b [u8], usize) {
    let rest = bytes.get(at..).unwrap_or_default();
    let end = input.position(rest, |b| b == line_end);
    let length = end.unwrap_or(rest.len());
    let line = rest.get(..length.min(LONGEST_LINE)).unwrap_or_default();
    (line.trim_ascii(), end.map_or(bytes.len(), |n| at + n + 1))
}

/// Reads the header.
pub(super) fn parse(input: &Input, bytes: &[u8]) -> Result<Header, ReadError> {
    let file = input.name.as_str();
    // The first line determines how lines end: the body of a binary file may begin with a byte that looks like the
    // second half of CR LF.
    let magic = input.position(bytes, |b| !b.is_ascii_whitespace()).unwrap_or(bytes.len());
    let first_end = bytes.iter().skip(magic).position(|&b| b == b'\r' || b == b'\n').map(|n| magic + n);
    let carriage_returns =
        first_end.is_some_and(|n| bytes.get(n) == Some(&b'\r') && bytes.get(n + 1) != Some(&b'\n'));
    let line_end = if carriage_returns { b'\r' } else { b'\n' };

    let mut line = 1 + input.count(bytes.get(..magic).unwrap_or_default(), |b| b == line_end);
    let (word, mut at) = cut_line(input, bytes, magic, line_end);
    if word != b"ply" {
        return Err(malformed(file, Place::Line(line), "\"ply\"", printable(word)));
    }
    let mut header = Header {
        encoding: Encoding::Ascii,
        elements: Vec::new(),
        textures: Vec::new(),
        body: 0,
        body_line: 0,
        carriage_returns,
        warnings: Vec::new(),
    };
    let mut encoding = None;
    let mut unknown_lines = 0;
    loop {
        line += 1;
        let place = Place::Line(line);
        if at >= bytes.len() {
            return Err(malformed(file, place, "\"end_header\"", "the end of the file"));
        }
        let (text, next) = cut_line(input, bytes, at, line_end);
        input.consumed(next - at);
        at = next;
        let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let mut word = || words.next().unwrap_or_default();
        match word() {
            b"" | b"obj_info" => {}
            b"comment" => {
                if word() == b"TextureFile" {
                    let name = text.trim_ascii_start().get(b"comment".len()..).unwrap_or_default();
                    let name = name.trim_ascii_start().get(b"TextureFile".len()..).unwrap_or_default();
                    header.textures.push(String::from_utf8_lossy(name.trim_ascii()).into_owned());
                }
            }
            b"format" => {
                encoding = Some(match word() {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    other => {
                        let expected = "the format ascii, binary_little_endian or binary_big_endian";
                        return Err(malformed(file, place, expected, found_word(other)));
                    }
                });
            }
            b"element" => {
                let name = String::from_utf8_lossy(word()).into_owned();
                let count = word();
                let number = parse_integer(count).filter(|&(_, n)| n == count.len());
                let Some(number) = number.and_then(|(n, _)| u64::try_from(n).ok()) else {
                    let expected = format!("the number of instances of element {name}");
                    return Err(malformed(file, place, expected, found_word(count)));
                };
                header.elements.push(Element { name, count: number, properties: Vec::new(), line });
            }
            b"property" => {
                let property = property(&mut word).map_err(|wrong| {
                    malformed(file, place, "a number type (such as float or uint8)", found_word(wrong))
                })?;
                let Some(element) = header.elements.last_mut() else {
                    return Err(malformed(file, place, "an element before its properties", "a property"));
                };
                element.properties.push(property);
            }
            b"end_header" => break,
            // Some writers forget the word "comment". After a header without end_header come bytes that are not text.
            _ if text.iter().all(|b| (b' '..0x7f).contains(b) || *b == b'\t') => unknown_lines += 1,
            other => {
                return Err(malformed(file, place, "a header line or \"end_header\"", found_word(other)));
            }
        }
    }
    if unknown_lines > 0 {
        header
            .warnings
            .push(format!("skipped {} that PLY does not know", counted(unknown_lines, "header line")));
    }
    let Some(encoding) = encoding else {
        return Err(malformed(file, Place::Line(line), "a line \"format …\"", "\"end_header\""));
    };
    header.encoding = encoding;
    header.body = at;
    header.body_line = line + 1;
    Ok(header)
}

/// The words after "property"; the wrong word if there is one.
fn property<'a>(word: &mut impl FnMut() -> &'a [u8]) -> Result<Property, &'a [u8]> {
    let scalar = |name: &'a [u8]| Scalar::parse(name).ok_or(name);
    let first = word();
    let shape = if first == b"list" {
        let count = scalar(word())?;
        Shape::List { count, item: scalar(word())? }
    } else {
        Shape::One(scalar(first)?)
    };
    Ok(Property { name: String::from_utf8_lossy(word()).into_owned(), shape })
}

fn found_word(word: &[u8]) -> String {
    if word.is_empty() { "the end of the line".into() } else { printable(word) }
}
