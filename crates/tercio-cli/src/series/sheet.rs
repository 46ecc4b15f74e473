//! The paper of a contact sheet: where pictures and their captions are.

use anyhow::{Result, bail};
use tercio::annotate::font::{ASCENT, LINE};
use tercio::annotate::layout::TextBlock;
use tercio::annotate::{Direction, Line, Overlay, Paint};
use tercio::image::{Picture, Pixels};
use tercio::raster::color8;
use tercio::raster::frame::Planes;

/// Width by height of a sheet whose columns are not given, about that of a screen.
const ASPECT: f64 = 1.5;

/// What a sheet looks like.
#[derive(Clone, Debug)]
pub struct Look {
    /// Pixels of one picture.
    pub cell: (u32, u32),
    /// Pictures beside each other; `None` for a good number.
    pub columns: Option<u32>,
    /// Whether there is a line of text below each picture.
    pub has_captions: bool,
    /// A title above all of them.
    pub title: Option<String>,
    /// A factor of all text.
    pub text_scale: f64,
    /// Linear light of text.
    pub text: [f32; 4],
    /// That of the paper.
    pub ground: [f32; 4],
}

/// A sheet that is being filled.
pub struct Paper {
    cell: (u32, u32),
    columns: u32,
    rows: u32,
    has_captions: bool,
    title: Option<String>,
    text: [f32; 4],
    ground: [f32; 4],
    /// Pixels of an em of the captions.
    em: f64,
    pixels: Vec<[u8; 4]>,
    /// Which pictures are there.
    is_there: Vec<bool>,
    overlay: Overlay,
}

impl Paper {
    /// An empty sheet for so many pictures. Its memory is taken when the first one is put on it.
    pub fn new(look: &Look, count: usize) -> Self {
        let (width, height) = look.cell;
        let em = (f64::from(width.min(height)) / 15.0).clamp(10.0, 30.0) * look.text_scale;
        let mut paper = Self {
            cell: look.cell,
            columns: 1,
            rows: 1,
            has_captions: look.has_captions,
            title: look.title.clone(),
            text: look.text,
            ground: look.ground,
            em,
            pixels: Vec::new(),
            is_there: vec![false; count],
            overlay: Overlay::default(),
        };
        let count = count.max(1) as u32;
        let (step_x, step_y) = (f64::from(paper.step().0), f64::from(paper.step().1));
        paper.columns = look.columns.unwrap_or_else(|| columns(count, step_x / step_y)).min(count);
        paper.rows = count.div_ceil(paper.columns);
        paper
    }

    /// Pixels around a picture, to the next one.
    fn gap(&self) -> u32 {
        (self.em * 0.8).round() as u32
    }

    /// Pixels of a caption.
    fn caption_height(&self) -> u32 {
        if self.has_captions { (self.em * 1.6).round() as u32 } else { 0 }
    }

    /// Pixels from picture to picture.
    fn step(&self) -> (u32, u32) {
        (self.cell.0 + self.gap(), self.cell.1 + self.caption_height() + self.gap())
    }

    fn title_em(&self) -> f64 {
        self.em * 1.5
    }

    /// Pixels above the first row.
    fn top(&self) -> u32 {
        let lines = self.title.as_ref().map_or(0, |title| title.lines().count());
        let title = if lines > 0 { self.title_em() * (LINE * lines as f64 + 0.6) } else { 0.0 };
        self.margin() + title.round() as u32
    }

    /// Pixels at the borders.
    fn margin(&self) -> u32 {
        (self.em * 1.2).round() as u32
    }

    /// Width and height of the sheet in pixels.
    pub fn size(&self) -> (u32, u32) {
        let (x, y) = self.step();
        let margin = self.margin();
        let width = u64::from(x) * u64::from(self.columns) - u64::from(self.gap()) + 2 * u64::from(margin);
        let height = u64::from(y) * u64::from(self.rows) - u64::from(self.gap())
            + u64::from(self.top())
            + u64::from(margin);
        (width.min(u32::MAX.into()) as u32, height.min(u32::MAX.into()) as u32)
    }

    /// Checks that the sheet fits into memory, also when it is written.
    ///
    /// # Errors
    /// What it needs, and the limit.
    pub fn check_memory(&self, limit: Option<u64>) -> Result<()> {
        let (width, height) = self.size();
        let bytes = u64::from(width) * u64::from(height) * 8;
        match limit {
            Some(limit) if bytes > limit / 2 => bail!(
                "a sheet of {width}x{height} pixels needs {bytes} bytes, half of the limit is {} bytes: choose a smaller --size",
                limit / 2
            ),
            _ => Ok(()),
        }
    }

    /// Left and upper border of a picture.
    fn place(&self, cell: usize) -> (u32, u32) {
        let (x, y) = self.step();
        let (column, row) = (cell as u32 % self.columns, cell as u32 / self.columns);
        (self.margin() + column * x, self.top() + row * y)
    }

    fn begin(&mut self) {
        if self.pixels.is_empty() {
            let (width, height) = self.size();
            let [r, g, b, alpha] = self.ground;
            let ground = color8([r * alpha, g * alpha, b * alpha, alpha]);
            self.pixels = vec![ground; width as usize * height as usize];
        }
    }

    /// Puts a picture on the sheet.
    pub fn put(&mut self, cell: usize, pixels: &[[u8; 4]]) {
        self.begin();
        self.is_there[cell] = true;
        let (left, top) = self.place(cell);
        let (width, of_sheet) = (self.cell.0 as usize, self.size().0 as usize);
        let first = top as usize * of_sheet + left as usize;
        for (row, pixels) in pixels.chunks_exact(width).enumerate() {
            let at = first + row * of_sheet;
            if let Some(to) = self.pixels.get_mut(at..at + width) {
                to.copy_from_slice(pixels);
            }
        }
    }

