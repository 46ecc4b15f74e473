//! `tercio sheet`: many small pictures in one, with their names below them.

mod cells;

use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use tercio::image::{Destination, JPEG_MAX_SIZE, Picture, PictureFormat, Pixels, WEBP_MAX_SIZE};
use tercio::raster::Frame;
use tercio::scene::Scene;

use self::cells::{Cells, Group, named};
use super::Render;
use super::alone::Artist;
use super::batch::{Item, Unread, side_by_side};
use super::steps::OfSeries;
use crate::args::annotation::text;
use crate::args::data::{RangeOver, Survey};
use crate::args::{ModelArgs, ProgressMode};
use crate::named_files::NamedFiles;
use crate::output::{UsageError, name, write_picture};
use crate::progress::Display;
use crate::report::counted;
use crate::series::pattern::{self, Names};
use crate::series::sheet::{Look, Paper};
use crate::{ending, messages, mpi};

/// The examples of the help.
pub const EXAMPLES: &str = "\
Examples:
  tercio sheet *.stl -o parts.png
  tercio sheet scan.ply -o views.png --view front,left,top,iso --size 400x300 --columns 2
  tercio sheet scan.ply -o turn.jpg --turntable 12
  tercio sheet run.pvd -o steps.png --color-by pressure --title 'Pressure'

The options of render for single pictures are understood: --size is that of one picture, and --title is that of the sheet, in whose
name {name}, {view}, {time} and {step} stand for what all pictures have in common. A model that cannot be drawn gets a place that
says so. Exit code: 0 success, 1 error or a model that could not be drawn, 2 wrong usage.";

/// Draws many models, or many views of one, into one picture: a contact sheet.
#[derive(Clone, Debug, Args)]
pub struct Sheet {
    #[command(flatten)]
    render: Render,
    /// Number of columns [default: so that the sheet is about as wide as a screen].
    #[arg(long, value_name = "N", help_heading = "Sheet", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    columns: Option<u32>,
    /// What is written below each picture, with {name}, {view}, {frame}, {step} and {time}; nothing for an empty one. A model
    /// without the time or the step that it says gets a place that tells that [default: what the pictures differ in].
    #[arg(long, value_name = "TEXT", help_heading = "Sheet", value_parser = text)]
    caption: Option<String>,
}

