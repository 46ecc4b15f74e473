//! Vertices and faces of ASCII files, and the mesh that is made of them.

use glam::DVec3;

use crate::error::{counted, expected_vertex, ignored_empty_faces};
use crate::io::text::Cursor;
use crate::io::{NotDrawn, ReadModel, ReadOptions, ReadReport, Translucent, input::Input};
use crate::mesh::{MAX_ELEMENTS, localize_at};
use crate::polygon::Triangulator;
use crate::strokes::Strokes;
use crate::{Mesh, OctNormal, ReadError};

use super::header::{Header, float, integer, line_is_over};

/// Bytes between two reports of progress.
const STEP: usize = 1 << 16;

/// Colours as in the file, and the range of their numbers.
#[derive(Default)]
pub struct Colors {
    /// One per element; NaN where it has none.
    values: Vec<[f32; 4]>,
    largest: f32,
    given: usize,
    /// Colours that are not finite.
    broken: u64,
}

/// Reports from time to time how far the cursor has come.
struct Reporter<'a> {
    input: &'a Input,
    options: &'a ReadOptions<'a>,
    reported: usize,
}

impl Reporter<'_> {
    #[inline]
    fn report(&mut self, cursor: &Cursor) {
        if cursor.offset() - self.reported >= STEP {
            let read = cursor.offset() - self.reported;
            self.reported = cursor.offset();
            self.input.consumed(read);
            if let Some(p) = self.options.progress {
                p.advance(read as u64);
            }
        }
    }

    /// Skips white space and comments, which may be longer than everything else.
    #[inline]
    fn skip_to_word(&mut self, cursor: &mut Cursor) {
        loop {
            while !cursor.skip_space_up_to(STEP) {
                self.report(cursor);
            }
            if cursor.rest().first() != Some(&b'#') {
                return;
            }
            cursor.skip_line();
            self.report(cursor);
        }
    }
}

/// Skips white space and comments before the counts.
pub fn skip_to_word(input: &Input, cursor: &mut Cursor) {
    let reported = cursor.offset();
    Reporter { input, options: &ReadOptions::default(), reported }.skip_to_word(cursor);
}

/// All vertices of a file.
pub struct Vertices {
    pub positions: Vec<[f64; 3]>,
    pub normals: Vec<OctNormal>,
    pub texcoords: Vec<[f32; 2]>,
    pub colors: Colors,
}

/// All faces of a file.
#[derive(Default)]
pub struct Faces {
    triangles: Vec<[u32; 3]>,
    /// Face of each triangle.
    faces: Vec<u32>,
    /// One per face.
    colors: Colors,
    kept: u64,
    /// Faces with one corner and with two.
    points: u64,
    lines: u64,
    /// Faces without corners.
    empty: u64,
}

/// Reads everything after the counts.
///
/// # Errors
/// An invalid number, an unexpected end of the file, or too little memory.
pub fn read(
    input: &Input,
    options: &ReadOptions,
    mut header: Header,
    mut cursor: Cursor,
) -> Result<ReadModel, ReadError> {
    check_counts(input, options, &header)?;
    if let Some(p) = options.progress {
        p.begin("parsing", (cursor.offset() + cursor.rest().len()) as u64);
    }
    let mut reporter = Reporter { input, options, reported: 0 };
    let file = input.name.as_str();
    let vertices = read_vertices(file, &header, &mut cursor, &mut reporter)?;
    let faces = read_faces(input, &header, &mut cursor, &vertices.positions, &mut reporter)?;
    reporter.skip_to_word(&mut cursor);
    if !cursor.is_at_end() {
        let warning = format!("ignored what follows the last face, from line {}", cursor.line());
        header.warnings.push(warning);
    }
    let format = if header.dialect() == "OFF" { String::new() } else { format!(", {}", header.dialect()) };
    Ok(model(input, options.origin, header, vertices, faces, format!("OFF{format}")))
}

/// Checks the counts, before memory is taken.
///
/// # Errors
/// Too many elements, or too little memory for them.
pub fn check_counts(input: &Input, options: &ReadOptions, header: &Header) -> Result<(), ReadError> {
    for (what, count) in [("vertices", header.vertices), ("faces", header.faces)] {
        if count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: input.name.clone(), what, count });
        }
    }
    // The header's check against the size of the file keeps these products far below 2^64.
    let vertex =
        36 + 20 * u64::from(header.colors) + 16 * u64::from(header.normals) + 8 * u64::from(header.texcoords);
    let needed = header.vertices * vertex + header.faces * 36;
    options.check_memory(&input.name, "vertices and faces", input.held_bytes() + needed)
}

