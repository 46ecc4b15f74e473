//! Pages as PDF 1.4: a catalogue, one page, its compressed content, and the table of where these are.

use std::fmt::Write as _;
use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec2;

use super::page::{Cap, Page, Shape, fixed, flush, is_closed, number, push_fixed};
use super::text::Text;

/// Writes a page.
pub fn write(page: &Page, out: &mut dyn Write) -> io::Result<()> {
    let alphas = alphas(page);
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    write_content(page, &alphas, &mut packed)?;
    let packed = packed.finish()?;

    // 72 points an inch, of 96 pixels.
    let [width, height] = page.size.map(|length| number(length * 0.75));
    let mut states = String::new();
    for (k, &alpha) in alphas.iter().enumerate() {
        let share = number(f64::from(alpha) / 255.0);
        let _ = write!(states, "/A{k} <</CA {share} /ca {share}>> ");
    }
    let has_text = page.shapes.iter().any(|shape| matches!(shape, Shape::Text(_)));
    let font = "/Font <</F <</Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding>>>>";
    let font = if has_text { font } else { "" };
    let objects = [
        "<</Type /Catalog /Pages 2 0 R>>".to_owned(),
        "<</Type /Pages /Kids [3 0 R] /Count 1>>".to_owned(),
        format!(
            "<</Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Contents 4 0 R \
             /Resources <</ExtGState <<{states}>>{font}>>>>"
        ),
        format!("<</Length {} /Filter /FlateDecode>>", packed.len()),
    ];
    // The bytes above 127 say that the file is not text.
    let mut file: Vec<u8> = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec();
    let mut places = Vec::new();
    for (object, body) in (1..).zip(&objects) {
        places.push(file.len());
        file.extend_from_slice(format!("{object} 0 obj\n{body}\n").as_bytes());
        if object == objects.len() {
            file.extend_from_slice(b"stream\n");
            file.extend_from_slice(&packed);
            file.extend_from_slice(b"\nendstream\n");
        }
        file.extend_from_slice(b"endobj\n");
    }
    let count = objects.len() + 1;
    let table = file.len();
    let mut end = format!("xref\n0 {count}\n0000000000 65535 f \n");
    for place in places {
        let _ = writeln!(end, "{place:010} 00000 n ");
    }
    let _ = write!(end, "trailer\n<</Size {count} /Root 1 0 R>>\nstartxref\n{table}\n%%EOF\n");
    file.extend_from_slice(end.as_bytes());
    out.write_all(&file)
}

/// The opacities of what is on a page.
fn alphas(page: &Page) -> Vec<u8> {
    let of_shapes = page.shapes.iter().map(|shape| match shape {
        Shape::Lines { style, .. } => style.color[3],
        Shape::Area { color, .. } => color[3],
        Shape::Text(text) => text.color[3],
    });
    let mut alphas: Vec<u8> = of_shapes.chain(page.background.map(|color| color[3])).collect();
    alphas.sort_unstable();
    alphas.dedup();
    alphas
}

fn write_content(page: &Page, alphas: &[u8], out: &mut dyn Write) -> io::Result<()> {
    let [width, height] = page.size.map(number);
    // Pixels from the upper left corner; round joins.
    writeln!(out, "0.75 0 0 -0.75 0 {} cm\n1 j", number(page.size[1] * 0.75))?;
    let color = |[r, g, b, alpha]: [u8; 4], operator: &str| {
        let state = alphas.partition_point(|&other| other < alpha);
        let [r, g, b] = [r, g, b].map(|c| number(f64::from(c) / 255.0));
        format!("/A{state} gs\n{r} {g} {b} {operator}\n")
    };
    if let Some(background) = page.background.filter(|color| color[3] > 0) {
        write!(out, "{}0 0 {width} {height} re\nf\n", color(background, "rg"))?;
    }
    for shape in &page.shapes {
        let mut text = String::new();
        match shape {
            Shape::Text(line) => {
                out.write_all(color(line.color, "rg").as_bytes())?;
                write_line(line, out)?;
            }
            Shape::Lines { style, lines } => {
                let cap = match style.cap {
                    Cap::Round => 1,
                    Cap::Square => 2,
                };
                let width = number(style.width.max(1e-4));
                write!(out, "{}{width} w\n{cap} J\n", color(style.color, "RG"))?;
                for line in lines {
                    let is_closed = is_closed(line);
                    push_path(&mut text, if is_closed { &line[1..] } else { line });
                    text.push_str(if is_closed { "h\n" } else { "" });
                    flush(&mut text, out)?;
                }
                writeln!(out, "{text}S")?;
            }
            Shape::Area { color: of_area, polygons } => {
                out.write_all(color(*of_area, "rg").as_bytes())?;
                for polygon in polygons.iter().filter(|polygon| polygon.len() > 2) {
                    push_path(&mut text, polygon);
                    text.push_str("h\n");
                    flush(&mut text, out)?;
                }
                writeln!(out, "{text}f")?;
            }
        }
    }
    Ok(())
}

fn write_line(line: &Text, out: &mut dyn Write) -> io::Result<()> {
    let [x, y] = line.start().to_array().map(number);
    // The page's y axis points down, that of letters up.
    let turn = if line.upwards { "0 -1 -1 0" } else { "1 0 0 -1" };
    write!(out, "BT\n/F {} Tf\n{turn} {x} {y} Tm\n(", number(line.size))?;
    for character in line.characters() {
        let byte = u8::try_from(u32::from(character)).unwrap_or(b'?');
        if matches!(byte, b'(' | b')' | b'\\') {
            out.write_all(b"\\")?;
        }
        out.write_all(&[byte])?;
    }
    out.write_all(b") Tj\nET\n")
}

fn push_path(text: &mut String, points: &[DVec2]) {
    let mut push = |point: &DVec2, operator: &str| {
        push_fixed(text, fixed(point.x));
        text.push(' ');
        push_fixed(text, fixed(point.y));
        text.push_str(operator);
    };
    let Some((first, rest)) = points.split_first() else { return };
    push(first, " m\n");
    // A line without length has its ends.
    let rest = if rest.is_empty() { points } else { rest };
    rest.iter().for_each(|point| push(point, " l\n"));
}