impl Sheet {
    /// Runs the command.
    ///
    /// # Errors
    /// Usage errors for options that make no sheet, else what went wrong; nothing could be drawn.
    pub fn run(&self) -> Result<ExitCode> {
        let start = Instant::now();
        if let Some(option) = self.render.scene.given() {
            let text = format!("{option} is for tercio render: a sheet has a picture of each model");
            return Err(UsageError(text).into());
        }
        let mut render = self.render.clone();
        let title = render.annotation.take_title().map(|text| title_of_sheet(&text)).transpose();
        let title = title.map_err(UsageError)?;
        render.writing.check_names().map_err(UsageError)?;
        self.output(&render).map_err(UsageError)?;
        let models = render.listed()?;
        models.iter().try_for_each(|model| ModelArgs::of(model).check_is_no_scene())?;
        let cells = self.cells(&render, &models)?;
        render.writing = named(&render.writing, &cells).map_err(UsageError)?;
        let Cells { groups, lacking, count } = cells;
        let (destination, format) = self.output(&render).map_err(UsageError)?;
        let paper = self.paper(&render, title.as_deref(), count, format).map_err(UsageError)?;
        let files = NamedFiles::default().writes("--output", &destination);
        let files = models.iter().fold(files, |files, model| files.reads_model(model));
        let files = render.data.named_files(render.environment.named_files(files));
        let files = Arc::new(render.series.named_files(files));
        files.check()?;
        files.check_places()?;
        ending::name_model(format!("one of {} models", models.len()));
        let pool = render.running.pool()?;
        paper.check_memory(render.running.memory_limit())?;
        pool.install(|| render.check_companions(&files, &models))?;
        let display = Display::new(render.running.progress_mode());
        let groups = pool.install(|| prepared(groups, &files, &display))?;
        let without = lacking.iter().map(|lacking| lacking.cells.len()).sum::<usize>();
        display.pictures((count - without) as u64);
        lacking.iter().for_each(|lacking| messages::error(&anyhow::anyhow!("{lacking}")));
        let (paper, failed) = (Mutex::new(paper), AtomicUsize::new(lacking.len()));
        let draw = |group: &Group| {
            let cells = group.first..group.first + group.captions.len();
            if let Err(error) = group.draw(&paper, &display) {
                failed.fetch_add(1, Relaxed);
                let mut paper = paper.lock().unwrap_or_else(PoisonError::into_inner);
                let words = reason(&group.steps[0].render, &error);
                cells.for_each(|cell| paper.tell(cell, &words));
                messages::error(&error);
            }
        };
        // As in a batch: the large ones first, with all threads.
        pool.install(|| groups.iter().filter(|group| group.steps[0].small.is_none()).for_each(draw));
        let small: Vec<&Group> = groups.iter().filter(|group| group.steps[0].small.is_some()).collect();
        let items: Vec<&Item> = small.iter().map(|group| &group.steps[0]).collect();
        let workers = render.workers(&items, pool.current_num_threads());
        side_by_side(&small, workers, |group| draw(group))?;
        drop(display);
        let (failed, all) = (failed.into_inner(), models.len());
        if failed == all {
            bail!("nothing was drawn, and {} was not written", name(&destination));
        }
        let mut paper = paper.into_inner().unwrap_or_else(PoisonError::into_inner);
        for lacking in &lacking {
            for cell in lacking.cells.clone() {
                paper.tell(cell, lacking.reason);
                paper.caption(cell, &lacking.caption);
            }
        }
        for group in &groups {
            group.captions.iter().enumerate().for_each(|(n, text)| paper.caption(group.first + n, text));
        }
        let picture = pool.install(|| paper.finish());
        pool.install(|| write_picture(&destination, &picture, format))?;
        if !render.running.quiet {
            let of_failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
            let (drawn, seconds) = (counted((all - failed) as u64, "model"), start.elapsed().as_secs_f64());
            let pictures = counted(count as u64, "picture");
            messages::note(&format!(
                "{drawn} of {all} drawn{of_failed}, {pictures} on a sheet of {}x{}, in {seconds:.1} s",
                picture.width, picture.height
            ));
        }
        Ok(if failed > 0 { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }

    /// Where the sheet is written.
    fn output(&self, render: &Render) -> Result<(Destination, PictureFormat), String> {
        let plan = render.writing.plan(&render.drawing, &render.stereo, false)?;
        if plan.film.is_some() || plan.drawing.is_some() {
            return Err("a sheet is a picture: choose .png, .jpg, .webp or .ppm".into());
        }
        if !plan.arrays.is_empty() || plan.stats.is_some() || plan.outputs.color16 {
            return Err("a sheet is a picture of 8 bits a component: leave out --output-depth, --output-ids, --output-normals, --stats and --depth 16".into());
        }
        if render.series.resume || render.series.watch || render.ranks.trace().is_some() {
            return Err("--resume, --watch and --trace make no sheet".into());
        }
        match plan.picture {
            Some((files, format)) if files.len() == 1 => Ok((files[0].clone(), format)),
            _ => Err("a sheet is one picture: --stereo pair makes two".into()),
        }
    }

    fn paper(
        &self,
        render: &Render,
        title: Option<&str>,
        count: usize,
        format: PictureFormat,
    ) -> Result<Paper, String> {
        let mut scene = Scene::default();
        render.drawing.dress(&mut scene);
        let [text, ground] = render.annotation.text_and_ground(&scene.background);
        let look = Look {
            cell: render.written_size(),
            columns: self.columns,
            has_captions: self.caption.as_deref() != Some(""),
            title: title.map(str::to_owned),
            text_scale: render.annotation.text_scale(),
            text,
            ground,
        };
        let paper = Paper::new(&look, count);
        let (width, height) = paper.size();
        let most = match format {
            PictureFormat::WebP => WEBP_MAX_SIZE,
            PictureFormat::Jpeg { .. } => JPEG_MAX_SIZE,
            _ => 1 << 20,
        };
        if width.max(height) > most {
            return Err(format!(
                "a sheet of {count} pictures would have {width}x{height} pixels, the most in {format} are {most} a side: choose a smaller --size"
            ));
        }
        Ok(paper)
    }
}

/// The title of a sheet, which is that of all pictures together.
fn title_of_sheet(text: &str) -> Result<String, String> {
    let title = pattern::expand_text(text, &Names::default(), true);
    title.map_err(|reason| match pattern::has_placeholders(text) {
        true => format!("--title \"{text}\" is that of all pictures of the sheet together: what differs is said by --caption"),
        false => reason,
    })
}

/// Why a model could not be drawn, without its name, which is below the picture.
fn reason(render: &Render, error: &anyhow::Error) -> String {
    let words = messages::text(error);
    let model = format!("{}: ", render.model.name());
    words.strip_prefix(&model).map_or_else(|| words.clone(), str::to_owned)
}

/// The models with all files of the run, and with what the colours of all pictures, and the cameras of all times of a model, have in
/// common.
///
/// # Errors
/// [`UsageError`]: that depends on models that can be read only once. What else is wrong with a model is reported when it is drawn.
fn prepared(mut groups: Vec<Group>, files: &Arc<NamedFiles>, display: &Display) -> Result<Vec<Group>> {
    let count: usize = groups.iter().map(|group| group.steps.len()).sum();
    let over = groups.first().and_then(|group| group.steps[0].render.data.range_over());
    // A single one has its own range.
    let over = over.filter(|over| *over != RangeOver::Each && count > 1);
    let (mut colors, mut all, mut unread) = (None::<Survey>, Vec::new(), Unread::default());
    for Group { steps, .. } in &groups {
        let models: Vec<ModelArgs> = steps.iter().map(|step| step.render.model.clone()).collect();
        let with_data = match over {
            Some(RangeOver::All) => models.len(),
            Some(RangeOver::First) if colors.is_none() => 1,
            _ => 0,
        };
        let of_series = steps[0].render.survey_data_of(with_data, &steps[0].job, &models, display);
        let mut of_series = match of_series {
            Err(error) if error.is::<UsageError>() => return Err(error),
            Err(_) => {
                unread.add(&steps[0].render);
                OfSeries::default()
            }
            Ok(of_series) => of_series,
        };
        if let Some(own) = of_series.colors.take() {
            over.into_iter().for_each(|over| unread.warn(over, &steps[0].render));
            colors = Some(colors.unwrap_or_default().and(own));
        }
        all.push(of_series);
    }
    for (group, mut of_series) in groups.iter_mut().zip(all) {
        of_series.colors.clone_from(&colors);
        for Item { render, job, .. } in &mut group.steps {
            *render = render.clone().of_series(&of_series);
            job.writing.files = Arc::clone(files);
        }
    }
    Ok(groups)
}

impl Group {
    /// Draws all pictures onto the paper.
    fn draw(&self, paper: &Mutex<Paper>, display: &Display) -> Result<()> {
        let silent = Display::new(ProgressMode::Never);
        let mut cameras = None;
        let mut cell = self.first;
        for Item { render, job, .. } in &self.steps {
            let mut loaded = render.load(job, &silent, None::<&mut mpi::Comm>)?;
            render.print_warnings(&loaded.reports);
            // All times have one camera.
            loaded.cameras.clone_from(cameras.get_or_insert_with(|| loaded.cameras.clone()));
            let mut artist = Artist::new(job.drawers, None);
            let mut spare = Frame::default();
            for (shot, cameras) in loaded.cameras.clone().iter().enumerate() {
                loaded.annotated.shot = shot;
                let (mut frames, mut reasons) = (Vec::new(), Vec::new());
                for camera in &cameras.views {
                    let frame = std::mem::take(&mut spare);
                    let drawn = render.draw_one(job, &loaded, camera, &silent, &mut artist, frame)?;
                    reasons.push(render.reason(&loaded.together, camera, &drawn.frame.stats));
                    frames.push(drawn.frame);
                }
                let mut reasons = reasons.into_iter().flatten();
                if let Some(reason) = reasons.next().filter(|_| shot == 0 && !job.writing.allow_empty) {
                    bail!("{}: {reason}", render.model.name());
                }
                drop(reasons);
                let mut frames = render.stereo.written(frames).with_context(|| render.model.name())?;
                let Some(frame) = frames.pop() else { continue };
                let picture = Picture::from_frame(&frame);
                let Pixels::Eight(pixels) = &picture.pixels else { continue };
                paper.lock().unwrap_or_else(PoisonError::into_inner).put(cell, pixels);
                spare = frame;
                cell += 1;
                display.progress.advance(1);
            }
        }
        Ok(())
    }
}