/// Makes the mesh.
pub fn model(
    input: &Input,
    origin: Option<DVec3>,
    header: Header,
    vertices: Vertices,
    faces: Faces,
    format: String,
) -> ReadModel {
    let mut warnings = header.warnings;
    if faces.empty > 0 {
        warnings.push(ignored_empty_faces(faces.empty));
    }
    for (colors, whose) in [(&vertices.colors, "vertices"), (&faces.colors, "faces")] {
        if colors.broken > 0 {
            let broken = counted(colors.broken, "colour");
            warnings.push(format!("set {broken} of {whose} that were not finite to white"));
        }
    }
    let is_split =
        faces.triangles.len() as u64 != faces.kept || faces.faces.iter().zip(0..).any(|(&f, i)| f != i);
    let face_colors = faces.colors.bytes().map(|colors| {
        faces.faces.iter().map(|&f| colors.get(f as usize).copied().unwrap_or([255; 4])).collect()
    });
    let (coordinates, origin, positions) = localize_at(&vertices.positions, origin);
    let mesh = Mesh {
        origin,
        positions,
        triangles: faces.triangles,
        normals: header.normals.then_some(vertices.normals),
        vertex_colors: vertices.colors.bytes(),
        face_colors,
        texcoords: header.texcoords.then_some(vertices.texcoords),
        face_of_triangle: is_split.then_some(faces.faces),
        ..Mesh::default()
    };
    let report = ReadReport {
        format,
        file_bytes: input.file_bytes,
        faces: faces.kept,
        translucent: Translucent::default(),
        not_drawn: NotDrawn { points: faces.points, lines: faces.lines, ..NotDrawn::default() },
        companions: Vec::new(),
        warnings,
    };
    ReadModel { mesh, strokes: Strokes::default(), coordinates, report }
}

fn read_vertices(
    file: &str,
    header: &Header,
    cursor: &mut Cursor,
    reporter: &mut Reporter,
) -> Result<Vertices, ReadError> {
    let mut vertices = Vertices::with_room(header);
    for i in 0..header.vertices {
        let mut number = |what: &str| {
            reporter.skip_to_word(cursor);
            float(cursor)
                .ok_or_else(|| cursor.expected(file, format!("{what} of vertex {i} of {}", header.vertices)))
        };
        let mut position = [0.0; 3];
        if header.is_plain() {
            for x in &mut position {
                *x = number("a coordinate")?;
            }
        } else {
            let mut last = 1.0;
            for k in 0..header.coordinates {
                last = number("a coordinate")?;
                if let Some(x) = position.get_mut(k as usize) {
                    *x = last;
                }
            }
            position = header.position(position, last);
        }
        vertices.positions.push(position);
        if header.normals {
            let mut normal = [0.0; 3];
            for x in &mut normal {
                *x = number("a normal's coordinate")?;
            }
            vertices.normals.push(OctNormal::from_vector(normal));
        }
        if header.colors {
            // There may be three or four numbers, so they are read up to the end of the line.
            let (numbers, count) = rest_of_line(file, cursor, "a colour or a texture coordinate")?;
            let colors = if header.texcoords { count.saturating_sub(2) } else { count };
            if header.texcoords {
                match numbers.get(colors..count) {
                    Some(&[u, v]) => vertices.texcoords.push([u, v]),
                    _ => return Err(cursor.expected(file, "two texture coordinates")),
                }
            }
            let known = vertices.colors.push(numbers.get(..colors).unwrap_or_default());
            if !known {
                return Err(
                    cursor.expected(file, format!("a colour of three or four numbers instead of {colors}"))
                );
            }
        } else if header.texcoords {
            let u = number("a texture coordinate")? as f32;
            let v = number("a texture coordinate")? as f32;
            vertices.texcoords.push([u, v]);
        }
        reporter.report(cursor);
    }
    Ok(vertices)
}

/// At most seven numbers up to the end of the line.
fn rest_of_line(file: &str, cursor: &mut Cursor, what: &str) -> Result<([f32; 7], usize), ReadError> {
    let mut numbers = [0.0; 7];
    let mut count = 0;
    while !line_is_over(cursor) {
        match (float(cursor), numbers.get_mut(count)) {
            (Some(value), Some(slot)) => *slot = value as f32,
            (Some(_), None) => return Err(cursor.expected(file, "the end of the line")),
            (None, _) => return Err(cursor.expected(file, what)),
        }
        count += 1;
    }
    Ok((numbers, count))
}

