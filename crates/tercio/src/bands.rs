//! Pictures that are larger than memory: drawn in bands of rows, each of which is written before the next is drawn.

use std::io::Write;
use std::ops::Range;

use tercio_mesh::Progress;
use tercio_raster::context::FrameContext;
use tercio_raster::screen::TileGrid;
use tercio_raster::settings::MAX_SIZE;
use tercio_raster::stats::FrontEndCounts;
use tercio_raster::{Frame, FrameStats, Outputs, Renderer, Settings, TileSet};
use tercio_scene::{Background, Camera, Scene};

use crate::Result;
use crate::image::Picture;
use crate::image::png::write_parts;

/// Pixels of a band, approximately. Every band costs another pass over the clusters of the scene.
const BAND_PIXELS: u64 = 1 << 23;

/// Pictures of more pixels than this are better drawn in bands.
pub const MAX_PIXELS_IN_MEMORY: u64 = 1 << 26;

/// Draws a picture of any size in bands from top to bottom, with the pixels that [`Renderer::render`] gives, and writes it
/// as PNG. Memory is bounded whatever the height: a band of about 8 million pixels. The settings request 8-bit or
/// 16-bit colours.
///
/// Returns the statistics, summed over the bands; the front end is counted once. If nothing is visible in any band,
/// nothing is written, unless `allow_empty`.
///
/// # Errors
/// As [`Renderer::render`], and errors of `out`.
///
/// # Panics
/// If the settings request anything but either 8-bit or 16-bit colours.
pub fn write_png_in_bands(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    allow_empty: bool,
    progress: Option<&Progress>,
    out: &mut dyn Write,
) -> Result<FrameStats> {
    write_png_in_bands_with(scene, camera, settings, allow_empty, progress, |_, _| {}, out)
}

/// As [`write_png_in_bands`]; `finish` draws onto each band before it is written, and gets the rows of the picture that it has.
/// It leaves opaque what is opaque.
///
/// # Errors
/// As [`write_png_in_bands`].
///
/// # Panics
/// As [`write_png_in_bands`].
pub fn write_png_in_bands_with(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    allow_empty: bool,
    progress: Option<&Progress>,
    finish: impl Fn(&mut Frame, Range<u32>),
    out: &mut dyn Write,
) -> Result<FrameStats> {
    let Outputs { color, color16, .. } = settings.outputs;
    let only = Outputs { color, color16, ..Outputs::NONE };
    assert!(color != color16 && settings.outputs == only, "a picture of colours only, 8 or 16 bits");
    let bands = bands(settings);
    if let Some(progress) = progress {
        progress.begin("drawing and writing", bands.len() as u64);
    }
    let frontend = front_end_counts(scene, camera, settings)?;
    let (mut renderer, mut frame) = (Renderer::new(), Frame::default());
    let mut stats: Option<FrameStats> = None;
    let mut draw = |number: usize, frame: &mut Frame| -> Result<()> {
        renderer.render_into(scene, camera, &bands[number], frame)?;
        Ok(())
    };
    let mut count = |frame: &Frame| {
        stats = Some(match stats.take() {
            None => frame.stats.clone(),
            Some(before) => before.plus(&frame.stats),
        });
        if let Some(progress) = progress {
            progress.advance(1);
        }
    };
    // The file begins when something visible is drawn; the empty bands before it are then drawn again.
    let mut drawn = 0;
    while drawn < bands.len() && !allow_empty {
        draw(drawn, &mut frame)?;
        count(&frame);
        drawn += 1;
        if frame.stats.backend.pixels_visible > 0 {
            break;
        }
    }
    if allow_empty || frame.stats.backend.pixels_visible > 0 {
        let size = [settings.width, settings.height];
        write_parts(out, size, is_opaque(&scene.background), color16, |write| -> Result<()> {
            for number in 0..bands.len() {
                let is_in_frame = (drawn, number) == (1, 0);
                if !is_in_frame {
                    draw(number, &mut frame)?;
                }
                if number >= drawn {
                    count(&frame);
                }
                finish(&mut frame, bands[number].rows());
                write(&Picture::from_frame(&frame))?;
            }
            Ok(())
        })?;
    }
    let mut stats = stats.unwrap_or_default();
    stats.frontend = frontend;
    Ok(stats)
}

/// The counts of the front end of the picture as one tile. Those of the bands cannot be added up: each counts what is in
/// the others, too.
fn front_end_counts(scene: &Scene, camera: &Camera, settings: &Settings) -> Result<FrontEndCounts> {
    let mut context = FrameContext::new(scene, camera, settings, 1)?;
    context.grid = TileGrid::new(settings.width, settings.height, MAX_SIZE, TileSet::ALL);
    Ok(Renderer::count_front_end(&context))
}

/// The settings of each band.
fn bands(settings: &Settings) -> Vec<Settings> {
    let edge = settings.tile_edge();
    let rows =
        (BAND_PIXELS / u64::from(settings.width.max(1))).clamp(1, u64::from(settings.height.max(1))) as u32;
    let rows = rows.next_multiple_of(edge);
    let first = (0..settings.height).step_by(rows as usize);
    let band = |first: u32| first..first.saturating_add(rows).min(settings.height);
    first
        .map(|first| Settings { band: Some(band(first)), tile_size: Some(edge), ..settings.clone() })
        .collect()
}

/// Bytes of memory that drawing in bands takes: the pixels of the largest band, and their copy for the encoder.
pub fn band_bytes(settings: &Settings) -> u64 {
    let rows = bands(settings).iter().map(|band| band.rows().len() as u64).max().unwrap_or(0);
    2 * rows * u64::from(settings.width) * settings.outputs.pixel_bytes() as u64
}

