//! The points.

use std::borrow::Cow;

use super::header::{Data, Header};
use super::lzf;
use crate::ReadError;
use crate::error::{Place, counted};
use crate::io::ReadOptions;
use crate::io::input::Input;
use crate::io::text::Cursor;

/// Bytes of all points.
pub struct Body<'a> {
    bytes: Cow<'a, [u8]>,
    /// Fields one after the other, not points.
    columns: bool,
    points: usize,
}

impl<'a> Body<'a> {
    /// Finds or makes the bytes, and checks that they are all there.
    pub fn open(input: &'a Input, options: &ReadOptions, header: &Header) -> Result<Self, ReadError> {
        let rest = input.bytes().get(header.end..).unwrap_or_default();
        let needed = header.points.saturating_mul(header.stride() as u64);
        let malformed = |place, expected: String, found: String| {
            Err(ReadError::Malformed { file: input.name.clone(), place, expected, found })
        };
        let place = Place::Byte(header.end as u64);
        let points = counted(header.points, "point");
        let reserve =
            || options.check_memory(&input.name, "its points", input.held_bytes().saturating_add(needed));
        let (bytes, columns): (Cow<[u8]>, bool) = match header.data {
            Data::Binary => match usize::try_from(needed).ok().and_then(|n| rest.get(..n)) {
                Some(bytes) => (bytes.into(), false),
                None => {
                    let found = format!("{} of them", counted(rest.len() as u64, "byte"));
                    return malformed(place, format!("{points} in {needed} bytes"), found);
                }
            },
            Data::Compressed => {
                let word = |at: usize| rest.get(at..)?.first_chunk().copied().map(u32::from_le_bytes);
                let (Some(packed), Some(plain)) = (word(0), word(4)) else {
                    return malformed(
                        place,
                        "the sizes of the compressed points".into(),
                        "the end of the file".into(),
                    );
                };
                if u64::from(plain) != needed {
                    return malformed(place, format!("{points} in {needed} bytes"), format!("{plain} bytes"));
                }
                let Some(from) = rest.get(8..).and_then(|r| r.get(..packed as usize)) else {
                    let found =
                        format!("{} up to the end of the file", counted(rest.len() as u64 - 8, "byte"));
                    return malformed(place, format!("{packed} compressed bytes"), found);
                };
                // A byte stands for 264 at most.
                if needed / 264 > u64::from(packed) {
                    return malformed(
                        place,
                        format!("{packed} compressed bytes"),
                        format!("{plain} bytes of them"),
                    );
                }
                reserve()?;
                match lzf::decompress(from, plain as usize) {
                    Some(bytes) => (bytes.into(), true),
                    None => {
                        return malformed(
                            place,
                            format!("{points}, compressed by LZF"),
                            "damaged data".into(),
                        );
                    }
                }
            }
            Data::Ascii => {
                let values: u64 = header.fields.iter().map(|f| f.count as u64).sum();
                if header.points.saturating_mul(values) > rest.len() as u64 / 2 + 1 {
                    let found = format!("{} up to the end of the file", counted(rest.len() as u64, "byte"));
                    return malformed(
                        Place::Line(header.line),
                        format!("{points} of {values} numbers"),
                        found,
                    );
                }
                reserve()?;
                (ascii(input, header, rest, needed as usize)?.into(), false)
            }
        };
        input.consumed(rest.len());
        Ok(Self { bytes, columns, points: header.points as usize })
    }

    /// Bytes of memory beside the file.
    pub fn held(&self) -> u64 {
        if matches!(self.bytes, Cow::Owned(_)) { self.bytes.len() as u64 } else { 0 }
    }

    /// The bytes of a component of a field, point by point.
    fn raw(&self, header: &Header, field: usize, component: usize) -> impl Iterator<Item = &[u8]> {
        let field = &header.fields[field];
        let inside = component * field.size;
        let (first, stride) = if self.columns {
            (field.before * self.points + inside, field.size * field.count)
        } else {
            (field.before + inside, header.stride())
        };
        (0..self.points).map(move |i| {
            self.bytes.get(first + i * stride..).and_then(|b| b.get(..field.size)).unwrap_or_default()
        })
    }

    /// The numbers of a component of a field.
    pub fn column<'b>(
        &'b self,
        header: &'b Header,
        field: usize,
        component: usize,
    ) -> impl Iterator<Item = f64> + 'b {
        let kind = header.fields[field].kind;
        self.raw(header, field, component).map(move |bytes| number(kind, bytes))
    }

    /// Colours: blue, green, red and alpha, byte by byte.
    pub fn colors(&self, header: &Header, field: usize) -> impl Iterator<Item = [u8; 4]> {
        let has_alpha = header.fields[field].name == "rgba";
        let color = move |bytes: &[u8]| match *bytes {
            [b, g, r, a] => [r, g, b, if has_alpha { a } else { 255 }],
            _ => [255; 4],
        };
        self.raw(header, field, 0).map(color)
    }
}

fn number(kind: u8, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (b'F', &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]).into(),
        (b'F', bytes) => bytes.first_chunk().map_or(f64::NAN, |&b| f64::from_le_bytes(b)),
        (kind, bytes) => {
            let negative = kind == b'I' && bytes.last().is_some_and(|b| b & 0x80 > 0);
            let mut all = if negative { [0xff; 8] } else { [0; 8] };
            all.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
            if kind == b'I' { i64::from_le_bytes(all) as f64 } else { u64::from_le_bytes(all) as f64 }
        }
    }
}

/// Numbers of a text, as bytes of a binary file.
fn ascii(input: &Input, header: &Header, text: &[u8], length: usize) -> Result<Vec<u8>, ReadError> {
    let mut cursor = Cursor::new(text, header.line);
    let mut bytes = Vec::with_capacity(length);
    for point in 0..header.points {
        for field in &header.fields {
            for _ in 0..field.count {
                cursor.skip_space();
                let whole = if field.kind == b'F' { None } else { cursor.integer() };
                let Some(value) = whole.map(|n| n as f64).or_else(|| cursor.float()) else {
                    let expected = format!("{} of point {point} of {}", field.name, header.points);
                    return Err(cursor.expected(&input.name, expected));
                };
                match (field.kind, field.size) {
                    (b'F', 4) => bytes.extend((value as f32).to_le_bytes()),
                    (b'F', _) => bytes.extend(value.to_le_bytes()),
                    (b'I', size) => bytes.extend(&(value as i64).to_le_bytes()[..size]),
                    (_, size) => bytes.extend(&(value as u64).to_le_bytes()[..size]),
                }
            }
        }
    }
    Ok(bytes)
}
