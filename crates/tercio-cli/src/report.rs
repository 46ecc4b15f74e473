//! What was found in a model, for `--stats` and `info`. The keys are stable: programs rely on them.

use serde_json::{Value, json};
use tercio::glam::DVec3;
use tercio::mesh::Aabb;
use tercio::mesh::io::{NotDrawn, Translucent};
use tercio::parallel::{FrameReport, RankReport};
use tercio::scene::{Camera, Projection};
use tercio::{LoadReport, TextureReport};

/// Why `--crease-angle` has no effect, if it has none.
pub fn unused_crease_angle(angle: Option<f64>, report: &LoadReport) -> Option<String> {
    let made = report.made_normals || report.mended_normals > 0;
    let reason = match report {
        _ if angle.is_none() => return None,
        LoadReport { prepared: Some(_), .. } => "normals were made when the model was prepared",
        _ if made => return None,
        LoadReport { file_normals: true, .. } => "the model has normals of its own",
        _ => "no normals are needed",
    };
    Some(format!("--crease-angle has no effect: {reason}"))
}

/// Why nothing of a model was drawn, if all of it was cut away.
pub fn all_clipped(report: &LoadReport) -> Option<String> {
    let clipped = report.clipped.filter(|c| c.removed > 0 && report.mesh.triangles == 0)?;
    let all = match clipped.removed {
        1 => "the only triangle is".into(),
        n => format!("all {n} triangles are"),
    };
    Some(format!("nothing was drawn: {all} on the other side of a plane (--clip)"))
}

/// What was cut away, in words; `None` if nothing was.
pub fn clipped(report: &LoadReport) -> Option<String> {
    let clipped = report.clipped?;
    Some(format!(
        "{} cut away, {} cut; {} capped with {}",
        counted(clipped.removed, "triangle"),
        counted(clipped.cut, "triangle"),
        counted(clipped.outlines, "outline"),
        counted(clipped.cap_triangles, "triangle"),
    ))
}

/// Everything about the loading of a model.
pub fn load_json(model: &str, report: &LoadReport) -> Value {
    let mesh = &report.mesh;
    json!({
        "model": model,
        "format": report.read.format,
        "file_bytes": report.read.file_bytes,
        "prepared": report.prepared.as_ref().map(|origin| json!({
            "from": origin.model,
            "by": origin.program,
            "file_bytes": origin.file_bytes,
            "mapped_bytes": origin.mapped_bytes,
        })),
        "faces": report.read.faces,
        "vertices": mesh.vertices,
        "triangles": mesh.triangles,
        "bounds": bounds_json(&mesh.bounds),
        "normals": normals(report),
        "vertex_colors": mesh.vertex_colors,
        "face_colors": mesh.face_colors,
        "texcoords": mesh.texcoords,
        "memory_bytes": mesh.bytes,
        "repaired": {
            "duplicate_corner_triangles": report.cleaned.duplicate_corner,
            "degenerate_triangles": report.cleaned.degenerate,
            "stitching_triangles_kept": report.cleaned.stitching_kept,
            "non_finite_vertices": report.cleaned.non_finite_vertices,
            "non_finite_triangles": report.cleaned.non_finite_triangles,
            "welded_vertices": report.welded.unwrap_or(0),
        },
        "clipped": report.clipped,
        "lines": report.lines,
        "points": report.points,
        "not_drawn": not_drawn_json(&left(report)),
        "translucent": report.read.translucent,
        "warnings": report.read.warnings,
        "milliseconds": report.times,
    })
}

/// What was loaded of the materials and textures of a model.
pub fn textures_json(report: &TextureReport) -> Value {
    json!({
        "materials": report.materials,
        "textures": report.textures,
        "files": report.files.len(),
        "memory_bytes": report.bytes,
        "warnings": report.warnings,
        "milliseconds": report.milliseconds,
    })
}

fn not_drawn_json(n: &NotDrawn) -> Value {
    json!({
        "points": n.points,
        "lines": n.lines,
        "curves": n.curves,
        "surfaces": n.surfaces,
        "textures": n.textures,
    })
}

