//! Pictures that are larger than memory: drawn in bands of rows, each of which is written before the next is drawn.

use std::io::Write;

use tercio_mesh::Progress;
use tercio_raster::{Frame, FrameStats, Outputs, Renderer, Settings};
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
/// Returns the statistics, summed over the bands; clusters are counted in each band that tests them. If nothing is
/// visible in any band, nothing is written, unless `allow_empty`.
///
/// # Errors
/// As [`Renderer::render`], and errors of `out`.
///
/// # Panics
/// If the settings request neither 8-bit nor 16-bit colours, or any other plane.
pub fn write_png_in_bands(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    allow_empty: bool,
    progress: Option<&Progress>,
    out: &mut dyn Write,
) -> Result<FrameStats> {
    let Outputs { color, color16, .. } = settings.outputs;
    let only = Outputs { color, color16, ..Outputs::NONE };
    assert!(color != color16 && settings.outputs == only, "a picture of colours only, 8 or 16 bits");
    let bands = bands(settings);
    if let Some(progress) = progress {
        progress.begin("drawing and writing", bands.len() as u64);
    }
    let (mut renderer, mut frame, mut stats) = (Renderer::new(), Frame::default(), None);
    let mut draw = |number: usize, is_first_time: bool, frame: &mut Frame| -> Result<()> {
        renderer.render_into(scene, camera, &bands[number], frame)?;
        if is_first_time {
            stats = Some(match stats.take() {
                None => frame.stats.clone(),
                Some(before) => FrameStats::plus(&before, &frame.stats),
            });
            if let Some(progress) = progress {
                progress.advance(1);
            }
        }
        Ok(())
    };
    // The file begins when the first band with something visible is drawn; the bands before it are then drawn again.
    let mut drawn = 0;
    while drawn < bands.len() {
        draw(drawn, true, &mut frame)?;
        drawn += 1;
        if frame.stats.backend.pixels_visible > 0 {
            break;
        }
    }
    if frame.stats.backend.pixels_visible > 0 || allow_empty {
        let size = [settings.width, settings.height];
        write_parts(out, size, is_opaque(&scene.background), color16, |write| -> Result<()> {
            let mut other = Frame::default();
            for number in 0..bands.len() {
                if number + 1 == drawn {
                    write(&Picture::from_frame(&frame))?;
                    continue;
                }
                draw(number, number >= drawn, &mut other)?;
                write(&Picture::from_frame(&other))?;
            }
            Ok(())
        })?;
    }
    Ok(stats.unwrap_or_default())
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

/// Bytes of the pixels of the largest band.
pub fn band_bytes(settings: &Settings) -> u64 {
    let rows = bands(settings).iter().map(|band| band.rows().len() as u64).max().unwrap_or(0);
    rows * u64::from(settings.width) * settings.outputs.pixel_bytes() as u64
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
