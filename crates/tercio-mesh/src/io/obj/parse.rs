//! Parses one chunk of an OBJ file into arrays of its own.

use crate::OctNormal;
use crate::error::{Place, ReadError, printable};

use super::faces::{Corners, vertex_number};
use super::lines::{Counts, Kind, Line, Lines, join, kind};

/// Keywords that do not affect what is drawn; among them all that refine a curve or a surface.
const SILENT: [&[u8]; 23] = [
    b"s",
    b"mg",
    b"lod",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"usemap",
    b"maplib",
    b"vp",
    b"deg",
    b"cstype",
    b"bmat",
    b"step",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"con",
    b"ctech",
    b"end",
];

/// How many different unknown keywords are kept.
pub const UNKNOWN_KEPT: usize = 8;

/// What a chunk needs to know about the rest of the file.
pub struct Context<'c> {
    /// File name for messages.
    pub file: &'c str,
    /// Counts of the lines before the chunk.
    pub before: Counts,
    /// Counts of the whole file.
    pub total: Counts,
}

/// Where the chunk's own vertices are written: exactly as many as [`Counts`] found in it.
pub struct Slots<'s> {
    /// From `v`.
    pub positions: &'s mut [[f64; 3]],
    /// From `vt`.
    pub texcoords: &'s mut [[f32; 2]],
    /// From `vn`.
    pub normals: &'s mut [OctNormal],
}

/// A name that applies from a face on: the face's number in the chunk, and the name.
pub type NameFrom<'a> = (u32, &'a [u8]);

/// A name of a material, with the numbers in the chunk of the face, the segment and the point that follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint<'a> {
    /// As in the file.
    pub name: &'a [u8],
    /// Number of the next face.
    pub face: u32,
    /// Index into [`Chunk::segments`].
    pub segment: u32,
    /// Index into [`Chunk::dots`].
    pub dot: u32,
}

/// Parsed contents of a chunk.
#[derive(Debug, Default, PartialEq)]
pub struct Chunk<'a> {
    /// The faces' corners.
    pub corners: Corners,
    /// Red, green, blue, alpha as in the file, one per vertex; empty if none has a colour. Vertices without one have
    /// NaN.
    pub colors: Vec<[f32; 4]>,
    /// `usemtl`
    pub materials: Vec<Paint<'a>>,
    /// `g`
    pub groups: Vec<NameFrom<'a>>,
    /// `o`
    pub objects: Vec<NameFrom<'a>>,
    /// Number of `v` lines.
    pub vertices: u64,
    /// The words after `mtllib`.
    pub libraries: Vec<&'a [u8]>,
    /// Points in `p` lines.
    pub points: u64,
    /// Number of `l` lines
    pub lines: u64,
    /// Vertex numbers of the segments of `l` lines.
    pub segments: Vec<[u32; 2]>,
    /// Vertex numbers of `p` lines.
    pub dots: Vec<u32>,
    /// Words of these lines that are no numbers of vertices.
    pub not_vertices: u64,
    /// `curv` and `curv2`
    pub curves: u64,
    /// `surf`
    pub surfaces: u64,
    /// Faces with fewer than three corners.
    pub small_faces: u64,
    /// Line of the first one.
    pub first_small_face: Option<u64>,
    /// Numbers in notations that only a tolerant reader accepts.
    pub odd_numbers: u64,
    /// Lines that begin with a word that is not known.
    pub unknown_lines: u64,
    /// The first few of these words.
    pub unknown: Vec<&'a [u8]>,
}