/// Corners, size and centre of a box; null if it is empty.
pub fn bounds_json(bounds: &Aabb) -> Value {
    if bounds.is_empty() {
        return Value::Null;
    }
    json!({
        "min": bounds.min.to_array(),
        "max": bounds.max.to_array(),
        "size": bounds.size().to_array(),
        "center": bounds.center().to_array(),
    })
}

/// Where the normals come from.
pub fn normals(report: &LoadReport) -> &'static str {
    match (report.file_normals, report.made_normals) {
        (true, _) => "file",
        (false, true) => "made",
        (false, false) => "none",
    }
}

/// What users should know about their model, one sentence each.
pub fn warnings(report: &LoadReport) -> Vec<String> {
    let mut all = report.read.warnings.clone();
    let (vertices, triangles) = (report.cleaned.non_finite_vertices, report.cleaned.non_finite_triangles);
    if vertices + triangles > 0 {
        let (vertex, has) = if vertices == 1 { ("vertex", "has") } else { ("vertices", "have") };
        let (triangle, was) = if triangles == 1 { ("triangle", "was") } else { ("triangles", "were") };
        all.push(format!(
            "{vertices} {vertex} {has} coordinates that are not finite or too large for 32-bit floats; \
             {triangles} {triangle} there {was} left out"
        ));
    }
    if let Some(open) = report.clipped.map(|c| c.open_outlines).filter(|&open| open > 0) {
        let (outlines, are) = (counted(open, "outline"), if open == 1 { "is" } else { "are" });
        all.push(format!("{outlines} of the cut {are} not closed, and not capped: the model is open there"));
    }
    all
}

/// What the file contains that is not drawn. Readers count all lines and points; those that were loaded are drawn.
pub fn left(report: &LoadReport) -> NotDrawn {
    let mut left = report.read.not_drawn;
    left.lines = left.lines.saturating_sub(report.lines);
    left.points = left.points.saturating_sub(report.points);
    left
}

/// What the file contains that is not drawn, in words.
pub fn not_drawn(n: &NotDrawn) -> Option<String> {
    let textures = (n.textures > 0).then(|| counted(n.textures, "texture"));
    let list: Vec<_> = shapes(n).chain(textures).collect();
    (!list.is_empty()).then(|| list.join(", "))
}

/// Lines and points that are drawn besides triangles, in words.
pub fn lines_and_points(report: &LoadReport) -> Option<String> {
    let all = [(report.lines, "line segment"), (report.points, "point")];
    let list: Vec<_> = all.into_iter().filter(|n| n.0 > 0).map(|(n, what)| counted(n, what)).collect();
    (!list.is_empty()).then(|| list.join(", "))
}

/// What is drawn, for a message on something that is not: `not_drawn` of a model.
pub fn drawn(report: &LoadReport, not_drawn: &NotDrawn) -> &'static str {
    match not_drawn.textures {
        _ if report.prepared.is_some() && not_drawn.points + not_drawn.lines > 0 => PREPARED,
        0 => "tercio draws triangles, lines and points",
        _ => {
            "tercio draws triangles, lines and points, and textures of colour, opacity, highlights, emission, bumps, roughness and metals \
             where there are texture coordinates"
        }
    }
}

/// What `prepare` keeps.
pub const PREPARED: &str = "a prepared model holds triangles alone";

/// What of the model is not opaque, in words.
pub fn translucent(n: &Translucent) -> Option<String> {
    let all = [
        (n.materials, "material"),
        (n.vertices, "vertex"),
        (n.faces, "face"),
        (n.lines, "line"),
        (n.points, "point"),
    ];
    let list: Vec<_> = all.into_iter().filter(|n| n.0 > 0).map(|(n, what)| counted(n, what)).collect();
    (!list.is_empty()).then(|| list.join(", "))
}

/// What a model without triangles contains instead, in words.
pub fn only(n: &NotDrawn) -> Option<String> {
    let list: Vec<_> = shapes(n).collect();
    (!list.is_empty()).then(|| list.join(", "))
}

