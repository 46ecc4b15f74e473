//! The outputs of finished pictures.

use std::time::Instant;

use anyhow::Result;
use tercio::parallel::trace::Trace;
use tercio_lab::predict::choose::Choice;

use super::{Done, Drawn, Loaded, Render, Writing};
use crate::stereo::ViewReport;

impl Render {
    /// Writes the outputs, unless nothing was drawn.
    pub(super) fn write(
        &self,
        writing: &Writing,
        loaded: Loaded,
        drawn: Vec<Drawn>,
        choice: Option<Choice>,
        trace: Option<Trace>,
    ) -> Result<Done> {
        let Loaded { report, textures, scene, look, cameras, .. } = loaded;
        let mut frames = Vec::new();
        let (mut views, mut reasons) = (Vec::new(), Vec::new());
        let effect_milliseconds = drawn.iter().map(|d| d.effect_milliseconds).sum();
        for (Drawn { frame, parallel, .. }, camera) in drawn.into_iter().zip(&cameras.views) {
            reasons.push(self.reason(&report, camera, &frame.stats));
            views.push(ViewReport { stats: frame.stats.clone(), parallel });
            frames.push(frame);
        }
        // What one eye sees is something.
        let empty = reasons.into_iter().collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().next());
        let begin = Instant::now();
        // A large model takes longer to free than a picture takes to write.
        let is_written = empty.is_none() || writing.allow_empty;
        let write = || if is_written { writing.plan.write(&self.stereo.written(frames)?) } else { Ok(()) };
        let (written, ()) = rayon::join(write, || drop(scene));
        written?;
        let output_milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        Ok(Done {
            report,
            textures,
            look,
            cameras,
            choice,
            views,
            effect_milliseconds,
            output_milliseconds,
            empty,
            trace,
        })
    }
}