fn read_faces(
    input: &Input,
    header: &Header,
    cursor: &mut Cursor,
    positions: &[[f64; 3]],
    reporter: &mut Reporter,
) -> Result<Faces, ReadError> {
    let file = input.name.as_str();
    let mut faces = Faces::with_room(header);
    let mut scratch = Scratch::default();
    let mut polygon = Vec::new();
    for i in 0..header.faces {
        reporter.skip_to_word(cursor);
        let before = cursor.clone();
        let corners = match integer(cursor) {
            // Each corner takes at least a digit and a blank.
            Some(n) if n >= 0 && n as u64 <= cursor.rest().len() as u64 / 2 => n as usize,
            Some(_) => return Err(before.expected(file, "a number of corners that the file has room for")),
            None => {
                return Err(
                    before.expected(file, format!("the number of corners of face {i} of {}", header.faces))
                );
            }
        };
        polygon.clear();
        for _ in 0..corners {
            reporter.report(cursor);
            reporter.skip_to_word(cursor);
            let before = cursor.clone();
            match integer(cursor).and_then(|v| u32::try_from(v).ok()) {
                Some(v) if u64::from(v) < header.vertices => polygon.push(v),
                _ => {
                    return Err(before.expected(file, expected_vertex(header.vertices)));
                }
            }
        }
        let (numbers, count) = rest_of_line(file, cursor, "a colour of a face")?;
        let numbers = numbers.get(..count).unwrap_or_default();
        if !faces.push(file, &polygon, numbers, positions, &mut scratch)? {
            return Err(
                cursor.expected(file, format!("a colour of three or four numbers instead of {count}"))
            );
        }
        reporter.report(cursor);
    }
    Ok(faces)
}

impl Vertices {
    /// Empty, with room for all that the header counts.
    pub fn with_room(header: &Header) -> Self {
        let room = |wanted: bool| if wanted { header.vertices as usize } else { 0 };
        Self {
            positions: Vec::with_capacity(room(true)),
            normals: Vec::with_capacity(room(header.normals)),
            texcoords: Vec::with_capacity(room(header.texcoords)),
            colors: Colors { values: Vec::with_capacity(room(header.colors)), ..Colors::default() },
        }
    }
}

/// Working memory for triangulating polygons.
#[derive(Default)]
pub struct Scratch {
    triangulator: Triangulator,
    points: Vec<[f64; 3]>,
}

impl Faces {
    /// Empty, with room for all that the header counts.
    pub fn with_room(header: &Header) -> Self {
        let room = header.faces as usize;
        Self { triangles: Vec::with_capacity(room), faces: Vec::with_capacity(room), ..Self::default() }
    }

    /// Appends a face with the numbers of its colour, if it has three corners or more. False if the numbers are not a
    /// colour.
    ///
    /// # Errors
    /// More triangles than can be numbered.
    #[inline]
    pub fn push(
        &mut self,
        file: &str,
        polygon: &[u32],
        color: &[f32],
        positions: &[[f64; 3]],
        scratch: &mut Scratch,
    ) -> Result<bool, ReadError> {
        if polygon.len() < 3 {
            match polygon.len() {
                0 => self.empty += 1,
                1 => self.points += 1,
                _ => self.lines += 1,
            }
            return Ok(true);
        }
        // One number is an index into a colour map, which is not available.
        if !self.colors.push(if color.len() == 1 { &[] } else { color }) {
            return Ok(false);
        }
        if let &[a, b, c] = polygon {
            self.triangles.push([a, b, c]);
        } else {
            scratch.points.clear();
            scratch.points.extend(polygon.iter().map(|&v| positions[v as usize]));
            scratch.triangulator.triangulate(&scratch.points, |t| self.triangles.push(t.map(|k| polygon[k])));
        }
        let count = self.triangles.len() as u64;
        if count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: file.into(), what: "triangles", count });
        }
        self.faces.resize(self.triangles.len(), self.kept as u32);
        self.kept += 1;
        Ok(true)
    }
}

impl Colors {
    /// Appends the numbers of a colour, or none; false for any other count of numbers.
    pub fn push(&mut self, numbers: &[f32]) -> bool {
        let mut color = match *numbers {
            [] => [f32::NAN; 4],
            [r, g, b] => [r, g, b, f32::INFINITY],
            [r, g, b, a] => [r, g, b, a],
            _ => return false,
        };
        if !numbers.is_empty() {
            self.given += 1;
            if numbers.iter().all(|x| x.is_finite()) {
                self.largest = numbers.iter().fold(self.largest, |a, &b| a.max(b));
            } else {
                self.broken += 1;
                color = [f32::NAN; 4];
            }
        }
        self.values.push(color);
        true
    }

    /// In bytes; `None` if no element has a colour. Elements without one become white.
    ///
    /// Files hold numbers from 0 to 1 or from 0 to 255, written as integers or not; which of the two is meant follows
    /// only from the largest number.
    fn bytes(&self) -> Option<Vec<[u8; 4]>> {
        let scale = if self.largest > 1.0 { 1.0 } else { 255.0 };
        let byte = |x: f32| (x * scale).round() as u8;
        (self.given > 0).then(|| {
            let white = |c: &[f32; 4]| if c[0].is_nan() { [255; 4] } else { c.map(byte) };
            self.values.iter().map(white).collect()
        })
    }
}
