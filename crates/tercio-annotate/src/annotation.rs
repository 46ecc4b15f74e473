//! Everything that explains a picture, laid out together.

use glam::DVec3;
use tercio_scene::Camera;
use tercio_scene::camera::CameraError;

use crate::bar::ScalarBar;
use crate::caption::Caption;
use crate::layout::{Layout, Place, Placed, Rect};
use crate::number::NumberFormat;
use crate::overlay::Overlay;
use crate::project::{Projector, make_room};
use crate::scale_bar::ScaleLength;
use crate::{axes_box, floor, scale_bar, triad};

pub(crate) mod margins;

pub use margins::Shape;
pub(crate) use margins::sides_of;
use margins::{Claim, Framed, MOST_TAKEN, Margins, Room};

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

/// Something that is drawn onto a picture.
enum Item<'a> {
    Caption(&'a Caption),
    Bar(String, &'a ScalarBar),
    Axes(Place),
    ScaleBar(&'a str, Place),
}

/// What does not depend on the camera, and the boxes in which the rest is drawn.
struct Fixed {
    layout: Layout,
    axes: Option<Rect>,
    /// The largest box of the scale bar.
    scale_bar: Option<Rect>,
    claims: Vec<Claim>,
    room: Room,
}

impl Fixed {
    /// The box of something that has a place.
    fn box_of(&self, what: &str) -> Option<Rect> {
        self.layout.placed.iter().find(|placed| placed.what == what).map(|placed| placed.rect)
    }
}

/// What a scalar bar is called in [`Placed`]: `bar`, `bar 2` and so on.
fn bar_name(number: usize) -> String {
    if number == 0 { "bar".into() } else { format!("bar {}", number + 1) }
}

impl Item<'_> {
    /// What it is called in [`Placed`].
    fn what(&self) -> String {
        match self {
            Self::Caption(caption) => caption.what(),
            Self::Bar(name, _) => name.clone(),
            Self::Axes(_) => "axes".into(),
            Self::ScaleBar(..) => scale_bar::WHAT.into(),
        }
    }
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
        let Fixed { mut layout, axes, scale_bar, .. } = self.fixed(width, height);
        let projector = Projector::new(camera, layout.size)?;
        let mut laid_out = LaidOut::default();
        let has_box = bounds[0].cmple(bounds[1]).all() && bounds.iter().all(|corner| corner.is_finite());
        if let Some(rect) = axes {
            triad::draw(&mut layout, &projector, rect);
        }
        if let (Some((place, unit)), Some(slot)) = (&self.scale_bar, scale_bar) {
            laid_out.scale = scale_bar::draw(&mut layout, &projector, unit, *place, slot);
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

    /// Everything in the order in which it finds its room.
    fn items(&self) -> Vec<Item<'_>> {
        let captions = self.captions.iter().map(Item::Caption);
        let bars = self.bars.iter().enumerate().map(|(number, bar)| Item::Bar(bar_name(number), bar));
        let axes = self.axes.map(Item::Axes);
        let scale_bar = self.scale_bar.as_ref().map(|(place, unit)| Item::ScaleBar(unit, *place));
        captions.chain(bars).chain(axes).chain(scale_bar).collect()
    }

    /// What does not depend on the camera. What would leave the model too little room, beside what is before it, is left out.
    fn fixed(&self, width: u32, height: u32) -> Fixed {
        let items = self.items();
        let all: Vec<&Item> = items.iter().collect();
        let fixed = self.with(&all, width, height);
        let has_place = |fixed: &Fixed, item: &Item| match item {
            Item::Bar(name, _) => fixed.box_of(name).is_some(),
            _ => true,
        };
        if fixed.room.is_enough && items.iter().all(|item| has_place(&fixed, item)) {
            return self.in_order(&all, fixed, (width, height));
        }
        let (mut kept, mut left_out) = (Vec::new(), Vec::new());
        for item in &items {
            kept.push(item);
            // One thing is there even if it takes more.
            let with_it = self.with(&kept, width, height);
            if kept.len() > 1 && !(with_it.room.is_enough && has_place(&with_it, item)) {
                kept.pop();
                left_out.push(item.what());
            }
        }
        let fixed = self.with(&kept, width, height);
        let mut fixed = self.in_order(&kept, fixed, (width, height));
        left_out.iter().for_each(|what| fixed.layout.leave_out(what));
        fixed
    }

    /// A layout in which bars of one place, of which each next one is farther from the border, are read from left to right and from above
    /// to below like those of the models: they find their room in the opposite order, if that has room for all
    /// of these things, too.
    fn in_order(&self, items: &[&Item<'_>], fixed: Fixed, (width, height): (u32, u32)) -> Fixed {
        let boxes = |fixed: &Fixed| -> Option<Vec<Rect>> {
            let bars = items.iter().filter_map(|item| match item {
                Item::Bar(name, _) => Some(name),
                _ => None,
            });
            bars.map(|name| fixed.box_of(name)).collect()
        };
        let is_read = |boxes: &Vec<Rect>, is_in_order: bool| {
            boxes.windows(2).all(|pair| {
                let (first, second) = if is_in_order { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
                first[2] <= second[0] || first[3] <= second[1] && first[0] < second[2]
            })
        };
        let have_one_place = self.bars.windows(2).all(|pair| pair[0].place == pair[1].place);
        let is_reversed = boxes(&fixed).is_some_and(|boxes| !is_read(&boxes, true) && is_read(&boxes, false));
        if !(have_one_place && is_reversed) {
            return fixed;
        }
        // Bars follow each other in the list of items.
        let is_bar = |item: &Item| matches!(item, Item::Bar(..));
        let mut turned = items.to_vec();
        turned.chunk_by_mut(|a, b| is_bar(a) && is_bar(b)).for_each(<[_]>::reverse);
        let turned = self.with(&turned, width, height);
        let has_all = turned.room.is_enough == fixed.room.is_enough
            && turned.layout.left_out.len() <= fixed.layout.left_out.len();
        let is_better = has_all && boxes(&turned).is_some_and(|boxes| is_read(&boxes, true));
        if is_better { turned } else { fixed }
    }

    /// The layout of some things alone.
    fn with(&self, items: &[&Item<'_>], width: u32, height: u32) -> Fixed {
        let mut layout = Layout::new(width, height, self.text_scale, self.color);
        let (mut claims, mut axes, mut scale_bar) = (Vec::new(), None, None);
        for item in items {
            let (rect, sides) = match item {
                Item::Caption(caption) => (caption.add(&mut layout), sides_of(caption.place)),
                Item::Bar(name, bar) => (bar.add(&mut layout, name), bar.sides()),
                Item::Axes(place) => {
                    axes = margins::find(&layout, &claims, triad::size(&layout).as_slice(), *place);
                    axes.iter().for_each(|rect| layout.keep(&item.what(), *rect));
                    (axes, sides_of(*place))
                }
                Item::ScaleBar(unit, place) => {
                    scale_bar = margins::find(&layout, &claims, &scale_bar::sizes(&layout, unit), *place);
                    (scale_bar, sides_of(*place))
                }
            };
            match rect {
                Some(rect) => claims.push(Claim { rect, sides }),
                None => layout.leave_out(&item.what()),
            }
        }
        let room = margins::room(&claims, layout.size);
        Fixed { layout, axes, scale_bar, claims, room }
    }

    /// The room that is left for what is framed: something of this shape, or of these, each in a picture of its own.
    pub fn room(&self, (width, height): (u32, u32), shapes: &[Shape]) -> ModelRoom {
        let Fixed { layout, claims, .. } = self.fixed(width, height);
        let (size, em) = (layout.size, layout.em);
        let beside = if self.bounds { [4.5 * em, em, 2.0 * em, 2.8 * em] } else { [0.0; 4] };
        let mut margins = margins::room_for(&claims, size, &Framed { shapes, beside, gap: em * GAP }).margins;
        for (a, b, size) in [(0, 2, size[0]), (1, 3, size[1])] {
            let sum = beside[a] + beside[b];
            let left = (size * MOST_TAKEN - margins[a] - margins[b]).max(0.0);
            let factor = if sum > left { left / sum } else { 1.0 };
            margins[a] = (margins[a] + beside[a] * factor).round();
            margins[b] = (margins[b] + beside[b] * factor).round();
            // Of very large pictures, the middle cannot move: then the model has less room, instead.
            let most = (2.0 * FARTHEST - size).max(0.0);
            (margins[a], margins[b]) = (margins[a].max(margins[b] - most), margins[b].max(margins[a] - most));
        }
        ModelRoom { size: (width, height), margins }
    }
}

/// The farthest pixels from the line of sight that cameras can show.
const FARTHEST: f64 = 32768.0;

/// How far a model stays from what is in a corner of the picture, in text heights.
const GAP: f64 = 0.5;

/// The part of a picture in which a model is framed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelRoom {
    size: (u32, u32),
    margins: Margins,
}

impl ModelRoom {
    /// All of a picture.
    pub fn whole(size: (u32, u32)) -> Self {
        Self { size, margins: [0.0; 4] }
    }

    /// What annotation takes from the model at the left, above, at the right and below, in pixels.
    pub fn margins(&self) -> [f64; 4] {
        self.margins
    }

    /// Its width and height, for a camera that [`ModelRoom::place`] takes.
    pub fn size(&self) -> (u32, u32) {
        let [left, top, right, bottom] = self.margins;
        let inner = |size: u32, margins: f64| (f64::from(size) - margins).max(1.0) as u32;
        (inner(self.size.0, left + right), inner(self.size.1, top + bottom))
    }

    /// The camera of the whole picture that shows in this part what `camera` shows in a picture of this [size](Self::size).
    pub fn place(&self, camera: &Camera) -> Camera {
        match self.margins == [0.0; 4] {
            true => *camera,
            false => make_room(camera, f64::from(self.size.1), self.margins),
        }
    }
}

#[cfg(test)]
mod tests;
