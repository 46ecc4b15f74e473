//! Pictures that this process draws, by itself or with ranks that are its threads.

use anyhow::{Context, Result};
use tercio::parallel::trace::{Span, Step, Trace};
use tercio::parallel::{FrameReport, in_process};
use tercio::raster::{Frame, Renderer, Settings};
use tercio::scene::{Camera, Scene};
use tercio_lab::predict::choose::Choice;

use super::{Done, Drawn, Render, Writing};
use crate::args::ranks::{Drawers, How};
use crate::progress::Display;
use crate::{mpi, organisation};

impl Render {
    pub(super) fn draw(&self, writing: &Writing, settings: &Settings, drawers: Drawers) -> Result<Done> {
        let display = Display::new(self.running.progress_mode());
        let begin = self.ranks.now();
        let loaded = self.load(writing, &display, drawers, None::<&mut mpi::Comm>)?;
        let mut trace = begin.map(|begin| {
            let mut trace = Trace::default();
            trace.add(0, Step::Load, 0, Span::since(begin));
            trace
        });
        if self.is_in_bands(&writing.plan, drawers) {
            return self.draw_in_bands(writing, settings, loaded, &display, trace);
        }
        let (mut drawn, mut choice, mut drawers) = (Vec::new(), None, drawers);
        for camera in &loaded.cameras.views {
            let none = None::<&mut mpi::Comm>;
            let settings = &self.with_shadows(settings, &loaded.scene, camera, &display, none)?;
            display.stage("drawing");
            let scene = &*self.with_strokes(&loaded, camera)?;
            let (mut frame, parallel, chosen) = self
                .frame(scene, camera, settings, drawers, &mut trace)
                .with_context(|| self.model.name())?;
            if let (Some(chosen), Drawers::InProcess(count, _)) = (chosen, drawers) {
                // The second eye sees almost the same.
                drawers = Drawers::InProcess(count, How::As(chosen.sharing()));
                choice = Some(chosen);
            }
            let effect_milliseconds =
                self.add_effects(&mut frame, (scene, &loaded.background), camera, settings)?;
            drawn.push(Drawn { frame, parallel, effect_milliseconds });
        }
        display.stage("writing");
        self.write(writing, loaded, drawn, choice, trace)
    }

    pub(super) fn frame(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        drawers: Drawers,
        trace: &mut Option<Trace>,
    ) -> Result<(Frame, Option<FrameReport>, Option<Choice>)> {
        let threads = rayon::current_num_threads();
        let begin = self.ranks.now();
        let recorded;
        let drawn = match (organisation::in_process(drawers, threads, (scene, camera, settings))?, &trace) {
            (None, _) => {
                let frame = Renderer::new().render(scene, camera, settings)?;
                let Some(begin) = begin else { return Ok((frame, None, None)) };
                recorded = Trace::of_one(Step::Draw, Span::since(begin));
                (frame, None, None)
            }
            (Some((ranks, choice)), None) => {
                let (frame, report) = in_process::draw(ranks, scene, camera, settings)?;
                return Ok((frame, Some(report), choice));
            }
            (Some((ranks, choice)), Some(_)) => {
                let (frame, report, of_ranks) = in_process::record(ranks, scene, camera, settings)?;
                recorded = of_ranks;
                (frame, Some(report), choice)
            }
        };
        if let Some(trace) = trace {
            trace.append(recorded);
        }
        Ok(drawn)
    }
}
