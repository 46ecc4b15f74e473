//! Logical lines: the text between two line ends, where a backslash at the end continues on the next line.

use crate::io::text::find;

/// Iterates over the logical lines of a chunk of text.
pub struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: u64,
}

/// A logical line with its line end, if it has one.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// All bytes including the line end.
    pub text: &'a [u8],
    /// Number of the first line in the file; the first is 1.
    pub number: u64,
    /// True if backslashes join several lines.
    pub continued: bool,
}

impl<'a> Lines<'a> {
    /// Starts at the front of `bytes`, which is line `number` of the file.
    pub fn new(bytes: &'a [u8], number: u64) -> Self {
        Self { bytes, at: 0, number }
    }

    /// The number of the next line.
    pub fn number(&self) -> u64 {
        self.number
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    #[inline]
    fn next(&mut self) -> Option<Line<'a>> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let number = self.number;
        let mut len = line_length(rest);
        self.number += 1;
        let mut continued = false;
        // Tested once per line: a comment begins with the first character that is not blank, which may come late in
        // the line.
        while ends_with_backslash(&rest[..len]) && (continued || !is_comment(rest)) {
            continued = true;
            if len == rest.len() {
                break;
            }
            len += line_length(&rest[len..]);
            self.number += 1;
        }
        self.at += len;
        Some(Line { text: &rest[..len], number, continued })
    }
}

/// Length of the first line with its line end.
#[inline]
fn line_length(bytes: &[u8]) -> usize {
    // Eight bytes at a time: a zero byte of `x` is a line feed; the lowest marked byte is always a true one.
    const ONES: u64 = u64::from_le_bytes([1; 8]);
    let (words, tail) = bytes.as_chunks::<8>();
    for (i, &word) in words.iter().enumerate() {
        let x = u64::from_le_bytes(word) ^ (ONES * b'\n' as u64);
        let zeros = x.wrapping_sub(ONES) & !x & (ONES << 7);
        if zeros != 0 {
            return i * 8 + zeros.trailing_zeros() as usize / 8 + 1;
        }
    }
    match tail.iter().position(|&b| b == b'\n') {
        Some(n) => words.len() * 8 + n + 1,
        None => bytes.len(),
    }
}

#[inline]
fn ends_with_backslash(line: &[u8]) -> bool {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    line.last() == Some(&b'\\')
}

/// Comments are not continued: one that ends with a Windows folder would swallow the next line.
#[cold]
fn is_comment(line: &[u8]) -> bool {
    line.trim_ascii_start().first() == Some(&b'#')
}

/// A continued line in one piece: backslashes and the line ends after them become blanks, so that every byte keeps
/// its position.
pub fn join<'s>(line: &[u8], scratch: &'s mut Vec<u8>) -> &'s [u8] {
    scratch.clear();
    let mut start = 0;
    while start < line.len() {
        let part = &line[start..start + line_length(&line[start..])];
        start += part.len();
        scratch.extend_from_slice(part);
        if ends_with_backslash(part) {
            let kept = scratch.len() - part.len();
            let ink = part.iter().rposition(|&b| b == b'\\').unwrap_or(0);
            scratch[kept + ink..].fill(b' ');
        }
    }
    scratch
}

/// Splits a text into chunks of about `step` bytes that end at the end of a logical line. `consumed` is called with
/// the number of bytes that were searched.
pub fn split(bytes: &[u8], step: usize, consumed: impl Fn(usize)) -> Vec<&[u8]> {
    let line_length = |bytes: &[u8]| find(|b| b == b'\n', bytes, &consumed).map_or(bytes.len(), |n| n + 1);
    let step = step.max(1);
    let mut parts = Vec::new();
    let mut rest = bytes;
    while rest.len() > step {
        let mut cut = step - 1;
        cut += line_length(&rest[cut..]);
        while cut < rest.len() && ends_with_backslash(&rest[..cut]) {
            cut += line_length(&rest[cut..]);
        }
        let (part, tail) = rest.split_at(cut);
        consumed(part.len());
        parts.push(part);
        rest = tail;
    }
    if !rest.is_empty() {
        parts.push(rest);
    }
    parts
}

