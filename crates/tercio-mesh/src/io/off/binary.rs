//! Vertices and faces of binary files: three counts, then the vertices, then each face as its number of corners,
//! their vertices, and the components of its colour preceded by their number. All are 32-bit integers and floats.

use crate::error::{Place, counted, expected_vertex};
use crate::io::{ReadModel, ReadOptions, input::Input};
use crate::{OctNormal, ReadError};

use super::body::{self, Faces, Scratch, Vertices};
use super::header::Header;

/// Variants of the layout that programs write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    big_endian: bool,
    /// The number of colour components follows each face.
    colors: bool,
}

/// The standard layout of Geomview comes first. That big-endian numbers are tried before little-endian ones matters
/// only for files that fit both.
const LAYOUTS: [Layout; 4] = [
    Layout { big_endian: true, colors: true },
    Layout { big_endian: false, colors: true },
    Layout { big_endian: true, colors: false },
    Layout { big_endian: false, colors: false },
];

/// Bytes between two reports of consumed input.
const STEP: usize = 1 << 16;

/// A face with more corners needs a check of the memory limit.
const LARGE: usize = 1 << 16;

/// The bytes of a file and the read position.
#[derive(Clone, Copy)]
struct Words<'a> {
    input: &'a Input,
    options: &'a ReadOptions<'a>,
    bytes: &'a [u8],
    at: usize,
    /// Position up to which bytes were reported as consumed.
    reported: usize,
    layout: Layout,
}

/// What the faces need.
#[derive(Default)]
struct Extent {
    end: usize,
    triangles: u64,
}