fn is_opaque(background: &Background) -> bool {
    match *background {
        Background::Solid(color) => color[3] >= 1.0,
        Background::Gradient { top, bottom } => top[3].min(bottom[3]) >= 1.0,
    }
}

#[cfg(test)]
mod tests {
    use tercio_raster::{Filter, Sampling};

    use super::*;
    use crate::ImageError;

    /// A wide picture of 40 rows of tiles in bands equals the whole one.
    #[test]
    fn bands_are_the_picture() {
        let mesh = crate::load("builtin:teapot@2k").expect("a model").mesh;
        let mut scene = Scene::from_mesh(mesh);
        for (sampling, color16, alpha) in [
            (Sampling::NONE, false, 1.0),
            (Sampling::default(), true, 1.0),
            (Sampling { filter: Filter::Tent, ..Sampling::default() }, false, 0.5),
        ] {
            scene.background = Background::Solid([0.2, 0.4, 0.6, alpha]);
            let outputs = Outputs { color: !color16, color16, ..Outputs::NONE };
            let settings = Settings { sampling, outputs, ..Settings::new(6000, 3000) };
            assert!(bands(&settings).len() > 2);
            let camera = settings.framing().camera_for_scene(&scene);
            let mut file = Vec::new();
            let stats =
                write_png_in_bands(&scene, &camera, &settings, false, None, &mut file).expect("a picture");
            let frame = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
            assert_eq!(stats.backend.pixels_visible, frame.stats.backend.pixels_visible);
            assert!(
                Picture::from_bytes(&file).expect("a PNG") == Picture::from_frame(&frame),
                "{sampling:?}"
            );
        }
    }

    /// Empty bands before the model are drawn twice, but counted once.
    #[test]
    fn a_model_in_the_last_band_only() {
        let mesh = crate::load("builtin:sphere@1k").expect("a model").mesh;
        let mut scene = Scene::from_mesh(mesh);
        scene.background = Background::Solid([0.2, 0.4, 0.6, 1.0]);
        let settings = Settings::one_sample(6000, 4200);
        let mut camera = settings.framing().camera_for_scene(&scene);
        let first_row = |frame: &Frame| {
            let nothing = frame.planes.color[0];
            let first = frame.planes.color.iter().position(|c| *c != nothing);
            first.expect("a pixel") / frame.width as usize
        };
        // The camera moves up until the model is low enough in a small picture of the same shape.
        let up = camera.up * scene.bounds().radius() * 0.05;
        let small = Settings { width: 60, height: 42, ..settings.clone() };
        while first_row(&Renderer::new().render(&scene, &camera, &small).expect("a picture")) < 32 {
            (camera.eye, camera.target) = (camera.eye + up, camera.target + up);
        }
        let progress = Progress::default();
        let mut file = Vec::new();
        let stats = write_png_in_bands(&scene, &camera, &settings, false, Some(&progress), &mut file);
        let stats = stats.expect("a picture");
        let frame = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
        let bands = bands(&settings);
        assert!(bands.len() == 3 && first_row(&frame) >= bands[2].rows().start as usize);
        assert!(Picture::from_bytes(&file).expect("a PNG") == Picture::from_frame(&frame));
        assert_eq!(stats.frontend, frame.stats.frontend);
        assert_eq!(stats.backend.pixels_visible, frame.stats.backend.pixels_visible);
        let (_, done, total) = progress.state();
        assert_eq!((done, total), (3, 3));
    }

    /// The encoder of a stream would hide the error of the last chunk, and change the kind of the others.
    #[test]
    fn errors_of_the_file_are_reported() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
                if self.0 < bytes.len() {
                    return Err(std::io::ErrorKind::StorageFull.into());
                }
                self.0 -= bytes.len();
                Ok(bytes.len())
            }
            fn flush(&mut self) -> std::io::Result<()> {
                Ok(())
            }
        }
        let mesh = crate::load("builtin:sphere@1k").expect("a model").mesh;
        let scene = Scene::from_mesh(mesh);
        let settings = Settings::one_sample(900, 700);
        let camera = settings.framing().camera_for_scene(&scene);
        let write = |out: &mut dyn Write| write_png_in_bands(&scene, &camera, &settings, false, None, out);
        let mut file = Vec::new();
        write(&mut file).expect("a picture");
        for room in [0, 20, 100, file.len() / 2, file.len() - 20, file.len() - 1] {
            let error = write(&mut Full(room)).expect_err("no room");
            let is_full = |e: &std::io::Error| e.kind() == std::io::ErrorKind::StorageFull;
            assert!(
                matches!(&error, crate::Error::Image(ImageError::Io(e)) if is_full(e)),
                "{error}, {room}"
            );
        }
    }

    #[test]
    fn an_empty_picture_is_written_only_if_allowed() {
        let mesh = crate::load("builtin:teapot@1k").expect("a model").mesh;
        let scene = Scene::from_mesh(mesh);
        let settings = Settings::one_sample(5000, 4000);
        let mut camera = settings.framing().camera_for_scene(&scene);
        camera.target = camera.eye * 2.0 - camera.target;
        let mut file = Vec::new();
        write_png_in_bands(&scene, &camera, &settings, false, None, &mut file).expect("no error");
        assert!(file.is_empty());
        write_png_in_bands(&scene, &camera, &settings, true, None, &mut file).expect("no error");
        let picture = Picture::from_bytes(&file).expect("a PNG");
        assert_eq!((picture.width, picture.height), (5000, 4000));
        assert!(picture.is_opaque());
    }
}
