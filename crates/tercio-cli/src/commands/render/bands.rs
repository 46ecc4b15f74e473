//! Pictures that are too large to be kept in memory.

use std::time::Instant;

use anyhow::Result;
use tercio::parallel::trace::{Span, Step};
use tercio::raster::Frame;
use tercio::write_png_in_bands_with;

use super::alone::Artist;
use super::series::Series;
use super::{Job, Loaded, Render, Shot};
use crate::args::ranks::Drawers;
use crate::args::stereo::Cameras;
use crate::mpi;
use crate::output::Plan;
use crate::progress::Display;
use crate::series::whole;
use crate::stereo::ViewReport;

impl Render {
    /// Whether the picture is drawn in bands, because it is too large to be kept in memory.
    pub(super) fn is_in_bands(&self, plan: &Plan, drawers: Drawers) -> bool {
        drawers == Drawers::Alone && self.stereo.layout().is_none() && plan.is_in_bands(self.drawing.size)
    }

    pub(super) fn draw_in_bands(
        &self,
        job: &Job,
        loaded: &mut Loaded,
        display: &Display,
        artist: &mut Artist,
    ) -> Result<Series> {
        let writing = &job.writing;
        let mut series = Series { shots: Vec::new(), found: 0, output_milliseconds: 0.0, empty: None };
        let all: Vec<Cameras> = loaded.cameras.clone();
        let resumes = self.series.resume;
        let newest = if resumes { self.newest_input(&[]).max(loaded.newest_companion()) } else { None };
        for (number, (cameras, plan)) in all.iter().zip(&writing.pictures).enumerate() {
            loaded.annotated.shot = number;
            let loaded = &*loaded;
            if resumes && whole::is_there(plan, self.written_size(), newest) {
                series.found += 1;
                continue;
            }
            let camera = &cameras.middle;
            let none = None::<&mut mpi::Comm>;
            let settings = &self.with_shadows(&job.settings, loaded, camera, display, none)?;
            let scene = self.with_strokes(loaded, camera)?;
            let (width, onto) = (self.drawing.size.0, self.lay_out(&loaded.annotated, camera)?.onto);
            let (begin, began) = (Instant::now(), self.ranks.now());
            // One that shows nothing is left out at the beginning of a series only.
            let may_be_empty = writing.allow_empty || number > 0;
            let progress = Some(&*display.progress);
            let stats = plan.write_drawn(&self.model.name(), may_be_empty, |out| {
                let finish = |frame: &mut Frame, rows| onto.draw(&mut frame.planes, width, rows);
                write_png_in_bands_with(&scene, camera, settings, may_be_empty, progress, finish, out)
            })?;
            let all = begin.elapsed().as_secs_f64() * 1e3;
            if let (Some(trace), Some(began)) = (&mut artist.trace, began) {
                trace.add(0, Step::Draw, number as u32 + 1, Span::since(began));
            }
            series.output_milliseconds += (all - stats.milliseconds.total).max(0.0);
            let empty = self.reason(&loaded.together, camera, &stats);
            if number == 0 {
                series.empty.clone_from(&empty);
            }
            let is_nothing = empty.is_some() && !may_be_empty;
            let views = vec![ViewReport { stats, parallel: None }];
            let cameras = cameras.clone();
            series.shots.push(Shot { number, cameras, views, effect_milliseconds: 0.0, empty });
            if is_nothing {
                break;
            }
        }
        Ok(series)
    }
}
