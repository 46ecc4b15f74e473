//! Pictures that are too large to be kept in memory.

use std::time::Instant;

use anyhow::Result;
use tercio::parallel::trace::{Span, Step, Trace};
use tercio::raster::Settings;
use tercio::write_png_in_bands;

use super::{Done, Loaded, Render, Writing};
use crate::args::ranks::Drawers;
use crate::mpi;
use crate::output::Plan;
use crate::progress::Display;
use crate::stereo::ViewReport;

impl Render {
    /// Whether the picture is drawn in bands, because it is too large to be kept in memory.
    pub(super) fn is_in_bands(&self, plan: &Plan, drawers: Drawers) -> bool {
        drawers == Drawers::Alone && self.stereo.layout().is_none() && plan.is_in_bands(self.drawing.size)
    }

    pub(super) fn draw_in_bands(
        &self,
        writing: &Writing,
        settings: &Settings,
        loaded: Loaded,
        display: &Display,
        mut trace: Option<Trace>,
    ) -> Result<Done> {
        let settings = &self.with_shadows(
            settings,
            &loaded.scene,
            &loaded.cameras.middle,
            display,
            None::<&mut mpi::Comm>,
        )?;
        let scene = self.with_strokes(&loaded, &loaded.cameras.middle)?.into_owned();
        let Loaded { report, textures, look, cameras, .. } = loaded;
        let camera = &cameras.middle;
        let (begin, began) = (Instant::now(), self.ranks.now());
        let (progress, allow_empty) = (Some(&*display.progress), writing.allow_empty);
        let stats = writing.plan.write_drawn(&self.model.name(), allow_empty, |out| {
            write_png_in_bands(&scene, camera, settings, allow_empty, progress, out)
        })?;
        let all = begin.elapsed().as_secs_f64() * 1e3;
        if let (Some(trace), Some(began)) = (&mut trace, began) {
            trace.add(0, Step::Draw, 1, Span::since(began));
        }
        let output_milliseconds = (all - stats.milliseconds.total).max(0.0);
        let empty = self.reason(&report, camera, &stats);
        let views = vec![ViewReport { stats, parallel: None }];
        let (effect_milliseconds, choice) = (0.0, None);
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
