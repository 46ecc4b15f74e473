//! The keyword, the counts, and what may precede them.

use crate::ReadError;
use crate::error::{Place, counted, printable};
use crate::io::text::{Cursor, parse_integer};

/// What the file says it holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// `C`: vertices have colours.
    pub colors: bool,
    /// `N`: vertices have normals.
    pub normals: bool,
    /// `ST`: vertices have texture coordinates.
    pub texcoords: bool,
    /// Number of coordinates of a position.
    pub coordinates: u64,
    /// `4`: the last number of a position divides the others.
    pub homogeneous: bool,
    /// Number of vertices.
    pub vertices: u64,
    /// Number of faces.
    pub faces: u64,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl Header {
    /// The keyword, without the encoding of the numbers.
    pub fn dialect(&self) -> String {
        let n = self.coordinates != 3 && !self.homogeneous;
        let letters = [
            (self.texcoords, "ST"),
            (self.colors, "C"),
            (self.normals, "N"),
            (self.homogeneous, "4"),
            (n, "n"),
        ];
        letters.iter().filter(|l| l.0).map(|l| l.1).chain(["OFF"]).collect()
    }

    /// Are positions three numbers that need no conversion?
    #[inline]
    pub fn is_plain(&self) -> bool {
        self.coordinates == 3 && !self.homogeneous
    }

    /// A position from its first three numbers and its last one.
    ///
    /// Homogeneous coordinates are divided by the last; of more than three dimensions the first three are drawn, as
    /// Geomview does by default.
    #[inline]
    pub fn position(&self, first: [f64; 3], last: f64) -> [f64; 3] {
        if self.homogeneous { first.map(|x| x / last) } else { first }
    }
}

/// The letters before `OFF` and what follows in the same word.
struct Keyword<'a> {
    letters: &'a [u8],
    after: &'a [u8],
    /// An unrelated line before it.
    stray: Option<&'a [u8]>,
}

/// Splits a word into keyword and rest; the rest may begin with the counts.
fn keyword(word: &[u8]) -> Option<Keyword<'_>> {
    let at = word.windows(3).position(|w| w == b"OFF")?;
    let (letters, after) = (word.get(..at)?, word.get(at + 3..)?);
    let mut rest = letters;
    while !rest.is_empty() {
        rest = [&b"ST"[..], b"C", b"N", b"4", b"n"].iter().find_map(|p| rest.strip_prefix(*p))?;
    }
    (after.first().is_none_or(|b| b.is_ascii_digit() || *b == b'#')).then_some(Keyword {
        letters,
        after,
        stray: None,
    })
}

/// Skips white space and comments, over line ends.
pub fn skip_to_word(cursor: &mut Cursor) {
    loop {
        cursor.skip_space();
        if cursor.rest().first() != Some(&b'#') {
            return;
        }
        cursor.skip_line();
    }
}

/// True if nothing but a comment is left on the line.
pub fn line_is_over(cursor: &mut Cursor) -> bool {
    cursor.line_is_over() || cursor.rest().first() == Some(&b'#')
}

/// The next word as a number; a comment may follow it without a blank. `None` if it is not a number; the cursor then
/// stays.
#[inline]
pub fn float(cursor: &mut Cursor) -> Option<f64> {
    cursor.float().or_else(|| before_comment(cursor, |word| fast_float2::parse(word).ok()))
}

/// The same for whole numbers.
#[inline]
pub fn integer(cursor: &mut Cursor) -> Option<i64> {
    let whole =
        |word: &[u8]| parse_integer(word).filter(|&(_, len)| len == word.len()).map(|(value, _)| value);
    cursor.integer().or_else(|| before_comment(cursor, whole))
}

#[cold]
fn before_comment<T>(cursor: &mut Cursor, parse: impl Fn(&[u8]) -> Option<T>) -> Option<T> {
    let mut ahead = cursor.clone();
    let word = ahead.word();
    let value = parse(word.get(..word.iter().position(|&b| b == b'#')?)?)?;
    while !ahead.line_is_over() {
        ahead.word();
    }
    *cursor = ahead;
    Some(value)
}

/// Skips the appearance of an object, which Geomview allows before it: a block in braces, which may hold further
/// blocks.
fn skip_appearance(cursor: &mut Cursor) {
    skip_to_word(cursor);
    let mut ahead = cursor.clone();
    if ahead.word() != b"appearance" {
        return;
    }
    let mut depth = 0i64;
    loop {
        skip_to_word(&mut ahead);
        let word = ahead.word();
        if word.is_empty() {
            return;
        }
        depth += word.iter().map(|b| i64::from(*b == b'{') - i64::from(*b == b'}')).sum::<i64>();
        if depth <= 0 {
            *cursor = ahead;
            skip_to_word(cursor);
            return;
        }
    }
}

/// Moves past the keyword, which is the first word after an appearance, or the first word of the next line if counts
/// follow it. Without a keyword the cursor stays where the counts should be.
fn find_keyword<'a>(cursor: &mut Cursor<'a>) -> Option<Keyword<'a>> {
    skip_appearance(cursor);
    let mut ahead = cursor.clone();
    if let Some(keyword) = keyword(ahead.word()) {
        *cursor = ahead;
        return Some(keyword);
    }
    let mut ahead = cursor.clone();
    let stray = ahead.rest_of_line();
    skip_to_word(&mut ahead);
    let keyword = keyword(ahead.word()).filter(|k| k.after.is_empty())?;
    let mut after = ahead.clone();
    skip_to_word(&mut after);
    if after.clone().word() != b"BINARY" && counts(&mut after).is_none() {
        return None;
    }
    *cursor = ahead;
    Some(Keyword { stray: Some(stray), ..keyword })
}