    /// Says in the place of a picture why it is not there, if it is not.
    pub fn tell(&mut self, cell: usize, reason: &str) {
        self.begin();
        if self.is_there[cell] {
            return;
        }
        let (left, top) = self.place(cell);
        let [left, top, width, height] = [left, top, self.cell.0, self.cell.1].map(f64::from);
        let [r, g, b, alpha] = self.text;
        let frame = [r, g, b, alpha * 0.25];
        let line = (self.em / 12.0).round().max(1.0);
        let bars = [
            [left, top, left + width, top + line],
            [left, top + height - line, left + width, top + height],
            [left, top + line, left + line, top + height - line],
            [left + width - line, top + line, left + width, top + height - line],
        ];
        bars.into_iter().for_each(|bar| self.overlay.rectangle(bar, Paint::Solid(frame)));
        let em = self.em * 0.85;
        let room = height - 2.0 * self.em;
        let head = TextBlock::fit("could not be drawn", em, width - 2.0 * self.em, 2);
        let lines = ((room / (em * LINE)) as usize).saturating_sub(head.lines.len() + 1).max(1);
        let why = TextBlock::fit(reason, em, width - 2.0 * self.em, lines);
        let high = head.size[1] + why.size[1] + em * 0.6;
        let mut y = top + ((height - high) * 0.5).max(self.em * 0.5);
        for (block, alpha) in [(head, alpha), (why, alpha * 0.65)] {
            for text in &block.lines {
                let x = left + (width - text.width * em) * 0.5;
                self.overlay.text(text, [x, y + ASCENT * em], em, Direction::Right, [r, g, b, alpha]);
                y += em * LINE;
            }
            y += em * 0.6;
        }
    }

    /// Writes a line below a picture, shortened in its middle if it is too long.
    pub fn caption(&mut self, cell: usize, text: &str) {
        if !self.has_captions {
            return;
        }
        let (left, top) = self.place(cell);
        let width = f64::from(self.cell.0);
        let line = shortened(text, width / self.em);
        let x = f64::from(left) + (width - line.width * self.em) * 0.5;
        let y = f64::from(top + self.cell.1) + self.em * 1.25;
        self.overlay.text(&line, [x, y], self.em, Direction::Right, self.text);
    }

    /// The finished sheet.
    pub fn finish(mut self) -> Picture<'static> {
        self.begin();
        let (width, height) = self.size();
        let em = self.title_em();
        let title = self.title.take().unwrap_or_default();
        for (number, text) in title.lines().enumerate() {
            let line = shortened(text, f64::from(width - 2 * self.margin()) / em);
            let x = (f64::from(width) - line.width * em) * 0.5;
            let y = f64::from(self.margin()) + em * (ASCENT + LINE * number as f64);
            self.overlay.text(&line, [x, y], em, Direction::Right, self.text);
        }
        let mut planes = Planes { color: self.pixels, ..Planes::default() };
        self.overlay.draw(&mut planes, width, 0..height);
        Picture { width, height, pixels: Pixels::Eight(planes.color.into()) }
    }
}

/// A line that is at most so many ems wide: what is too long loses its middle, because names differ at their ends.
fn shortened(text: &str, width: f64) -> Line {
    let whole = Line::new(text);
    if whole.width <= width {
        return whole;
    }
    let characters: Vec<char> = text.chars().collect();
    let with = |kept: usize| {
        let (front, back) = (kept.div_ceil(2), kept / 2);
        let start: String = characters[..front].iter().collect();
        let end: String = characters[characters.len() - back..].iter().collect();
        Line::new(&format!("{}…{}", start.trim_end(), end.trim_start()))
    };
    // The width grows with what is kept.
    let (mut fits, mut too_many) = (0, characters.len());
    while too_many - fits > 1 {
        let middle = (fits + too_many) / 2;
        if with(middle).width <= width { fits = middle } else { too_many = middle }
    }
    with(fits)
}

/// How many columns so many pictures get, whose steps have this ratio of width to height: near the ratio of a screen, with few
/// empty places.
fn columns(count: u32, ratio: f64) -> u32 {
    let ideal = (f64::from(count) * ASPECT / ratio).sqrt().max(1.0);
    let near = (ideal * 0.75).floor().max(1.0) as u32..=((ideal * 1.35).ceil() as u32).min(count).max(1);
    let cost = |columns: u32| {
        let places = columns * count.div_ceil(columns);
        let empty = f64::from(places - count) / f64::from(places);
        empty + (f64::from(columns) / ideal).ln().abs()
    };
    near.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_are_about_as_wide_as_screens_with_few_empty_places() {
        let found: Vec<u32> = [1, 2, 3, 4, 6, 8, 9, 10, 12, 24, 100].map(|n| columns(n, 1.0)).to_vec();
        assert_eq!(found, [1, 2, 2, 2, 3, 4, 3, 4, 4, 6, 12]);
        for count in 1..2000 {
            let columns = columns(count, 0.9);
            let empty = columns * count.div_ceil(columns) - count;
            assert!(empty < columns && columns <= count, "{columns} columns for {count}");
        }
    }

    #[test]
    fn long_names_lose_their_middle_and_fit() {
        for text in ["short", "a name that is far too long for its picture 17", "ÄÄÄÄÄÄÄÄÄÄÄÄÄÄÄÄ"]
        {
            let line = shortened(text, 8.0);
            assert!(line.width <= 8.0 && !line.is_empty(), "{text}");
        }
        assert_eq!(shortened("short", 8.0).width, Line::new("short").width);
    }
}
