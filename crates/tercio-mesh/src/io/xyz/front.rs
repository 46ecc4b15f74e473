//! What the first lines say.

/// How much of a file is examined for detecting the format.
pub const FRONT: usize = 1 << 16;

/// Lines that decide.
const ENOUGH: usize = 200;

/// After so many lines of points a text is a cloud; a line that is none is an error in it.
const SURE: usize = 10;

/// Most columns.
const MOST: usize = 256;

/// Most columns without names: more are a matrix.
const MOST_UNNAMED: usize = 16;

/// What separates numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delimiter {
    Blank,
    Comma,
    Semicolon,
    Tab,
}

impl Delimiter {
    pub fn name(self) -> &'static str {
        match self {
            Self::Blank => "separated by blanks",
            Self::Comma => "separated by commas",
            Self::Semicolon => "separated by semicolons",
            Self::Tab => "separated by tabs",
        }
    }

    /// That of a line. Commas and tabs may have blanks around them.
    fn of(line: &[u8]) -> Self {
        let has = |b: u8| line.contains(&b);
        if has(b';') {
            Self::Semicolon
        } else if has(b',') {
            Self::Comma
        } else if has(b'\t') && !has(b' ') {
            Self::Tab
        } else {
            Self::Blank
        }
    }

    /// Takes a field from the front of a trimmed line that is not over; `None` remains where it was the last.
    #[inline]
    pub fn field<'a>(self, rest: &mut Option<&'a [u8]>) -> Option<&'a [u8]> {
        let line = (*rest)?;
        let byte = match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Blank => {
                let is_blank = |b: &u8| matches!(b, b' ' | b'\t' | 0x0b | 0x0c);
                let end = line.iter().position(is_blank).unwrap_or(line.len());
                let (field, tail) = line.split_at(end);
                let next = tail.iter().position(|b| !is_blank(b)).and_then(|n| tail.get(n..));
                *rest = next;
                return Some(field);
            }
        };
        let Some(end) = line.iter().position(|&b| b == byte) else {
            *rest = None;
            return Some(line.trim_ascii());
        };
        *rest = line.get(end + 1..);
        Some(line.get(..end).unwrap_or_default().trim_ascii())
    }

    /// All fields of a trimmed line, of which so many are expected. A delimiter at the end of a line is no further field
    /// unless one is missing.
    fn fields(self, line: &[u8], expected: usize) -> Vec<&[u8]> {
        let mut rest = Some(line);
        let mut fields = Vec::new();
        while let Some(field) = self.field(&mut rest) {
            fields.push(field);
            if fields.len() > MOST {
                break;
            }
        }
        if fields.len() > 1 && fields.len() != expected && fields.last().is_some_and(|f| f.is_empty()) {
            fields.pop();
        }
        fields
    }
}

/// A number, or nothing at all in a place between delimiters.
pub fn number(field: &[u8]) -> Option<f64> {
    if field.is_empty() { Some(f64::NAN) } else { fast_float2::parse(field).ok() }
}

/// What a line is.
pub fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.starts_with(b"//")
}

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// A coordinate.
    Axis(usize),
    /// A component of colours.
    Color(usize),
    /// An attribute; without a name in a file without names.
    Value(String),
    /// No numbers.
    LeftOut(String),
}

/// The form of a text cloud.
#[derive(Clone, Debug)]
pub struct Front {
    pub delimiter: Delimiter,
    /// Of every line.
    pub columns: Vec<Column>,
    pub has_names: bool,
    /// The number of points that the file announces.
    pub count: Option<u64>,
    /// Where the points begin, and how many lines are before.
    pub begin: usize,
    pub lines: u64,
}

