//! Everything that explains a picture, laid out together.

use glam::DVec3;
use tercio_scene::Camera;
use tercio_scene::camera::CameraError;

use crate::bar::ScalarBar;
use crate::caption::Caption;
use crate::layout::{Layout, Place, Placed};
use crate::number::NumberFormat;
use crate::overlay::Overlay;
use crate::project::{Projector, make_room};
use crate::scale_bar::ScaleLength;
use crate::{axes_box, floor, scale_bar, triad};

/// What is drawn onto a picture, in the order in which it finds its room.
#[derive(Clone, Debug)]
pub struct Annotation {
    /// Titles and captions.
    pub captions: Vec<Caption>,
    /// The scalar bars: several of them side by side, where they have the same place.
    pub bars: Vec<ScalarBar>,
    /// Where the directions of the model's axes are shown.
    pub axes: Option<Place>,
    /// Where a line of a round length is shown, and the unit of lengths.
    pub scale_bar: Option<(Place, String)>,
    /// Whether the model's box is drawn, with numbers.
    pub bounds: bool,
    /// Whether there is a grid on the floor.
    pub grid: bool,
    /// Size of text, relative to the usual one.
    pub text_scale: f64,
    /// Colour of text and lines, linear light, not multiplied by its alpha.
    pub color: [f32; 4],
}

impl Default for Annotation {
    /// Nothing, in dark letters of the usual size.
    fn default() -> Self {
        Self {
            captions: Vec::new(),
            bars: Vec::new(),
            axes: None,
            scale_bar: None,
            bounds: false,
            grid: false,
            text_scale: 1.0,
            color: DARK,
        }
    }
}

/// Letters on a bright background, linear light.
pub const DARK: [f32; 4] = [0.009, 0.009, 0.011, 1.0];
/// Letters on a dark background.
pub const BRIGHT: [f32; 4] = [0.86, 0.86, 0.86, 1.0];

