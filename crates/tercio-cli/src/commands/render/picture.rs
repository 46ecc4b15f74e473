//! What belongs to one picture besides drawing it: shadows before it, effects after it.

use std::time::Instant;

use anyhow::{Context, Result};
use tercio::LoadReport;
use tercio::parallel::Communicator;
use tercio::raster::{Frame, FrameStats, Settings};
use tercio::scene::{Background, Camera, Scene};

use super::Render;
use crate::progress::Display;
use crate::{nothing_drawn, report};

impl Render {
    /// Settings with the shadows of the scene's lights, if they are requested. Every rank draws the same ones; if there are `parts`,
    /// the ranks that have the others, those of its own.
    pub(super) fn with_shadows(
        &self,
        settings: &Settings,
        scene: &Scene,
        camera: &Camera,
        display: &Display,
        parts: Option<&mut impl Communicator>,
    ) -> Result<Settings> {
        if self.drawing.casts_shadows() {
            display.stage("drawing shadows");
        }
        let name = || self.model.name();
        let shadows = match parts {
            None => self.drawing.shadows(scene, camera, settings).with_context(name)?,
            Some(comm) => self.drawing.shadows_of_parts(comm, scene, camera, settings).with_context(name)?,
        };
        Ok(Settings { shadows, ..settings.clone() })
    }

    /// Applies the effects that are requested; returns the milliseconds that they took.
    pub(super) fn add_effects(
        &self,
        frame: &mut Frame,
        (scene, background): (&Scene, &Background),
        camera: &Camera,
        settings: &Settings,
    ) -> Result<f64> {
        let begin = Instant::now();
        let added = self.effects.apply(frame, scene, camera, settings, background);
        added.with_context(|| self.model.name())?;
        Ok(begin.elapsed().as_secs_f64() * 1e3)
    }

    /// Why nothing was drawn, if that is the case.
    pub(super) fn reason(&self, report: &LoadReport, camera: &Camera, stats: &FrameStats) -> Option<String> {
        if let Some(reason) = report::all_clipped(report) {
            return Some(reason);
        }
        if stats.frontend.triangles_in == 0 && self.strokes_are_beside(report) {
            return Some(
                "nothing was drawn: lines, edges and points are outside the picture, or there are none"
                    .into(),
            );
        }
        let empty = nothing_drawn::reason(&report.mesh.bounds, camera, self.drawing.cull(), stats);
        empty.map(|reason| match report::only(&report::left(report)) {
            Some(only) if report.mesh.triangles == 0 => format!("{reason}, only {only}"),
            _ => reason,
        })
    }
}