/// Parses `bytes`.
///
/// # Errors
/// The first line that cannot be understood.
pub fn parse<'a>(bytes: &'a [u8], context: &Context, slots: Slots) -> Result<Chunk<'a>, ReadError> {
    let mut chunk = Chunk::default();
    let mut scratch = Vec::new();
    let mut seen = Counts { lines: 0, ..context.before };
    let mut positions = slots.positions.iter_mut();
    let mut texcoords = slots.texcoords.iter_mut();
    let mut normals = slots.normals.iter_mut();
    for line in Lines::new(bytes, context.before.lines + 1) {
        let (kind, keyword) = kind(line.text);
        let joined = if line.continued { join(line.text, &mut scratch) } else { line.text };
        let mut words = Words { rest: &joined[keyword..], file: context.file, line: line.number, odd: 0 };
        match kind {
            Kind::Vertex => {
                let (position, color) = vertex(&mut words)?;
                if let Some(slot) = positions.next() {
                    *slot = position;
                }
                let local = (seen.vertices - context.before.vertices) as usize;
                match color {
                    Some(color) => {
                        chunk.colors.resize(local, [f32::NAN; 4]);
                        chunk.colors.push(color);
                    }
                    None if !chunk.colors.is_empty() => chunk.colors.push([f32::NAN; 4]),
                    None => {}
                }
                seen.vertices += 1;
            }
            Kind::Texcoord => {
                let u = words.number("a texture coordinate")?;
                let v = if words.is_over() { 0.0 } else { words.number("a texture coordinate")? };
                if let Some(slot) = texcoords.next() {
                    *slot = [u as f32, v as f32];
                }
                seen.texcoords += 1;
            }
            Kind::Normal => {
                let mut normal = [0.0; 3];
                for n in &mut normal {
                    *n = words.number("three coordinates of a normal")?;
                }
                if let Some(slot) = normals.next() {
                    *slot = OctNormal::from_vector(normal);
                }
                seen.normals += 1;
            }
            Kind::Face => {
                let corners = chunk.corners.push_face(&mut words, &seen, &context.total)?;
                if corners < 3 {
                    chunk.small_faces += 1;
                    chunk.first_small_face.get_or_insert(line.number);
                }
            }
            Kind::Other => other(&mut chunk, line, &mut words, (&seen, &context.total)),
        }
        chunk.odd_numbers += words.odd;
    }
    chunk.vertices = seen.vertices - context.before.vertices;
    Ok(chunk)
}

/// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`.
#[inline]
fn vertex(words: &mut Words) -> Result<([f64; 3], Option<[f32; 4]>), ReadError> {
    let mut position = [0.0; 3];
    for x in &mut position {
        *x = words.number("three coordinates of a vertex")?;
    }
    if words.is_over() {
        return Ok((position, None));
    }
    let mut more = [0.0; 4];
    let mut n = 0;
    while n < 4 && !words.is_over() {
        more[n] = words.number("a weight or a colour of a vertex")? as f32;
        n += 1;
    }
    // A single number is the weight of a rational curve's control point and has no meaning for polygons.
    let color = match n {
        3 => Some([more[0], more[1], more[2], 1.0]),
        4 => Some(more),
        _ => None,
    };
    Ok((position, color))
}

#[cold]
fn other<'a>(chunk: &mut Chunk<'a>, line: Line<'a>, words: &mut Words, (seen, total): (&Counts, &Counts)) {
    let next_face = chunk.corners.faces();
    let text = line.text.trim_ascii();
    let keyword = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    // The backslash that continues the line may directly follow the keyword.
    let keyword = keyword.strip_suffix(b"\\").filter(|_| line.continued).unwrap_or(keyword);
    let name = text.get(keyword.len()..).unwrap_or_default().trim_ascii();
    match keyword {
        b"" => {}
        _ if keyword.starts_with(b"#") => {}
        b"usemtl" => {
            let (segment, dot) = (chunk.segments.len() as u32, chunk.dots.len() as u32);
            chunk.materials.push(Paint { name, face: next_face, segment, dot });
        }
        b"g" => chunk.groups.push((next_face, name)),
        b"o" => chunk.objects.push((next_face, name)),
        b"mtllib" => chunk.libraries.push(name),
        b"l" => {
            words.word();
            chunk.lines += 1;
            let mut last = None;
            while !words.is_over() {
                let next = vertex_number(words.word(), seen, total);
                chunk.not_vertices += u64::from(next.is_none());
                chunk.segments.extend(last.zip(next).map(<[u32; 2]>::from));
                last = next;
            }
        }
        b"curv" | b"curv2" => chunk.curves += 1,
        b"surf" => chunk.surfaces += 1,
        b"p" => {
            words.word();
            while !words.is_over() {
                let vertex = vertex_number(words.word(), seen, total);
                chunk.not_vertices += u64::from(vertex.is_none());
                chunk.dots.extend(vertex);
                chunk.points += 1;
            }
        }
        _ if SILENT.contains(&keyword) => {}
        _ => {
            chunk.unknown_lines += 1;
            if chunk.unknown.len() < UNKNOWN_KEPT && !chunk.unknown.contains(&keyword) {
                chunk.unknown.push(keyword);
            }
        }
    }
}

