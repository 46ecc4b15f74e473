//! What belongs to one picture besides drawing it: shadows before it, effects after it.

use std::time::Instant;

use anyhow::{Context, Result};
use tercio::LoadReport;
use tercio::annotate::LaidOut;
use tercio::effects::add_background;
use tercio::parallel::Communicator;
use tercio::raster::{Frame, FrameStats, Settings, ShadowArea};
use tercio::scene::{Camera, Scene};

use super::{Loaded, Render};
use crate::progress::Display;
use crate::{nothing_drawn, report};

impl Render {
    /// Settings with the shadows of the scene's lights, if they are requested. Every rank draws the same ones; if there are `parts`,
    /// the ranks that have the others, those of its own.
    pub(super) fn with_shadows(
        &self,
        settings: &Settings,
        loaded: &Loaded,
        camera: &Camera,
        display: &Display,
        parts: Option<&mut impl Communicator>,
    ) -> Result<Settings> {
        let scene = &loaded.scene;
        // Lines, points and glyphs may be beside the bounds of the surfaces.
        let area = if self.is_plain(loaded) { ShadowArea::Picture } else { ShadowArea::Scene };
        if self.drawing.casts_shadows() {
            display.stage("drawing shadows");
        }
        let name = || self.model.name();
        let shadows = match parts {
            None => self.drawing.shadows(scene, camera, settings, area).with_context(name)?,
            Some(comm) => {
                self.drawing.shadows_of_parts(comm, scene, camera, settings, area).with_context(name)?
            }
        };
        Ok(Settings { shadows, ..settings.clone() })
    }

    /// Applies the effects that are requested, and the annotation; returns the milliseconds that they took.
    pub(super) fn add_effects(
        &self,
        frame: &mut Frame,
        (scene, loaded): (&Scene, &Loaded),
        camera: &Camera,
        settings: &Settings,
    ) -> Result<f64> {
        let begin = Instant::now();
        let added = self.effects.apply(frame, scene, camera, settings);
        added.with_context(|| self.model.name())?;
        let (width, height) = self.drawing.size;
        // Without a picture there are only arrays.
        let has_picture = settings.outputs.color || settings.outputs.color16;
        let annotation =
            if has_picture { self.lay_out(&loaded.annotated, camera)? } else { LaidOut::default() };
        if !annotation.behind.is_empty() {
            annotation.behind.draw_behind(&mut frame.planes, width, height);
        }
        if self.needs_transparency() {
            add_background(&mut frame.planes, width as usize, &loaded.background);
        }
        annotation.onto.draw(&mut frame.planes, width, 0..height);
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