/// Counts on one line: vertices, faces, and edges, which many files leave out.
fn counts(cursor: &mut Cursor) -> Option<[u64; 2]> {
    let mut next = || integer(cursor).and_then(|n| u64::try_from(n).ok());
    Some([next()?, next()?])
}

/// See [`super::looks_like`].
pub fn looks_like(front: &[u8], file_len: usize) -> bool {
    let mut cursor = Cursor::new(front, 1);
    if find_keyword(&mut cursor).is_some() {
        return true;
    }
    // Without the keyword: two or three counts alone on a line, for which the file has room, then a position.
    let Some([vertices, faces]) = counts(&mut cursor) else { return false };
    if !line_is_over(&mut cursor)
        && (integer(&mut cursor).is_none_or(|n| n < 0) || !line_is_over(&mut cursor))
    {
        return false;
    }
    let fits = least_bytes(vertices, faces, 3).is_some_and(|n| n <= file_len as u64);
    skip_to_word(&mut cursor);
    vertices >= 3 && faces > 0 && fits && (0..3).all(|_| float(&mut cursor).is_some())
}

/// The fewest bytes that this many vertices with this many numbers and this many faces can take: a digit and a blank
/// each.
pub fn least_bytes(vertices: u64, faces: u64, numbers: u64) -> Option<u64> {
    let vertices = vertices.checked_mul(numbers.checked_mul(2)?)?;
    vertices.checked_add(faces.checked_mul(2)?)
}

/// How the numbers after the keyword are written.
pub enum Encoding<'t> {
    /// As text, from here on.
    Ascii(Cursor<'t>),
    /// In binary, from this byte on.
    Binary(usize),
}

/// Reads what precedes the counts.
///
/// # Errors
/// An unsupported dialect.
pub fn parse_keyword<'t>(file: &str, text: &'t [u8]) -> Result<(Header, Encoding<'t>), ReadError> {
    let mut cursor = Cursor::new(text, 1);
    let mut header = Header { coordinates: 3, ..Header::default() };
    let Some(Keyword { letters, after, stray }) = find_keyword(&mut cursor) else {
        header.warnings.push("the keyword OFF is missing".into());
        return Ok((header, Encoding::Ascii(cursor)));
    };
    if let Some(line) = stray {
        header.warnings.push(format!("ignored the line before the keyword: {}", printable(line)));
    }
    let line = cursor.line();
    header.colors = letters.contains(&b'C');
    header.normals = letters.contains(&b'N');
    header.texcoords = letters.contains(&b'S');
    header.homogeneous = letters.contains(&b'4');
    if !after.is_empty() {
        // "OFF8 6 12": move back to the start of the counts.
        let at = text.len() - cursor.rest().len() - after.len();
        cursor = Cursor::new(text.get(at..).unwrap_or_default(), line);
    }
    if letters.contains(&b'n') {
        if header.homogeneous {
            let what = "OFF of any number of homogeneous coordinates (4nOFF)".into();
            return Err(ReadError::Unsupported { file: file.into(), place: Place::Line(line), what });
        }
        skip_to_word(&mut cursor);
        let before = cursor.clone();
        if before.clone().word() == b"BINARY" {
            let what = "binary OFF whose number of dimensions is binary, too (nOFF BINARY)".into();
            return Err(ReadError::Unsupported { file: file.into(), place: Place::Line(line), what });
        }
        let dimensions = integer(&mut cursor).and_then(|n| u64::try_from(n).ok()).filter(|&n| n > 0);
        header.coordinates =
            dimensions.ok_or_else(|| before.expected(file, "the number of coordinates of a vertex"))?;
        if header.coordinates > 3 {
            header.warnings.push(format!("drew the first 3 of {} dimensions", header.coordinates));
        }
    } else if header.homogeneous {
        header.coordinates = 4;
    }
    let mut ahead = cursor.clone();
    if ahead.word() == b"BINARY" && line_is_over(&mut ahead) {
        ahead.skip_line();
        return Ok((header, Encoding::Binary(text.len() - ahead.rest().len())));
    }
    Ok((header, Encoding::Ascii(cursor)))
}

/// Reads the counts.
///
/// # Errors
/// No counts, or more elements than the file has room for.
pub fn parse_counts(file: &str, header: &mut Header, cursor: &mut Cursor) -> Result<(), ReadError> {
    skip_to_word(cursor);
    let at_counts = cursor.clone();
    let Some([vertices, faces]) = counts(cursor) else {
        return Err(cursor.expected(file, "the numbers of vertices and faces"));
    };
    // The number of edges is not used and may be missing; so may the line end after the counts.
    if !line_is_over(cursor) && integer(cursor).is_none() {
        return Err(cursor.expected(file, "the number of edges"));
    }
    header.vertices = vertices;
    header.faces = faces;
    let others = 3 * u64::from(header.normals) + 2 * u64::from(header.texcoords);
    let left = cursor.rest().len() as u64;
    // The last number needs no blank after it.
    if least_bytes(vertices, faces, header.coordinates.saturating_add(others)).is_none_or(|n| n > left + 1) {
        return Err(ReadError::Malformed {
            file: file.into(),
            place: Place::Line(at_counts.line()),
            expected: format!("{vertices} vertices and {faces} faces"),
            found: format!("only {} after the counts", counted(left, "byte")),
        });
    }
    Ok(())
}
