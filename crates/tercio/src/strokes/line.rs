//! Lines and edges as strips of triangles that face the camera.
//!
//! A line is drawn as two strips, one on each side of it, with round ends. Where a face of the model adjoins the edge on a side,
//! the strip of that side lies in the plane of the face, so it neither cuts the surface nor is cut by it, at any angle. Then it
//! is moved along the lines of sight, which does not change its place in the picture, by what the renderer's rounding to
//! sub-pixels can change of the depth of that plane, several times over: a thirty-second of a pixel, times the slope. So
//! nothing shines through a surface that is farther from it than that.

use glam::{DVec2, DVec3};
use tercio_mesh::trig::{acos, sin_cos};

use super::eye::{Eye, part};
use super::sheet::{Ink, Sheet};
use super::{EdgePart, Length, Pen};

/// Distance of an end from the true one, in pixels, at most.
const ROUNDNESS: f64 = 0.1;
/// Beyond what a face reaches, its strip does not come nearer than this many times the width.
const STEEPEST: f64 = 40.0;
/// Share of a pixel, times the slope, by which a strip is in front of its face.
const AHEAD: f64 = 1.0 / 32.0;
/// Width of the overlap of a strip with the surface beside it, in pixels.
const OVERLAP: f64 = 1.0 / 32.0;
/// Slopes above this one, in pixels of depth per pixel, count as this one.
const LARGEST_SLOPE: f64 = 1000.0;

/// A line, in eye space.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its ends.
    pub ends: [DVec3; 2],
    /// The third corners of the triangles beside it, if it is an edge: the first one runs from the first end to the second, the
    /// second one back.
    pub apexes: [Option<DVec3>; 2],
    /// Draws it only on its own triangles if the viewer sees the backs of both, so that it does not stick out beside the
    /// silhouette of a solid.
    pub hides_back: bool,
    /// If it is not all of it, the line is drawn only if it is on the silhouette: all its triangles are on one side of it.
    pub part: EdgePart,
}

/// An end of what is visible of a line.
#[derive(Clone, Copy)]
struct End {
    screen: DVec2,
    /// Half of the width, in pixels.
    radius: f64,
    z: f64,
}

/// A triangle beside a line.
#[derive(Clone, Copy)]
struct Face {
    apex: DVec3,
    /// Gradient of the nearness.
    slope: DVec2,
    /// On which side of the line: 1 or -1.
    side: f64,
    nearest: f64,
}

/// One side of a line.
struct Half {
    /// Nearness at both ends of the rim, and by how much distance these and the middle are moved ahead.
    rim: [f64; 2],
    ahead: [f64; 2],
}

/// Draws a line.
pub fn draw(sheet: &mut Sheet, line: &Line, pen: &Pen, inks: [Ink; 2]) {
    let eye = sheet.eye();
    let margin = match pen.width {
        Length::Pixels(width) => width + 2.0,
        Length::Units(_) => eye.size().max_element(),
    };
    let Some(shares) = eye.clip_shares(line.ends, margin) else { return };
    let ends = part(line.ends, shares);
    let inks = shares.map(|share| sheet.between(inks, share));
    let end = |p: DVec3| End { screen: eye.screen(p), radius: 0.5 * pen.width.pixels(eye, p.z), z: p.z };
    let ends3 = ends;
    let ends = ends.map(end);
    let across = ends[1].screen - ends[0].screen;
    let along = if across.length() > 1e-6 { across.normalize() } else { DVec2::X };
    let normal = along.perp();
    let faces = line
        .apexes
        .map(|apex| apex.and_then(|apex| face(eye, line, ends3[0], (normal, ends[0].screen), apex)));
    if line.part != EdgePart::All
        && let [Some(a), Some(b)] = faces
        && a.side != b.side
    {
        return;
    }
    let is_back = |k: usize| {
        line.apexes[k].is_some_and(|apex| {
            let [p, q] = line.ends;
            let outward = (q - p).cross(apex - p) * if k == 0 { 1.0 } else { -1.0 };
            outward.dot(eye.to_viewer(p)) <= 0.0
        })
    };
    if line.hides_back && is_back(0) && is_back(1) && ends.iter().all(|end| end.radius > 0.0) {
        if line.part == EdgePart::BesideSurface {
            return;
        }
        for face in faces.into_iter().flatten() {
            on_its_face(sheet, &ends, ends3, &face, normal * face.side, inks);
        }
        return;
    }
    let halves = [1.0, -1.0].map(|side| {
        let is_free = faces.iter().flatten().all(|face| face.side != side);
        (is_free || line.part != EdgePart::BesideSurface).then(|| half(eye, &ends, &faces, normal, side))
    });
    strips(sheet, &ends, along, &halves, inks, line.apexes != [None; 2]);
}