impl Front {
    /// The form of a text; `None` if it is no cloud. Of a text that `is_cut` the last line does not count.
    pub fn of(text: &[u8], is_cut: bool) -> Option<Self> {
        if text.iter().take(4096).any(|&b| b == 0) {
            return None;
        }
        let (mut at, mut lines) = (0, 0);
        let mut names: Option<Vec<String>> = None;
        let mut count = None;
        let mut found: Option<Self> = None;
        let (mut seen, mut looked_at) = (0, 0);
        while at < text.len() && seen < ENOUGH {
            let rest = text.get(at..)?;
            let end = rest.iter().position(|&b| b == b'\n');
            if is_cut && end.is_none() {
                break;
            }
            let line = rest.get(..end.unwrap_or(rest.len()))?.trim_ascii();
            let begin = at;
            at += end.map_or(rest.len(), |n| n + 1);
            let before = lines;
            lines += 1;
            if let Some(front) = &found {
                if line.is_empty() || is_comment(line) {
                    continue;
                }
                if !front.holds(line) {
                    if seen >= SURE || front.is_said(text) {
                        break;
                    }
                    return None;
                }
                seen += 1;
                continue;
            }
            looked_at += 1;
            if looked_at > ENOUGH {
                return None;
            }
            if line.is_empty() {
                continue;
            }
            if is_comment(line) {
                let inside = line.trim_ascii_start();
                let inside = inside.strip_prefix(b"//").unwrap_or(inside);
                names = header(inside.strip_prefix(b"#").unwrap_or(inside).trim_ascii()).or(names);
                continue;
            }
            if count.is_none() && names.is_none() {
                let digits = line.iter().all(u8::is_ascii_digit);
                if let (true, Ok(n)) = (digits, std::str::from_utf8(line).unwrap_or_default().parse()) {
                    count = Some(n);
                    continue;
                }
            }
            let delimiter = Delimiter::of(line);
            let fields = delimiter.fields(line, names.as_ref().map_or(0, Vec::len));
            if let (None, Some(of_line)) = (&names, header(line)) {
                names = Some(of_line);
                continue;
            }
            // Names behind a comment need not be those of the columns.
            let names = names.take().map(|names| joined(names, fields.len()));
            let columns = match names.filter(|names| names.len() == fields.len()) {
                Some(names) => named(names, &fields),
                None => unnamed(fields.len()),
            };
            let has_names = columns.iter().any(|c| !matches!(c, Column::Value(name) if name.is_empty()))
                && columns.iter().any(|c| !matches!(c, Column::Axis(_)) && !is_plain(c));
            let front = Self { delimiter, columns, has_names, count, begin, lines: before };
            let most = if front.has_names { MOST } else { MOST_UNNAMED };
            // Without a line before it the first point decides what the columns are, and has to have a place.
            let is_placed = front
                .columns
                .iter()
                .zip(&fields)
                .all(|(column, field)| !matches!(column, Column::Axis(_)) || !field.is_empty());
            let is_clear = is_placed || front.is_said(text);
            if fields.len() < 3 || fields.len() > most || !is_clear || !front.holds(line) {
                return None;
            }
            seen = 1;
            found = Some(front);
        }
        let front = found?;
        (seen >= 3 || front.is_said(text)).then_some(front)
    }

    /// Does a line before the points say what or how many they are?
    fn is_said(&self, text: &[u8]) -> bool {
        self.has_names || self.count.is_some() || names_axes(text)
    }

    /// Has a line the columns?
    fn holds(&self, line: &[u8]) -> bool {
        let fields = self.delimiter.fields(line, self.columns.len());
        let is_right = |(field, column): (&&[u8], &Column)| match column {
            Column::LeftOut(_) => true,
            Column::Axis(_) | Column::Color(_) | Column::Value(_) => number(field).is_some(),
        };
        fields.len() == self.columns.len() && fields.iter().zip(&self.columns).all(is_right)
    }

    /// Names of columns that are not numbers.
    pub fn left_out(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().filter_map(|c| match c {
            Column::LeftOut(name) => Some(name.as_str()),
            _ => None,
        })
    }
}

/// Names of so many columns: the last one may have blanks in it.
fn joined(mut names: Vec<String>, columns: usize) -> Vec<String> {
    if columns > 0 && names.len() > columns {
        let rest = names.split_off(columns - 1);
        names.push(rest.join(" "));
    }
    names
}

fn is_plain(column: &Column) -> bool {
    matches!(column, Column::Value(name) if name.is_empty())
}

/// Is the first line that is not empty one of names?
fn names_axes(text: &[u8]) -> bool {
    let first = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii).find(|line| !line.is_empty());
    let inside = first.unwrap_or_default();
    let inside = inside.strip_prefix(b"//").unwrap_or(inside);
    header(inside.strip_prefix(b"#").unwrap_or(inside).trim_ascii()).is_some()
}

/// The names of a line, if those of the axes are among them.
fn header(line: &[u8]) -> Option<Vec<String>> {
    let fields = Delimiter::of(line).fields(line, 0);
    let name = |f: &&[u8]| String::from_utf8_lossy(f).trim_matches(['"', '\'']).trim().to_owned();
    let names: Vec<String> = fields.iter().map(name).collect();
    let has = |axis: &str| names.iter().filter(|n| n.eq_ignore_ascii_case(axis)).count() == 1;
    (has("x") && has("y") && has("z")).then_some(names)
}

fn unnamed(count: usize) -> Vec<Column> {
    (0..count).map(|k| if k < 3 { Column::Axis(k) } else { Column::Value(String::new()) }).collect()
}

/// Columns by their names; those whose first value is no number are left out.
fn named(names: Vec<String>, first: &[&[u8]]) -> Vec<Column> {
    let place = |name: &str, of: &[&[&str]]| {
        of.iter().position(|names| names.iter().any(|n| name.eq_ignore_ascii_case(n)))
    };
    const AXES: [&[&str]; 3] = [&["x"], &["y"], &["z"]];
    const COLORS: [&[&str]; 4] = [&["r", "red"], &["g", "green"], &["b", "blue"], &["a", "alpha"]];
    let of_colors = |k: usize| names.iter().filter(|n| place(n, &COLORS) == Some(k)).count() == 1;
    let has_colors = (0..3).all(of_colors);
    let has_alpha = has_colors && of_colors(3);
    let column = |(name, field): (&String, &&[u8])| match (place(name, &AXES), place(name, &COLORS)) {
        (Some(axis), _) => Column::Axis(axis),
        (_, Some(k)) if has_colors && (k < 3 || has_alpha) => Column::Color(k),
        _ if number(field).is_none() => Column::LeftOut(name.clone()),
        _ if name.is_empty() => Column::Value("value".into()),
        _ => Column::Value(name.clone()),
    };
    names.iter().zip(first).map(column).collect()
}