/// The words of one line.
pub struct Words<'w> {
    /// What remains to be read.
    pub rest: &'w [u8],
    file: &'w str,
    line: u64,
    odd: u64,
}

impl<'w> Words<'w> {
    /// True if no word is left before the line end or a comment.
    #[inline]
    pub fn is_over(&mut self) -> bool {
        self.skip_blanks();
        matches!(self.rest.first(), None | Some(b'\n' | b'#'))
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while let [b' ' | b'\t' | b'\r' | 0x0b | 0x0c, rest @ ..] = self.rest {
            self.rest = rest;
        }
    }

    fn word(&mut self) -> &'w [u8] {
        self.skip_blanks();
        let len = self.rest.iter().position(|&b| ends_word(Some(b))).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(len);
        self.rest = rest;
        word
    }

    #[inline]
    fn number(&mut self, expected: &str) -> Result<f64, ReadError> {
        self.skip_blanks();
        if let Ok((value, len)) = fast_float2::parse_partial::<f64, _>(self.rest)
            && ends_word(self.rest.get(len).copied())
        {
            self.rest = &self.rest[len..];
            return Ok(value);
        }
        self.odd_number(expected)
    }

    /// Numbers as some programs write them: `1.#IND` and `1.#INF` (old C libraries of Microsoft), `-nan(ind)`, and an
    /// exponent after a stray sign, `3.1+e2`, of which only the part before the sign is used.
    #[cold]
    fn odd_number(&mut self, expected: &str) -> Result<f64, ReadError> {
        let mut ahead = Self { ..*self };
        let word = ahead.word();
        let unsigned = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
        let sign = if word.starts_with(b"-") { -1.0 } else { 1.0 };
        let value = if unsigned.starts_with(b"1.#INF") {
            Some(sign * f64::INFINITY)
        } else if ["1.#IND", "1.#QNAN", "1.#SNAN", "nan("].iter().any(|p| unsigned.starts_with(p.as_bytes()))
        {
            Some(f64::NAN)
        } else {
            match fast_float2::parse_partial::<f64, _>(word) {
                Ok((value, len)) if matches!(word.get(len..len + 2), Some(b"+e" | b"-e")) => Some(value),
                _ => None,
            }
        };
        match value {
            Some(value) => {
                self.rest = ahead.rest;
                self.odd += 1;
                Ok(value)
            }
            None => Err(self.expected(expected)),
        }
    }

    /// The error that `expected` was not found here.
    #[cold]
    pub fn expected(&self, expected: impl Into<String>) -> ReadError {
        let mut ahead = Self { ..*self };
        let found = match ahead.word() {
            [] => "the end of the line".into(),
            word => printable(word),
        };
        ReadError::Malformed {
            file: self.file.into(),
            place: Place::Line(self.line),
            expected: expected.into(),
            found,
        }
    }
}

#[inline]
pub fn ends_word(byte: Option<u8>) -> bool {
    matches!(byte, None | Some(b' ' | b'\n' | b'\t' | b'\r' | 0x0b | 0x0c))
}
