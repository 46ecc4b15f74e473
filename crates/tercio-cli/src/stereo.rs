//! What `--stats` and messages say about the pictures of two eyes.

use serde_json::{Value, json};
use tercio::parallel::FrameReport;
use tercio::raster::FrameStats;

use crate::args::stereo::{Cameras, StereoName};
use crate::args::values;
use crate::report;

/// Counts and times of one camera's picture.
#[derive(Debug)]
pub struct ViewReport {
    /// Those of the frame.
    pub stats: FrameStats,
    /// The report of every rank, if there are ranks.
    pub parallel: Option<FrameReport>,
}

/// The names of the eyes, in the order of their pictures.
const EYES: [&str; 2] = ["left", "right"];

/// Counts and times of all pictures together.
pub fn together(views: &[ViewReport]) -> FrameStats {
    let all = views.iter().map(|view| view.stats.clone());
    all.reduce(|all, stats| all.plus(&stats)).unwrap_or_default()
}

/// The eye that sees nothing although the other one does.
pub fn blind_eye(views: &[ViewReport]) -> Option<&'static str> {
    let sees = |view: &ViewReport| view.stats.backend.pixels_visible > 0;
    let [left, right] = views else { return None };
    match (sees(left), sees(right)) {
        (false, true) => Some(EYES[0]),
        (true, false) => Some(EYES[1]),
        _ => None,
    }
}

/// The layout, the distances that were used, and the camera, counts and times of each eye; null for one picture.
pub fn json(layout: Option<StereoName>, cameras: &Cameras, views: &[ViewReport]) -> Value {
    let (Some(layout), Some(stereo)) = (layout, cameras.stereo) else { return Value::Null };
    let eyes = EYES.iter().zip(&cameras.views).zip(views).map(|((name, camera), view)| {
        json!({
            "eye": name,
            "camera": report::camera_json(camera),
            "shift": camera.shift,
            "frame": view.stats,
            "parallel": view.parallel,
        })
    });
    json!({
        "layout": values::name(&layout),
        "eye_distance": stereo.eye_distance,
        "convergence": stereo.convergence,
        "eyes": eyes.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(visible: u64) -> ViewReport {
        let mut stats = FrameStats::default();
        stats.backend.pixels_visible = visible;
        ViewReport { stats, parallel: None }
    }

    #[test]
    fn an_eye_that_sees_nothing_is_named() {
        assert_eq!(blind_eye(&[view(1), view(2)]), None);
        assert_eq!(blind_eye(&[view(0), view(2)]), Some("left"));
        assert_eq!(blind_eye(&[view(2), view(0)]), Some("right"));
        assert_eq!(blind_eye(&[view(0), view(0)]), None, "that is an error of its own");
        assert_eq!(blind_eye(&[view(0)]), None);
    }

    #[test]
    fn counts_of_both_eyes_are_added() {
        assert_eq!(together(&[view(3)]).backend.pixels_visible, 3);
        assert_eq!(together(&[view(3), view(4)]).backend.pixels_visible, 7);
    }
}