/// A triangle beside a line; `None` if it is seen edge-on.
fn face(eye: &Eye, line: &Line, from: DVec3, (normal, at): (DVec2, DVec2), apex: DVec3) -> Option<Face> {
    let [p, q] = line.ends;
    let slope = eye.slope((q - p).cross(apex - p), from);
    let side = eye.side(normal, at, apex);
    let nearest = p.z.min(q.z).min(apex.z);
    (slope.is_finite() && side != 0.0).then_some(Face { apex, slope, side: side.signum(), nearest })
}

/// The depths of a strip.
fn half(eye: &Eye, ends: &[End; 2], faces: &[Option<Face>; 2], normal: DVec2, side: f64) -> Half {
    let all = || faces.iter().flatten();
    let own = || all().filter(|face| face.side == side);
    let is_free = own().next().is_none();
    let towards = |face: &Face| face.slope.dot(normal * side);
    // Where several faces are on one side, the nearer one. Where there is none, not behind the line, which nothing hides then;
    // and not behind the planes of the others, because the surface may go on there without being connected.
    let slope = match is_free {
        true => all().map(towards).fold(0.0, f64::max),
        false => own().map(towards).fold(f64::NEG_INFINITY, f64::max),
    };
    let steepest = all().map(|face| face.slope.length()).fold(0.0, f64::max);
    let (mut rim, mut ahead) = ([0.0; 2], [0.0; 2]);
    for (k, end) in ends.iter().enumerate() {
        let (pixel, nearness) = (eye.pixel(end.z), eye.nearness(end.z));
        let nearest = own().map(|face| face.nearest).fold(end.z, f64::min);
        let reach = STEEPEST * end.radius * pixel;
        let bounds = [reach, -reach.max(end.z - nearest)].map(|by| eye.nearness(ahead_of(end.z, -by)));
        rim[k] = (nearness + slope * end.radius).clamp(bounds[0], bounds[1]);
        ahead[k] = eye.rounding(end.z)
            + match all().next() {
                // A line of its own: on a surface that is less steep than 45 degrees it is whole.
                None => end.radius * pixel,
                Some(_) => {
                    let steep =
                        (steepest * eye.distance_per_nearness(end.z) / pixel).abs().min(LARGEST_SLOPE);
                    (AHEAD * (1.0 + steep) * pixel).min(pixel.max(end.z - nearest))
                }
            };
    }
    Half { rim, ahead }
}

/// A distance that is smaller, but not behind the viewer.
fn ahead_of(z: f64, by: f64) -> f64 {
    // An orthographic camera may see what is beside it.
    if z > 0.0 { (z - by).max(z * 1e-3) } else { z - by }
}

