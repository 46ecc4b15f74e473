//! Pages as SVG.

use std::fmt::Write as _;
use std::io::{self, Write};

use glam::DVec2;

use super::page::{Cap, Page, Shape, fixed, flush, is_closed, number, push_fixed};
use super::text::{Anchor, Text, text_width};

/// Writes a page.
pub fn write(page: &Page, out: &mut dyn Write) -> io::Result<()> {
    let mut text = String::new();
    let [width, height] = page.size.map(number);
    let _ = write!(
        text,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" \
         height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n"
    );
    if let Some(color) = page.background.filter(|color| color[3] > 0) {
        let _ = writeln!(text, "<rect width=\"{width}\" height=\"{height}\"{}/>", paint("fill", color));
    }
    for shape in &page.shapes {
        match shape {
            Shape::Text(line) => {
                push_text(&mut text, line);
                continue;
            }
            Shape::Lines { style, lines } => {
                let cap = match style.cap {
                    Cap::Round => "round",
                    Cap::Square => "square",
                };
                let _ = write!(text, "<path fill=\"none\"{} stroke-width=\"", paint("stroke", style.color));
                push_fixed(&mut text, fixed(style.width).max(1));
                let _ = write!(text, "\" stroke-linecap=\"{cap}\" stroke-linejoin=\"round\" d=\"");
                for line in lines {
                    let is_closed = is_closed(line);
                    push_path(&mut text, &line[..line.len() - usize::from(is_closed)], is_closed);
                    flush(&mut text, out)?;
                }
            }
            Shape::Area { color, polygons } => {
                let _ = write!(text, "<path{} d=\"", paint("fill", *color));
                for polygon in polygons {
                    push_path(&mut text, polygon, true);
                    flush(&mut text, out)?;
                }
            }
        }
        text.push_str("\"/>\n");
    }
    text.push_str("</svg>\n");
    out.write_all(text.as_bytes())
}

fn push_text(out: &mut String, line: &Text) {
    let anchor = match line.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let [x, y] = line.at.to_array().map(number);
    let turn = if line.upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    // Where the font is another one, it is as wide.
    let width = number(text_width(&line.text, line.size));
    // Two more that XML does not have.
    let text = line.characters().map(|c| if matches!(c, '\u{fffe}' | '\u{ffff}') { '?' } else { c });
    let text = text.collect::<String>().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\"{turn}{} font-family=\"Helvetica,Arial,'Liberation Sans',sans-serif\" \
         font-size=\"{}\" text-anchor=\"{anchor}\" textLength=\"{width}\" lengthAdjust=\"spacingAndGlyphs\">{text}</text>",
        paint("fill", line.color),
        number(line.size)
    );
}

fn paint(what: &str, [r, g, b, alpha]: [u8; 4]) -> String {
    let color = format!(" {what}=\"#{r:02x}{g:02x}{b:02x}\"");
    if alpha == 0xff {
        return color;
    }
    format!("{color} {what}-opacity=\"{}\"", number(f64::from(alpha) / 255.0))
}

/// A line, each point relative to the one before.
fn push_path(text: &mut String, points: &[DVec2], is_closed: bool) {
    let mut last = [0i64; 2];
    for (number, point) in points.iter().enumerate() {
        let here = point.to_array().map(fixed);
        text.push_str(match number {
            0 => "M",
            1 => "l",
            _ => " ",
        });
        let step = if number == 0 { here } else { [here[0] - last[0], here[1] - last[1]] };
        push_fixed(text, step[0]);
        text.push(' ');
        push_fixed(text, step[1]);
        last = here;
    }
    match points.len() {
        0 => {}
        // A line without length has its ends.
        1 => text.push_str("h0"),
        _ if is_closed => text.push('z'),
        _ => {}
    }
}