/// Reads the contents from byte `at` on.
///
/// # Errors
/// An invalid number, an unexpected end of the file, or too little memory.
pub fn read(
    input: &Input,
    options: &ReadOptions,
    mut header: Header,
    at: usize,
) -> Result<ReadModel, ReadError> {
    let begin = |layout| Words { input, options, bytes: input.bytes(), at, reported: at, layout };
    options.check_memory(&input.name, "the file", input.held_bytes())?;
    if let Some(p) = options.progress {
        p.begin("parsing", input.bytes().len() as u64);
    }
    // The error of the standard layout is the one that is reported.
    let mut first_error = None;
    let mut found = None;
    for layout in LAYOUTS {
        match begin(layout).extent(&header) {
            Ok(extent) if layout == LAYOUTS[0] || begin(layout).is_rest_empty(extent.end) => {
                found = Some((layout, extent));
                break;
            }
            Ok(_) => {}
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    let Some((layout, extent)) = found else {
        return Err(first_error.unwrap_or_else(|| begin(LAYOUTS[0]).expected("faces", "others")));
    };
    let mut words = begin(layout);
    words.counts(&mut header)?;
    body::check_counts(input, options, &header)?;
    // Faces of more than three corners become more triangles than there are faces.
    let triangles = extent.triangles * 16 + header.vertices * 60 + header.faces * 36;
    options.check_memory(&input.name, "triangles", input.held_bytes() + triangles)?;

    let vertices = words.vertices(&header)?;
    let mut faces = Faces::with_room(&header);
    let mut scratch = Scratch::default();
    words.faces(&header, |polygon, color| {
        // Colours of two components were rejected.
        faces.push(&input.name, polygon, color, &vertices.positions, &mut scratch).map(drop)
    })?;
    if let Some(p) = options.progress {
        p.advance(input.bytes().len() as u64);
    }
    header.warnings.extend(layout.oddities().map(Into::into));
    let rest = input.bytes().len() - extent.end;
    if rest > 0 {
        header.warnings.push(format!("ignored {} after the last face", counted(rest as u64, "byte")));
    }
    let dialect = if header.dialect() == "OFF" { String::new() } else { format!("{}, ", header.dialect()) };
    let order = if layout.big_endian { "" } else { " little-endian" };
    let format = format!("OFF, {dialect}binary{order}");
    Ok(body::model(input, options.origin, header, vertices, faces, format))
}

impl Layout {
    fn oddities(self) -> impl Iterator<Item = &'static str> {
        let order = (!self.big_endian).then_some("the numbers are little-endian, which OFF does not know");
        let colors = (!self.colors).then_some("the faces lack the number of their colour's components");
        order.into_iter().chain(colors)
    }
}

impl Words<'_> {
    /// End of the faces and the number of their triangles, if they are valid.
    fn extent(mut self, header: &Header) -> Result<Extent, ReadError> {
        let mut header = header.clone();
        self.counts(&mut header)?;
        self.at += self.vertex_bytes(&header) as usize;
        self.reported = self.at;
        let mut triangles = 0;
        self.faces(&header, |polygon, _| {
            triangles += polygon.len().saturating_sub(2) as u64;
            Ok(())
        })?;
        Ok(Extent { end: self.at, triangles })
    }

    fn is_rest_empty(&self, at: usize) -> bool {
        self.input.all(self.bytes.get(at..).unwrap_or_default(), |b| b == 0)
    }

    /// Bytes of all vertices; saturates at a number that no file reaches.
    fn vertex_bytes(&self, header: &Header) -> u64 {
        let others =
            3 * u64::from(header.normals) + 4 * u64::from(header.colors) + 2 * u64::from(header.texcoords);
        let numbers = header.coordinates.saturating_add(others);
        header.vertices.saturating_mul(numbers.saturating_mul(4))
    }

    /// Reads the counts, and checks them against the bytes that are left.
    fn counts(&mut self, header: &mut Header) -> Result<(), ReadError> {
        let at = self.at;
        let negative =
            |words: &Self| words.expected("the numbers of vertices and faces", "a negative number");
        let mut next = || self.word("the number of vertices, faces or edges").map(i64::from);
        let (vertices, faces) = (next()?, next()?);
        next()?;
        header.vertices = u64::try_from(vertices).map_err(|_| negative(self))?;
        header.faces = u64::try_from(faces).map_err(|_| negative(self))?;
        let face = if self.layout.colors { 8 } else { 4 };
        let needed = self.vertex_bytes(header).saturating_add(header.faces * face);
        let left = (self.bytes.len() - self.at) as u64;
        if needed > left {
            self.at = at;
            let expected = format!("{vertices} vertices and {faces} faces, at least {needed} bytes");
            return Err(self.expected(&expected, &format!("only {} after the counts", counted(left, "byte"))));
        }
        Ok(())
    }

    fn vertices(&mut self, header: &Header) -> Result<Vertices, ReadError> {
        let mut vertices = Vertices::with_room(header);
        for _ in 0..header.vertices {
            let (mut position, mut last) = ([0.0; 3], 1.0);
            for k in 0..header.coordinates {
                last = f64::from(self.float()?);
                if let Some(x) = position.get_mut(k as usize) {
                    *x = last;
                }
            }
            vertices.positions.push(header.position(position, last));
            if header.normals {
                let normal = [self.float()?, self.float()?, self.float()?];
                vertices.normals.push(OctNormal::from_vector(normal.map(f64::from)));
            }
            if header.colors {
                vertices.colors.push(&[self.float()?, self.float()?, self.float()?, self.float()?]);
            }
            if header.texcoords {
                vertices.texcoords.push([self.float()?, self.float()?]);
            }
        }
        Ok(vertices)
    }

    /// Reads the faces and passes on their corners and colours of 0, 1, 3 or 4 components.
    fn faces(
        &mut self,
        header: &Header,
        mut take: impl FnMut(&[u32], &[f32]) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        // What other programs write has no smaller faces; there a 0 is the number of components of a colour.
        let least = if self.layout == LAYOUTS[0] { 0 } else { 3 };
        let mut polygon = Vec::new();
        for face in 0..header.faces {
            let corners = self.word("the number of corners of a face")?;
            let room = (self.bytes.len() - self.at) / 4;
            if usize::try_from(corners).map_or(true, |n| !(least..=room).contains(&n)) {
                self.at -= 4;
                let expected =
                    format!("the number of corners of face {face}, and as many in the rest of the file");
                let found = format!("{corners} and {} after it", counted(4 * room as u64, "byte"));
                return Err(self.expected(&expected, &found));
            }
            polygon.clear();
            if corners as usize > LARGE {
                // A growing vector may take twice its size.
                let needed = self.input.held_bytes() + 8 * corners as u64;
                self.options.check_memory(&self.input.name, "a face", needed)?;
            }
            for _ in 0..corners {
                let vertex = self.word("a vertex of a face")?;
                match u32::try_from(vertex) {
                    Ok(v) if u64::from(v) < header.vertices => polygon.push(v),
                    _ => {
                        self.at -= 4;
                        return Err(self.expected(&expected_vertex(header.vertices), &vertex.to_string()));
                    }
                }
            }
            let mut color = [0.0; 4];
            let mut components = 0;
            if self.layout.colors {
                let count = self.word("the number of components of a face's colour")?;
                components = usize::try_from(count).ok().filter(|&n| n <= 4 && n != 2).ok_or_else(|| {
                    let at_count = Self { at: self.at - 4, ..*self };
                    at_count.expected("0, 1, 3 or 4 components of a face's colour", &count.to_string())
                })?;
                for value in color.iter_mut().take(components) {
                    *value = self.float()?;
                }
            }
            take(&polygon, color.get(..components).unwrap_or_default())?;
        }
        Ok(())
    }

    fn next(&mut self) -> Option<[u8; 4]> {
        let word = *self.bytes.get(self.at..)?.first_chunk()?;
        self.at += 4;
        if self.at >= self.reported + STEP {
            self.input.consumed(self.at - self.reported);
            self.reported = self.at;
        }
        Some(word)
    }

    fn word(&mut self, what: &str) -> Result<i32, ReadError> {
        let word = self.next().ok_or_else(|| self.expected(what, "the end of the file"))?;
        Ok(if self.layout.big_endian { i32::from_be_bytes(word) } else { i32::from_le_bytes(word) })
    }

    fn float(&mut self) -> Result<f32, ReadError> {
        let word = self.next().ok_or_else(|| self.expected("a number", "the end of the file"))?;
        Ok(if self.layout.big_endian { f32::from_be_bytes(word) } else { f32::from_le_bytes(word) })
    }

    #[cold]
    fn expected(&self, expected: &str, found: &str) -> ReadError {
        ReadError::Malformed {
            file: self.input.name.clone(),
            place: Place::Byte(self.at as u64),
            expected: expected.into(),
            found: found.into(),
        }
    }
}