/// A strip on each side, or on one alone, with round ends.
fn strips(
    sheet: &mut Sheet,
    ends: &[End; 2],
    along: DVec2,
    halves: &[Option<Half>; 2],
    inks: [Ink; 2],
    is_joined: bool,
) {
    let eye = sheet.eye();
    // One alone overlaps with what is on the other side: both are rounded to sub-pixels.
    let inwards = match halves {
        [Some(_), None] => along.perp() * -OVERLAP,
        [None, Some(_)] => along.perp() * OVERLAP,
        _ => DVec2::ZERO,
    };
    let (mut middles, mut tips, mut steps) = ([0; 2], [0; 2], [0; 2]);
    for (k, end) in ends.iter().enumerate() {
        let by = halves.iter().flatten().map(|half| half.ahead[k]).fold(0.0, f64::max);
        let nearness = eye.nearness(ahead_of(end.z, by));
        steps[k] = rounds(end.radius, is_joined);
        middles[k] = sheet.vertex(end.screen + inwards, nearness, inks[k]);
        let out = along * if k == 0 { -end.radius } else { end.radius };
        tips[k] = if steps[k] > 0 { sheet.vertex(end.screen + out, nearness, inks[k]) } else { 0 };
    }
    for (half, side) in halves.iter().zip([1.0, -1.0]) {
        let Some(half) = half else { continue };
        let turned = |[a, b, c]: [u32; 3]| if side > 0.0 { [a, b, c] } else { [a, c, b] };
        let mut sides = [0; 2];
        for (k, end) in ends.iter().enumerate() {
            let outwards = if k == 0 { -along } else { along };
            let middle = eye.nearness(ahead_of(end.z, half.ahead[k]));
            let rim = eye.nearness(ahead_of(eye.distance(half.rim[k]), half.ahead[k]));
            let mut last = tips[k];
            for step in 1..=steps[k].max(1) {
                // Without a round end, the corner alone.
                let angle = std::f64::consts::FRAC_PI_2 * f64::from(step) / f64::from(steps[k].max(1));
                let (sin, cos) = if step >= steps[k] { (1.0, 0.0) } else { sin_cos(angle) };
                let offset = (outwards * cos + along.perp() * (side * sin)) * end.radius;
                let next = sheet.vertex(end.screen + offset, middle + (rim - middle) * sin, inks[k]);
                if steps[k] > 0 {
                    let corners = if k == 1 { [middles[k], last, next] } else { [middles[k], next, last] };
                    sheet.triangle(turned(corners));
                }
                last = next;
            }
            sides[k] = last;
        }
        sheet.triangle(turned([middles[0], middles[1], sides[1]]));
        sheet.triangle(turned([middles[0], sides[1], sides[0]]));
    }
}

/// Triangles of a quarter of a round end. Where other edges join, a coarse one fills the gap.
fn rounds(radius: f64, is_joined: bool) -> u32 {
    match radius {
        r if is_joined && r <= 0.5 || r <= 0.25 => 0,
        r if is_joined && r <= 1.5 => 1,
        r => (std::f64::consts::FRAC_PI_4 / acos(1.0 - ROUNDNESS / r.max(0.2))).ceil().min(16.0) as u32,
    }
}

/// The strip of one side, as far as its triangle reaches.
fn on_its_face(
    sheet: &mut Sheet,
    ends: &[End; 2],
    ends3: [DVec3; 2],
    face: &Face,
    outwards: DVec2,
    inks: [Ink; 2],
) {
    let eye = sheet.eye();
    let Some([_, apex]) = eye.clip([ends3[0], face.apex], f64::INFINITY).filter(|part| part[1] == face.apex)
    else {
        return;
    };
    let top = eye.screen(apex);
    let height = (top - ends[0].screen).dot(outwards);
    if height <= 0.0 {
        return;
    }
    let faces = [Some(*face), None];
    let half = half(eye, ends, &faces, outwards * face.side, face.side);
    let at = |k: usize, share: f64| {
        let nearness = eye.nearness(ends[k].z);
        let across = nearness + share * (eye.nearness(apex.z) - nearness);
        (ends[k].screen.lerp(top, share), eye.nearness(ahead_of(eye.distance(across), half.ahead[k])))
    };
    let share = |k: usize| (ends[k].radius / height).min(1.0);
    let corners = [(0, 0.0), (1, 0.0), (1, share(1)), (0, share(0))].map(|(k, share)| {
        let (screen, nearness) = at(k, share);
        sheet.vertex(screen, nearness, inks[k])
    });
    let [a, b, c, d] =
        if face.side > 0.0 { corners } else { [corners[1], corners[0], corners[3], corners[2]] };
    sheet.triangle([a, b, c]);
    sheet.triangle([a, c, d]);
}
