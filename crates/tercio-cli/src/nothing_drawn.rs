//! Why a picture is empty.

use std::borrow::Cow;

use tercio::mesh::Aabb;
use tercio::raster::view::View;
use tercio::raster::{Cull, FrameStats};
use tercio::scene::Camera;

/// The reason in one sentence, or `None` if something was drawn.
pub fn reason(bounds: &Aabb, camera: &Camera, cull: Cull, stats: &FrameStats) -> Option<String> {
    if stats.backend.pixels_visible > 0 {
        return None;
    }
    let counts = &stats.frontend;
    let all = counts.triangles_in;
    if all == 0 {
        return Some("nothing was drawn: the model has no triangles".into());
    }
    let outside = counts.triangles_in_outside_clusters + counts.triangles_outside;
    let facing = counts.triangles_in_facing_clusters + counts.triangles_facing;
    let rest = all.saturating_sub(outside + facing);
    if stats.backend.pixels_shaded > 0 {
        return Some("nothing was drawn: what the camera sees is fully transparent".into());
    }
    let why = if outside == all {
        outside_reason(bounds, camera)
    } else if facing == all {
        let side = if cull == Cull::Front { "front" } else { "back" };
        let rest = format!("{side}, which --cull leaves out");
        Statement { one: "shows the camera its", many: "show the camera their", rest: rest.into() }
    } else if rest == all && counts.triangles_clipped > 0 {
        CUT_AWAY
    } else if rest == all {
        Statement { rest: "too small or too thin to cover a sample of a pixel".into(), ..ARE }
    } else {
        let culled = Statement { one: "shows", many: "show", rest: "the side that --cull leaves out".into() };
        let small = Statement { one: "covers", many: "cover", rest: "no sample of a pixel".into() };
        let parts = [
            (outside, OUTSIDE),
            (facing, culled),
            (rest, if counts.triangles_clipped > 0 { CUT_AWAY } else { small }),
        ];
        let parts =
            parts.iter().filter(|p| p.0 > 0).map(|(n, statement)| format!("{n} {}", statement.of(*n)));
        return Some(format!(
            "nothing was drawn: of {all} triangles {}",
            parts.collect::<Vec<_>>().join(", ")
        ));
    };
    let why = why.of(all);
    Some(match all {
        1 => format!("nothing was drawn: the only triangle {why}"),
        _ => format!("nothing was drawn: all {all} triangles {why}"),
    })
}

/// A statement about triangles: its beginning in singular and plural, and its common rest.
struct Statement {
    one: &'static str,
    many: &'static str,
    rest: Cow<'static, str>,
}

const ARE: Statement = Statement { one: "is", many: "are", rest: Cow::Borrowed("") };

const OUTSIDE: Statement = Statement { one: "is", many: "are", rest: Cow::Borrowed("outside the picture") };

/// Triangles of which clipping left nothing visible.
const CUT_AWAY: Statement = Statement {
    one: "is cut away: it lies",
    many: "are cut away: they lie",
    rest: Cow::Borrowed("beside the picture, or nearer to the camera than the near plane (--near)"),
};

impl Statement {
    /// The statement about `n` triangles.
    fn of(&self, n: u64) -> String {
        format!("{} {}", if n == 1 { self.one } else { self.many }, self.rest)
    }
}

fn outside_reason(bounds: &Aabb, camera: &Camera) -> Statement {
    let Ok(basis) = camera.basis() else { return OUTSIDE };
    let distances = bounds.corners().map(|c| (c - camera.eye).dot(basis.forward));
    let farthest = distances.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let nearest = distances.into_iter().fold(f64::INFINITY, f64::min);
    let rest = match camera.near {
        _ if farthest <= 0.0 => format!("behind the camera, which is at {}", camera.eye),
        Some(near) if farthest <= near => {
            let [farthest, near] = [farthest, near].map(readable);
            format!("nearer than the near plane: at most {farthest} from the camera, --near is {near}")
        }
        _ => format!(
            "outside the picture: the camera at {} looks towards {}, the model reaches from {} to {}{}",
            camera.eye,
            camera.target,
            bounds.min,
            bounds.max,
            automatic_near(bounds, camera, nearest)
        ),
    };
    Statement { rest: rest.into(), ..ARE }
}

/// A note if the automatic near plane is inside the model's box, as it may be what cuts the model.
fn automatic_near(bounds: &Aabb, camera: &Camera, nearest: f64) -> String {
    match View::new(camera, bounds, 1, 1) {
        Ok(view) if camera.near.is_none() && view.near > nearest.max(0.0) => {
            format!("; what is nearer than {} is cut (--near)", readable(view.near))
        }
        _ => String::new(),
    }
}

/// A distance without long rows of digits.
fn readable(distance: f64) -> String {
    if (1e-4..1e9).contains(&distance) { distance.to_string() } else { format!("{distance:e}") }
}