/// The colour of letters that can be read on a background of this linear light, which is not multiplied by its alpha.
pub fn readable_on([r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    if alpha < 0.5 || luminance > 0.18 { DARK } else { BRIGHT }
}

/// The shapes of an annotation, for one picture.
#[derive(Default)]
pub struct LaidOut {
    /// What is drawn onto the picture.
    pub onto: Overlay,
    /// What is drawn behind it.
    pub behind: Overlay,
    /// The boxes of what is drawn onto it; lines of the box and the grid have none.
    pub placed: Vec<Placed>,
    /// What there was no room for.
    pub left_out: Vec<String>,
    /// The length of the scale bar.
    pub scale: Option<ScaleLength>,
    /// The distance of the lines of the grid.
    pub grid_step: Option<f64>,
}

/// Margins take at most this share of the picture's width or height.
const MOST_TAKEN: f64 = 0.6;
/// Pictures with a shorter side of fewer pixels have no corners in which there is room beside the model.
const SMALL: f64 = 100.0;

/// What a scalar bar is called in [`Placed`]: `bar`, `bar 2` and so on.
fn bar_name(number: usize) -> String {
    if number == 0 { "bar".into() } else { format!("bar {}", number + 1) }
}

impl Annotation {
    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        let Self { captions, bars, axes, scale_bar, .. } = self;
        captions.is_empty() && bars.is_empty() && axes.is_none() && scale_bar.is_none() && !self.is_behind()
    }

    /// Whether something is drawn behind the model: the picture has to be drawn on a transparent background then.
    pub fn is_behind(&self) -> bool {
        self.bounds || self.grid
    }

    /// Lays everything out in a picture of this size. `bounds` is the box of the model in world coordinates, `up` the
    /// direction of the axis that points upwards.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn lay_out(
        &self,
        camera: &Camera,
        (width, height): (u32, u32),
        bounds: [DVec3; 2],
        up: DVec3,
    ) -> Result<LaidOut, CameraError> {
        let mut layout = self.fixed(width, height);
        let projector = Projector::new(camera, layout.size)?;
        let mut laid_out = LaidOut::default();
        let has_box = bounds[0].cmple(bounds[1]).all() && bounds.iter().all(|corner| corner.is_finite());
        if let Some(place) = self.axes {
            triad::add(&mut layout, &projector, place);
        }
        if let Some((place, unit)) = &self.scale_bar {
            laid_out.scale = scale_bar::add(&mut layout, &projector, unit, *place);
        }
        if self.grid && has_box {
            laid_out.grid_step =
                floor::add(&mut layout, &mut laid_out.behind, &projector, bounds, up, self.bounds);
        }
        if self.bounds && has_box {
            axes_box::add(&mut layout, &mut laid_out.behind, &projector, bounds, NumberFormat::Auto);
        }
        let Layout { overlay, placed, left_out, .. } = layout;
        Ok(LaidOut { onto: overlay, placed, left_out, ..laid_out })
    }

    /// What does not depend on the camera. Where the model would have too little room, the last of it is left out.
    fn fixed(&self, width: u32, height: u32) -> Layout {
        let count = self.captions.len() + self.bars.len();
        let mut left_out = vec![false; count];
        loop {
            let mut layout = Layout::new(width, height, self.text_scale, self.color);
            for (number, caption) in self.captions.iter().enumerate() {
                if left_out[number] { layout.leave_out(&caption.what()) } else { caption.add(&mut layout) }
            }
            for (number, bar) in self.bars.iter().enumerate() {
                let name = bar_name(number);
                if left_out[self.captions.len() + number] {
                    layout.leave_out(&name);
                } else {
                    bar.add(&mut layout, &name);
                }
            }
            let [left, top, right, bottom] = self.taken(&layout);
            let is_too_much =
                left + right > layout.size[0] * MOST_TAKEN || top + bottom > layout.size[1] * MOST_TAKEN;
            // One thing is there even if it takes more.
            let is_alone = left_out.iter().filter(|is_left_out| !*is_left_out).count() < 2;
            let last = left_out.iter().rposition(|is_left_out| !is_left_out);
            match last.filter(|_| is_too_much && !is_alone) {
                Some(last) => left_out[last] = true,
                None => return layout,
            }
        }
    }

    /// The margins that text at the upper and lower border and bars at any border take.
    fn taken(&self, layout: &Layout) -> [f64; 4] {
        let [w, h] = layout.size;
        // There is room in the corners of all but small pictures.
        let has_corners = w.min(h) >= SMALL;
        let mut margins = [0.0f64; 4];
        let bar_of = |what: &str| {
            let numbered = self.bars.iter().enumerate();
            numbered
                .map(|(number, bar)| (bar_name(number), bar))
                .find(|(name, _)| name == what)
                .map(|(_, bar)| bar)
        };
        for Placed { what, rect: [left, top, right, bottom] } in &layout.placed {
            let bar = bar_of(what);
            let place = match bar {
                Some(bar) => bar.place,
                None => {
                    let own = self.captions.iter().find(|caption| caption.what() == *what);
                    match own.map(|caption| caption.place) {
                        Some(place) if place.x == 0.5 || !has_corners => place,
                        _ => continue,
                    }
                }
            };
            // One that lies across its border takes its room there, too.
            let is_upright = bar.is_some_and(|bar| bar.is_upright != bar.is_across());
            if is_upright && place.x == 1.0 {
                margins[2] = margins[2].max(w - left);
            } else if is_upright && place.x == 0.0 {
                margins[0] = margins[0].max(*right);
            } else if !is_upright && place.y == 0.0 {
                margins[1] = margins[1].max(*bottom);
            } else if !is_upright && place.y == 1.0 {
                margins[3] = margins[3].max(h - top);
            }
        }
        margins
    }

    /// The margins, left, upper, right and lower, that text at the upper and lower border, a bar at any border and the numbers of
    /// the box take from the model, in pixels.
    pub fn margins(&self, width: u32, height: u32) -> [f64; 4] {
        let layout = self.fixed(width, height);
        let mut margins = self.taken(&layout);
        let em = layout.em;
        let of_box = if self.bounds { [4.5 * em, em, 2.0 * em, 2.8 * em] } else { [0.0; 4] };
        for (a, b, size) in [(0, 2, layout.size[0]), (1, 3, layout.size[1])] {
            let sum = of_box[a] + of_box[b];
            let left = (size * MOST_TAKEN - margins[a] - margins[b]).max(0.0);
            let factor = if sum > left { left / sum } else { 1.0 };
            margins[a] = (margins[a] + of_box[a] * factor).round();
            margins[b] = (margins[b] + of_box[b] * factor).round();
        }
        margins
    }

    /// The size of the picture that is left for the model, for a camera that [`Annotation::make_room`] takes.
    pub fn room(&self, (width, height): (u32, u32)) -> (u32, u32) {
        let [left, top, right, bottom] = self.margins(width, height);
        let inner = |size: u32, margins: f64| (f64::from(size) - margins).max(1.0) as u32;
        (inner(width, left + right), inner(height, top + bottom))
    }

    /// The camera of the whole picture that shows in its free part what `camera` shows in a picture of the size
    /// [`Annotation::room`].
    pub fn make_room(&self, camera: &Camera, (width, height): (u32, u32)) -> Camera {
        let margins = self.margins(width, height);
        if margins == [0.0; 4] { *camera } else { make_room(camera, f64::from(height), margins) }
    }
}

#[cfg(test)]
mod tests;