fn shapes(n: &NotDrawn) -> impl Iterator<Item = String> {
    let all = [
        (n.points, "point"),
        (n.lines, "line"),
        (n.curves, "free-form curve"),
        (n.surfaces, "free-form surface"),
    ];
    all.into_iter().filter(|s| s.0 > 0).map(|(n, what)| counted(n, what))
}

/// "1 face", "2,000 faces".
pub fn counted(n: u64, what: &str) -> String {
    match (n, what) {
        (1, _) => format!("1 {what}"),
        (_, "vertex") => format!("{} vertices", grouped(n)),
        _ => format!("{} {what}s", grouped(n)),
    }
}

/// What was repaired, in words; empty if nothing was.
pub fn repairs(report: &LoadReport) -> Vec<String> {
    let cleaned = &report.cleaned;
    let counts = [
        (cleaned.duplicate_corner, "triangle", "with a repeated corner dropped"),
        (cleaned.degenerate, "triangle", "without area dropped"),
        (cleaned.non_finite_triangles, "triangle", "at vertices that are not finite or out of range dropped"),
        (report.welded.unwrap_or(0), "vertex", "merged with others at the same position"),
    ];
    let found = counts.into_iter().filter(|c| c.0 > 0);
    found.map(|(n, what, how)| format!("{} {how}", counted(n, what))).collect()
}

/// The work, messages and milliseconds of each rank, in columns.
pub fn table_of_ranks(frame: &FrameReport) -> Vec<String> {
    let titles = [
        "rank",
        "clusters",
        "triangles",
        "visible",
        "sent",
        "bytes",
        "taken",
        "bytes",
        "draw",
        "redistribute",
        "composite",
        "collect",
        "wait ms",
    ];
    let of_rank = |rank: &RankReport| {
        let (stages, traffic) = (&rank.stages, &rank.traffic);
        let counts = [
            rank.rank as u64,
            rank.clusters,
            rank.frame.backend.triangles_drawn,
            rank.pixels.visible,
            traffic.sent_messages,
            traffic.sent_bytes,
            traffic.taken_messages,
            traffic.taken_bytes,
        ];
        let times = [&stages.draw, &stages.redistribute, &stages.compose, &stages.collect, &stages.wait];
        let times = times.map(|stage| format!("{:.1}", stage.milliseconds));
        counts.map(grouped).into_iter().chain(times).collect()
    };
    let titles = titles.map(String::from).to_vec();
    aligned(std::iter::once(titles).chain(frame.ranks.iter().map(of_rank)).collect())
}

/// Most ranks of a table of messages.
const MOST_PARTNERS: usize = 12;

/// Messages and bytes by what they are for; then the bytes that each rank sends to each other one, if there are counts by
/// partner. Of many ranks the first are in the table.
pub fn tables_of_partners(frame: &FrameReport) -> Vec<String> {
    let by_kind = frame.by_kind();
    if by_kind.is_empty() {
        return Vec::new();
    }
    let titles = ["messages", "sent", "bytes"].map(String::from).to_vec();
    let of_kind = by_kind
        .iter()
        .map(|(kind, sent)| vec![kind.to_string(), grouped(sent.sent_messages), grouped(sent.sent_bytes)]);
    let mut lines = aligned(std::iter::once(titles).chain(of_kind).collect());
    let shown = frame.ranks.len().min(MOST_PARTNERS);
    let mut titles = vec!["bytes from, to".to_string()];
    titles.extend((0..shown).map(|rank| rank.to_string()));
    let of_rank = |rank: &RankReport| {
        let mut bytes = vec![0; shown];
        for with in rank.partners.iter().filter(|with| with.partner < shown) {
            bytes[with.partner] += with.traffic.sent_bytes;
        }
        let cells = bytes.into_iter().enumerate();
        let cells = cells.map(|(to, bytes)| if to == rank.rank { "-".into() } else { grouped(bytes) });
        std::iter::once(rank.rank.to_string()).chain(cells).collect()
    };
    let rows = std::iter::once(titles).chain(frame.ranks.iter().take(shown).map(of_rank));
    lines.extend(aligned(rows.collect()));
    if shown < frame.ranks.len() {
        lines.push(format!("(the first {shown} of {} ranks; --stats has all)", frame.ranks.len()));
    }
    lines
}

