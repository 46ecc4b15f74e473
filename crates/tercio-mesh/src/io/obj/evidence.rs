//! Is it OBJ? The format has no magic bytes, and its keywords are so short that other texts begin with them.
//!
//! The rule: the first 250 lines that are neither comments nor names are examined. There must be valid statements
//! about geometry (a `v` with three numbers, an `f` with indices, and so on), at least as many as lines that OBJ does
//! not know. Those lines may begin with one unknown word, and with one more for every eight statements: programs with
//! keywords of their own repeat them, prose around an example does not. Names and groups count for neither side,
//! because anything may follow them. Whether the file has any vertex is checked when it is read.

use std::collections::HashSet;

use super::lines::{Lines, split};
use super::transcode;
use crate::io::input::Input;

/// How much of a file is examined.
const FRONT: usize = 1 << 18;

/// About how much of it is examined at a time.
const PART: usize = 1 << 16;

/// Number of lines that decide.
const ENOUGH: u64 = 250;

/// Keywords whose values [`is_statement`] checks.
const GEOMETRY: [&[u8]; 8] = [b"v", b"vt", b"vn", b"vp", b"f", b"fo", b"l", b"p"];

/// Keywords followed by a name, a number or nothing.
const OTHERS: [&[u8]; 30] = [
    b"o",
    b"g",
    b"s",
    b"mg",
    b"mtllib",
    b"usemtl",
    b"maplib",
    b"usemap",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"bevel",
    b"lod",
    b"c_interp",
    b"d_interp",
    b"ctech",
    b"stech",
    b"shadow_obj",
    b"trace_obj",
];

/// Counts of the kinds of lines in a text.
#[derive(Debug, Default, PartialEq)]
struct Votes {
    comments: u64,
    /// Valid statements about geometry.
    statements: u64,
    /// Other lines that OBJ knows.
    others: u64,
    /// Lines that OBJ does not know or that are invalid, and the number of different unknown words.
    unknown: u64,
    unknown_words: u64,
}

/// Does the content look like OBJ?
pub fn looks_like(input: &Input) -> bool {
    let votes = votes(input);
    votes.statements > 0
        && votes.unknown <= votes.statements
        && votes.unknown_words <= 1 + votes.statements / 8
}

/// What a text without statements and unknown lines holds, for the error.
pub fn holds_nothing_but(input: &Input) -> Option<&'static str> {
    match votes(input) {
        Votes { statements: 0, unknown: 0, others: 0, comments: 1.., .. } => Some("comments"),
        Votes { statements: 0, unknown: 0, others: 1.., .. } => Some("names of OBJ, without any geometry"),
        _ => None,
    }
}

/// Examines more of the file if its front holds nothing but comments and names, and at most one other line: thousands
/// of them may precede the geometry.
fn votes(input: &Input) -> Votes {
    let bytes = input.unpadded(input.bytes());
    let mut length = FRONT;
    loop {
        let votes = votes_of_front(input, bytes, length);
        let continues = votes.statements == 0 && votes.unknown <= 1 && votes.comments + votes.others > 0;
        if !continues || length >= bytes.len() {
            return votes;
        }
        length *= 64;
    }
}

fn votes_of_front(input: &Input, bytes: &[u8], length: usize) -> Votes {
    let text = transcode::front(bytes, length);
    let mut votes = Votes::default();
    // No text holds zeros; testing the front is enough.
    if text.iter().take(4096).any(|&b| b == 0) {
        return votes;
    }
    let mut unknown = HashSet::new();
    let is_cut = length < bytes.len();
    let parts = split(&text, PART, |bytes| input.consumed(bytes));
    'parts: for (i, part) in parts.iter().enumerate() {
        // Of overlong lines only the front is examined.
        let mut lines = Lines::new(part.get(..4 * PART).unwrap_or(part), 1).peekable();
        while let Some(line) = lines.next() {
            // The last line of a front may be cut in the middle of a word, so it counts only if there is no other.
            let is_last = i + 1 == parts.len() && lines.peek().is_none();
            if is_cut && is_last && votes != Votes::default() {
                break;
            }
            let line = line.text.trim_ascii();
            let word = words(line).next().unwrap_or_default();
            let votes_for = match line.first() {
                None => continue,
                Some(b'#') => &mut votes.comments,
                _ if is_statement(line) => &mut votes.statements,
                _ if OTHERS.contains(&word) => &mut votes.others,
                _ => {
                    if !GEOMETRY.contains(&word) {
                        unknown.insert(word);
                    }
                    &mut votes.unknown
                }
            };
            *votes_for += 1;
            if votes.statements + votes.unknown == ENOUGH {
                break 'parts;
            }
        }
        input.consumed(part.len());
    }
    votes.unknown_words = unknown.len() as u64;
    votes
}

/// The words of a line up to a comment; a backslash that joins lines is not a word.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let line = line.split(|&b| b == b'#').next().unwrap_or_default();
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty() && *w != b"\\")
}

fn is_statement(line: &[u8]) -> bool {
    let mut words = words(line);
    let keyword = words.next().unwrap_or_default();
    let mut numbers = |n: usize| words.by_ref().take(n).filter(|w| is_number(w)).count() == n;
    match keyword {
        b"v" | b"vn" => numbers(3),
        b"vt" | b"vp" => numbers(1),
        b"f" | b"fo" | b"l" | b"p" => {
            let mut corners = words.peekable();
            corners.peek().is_some() && corners.all(is_corner)
        }
        _ => false,
    }
}

/// Old programs write numbers in their own notations (`1.#IND`, `3.1+e2`), but never without a digit or a name.
fn is_number(word: &[u8]) -> bool {
    let known = |b: &u8| b.is_ascii_alphanumeric() || b"+-.#()".contains(b);
    fast_float2::parse::<f64, _>(word).is_ok()
        || (word.iter().any(u8::is_ascii_digit) && word.iter().all(known))
}

/// `1`, `1/2`, `1//3`, `-1/-2/-3`
fn is_corner(word: &[u8]) -> bool {
    word.first().is_some_and(|b| b.is_ascii_digit() || *b == b'-' || *b == b'+')
        && word.iter().all(|b| b.is_ascii_digit() || b"/+-".contains(b))
}
