//! The elements of an XML file, up to the data that are appended to them.

use std::ops::Range;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::ReadError;
use crate::error::Place;
use crate::io::vtk::dataset::Job;

/// Deepest nesting of elements.
const DEEPEST: usize = 64;

/// Bytes of memory that are counted together.
const COUNTED_BYTES: u64 = 1 << 18;

/// Bytes that a small allocation takes at least, with what the allocator keeps beside it.
const ALLOCATION_BYTES: u64 = 32;

/// Attributes of a longer element are counted before they are read.
const LONG: usize = 1 << 12;

/// An element.
pub struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    /// Bytes of the file with its first text.
    pub text: Range<usize>,
    /// Where it begins in the file.
    pub at: usize,
}

/// The elements of a file.
pub struct Document {
    pub root: Element,
    /// Where appended data begin, and whether they are base64.
    pub appended: Option<(usize, bool)>,
}

impl Element {
    /// Bytes of memory that it takes, about, without its children.
    fn bytes(&self) -> u64 {
        // A parent has room for four children at first, and later for up to twice as many as it has.
        let own = 4 * size_of::<Self>() as u64 + ALLOCATION_BYTES;
        let of_string = |text: &String| text.len() as u64 + ALLOCATION_BYTES;
        let of_attribute = |(name, value): &(String, String)| {
            2 * size_of::<(String, String)>() as u64 + of_string(name) + of_string(value)
        };
        own + self.attributes.iter().map(of_attribute).sum::<u64>()
    }

    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|c| c.name == name)
    }

    pub fn children_named<'b>(&'b self, name: &'b str) -> impl Iterator<Item = &'b Element> {
        self.children.iter().filter(move |c| c.name == name)
    }
}

/// Reads the elements of a file.
///
/// # Errors
/// What is no well-formed XML in UTF-8, and too little memory.
pub fn parse(job: &Job) -> Result<Document, ReadError> {
    let bytes = job.input.bytes();
    // Appended data need not be text.
    let markup = markup(job, bytes)?;
    let mark = if markup.starts_with('\u{feff}') { 3 } else { 0 };
    let mut reader = Reader::from_str(&markup[mark..]);
    let mut open: Vec<Element> = Vec::new();
    let (mut root, mut appended, mut uncounted) = (None, None, 0u64);
    while root.is_none() {
        let before = mark + reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            let place = job.line(mark + reader.error_position() as usize);
            job.malformed(place, "well-formed XML", error.to_string())
        })?;
        let after = mark + reader.buffer_position() as usize;
        if matches!(event, Event::Start(_) | Event::Empty(_)) {
            if uncounted > COUNTED_BYTES {
                job.reserve("the elements of its XML", std::mem::take(&mut uncounted))?;
            }
            if after - before > LONG {
                // Attributes take more memory than they have characters.
                job.reserve("the attributes of an element", 32 * (after - before) as u64)?;
            }
            if open.len() >= DEEPEST {
                let found = "deeper ones";
                return Err(job.malformed(
                    job.line(before),
                    format!("elements nested {DEEPEST} deep at most"),
                    found,
                ));
            }
        }
        match event {
            Event::Start(start) | Event::Empty(start)
                if start.name().as_ref().as_bytes_of() == b"AppendedData" =>
            {
                let encoding = element(&start, before, after).attribute("encoding").map(str::to_owned);
                let base64 = match encoding.as_deref() {
                    Some("raw") => false,
                    Some("base64") | None => true,
                    Some(other) => {
                        let place = job.line(before);
                        return Err(job.malformed(
                            place,
                            "encoding=\"raw\" or \"base64\"",
                            format!("{other:?}"),
                        ));
                    }
                };
                let rest = bytes.get(after..).unwrap_or_default();
                let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
                if rest.get(blanks) != Some(&b'_') {
                    let place = Place::Byte((after + blanks) as u64);
                    let found = crate::error::printable(
                        rest.get(blanks..(blanks + 8).min(rest.len())).unwrap_or_default(),
                    );
                    return Err(job.malformed(place, "an underscore before the appended data", found));
                }
                appended = Some((after + blanks + 1, base64));
                // Nothing but data follows.
                while let Some(done) = open.pop() {
                    close(&mut open, &mut root, done);
                }
                break;
            }
            Event::Start(start) => {
                let started = element(&start, before, after);
                uncounted += started.bytes();
                open.push(started);
            }
            Event::Empty(start) => {
                let done = element(&start, before, after);
                uncounted += done.bytes();
                close(&mut open, &mut root, done);
            }
            Event::End(_) => {
                if let Some(done) = open.pop() {
                    close(&mut open, &mut root, done);
                }
            }
            Event::Text(_) => {
                if let Some(now) = open.last_mut().filter(|e| e.text.is_empty())
                    && bytes.get(before..after).is_some_and(|t| t.iter().any(|b| !b.is_ascii_whitespace()))
                {
                    now.text = before..after;
                    job.input.consumed(after - before);
                }
            }
            Event::Eof => {
                let place = job.line(after);
                let expected = match open.last() {
                    Some(open) => format!("the end of element {}", open.name),
                    None => "the element VTKFile".into(),
                };
                return Err(job.malformed(place, expected, "the end of the file"));
            }
            _ => {}
        }
    }
    job.reserve("the elements of its XML", uncounted)?;
    match root {
        Some(root) if root.name == "VTKFile" => Ok(Document { root, appended }),
        _ => Err(job.malformed(Place::Line(1), "the element VTKFile", "another one")),
    }
}

/// The text up to the data that are appended to it.
fn markup<'a>(job: &Job<'a>, bytes: &'a [u8]) -> Result<&'a str, ReadError> {
    let mut end = 0;
    while let Some(at) = job.input.position(&bytes[end..], |b| b == b'<') {
        end += at + 1;
        if bytes[end..].starts_with(b"AppendedData") {
            end += bytes[end..].iter().position(|&b| b == b'>').map_or(bytes.len() - end, |n| n + 1);
            break;
        }
    }
    let is_appended = bytes[..end].ends_with(b">");
    let markup = if is_appended { &bytes[..end] } else { bytes };
    std::str::from_utf8(markup)
        .map_err(|error| job.malformed(job.line(error.valid_up_to()), "text in UTF-8", "bytes that are none"))
}

fn close(open: &mut [Element], root: &mut Option<Element>, done: Element) {
    match open.last_mut() {
        Some(parent) => parent.children.push(done),
        None => *root = Some(done),
    }
}

/// Bytes of a name, whatever the library keeps it in.
trait AsBytesOf {
    fn as_bytes_of(&self) -> &[u8];
}

impl AsBytesOf for [u8] {
    fn as_bytes_of(&self) -> &[u8] {
        self
    }
}

impl AsBytesOf for str {
    fn as_bytes_of(&self) -> &[u8] {
        self.as_bytes()
    }
}

fn element(start: &BytesStart, at: usize, after: usize) -> Element {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut all = start.attributes();
    let attributes = all.with_checks(false).flatten().map(|attribute| {
        let value = attribute.value.as_ref();
        let value = quick_xml::escape::unescape(value).map_or_else(|_| value.to_owned(), |v| v.into_owned());
        (text(attribute.key.as_ref().as_bytes_of()), value)
    });
    let attributes = attributes.collect();
    Element {
        name: text(start.name().as_ref().as_bytes_of()),
        attributes,
        children: Vec::new(),
        text: after..after,
        at,
    }
}
