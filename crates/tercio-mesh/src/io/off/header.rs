//! The keyword, the counts, and what may stand before them.

use crate::ReadError;
use crate::error::Place;
use crate::io::text::{Cursor, parse_integer};

/// What the file says it holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Whether the keyword stood in the file.
    pub has_keyword: bool,
    /// `C`: vertices have colours.
    pub colors: bool,
    /// `N`: vertices have normals.
    pub normals: bool,
    /// `ST`: vertices have texture coordinates.
    pub texcoords: bool,
    /// Number of vertices.
    pub vertices: u64,
    /// Number of faces.
    pub faces: u64,
}

/// The letters before `OFF` and what follows behind it in the same word.
struct Keyword<'a> {
    letters: &'a [u8],
    behind: &'a [u8],
}

/// Splits a word into keyword and rest; the rest may begin with the counts.
fn keyword(word: &[u8]) -> Option<Keyword<'_>> {
    let at = word.windows(3).position(|w| w == b"OFF")?;
    let (letters, behind) = (word.get(..at)?, word.get(at + 3..)?);
    let mut rest = letters;
    while !rest.is_empty() {
        rest = [&b"ST"[..], b"C", b"N", b"4", b"n"].iter().find_map(|p| rest.strip_prefix(*p))?;
    }
    (behind.first().is_none_or(|b| b.is_ascii_digit() || *b == b'#')).then_some(Keyword { letters, behind })
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

/// The next word as a number; a comment may follow it without a blank. `None` and no step if it is none.
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

/// Geomview allows the appearance of an object before it: a block in braces, which may hold blocks.
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

/// Counts as they stand on one line: vertices, faces, and edges, which many files leave out.
fn counts(cursor: &mut Cursor) -> Option<[u64; 2]> {
    let mut next = || integer(cursor).and_then(|n| u64::try_from(n).ok());
    Some([next()?, next()?])
}

/// See [`super::looks_like`].
pub fn looks_like(front: &[u8], file_len: usize) -> bool {
    let mut cursor = Cursor::new(front, 1);
    skip_appearance(&mut cursor);
    let mut ahead = cursor.clone();
    if keyword(ahead.word()).is_some() {
        return true;
    }
    // Without the keyword: two or three counts alone on a line that the file has room for, then a position.
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

/// The fewest bytes that so many vertices of so many numbers and so many faces can take: a digit and a blank
/// each.
pub fn least_bytes(vertices: u64, faces: u64, numbers: u64) -> Option<u64> {
    let vertices = vertices.checked_mul(2 * numbers)?;
    vertices.checked_add(faces.checked_mul(2)?)
}

/// Reads up to the first vertex.
///
/// # Errors
/// No counts, more of them than the file has room for, or a dialect that is not drawn.
pub fn parse<'t>(file: &str, text: &'t [u8]) -> Result<(Header, Cursor<'t>), ReadError> {
    let mut cursor = Cursor::new(text, 1);
    skip_appearance(&mut cursor);
    let mut header = Header::default();
    let start = cursor.clone();
    let word = cursor.word();
    let unsupported = |line: u64, what: &str| ReadError::Unsupported {
        file: file.into(),
        place: Place::Line(line),
        what: what.into(),
    };
    match keyword(word) {
        Some(Keyword { letters, behind }) => {
            header.has_keyword = true;
            if letters.iter().any(|b| matches!(b, b'4' | b'n')) {
                return Err(unsupported(start.line(), "OFF of more than three dimensions"));
            }
            header.colors = letters.contains(&b'C');
            header.normals = letters.contains(&b'N');
            header.texcoords = letters.contains(&b'S');
            if !behind.is_empty() {
                // "OFF8 6 12": step back to what belongs to the counts.
                let at = cursor.offset() - behind.len();
                cursor = Cursor::new(text.get(at..).unwrap_or_default(), start.line());
            }
            let mut ahead = cursor.clone();
            if ahead.word() == b"BINARY" {
                return Err(unsupported(start.line(), "binary OFF"));
            }
        }
        None => cursor = start,
    }
    skip_to_word(&mut cursor);
    let at_counts = cursor.clone();
    let Some([vertices, faces]) = counts(&mut cursor) else {
        return Err(cursor.expected(file, "the numbers of vertices and faces"));
    };
    // The number of edges is not used and may be missing; so may the line end behind the counts.
    if !line_is_over(&mut cursor) && integer(&mut cursor).is_none() {
        return Err(cursor.expected(file, "the number of edges"));
    }
    header.vertices = vertices;
    header.faces = faces;
    let numbers = 3 + 3 * u64::from(header.normals) + 2 * u64::from(header.texcoords);
    let left = cursor.rest().len() as u64;
    // The last number needs no blank behind it.
    if least_bytes(vertices, faces, numbers).is_none_or(|least| least > left + 1) {
        return Err(ReadError::Malformed {
            file: file.into(),
            place: Place::Line(at_counts.line()),
            expected: format!("{vertices} vertices and {faces} faces"),
            found: format!("only {left} bytes behind the counts"),
        });
    }
    Ok((header, cursor))
}