/// The kind of a line, as far as it is needed before parsing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `v`
    Vertex,
    /// `vt`
    Texcoord,
    /// `vn`
    Normal,
    /// `f`
    Face,
    /// Anything else.
    Other,
}

/// The kind of a line, and the length of its keyword including leading blanks.
#[inline]
pub fn kind(line: &[u8]) -> (Kind, usize) {
    let indent = line.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    let over = |at: usize| {
        matches!(line.get(indent + at), None | Some(b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | b'\\'))
    };
    match (line.get(indent), line.get(indent + 1)) {
        (Some(b'v'), _) if over(1) => (Kind::Vertex, indent + 1),
        (Some(b'f'), _) if over(1) => (Kind::Face, indent + 1),
        (Some(b'v'), Some(b't')) if over(2) => (Kind::Texcoord, indent + 2),
        (Some(b'v'), Some(b'n')) if over(2) => (Kind::Normal, indent + 2),
        _ => (Kind::Other, indent),
    }
}

/// How many lines of each kind a chunk of text holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Lines of the file, each as one even if continued.
    pub lines: u64,
    /// `v`
    pub vertices: u64,
    /// `vt`
    pub texcoords: u64,
    /// `vn`
    pub normals: u64,
    /// `f`
    pub faces: u64,
}

impl Counts {
    /// Counts without parsing.
    pub fn of(bytes: &[u8]) -> Self {
        let mut counts = Self::default();
        let mut lines = Lines::new(bytes, 0);
        for line in &mut lines {
            match kind(line.text).0 {
                Kind::Vertex => counts.vertices += 1,
                Kind::Texcoord => counts.texcoords += 1,
                Kind::Normal => counts.normals += 1,
                Kind::Face => counts.faces += 1,
                Kind::Other => {}
            }
        }
        counts.lines = lines.number();
        counts
    }

    /// Sum of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            lines: self.lines + other.lines,
            vertices: self.vertices + other.vertices,
            texcoords: self.texcoords + other.texcoords,
            normals: self.normals + other.normals,
            faces: self.faces + other.faces,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn continued_lines_are_one_line_and_keep_their_numbers() {
        let text = b"v 1 \\\n 2 3\r\n# C:\\\nf 1 \\\r\n 2 \\\n 3\nl 1 \\";
        let lines: Vec<_> = Lines::new(text, 1).map(|l| (l.number, l.continued)).collect();
        assert_eq!(lines, [(1, true), (3, false), (4, true), (7, true)]);
        let mut scratch = Vec::new();
        let first = Lines::new(text, 1).next().map(|l| join(l.text, &mut scratch).to_vec());
        assert_eq!(first.as_deref(), Some(&b"v 1    2 3\r\n"[..]));
    }

    #[test]
    fn chunks_never_end_inside_a_logical_line() {
        let text = b"v 1 2 3\nf 1 \\\n 2 \\\n 3\nv 4 5 6\n";
        let whole: Vec<_> = Lines::new(text, 1).map(|l| l.text).collect();
        for step in 1..text.len() + 1 {
            let parts = split(text, step, |_| ());
            assert_eq!(parts.concat(), text);
            let cut: Vec<_> = parts.iter().flat_map(|p| Lines::new(p, 1)).map(|l| l.text).collect();
            assert_eq!(cut, whole, "step {step}");
        }
    }

    #[test]
    fn the_end_of_a_line_is_found_at_every_distance() {
        for n in 0..40 {
            let mut text = vec![b'\x0b'; n];
            text.extend(b"\nabc\n");
            assert_eq!(line_length(&text), n + 1);
        }
    }
}