/// The rows of a table, whose cells are aligned to the right. All rows have as many cells.
fn aligned(rows: Vec<Vec<String>>) -> Vec<String> {
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}"));
        cells.collect::<Vec<_>>().join("  ")
    };
    rows.iter().map(line).collect()
}

/// A number with thousands separators: 1,234,567.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A point with as many digits as `f32` positions have in a model of this size; in exponential notation if there would
/// be too many.
pub fn point(p: DVec3, size: f64) -> String {
    let largest = size.max(f64::MIN_POSITIVE).log10().floor();
    let digits = (6.0 - largest).clamp(0.0, 12.0) as usize;
    let is_readable = (-6.0..15.0).contains(&largest) || size == 0.0;
    let number = |v: f64| {
        let text = if is_readable { format!("{v:.digits$}") } else { format!("{v:.6e}") };
        let (mantissa, power) = text.split_at(text.find('e').unwrap_or(text.len()));
        let short = if mantissa.contains('.') {
            mantissa.trim_end_matches('0').trim_end_matches('.')
        } else {
            mantissa
        };
        if matches!(short, "0" | "-0") { "0".to_owned() } else { format!("{short}{power}") }
    };
    format!("{} {} {}", number(p.x), number(p.y), number(p.z))
}

/// An amount of memory in readable units.
pub fn size(bytes: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB", "PB", "EB"];
    let unit = (bytes.max(1).ilog10() / 3) as usize;
    let value = bytes as f64 / 1000f64.powi(unit as i32);
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}

/// The camera in a form that can be passed to `--eye --target --up`.
pub fn camera_json(camera: &Camera) -> Value {
    let projection = match camera.projection {
        Projection::Perspective { fov_y } => json!({ "fov_degrees": fov_y.to_degrees() }),
        Projection::Orthographic { height } => json!({ "height": height }),
    };
    json!({
        "eye": camera.eye.to_array(),
        "target": camera.target.to_array(),
        "up": camera.up.to_array(),
        "projection": projection,
        "near": camera.near,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_show_the_digits_that_count() {
        assert_eq!(point(DVec3::new(-0.10832399874925613, 1.0, -0.0), 0.2), "-0.108324 1 0");
        assert_eq!(point(DVec3::new(4_500_000.25, 100.0, 0.0), 1000.0), "4500000.25 100 0");
        assert_eq!(point(DVec3::new(1e9, 0.0, 3.0), 1e9), "1000000000 0 3");
        assert_eq!(point(DVec3::ZERO, 0.0), "0 0 0");
        assert_eq!(point(DVec3::new(3.4e38f32.into(), -1.5, 0.0), 3.4e38), "3.4e38 -1.5e0 0");
        assert_eq!(point(DVec3::new(2e-20, 0.0, -1.0 / 3e45), 2e-20), "2e-20 0 -3.333333e-46");
    }

    #[test]
    fn what_is_not_drawn_is_reported_with_counts() {
        assert_eq!(not_drawn(&NotDrawn::default()), None);
        let mut n = NotDrawn::default();
        (n.points, n.lines, n.textures) = (1200, 1, 3);
        assert_eq!(not_drawn(&n).as_deref(), Some("1,200 points, 1 line, 3 textures"));
        assert_eq!(only(&n).as_deref(), Some("1,200 points, 1 line"));
        (n.points, n.lines) = (0, 0);
        assert_eq!(only(&n), None);
    }

    #[test]
    fn numbers_are_readable() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0, 999, 1500, u64::MAX].map(size), ["0 B", "999 B", "1.5 kB", "18.4 EB"]);
    }
}