#[cfg(test)]
mod tests {
    use tercio::glam::DVec3;
    use tercio::raster::stats::{BackEndCounts, FrontEndCounts};
    use tercio::scene::Projection;

    use super::*;

    /// Counts with some fields set.
    fn set<T>(mut counts: T, some: impl FnOnce(&mut T)) -> T {
        some(&mut counts);
        counts
    }

    fn why(eye: DVec3, target: DVec3, near: Option<f64>, cull: Cull, frontend: FrontEndCounts) -> String {
        let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let projection = Projection::Perspective { fov_y: 0.5 };
        let camera = Camera { eye, target, up: DVec3::Y, projection, near, shift: [0.0; 2] };
        let stats = set(FrameStats::default(), |c| c.frontend = frontend);
        reason(&bounds, &camera, cull, &stats).unwrap()
    }

    fn outside() -> FrontEndCounts {
        set(FrontEndCounts::default(), |c| {
            (c.triangles_in, c.triangles_in_outside_clusters, c.triangles_outside) = (10, 7, 3)
        })
    }

    #[test]
    fn a_drawn_picture_has_no_reason() {
        let backend = set(BackEndCounts::default(), |c| c.pixels_visible = 1);
        let stats = set(FrameStats::default(), |c| c.backend = backend);
        let projection = Projection::Orthographic { height: 1.0 };
        let camera = Camera {
            eye: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection,
            near: None,
            shift: [0.0; 2],
        };
        assert_eq!(reason(&Aabb::EMPTY, &camera, Cull::Auto, &stats), None);
    }

    #[test]
    fn an_empty_model_is_reported_first() {
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, FrontEndCounts::default());
        assert!(text.ends_with("the model has no triangles"), "{text}");
    }

    #[test]
    fn behind_beside_and_too_near_are_distinguished() {
        let behind = why(DVec3::Z * 5.0, DVec3::Z * 9.0, None, Cull::Auto, outside());
        assert!(behind.contains("all 10 triangles are behind the camera"), "{behind}");
        let beside = why(DVec3::Z * 5.0, DVec3::new(9.0, 0.0, 4.0), None, Cull::Auto, outside());
        assert!(beside.contains("outside the picture"), "{beside}");
        let within = why(DVec3::ZERO, DVec3::Z, None, Cull::Auto, outside());
        assert!(
            within.contains("; what is nearer than 1.57") && within.ends_with("e-12 is cut (--near)"),
            "{within}"
        );
        let near = why(DVec3::Z * 5.0, DVec3::ZERO, Some(100.0), Cull::Auto, outside());
        assert!(near.contains("--near is 100"), "{near}");
        let far = why(DVec3::Z * 5.0, DVec3::ZERO, Some(1e300), Cull::Auto, outside());
        assert!(far.ends_with("--near is 1e300"), "{far}");
    }

    #[test]
    fn culled_and_tiny_triangles_are_distinguished() {
        let culled = set(FrontEndCounts::default(), |c| (c.triangles_in, c.triangles_facing) = (4, 4));
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Front, culled).contains("their front"));
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Back, culled).contains("their back"));
        let tiny = set(FrontEndCounts::default(), |c| (c.triangles_in, c.triangles_no_sample) = (4, 4));
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, tiny).contains("too small"));
        let one = set(tiny, |c| (c.triangles_in, c.triangles_no_sample) = (1, 1));
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, one);
        assert!(text.contains("the only triangle is too small"), "{text}");
        let clipped = set(FrontEndCounts::default(), |c| (c.triangles_in, c.triangles_clipped) = (4, 4));
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, clipped);
        assert!(text.contains("all 4 triangles are cut away: they lie beside"), "{text}");
        let of_one = |cull, counts: FrontEndCounts| {
            why(DVec3::Z * 5.0, DVec3::ZERO, None, cull, set(counts, |c| c.triangles_in = 1))
        };
        let text = of_one(Cull::Auto, set(tiny, |c| c.triangles_clipped = 1));
        assert!(text.contains("the only triangle is cut away: it lies beside"), "{text}");
        let text = of_one(Cull::Back, set(tiny, |c| c.triangles_facing = 1));
        assert!(text.contains("the only triangle shows the camera its back, which"), "{text}");
        let text = of_one(Cull::Auto, set(tiny, |c| c.triangles_outside = 1));
        assert!(text.contains("the only triangle is outside the picture: the camera"), "{text}");
        let counts = set(tiny, |c| (c.triangles_facing, c.triangles_outside, c.triangles_in) = (1, 2, 4));
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Back, counts);
        assert!(
            text.contains("2 are outside the picture, 1 shows the side that --cull leaves out"),
            "{text}"
        );
        assert!(text.ends_with("out, 1 covers no sample of a pixel"), "{text}");
        let mixed = set(tiny, |c| (c.triangles_outside, c.triangles_in) = (1, 4));
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, mixed);
        assert!(text.ends_with("of 4 triangles 1 is outside the picture, 3 cover no sample of a pixel"));
    }
}
