//! Why a picture is empty: the first thing to tell a user who sees one.

use tercio::mesh::Aabb;
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
    let why = if outside == all {
        outside_reason(bounds, camera)
    } else if facing == all {
        let side = if cull == Cull::Front { "front" } else { "back" };
        format!("show the camera their {side}, which --cull leaves out")
    } else if rest == all && counts.triangles_clipped > 0 {
        CUT_AWAY.into()
    } else if rest == all {
        "are too small or too thin to cover the centre of a pixel".into()
    } else {
        let parts = [
            (outside, "are outside the picture"),
            (facing, "show the side that --cull leaves out"),
            (rest, if counts.triangles_clipped > 0 { CUT_AWAY } else { "cover no centre of a pixel" }),
        ];
        let parts = parts.iter().filter(|p| p.0 > 0).map(|&(n, what)| format!("{n} {}", numbered(n, what)));
        return Some(format!(
            "nothing was drawn: of {all} triangles {}",
            parts.collect::<Vec<_>>().join(", ")
        ));
    };
    Some(match all {
        1 => format!("nothing was drawn: the only triangle {}", numbered(1, &why)),
        _ => format!("nothing was drawn: all {all} triangles {why}"),
    })
}

/// Said of triangles of which clipping left nothing that is seen.
const CUT_AWAY: &str =
    "are cut away: they lie beside the picture, or nearer to the camera than the near plane (--near)";

/// What is said of several, said of `n`.
fn numbered(n: u64, what: &str) -> String {
    if n != 1 {
        return what.into();
    }
    let pairs = [
        ("are ", "is "),
        ("show the camera their ", "shows the camera its "),
        ("show ", "shows "),
        ("cover ", "covers "),
    ];
    let found = pairs.iter().find_map(|(many, one)| Some(format!("{one}{}", what.strip_prefix(many)?)));
    found.unwrap_or_else(|| what.into()).replace("they lie", "it lies")
}

fn outside_reason(bounds: &Aabb, camera: &Camera) -> String {
    let Ok(basis) = camera.basis() else { return "are outside the picture".into() };
    let distances = bounds.corners().map(|c| (c - camera.eye).dot(basis.forward));
    let farthest = distances.into_iter().fold(f64::NEG_INFINITY, f64::max);
    match camera.near {
        _ if farthest <= 0.0 => format!("are behind the camera, which stands at {}", camera.eye),
        Some(near) if farthest <= near => {
            let [farthest, near] = [farthest, near].map(readable);
            format!("are nearer than the near plane: at most {farthest} from the camera, --near is {near}")
        }
        _ => format!(
            "are outside the picture: the camera at {} looks towards {}, the model reaches from {} to {}",
            camera.eye, camera.target, bounds.min, bounds.max
        ),
    }
}

/// A distance without rows of digits that nobody reads.
fn readable(distance: f64) -> String {
    if (1e-4..1e9).contains(&distance) { distance.to_string() } else { format!("{distance:e}") }
}

#[cfg(test)]
mod tests {
    use tercio::glam::DVec3;
    use tercio::raster::stats::{BackEndCounts, FrontEndCounts};
    use tercio::scene::Projection;

    use super::*;

    fn why(eye: DVec3, target: DVec3, near: Option<f64>, cull: Cull, frontend: FrontEndCounts) -> String {
        let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let projection = Projection::Perspective { fov_y: 0.5 };
        let camera = Camera { eye, target, up: DVec3::Y, projection, near };
        let stats = FrameStats { frontend, ..FrameStats::default() };
        reason(&bounds, &camera, cull, &stats).unwrap()
    }

    fn outside() -> FrontEndCounts {
        FrontEndCounts {
            triangles_in: 10,
            triangles_in_outside_clusters: 7,
            triangles_outside: 3,
            ..FrontEndCounts::default()
        }
    }

    #[test]
    fn a_drawn_picture_has_no_reason() {
        let backend = BackEndCounts { pixels_visible: 1, ..BackEndCounts::default() };
        let stats = FrameStats { backend, ..FrameStats::default() };
        let projection = Projection::Orthographic { height: 1.0 };
        let camera = Camera { eye: DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, projection, near: None };
        assert_eq!(reason(&Aabb::EMPTY, &camera, Cull::Auto, &stats), None);
    }

    #[test]
    fn an_empty_model_is_told_first() {
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, FrontEndCounts::default());
        assert!(text.ends_with("the model has no triangles"), "{text}");
    }

    #[test]
    fn behind_beside_and_too_near_are_told_apart() {
        let behind = why(DVec3::Z * 5.0, DVec3::Z * 9.0, None, Cull::Auto, outside());
        assert!(behind.contains("all 10 triangles are behind the camera"), "{behind}");
        let beside = why(DVec3::Z * 5.0, DVec3::new(9.0, 0.0, 4.0), None, Cull::Auto, outside());
        assert!(beside.contains("outside the picture"), "{beside}");
        let near = why(DVec3::Z * 5.0, DVec3::ZERO, Some(100.0), Cull::Auto, outside());
        assert!(near.contains("--near is 100"), "{near}");
        let far = why(DVec3::Z * 5.0, DVec3::ZERO, Some(1e300), Cull::Auto, outside());
        assert!(far.ends_with("--near is 1e300"), "{far}");
    }

    #[test]
    fn culled_and_tiny_triangles_are_told_apart() {
        let culled = FrontEndCounts { triangles_in: 4, triangles_facing: 4, ..FrontEndCounts::default() };
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Front, culled).contains("their front"));
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Back, culled).contains("their back"));
        let tiny = FrontEndCounts { triangles_in: 4, triangles_no_sample: 4, ..FrontEndCounts::default() };
        assert!(why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, tiny).contains("too small"));
        let one = FrontEndCounts { triangles_in: 1, triangles_no_sample: 1, ..tiny };
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, one);
        assert!(text.contains("the only triangle is too small"), "{text}");
        let clipped = FrontEndCounts { triangles_in: 4, triangles_clipped: 4, ..FrontEndCounts::default() };
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, clipped);
        assert!(text.contains("all 4 triangles are cut away: they lie beside"), "{text}");
        let mixed = FrontEndCounts { triangles_outside: 1, triangles_in: 4, ..tiny };
        let text = why(DVec3::Z, DVec3::ZERO, None, Cull::Auto, mixed);
        assert!(text.ends_with("of 4 triangles 1 is outside the picture, 3 cover no centre of a pixel"));
    }
}
