//! Placement: copies of polygons, destinations stage by stage, owners of pixels (sections 6.3, A.1 and A.2). The
//! simulator of the ring is in [`crate::simulators`]; these are the rules that it has to follow.

use crate::models;
use crate::models::registry::Model;
use crate::units::{Count, Length, Processors};

/// Maximum number of entries of a list.
const LONGEST_LIST: f64 = (1u64 << 20) as f64;

/// Remainder for processor numbers, which are whole and not negative.
fn modulo(number: f64, n: f64) -> f64 {
    number.rem_euclid(n)
}

/// The processors with a copy of polygon `b`, `m` copies on a ring of `n` (A.2.1): every n/m-th one from b mod n/m.
/// The document prints the distance of the copies as m; section 5.4 has n/m.
///
/// # Errors
/// `m` that does not divide `n`, more than 2^20 copies.
pub fn copies(b: Count, n: Count, m: Count) -> Result<Vec<Count>, String> {
    let distance = n.get() / m.get();
    if !(distance >= 1.0 && distance.fract() == 0.0) {
        return Err(format!("m: expected a divisor of n = {n}, found {m}"));
    }
    if m.get() > LONGEST_LIST {
        return Err(format!("m: expected at most {LONGEST_LIST} copies, found {m}"));
    }
    let first = modulo(b.get(), distance);
    Ok((0..m.get() as u64).map(|k| Count::new(first + k as f64 * distance)).collect())
}

/// The processor at which the stage of stride `d` delivers a descriptor on its way from `source` to `target` (figure
/// A-6): after the largest number of whole strides that does not overshoot.
fn stop(n: f64, d: f64, source: f64, target: f64) -> f64 {
    let offset = modulo(target - source, n);
    modulo(source + (offset / d).floor() * d, n)
}

/// The destinations of a descriptor in the stage of stride `d`, in the order of the ring (figure A-6a).
pub fn stage_destinations(n: Count, d: Processors, source: Count, targets: Vec<Count>) -> Vec<Count> {
    let mut stops: Vec<_> = targets.iter().map(|t| stop(n.get(), d.get(), source.get(), t.get())).collect();
    stops.sort_by(|a, b| modulo(a - source.get(), n.get()).total_cmp(&modulo(b - source.get(), n.get())));
    stops.dedup();
    stops.into_iter().map(Count::new).collect()
}

/// The targets that each of [`stage_destinations`] has to serve in the stages that follow (figure A-6b).
pub fn stage_targets(n: Count, d: Processors, source: Count, targets: Vec<Count>) -> Vec<Vec<Count>> {
    let destinations = stage_destinations(n, d, source, targets.clone());
    let serves = |at: &Count, target: &&Count| stop(n.get(), d.get(), source.get(), target.get()) == at.get();
    destinations.iter().map(|at| targets.iter().filter(|t| serves(at, t)).copied().collect()).collect()
}

/// The processor that has the composited pixel `j` of region `r` (section 6.3, figures 6-2 and 6-3), for groups of
/// `g` among `n`.
pub fn composite_owner(n: Count, g: Count, r: Count, j: Count) -> Count {
    Count::new(r.get() + g.get() * modulo(j.get(), n.get() / g.get()))
}

/// The processors where pixel `j` of region `r` starts its composition and where it ends (figure 6-2).
pub fn composite_path(n: Count, g: Count, r: Count, j: Count) -> [Count; 2] {
    let owner = composite_owner(n, g, r, j);
    [Count::new(modulo(owner.get() + g.get(), n.get())), owner]
}

/// The owners of the first `pixels` pixels of region `r`, in rows of `width` (figure 6-3).
///
/// # Errors
/// A width of zero, more than 2^20 pixels.
pub fn composite_map(
    n: Count,
    g: Count,
    r: Count,
    width: Count,
    pixels: Count,
) -> Result<Vec<Vec<Count>>, String> {
    if width.get() < 1.0 {
        return Err("width: expected at least 1, found 0".into());
    }
    if pixels.get() > LONGEST_LIST {
        return Err(format!("pixels: expected at most {LONGEST_LIST}, found {pixels}"));
    }
    let owners: Vec<_> =
        (0..pixels.get() as u64).map(|j| composite_owner(n, g, r, Count::new(j as f64))).collect();
    Ok(owners.chunks(width.get() as usize).map(<[Count]>::to_vec).collect())
}

/// How many regions of a screen map, each `[processor, left, top, right, bottom]` with both ends inclusive, contain the
/// pixel (x, y). A map is valid if it is 1 everywhere (A.1.1). Figure A-2 as printed has row 255 of the left half
/// twice: its second region has to begin at row 256.
pub fn owners_of_pixel(map: Vec<[f64; 5]>, x: Length, y: Length) -> Count {
    let (x, y) = (x.get(), y.get());
    let owns = |r: &&[f64; 5]| r[1] <= x && x <= r[3] && r[2] <= y && y <= r[4];
    Count::new(map.iter().filter(owns).count() as f64)
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.copies", "A.2.1", "processors with a copy of polygon b, m copies; printed with distance m":
        copies["b": Count, "n": Count where 1.0, "m": Count where 1.0] -> Result<Vec<Count>, String>;
    "eldridge.stage-destinations", "fig A-6", "destinations of a descriptor in the stage of stride d":
        stage_destinations["n": Count where 1.0, "d": Processors, "source": Count, "targets": Vec<Count>] -> Vec<Count>;
    "eldridge.stage-targets", "fig A-6", "targets that each of these destinations has to serve":
        stage_targets["n": Count where 1.0, "d": Processors, "source": Count, "targets": Vec<Count>] -> Vec<Vec<Count>>;
    "eldridge.composite-path", "fig 6-2", "processors where a pixel's composition starts and ends":
        composite_path["n": Count where 1.0, "g": Count where 1.0, "r": Count = 0.0, "j": Count] -> [Count; 2];
    "eldridge.composite-map", "fig 6-3", "owners of the composited pixels of a region, in rows":
        composite_map["n": Count where 1.0, "g": Count where 1.0, "r": Count = 0.0, "width": Count, "pixels": Count]
            -> Result<Vec<Vec<Count>>, String>;
    "eldridge.owners-of-pixel", "fig A-2", "regions of a screen map [processor, left, top, right, bottom] at a pixel":
        owners_of_pixel["map": Vec<[f64; 5]>, "x": Length, "y": Length] -> Count;
};
