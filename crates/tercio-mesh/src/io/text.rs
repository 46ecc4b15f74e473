//! Reads ASCII formats byte by byte and keeps track of the position for error messages.

use crate::error::{Place, ReadError, printable};

/// A cursor over one chunk of a text file.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Cursor<'a> {
    /// Starts at the front of `bytes`, which is line `line` of the file.
    pub fn new(bytes: &'a [u8], line: u64) -> Self {
        Self { bytes, at: 0, line }
    }

    /// The line that the cursor is on; the first is 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Bytes from the front.
    pub fn offset(&self) -> usize {
        self.at
    }

    /// What remains to be read.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Moves over bytes that are no text and returns them; fewer at the end. Line ends in them do not count.
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let rest = self.rest();
        let taken = &rest[..count.min(rest.len())];
        self.at += taken.len();
        taken
    }

    /// Moves back over bytes of this line that were read last.
    pub fn step_back(&mut self, count: usize) {
        self.at = self.at.saturating_sub(count);
    }

    /// True at the end.
    pub fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    /// Skips blanks inside the line.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(b' ' | b'\t' | b'\r' | 0x0b | 0x0c) = self.bytes.get(self.at) {
            self.at += 1;
        }
    }

    /// Skips blanks and line ends.
    #[inline]
    pub fn skip_space(&mut self) {
        self.skip_space_up_to(usize::MAX);
    }

    /// The same for at most this many bytes; false if there may be more.
    #[inline]
    pub fn skip_space_up_to(&mut self, most: usize) -> bool {
        let end = self.bytes.len().min(self.at.saturating_add(most));
        while let Some(&b) = self.bytes[..end].get(self.at) {
            if !is_space(b) {
                return true;
            }
            self.line += u64::from(b == b'\n');
            self.at += 1;
        }
        end == self.bytes.len()
    }

    /// True if nothing but blanks is left on the line.
    #[inline]
    pub fn line_is_over(&mut self) -> bool {
        self.skip_blanks();
        matches!(self.bytes.get(self.at), None | Some(b'\n'))
    }

    /// Moves to the front of the next line.
    #[inline]
    pub fn skip_line(&mut self) {
        match self.bytes[self.at..].iter().position(|&b| b == b'\n') {
            Some(n) => {
                self.at += n + 1;
                self.line += 1;
            }
            None => self.at = self.bytes.len(),
        }
    }

    /// The next word on the line, without blanks; empty at the line's end.
    #[inline]
    pub fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let n = rest.iter().position(|b| b.is_ascii_whitespace() || *b == 0x0b).unwrap_or(rest.len());
        self.at += n;
        &rest[..n]
    }

    /// The rest of the line without its end and surrounding blanks; moves to the next line.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let from = self.at;
        self.skip_line();
        self.bytes[from..self.at].trim_ascii()
    }

    /// The next word as a number (decimal, exponent, `nan`, `inf`); `None` if it is not one; the cursor then stays.
    #[inline]
    pub fn float(&mut self) -> Option<f64> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let (value, n) = fast_float2::parse_partial::<f64, _>(rest).ok()?;
        match rest.get(n) {
            None | Some(b' ' | b'\n' | b'\t' | b'\r' | 0x0b | 0x0c) => {
                self.at += n;
                Some(value)
            }
            _ => None,
        }
    }

    /// The next word as a whole number; `None` if it is not one or exceeds 64 bits; the cursor then stays.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let (value, n) = parse_integer(rest)?;
        match rest.get(n) {
            None | Some(b' ' | b'\n' | b'\t' | b'\r' | 0x0b | 0x0c) => {
                self.at += n;
                Some(value)
            }
            _ => None,
        }
    }

    /// The error that `expected` was not found here; shows the next word of the line.
    #[cold]
    pub fn expected(&self, file: &str, expected: impl Into<String>) -> ReadError {
        let mut ahead = self.clone();
        let word = ahead.word();
        let found = if !word.is_empty() {
            printable(word)
        } else if ahead.is_at_end() {
            "the end of the file".into()
        } else {
            "the end of the line".into()
        };
        ReadError::Malformed {
            file: file.into(),
            place: Place::Line(self.line),
            expected: expected.into(),
            found,
        }
    }
}

/// A blank or a line end.
pub fn is_space(b: u8) -> bool {
    matches!(b, b'\n' | b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// A decimal integer at the front of `bytes` with its length; `None` if there is none or it overflows.
#[inline]
pub fn parse_integer(bytes: &[u8]) -> Option<(i64, usize)> {
    let (negative, sign) = match bytes.first() {
        Some(b'-') => (true, 1),
        Some(b'+') => (false, 1),
        _ => (false, 0),
    };
    let mut value = 0i64;
    let mut n = sign;
    while let Some(digit @ b'0'..=b'9') = bytes.get(n) {
        let digit = i64::from(digit - b'0');
        value = value.checked_mul(10)?;
        value = if negative { value.checked_sub(digit)? } else { value.checked_add(digit)? };
        n += 1;
    }
    (n > sign).then_some((value, n))
}

/// Index of the first byte for which `is` is true; `consumed` is called with the length of each searched piece before
/// it.
pub fn find(is: impl Fn(u8) -> bool, bytes: &[u8], consumed: impl Fn(usize)) -> Option<usize> {
    const STRETCH: usize = 1 << 16;
    for (i, stretch) in bytes.chunks(STRETCH).enumerate() {
        if let Some(n) = stretch.iter().position(|&b| is(b)) {
            return Some(i * STRETCH + n);
        }
        consumed(stretch.len());
    }
    None
}

/// Splits a text into about `pieces` chunks that end at line ends, for parsing on several cores. `consumed` is called
/// with the number of bytes that were searched.
pub fn split_lines(bytes: &[u8], pieces: usize, consumed: impl Fn(usize)) -> Vec<&[u8]> {
    let step = (bytes.len() / pieces.max(1)).max(1 << 16);
    let mut parts = Vec::new();
    let mut rest = bytes;
    while rest.len() > step {
        let Some(n) = find(|b| b == b'\n', &rest[step..], &consumed) else { break };
        let (part, tail) = rest.split_at(step + n + 1);
        consumed(part.len());
        parts.push(part);
        rest = tail;
    }
    parts.push(rest);
    parts
}
