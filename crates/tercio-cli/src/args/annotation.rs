//! Options of what explains a picture: scalar bar, text, axes, box, grid and scale bar.

use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::annotate::annotation::readable_on;
use tercio::annotate::{Annotation, Caption, LaidOut, Marks, NumberFormat, Place, ScalarBar, font};
use tercio::raster::Outputs;
use tercio::scene::color_map::DataColors;
use tercio::scene::{Background, Instance, SurfaceData, srgb_to_linear};

use super::values;
use crate::series::pattern::{self, Names};

/// The orientation of a scalar bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Orientation {
    /// With the largest number above.
    Vertical,
    /// With the largest number at the right.
    Horizontal,
}

/// Annotation of the finished picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Annotation")]
pub struct AnnotationArgs {
    /// Where the scalar bar is, which --color-by shows by default: right, left, top, bottom, top-left ... bottom-right, center, or
    /// X,Y, shares of 0 to 1 of the room beside it. At a border, the model is framed beside it [default: right].
    #[arg(long, value_name = "PLACE", value_parser = place, requires = "color_by", conflicts_with = "no_bar")]
    bar: Option<Place>,
    /// No scalar bar.
    #[arg(long)]
    no_bar: bool,
    /// What is written above or beside the scalar bar, with placeholders as in --title [default: the name of the data].
    #[arg(long, value_name = "TEXT", value_parser = text, requires = "color_by", conflicts_with = "no_bar")]
    #[arg(allow_hyphen_values = true)]
    bar_title: Option<String>,
    /// The unit of the data, which is added to the title in parentheses.
    #[arg(long, value_name = "UNIT", value_parser = text, requires = "color_by", conflicts_with = "no_bar")]
    bar_unit: Option<String>,
    /// How the scalar bar's numbers are printed: auto, or as in C: .3g, %.2f, .1e.
    #[arg(
        long,
        value_name = "FORMAT",
        default_value = "auto",
        requires = "color_by",
        conflicts_with = "no_bar"
    )]
    bar_format: NumberFormat,
    /// Numbers of the scalar bar: how many, 2 to 64, spread evenly from one end to the other, or their values with commas (a
    /// single one ends with a comma) [default: the borders of bands, or round numbers, and on a
    /// logarithmic scale the ends].
    #[arg(long, alias = "n-labels", value_name = "N|V1,V2", allow_hyphen_values = true, value_parser = marks)]
    #[arg(requires = "color_by", conflicts_with = "no_bar")]
    bar_ticks: Option<Marks>,
    /// Orientation of the scalar bar [default: horizontal at the top and at the bottom, else vertical]. A list of categories at the
    /// left or right is vertical.
    #[arg(long, value_name = "NAME", value_enum, requires = "color_by", conflicts_with = "no_bar")]
    bar_orientation: Option<Orientation>,
    /// A title above the picture's middle; \n begins a line, and {name}, {frame}, {view}, {step} and {time} (or {time:.2f}) stand for
    /// what they do in the names of outputs; {{ and }} are braces. It is the same in all texts: of --text, --bar-title, units.
    #[arg(long, value_name = "TEXT", value_parser = text, allow_hyphen_values = true)]
    title: Option<String>,
    /// A text in the picture, several times; PLACE as with --bar [default: top-left]; \n and placeholders as in --title.
    #[arg(long, value_name = "[PLACE:]TEXT", value_parser = caption, allow_hyphen_values = true)]
    text: Vec<Caption>,
    /// The directions of the model's axes, in a corner of the picture [default: bottom-left].
    #[arg(long, value_name = "PLACE", num_args = 0..=1, default_missing_value = "bottom-left", require_equals = true)]
    #[arg(value_parser = place, alias = "axis")]
    axes: Option<Place>,
    /// A line of a round length, with the unit of the model's coordinates; with perspective it is true at the distance of what the
    /// camera looks at (the middle of the model, or --target).
    #[arg(long, value_name = "UNIT", num_args = 0..=1, default_missing_value = "", require_equals = true)]
    #[arg(value_parser = text)]
    scale_bar: Option<String>,
    /// The model's box, with the coordinates of the file along its edges; those edges are drawn that are behind the model.
    #[arg(long)]
    bounds: bool,
    /// A grid on the floor below the model, which hides it.
    #[arg(long)]
    grid: bool,
    /// Makes all text and what belongs to it larger or smaller, 0.25 to 8.
    #[arg(long, value_name = "FACTOR", value_parser = text_scale, default_value = "1", hide_default_value = true)]
    text_scale: f64,
    /// Colour of text and lines [default: dark or bright, by the background].
    #[arg(long, value_name = "COLOR", value_parser = values::color)]
    text_color: Option<[u8; 4]>,
}

fn place(name: &str) -> Result<Place, String> {
    Place::named(name).ok_or_else(|| {
        let names: Vec<_> = Place::names().collect();
        format!("expected {}, or X,Y with shares of 0 to 1", names.join(", "))
    })
}

fn marks(text: &str) -> Result<Marks, String> {
    const EXPECTED: &str = "expected how many, 2 to 64, or at most 64 numbers with commas between";
    if let Ok(count) = text.trim().parse::<usize>() {
        return if (2..=64).contains(&count) { Ok(Marks::Count(count)) } else { Err(EXPECTED.into()) };
    }
    let words = text.split(',').map(str::trim).filter(|word| !word.is_empty());
    let values: Result<Vec<f64>, String> = words.map(values::number).collect();
    match values {
        Ok(values) if (1..=64).contains(&values.len()) => Ok(Marks::At(values)),
        _ => Err(EXPECTED.into()),
    }
}

/// Most characters of a text.
const MOST: usize = 4096;

/// A text that the font has.
///
/// # Errors
/// One sentence: the character that it does not have.
pub fn text(text: &str) -> Result<String, String> {
    if text.chars().count() > MOST {
        return Err(format!("expected at most {MOST} characters"));
    }
    let text = text.replace("\\n", "\n");
    let missing =
        |c| format!("the font has no \"{c}\" (Latin, Greek, punctuation, mathematics, arrows, superscripts)");
    font::covers(&text).map_err(missing)?;
    Ok(text)
}

fn caption(given: &str) -> Result<Caption, String> {
    let placed = given.split_once(':').and_then(|(name, text)| Some((Place::named(name)?, text)));
    let (place, content) = placed.unwrap_or((Place { x: 0.0, y: 0.0 }, given));
    Ok(Caption { text: text(content)?, place, size: 1.0 })
}

fn text_scale(text: &str) -> Result<f64, String> {
    let scale = values::number(text).ok().filter(|v| (0.25..=8.0).contains(v));
    scale.ok_or_else(|| "expected a factor of 0.25 to 8".into())
}

/// Linear light of a colour in sRGB with straight alpha.
fn linear([r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|v| srgb_to_linear(f64::from(v)) as f32);
    [r, g, b, alpha]
}

/// The mean light of a background.
fn mean_of(background: &Background) -> [f32; 4] {
    match *background {
        Background::Solid(color) => linear(color),
        Background::Gradient { top, bottom } => {
            let (top, bottom) = (linear(top), linear(bottom));
            std::array::from_fn(|k| (top[k] + bottom[k]) * 0.5)
        }
    }
}

impl AnnotationArgs {
    /// Whether anything is asked for, besides the scalar bar that data have by default.
    pub fn is_given(&self) -> bool {
        self.is_behind()
            || self.title.is_some()
            || !self.text.is_empty()
            || self.axes.is_some()
            || self.scale_bar.is_some()
    }

    /// Whether something is drawn behind the model: its picture is drawn on a transparent background then.
    pub fn is_behind(&self) -> bool {
        self.bounds || self.grid
    }

    /// The title, which is that of a whole sheet, and not of its parts.
    pub fn take_title(&mut self) -> Option<String> {
        self.title.take()
    }

    /// The factor of all text.
    pub fn text_scale(&self) -> f64 {
        self.text_scale
    }

    /// Linear light of text on a background, and of that.
    pub fn text_and_ground(&self, background: &Background) -> [[f32; 4]; 2] {
        let ground = mean_of(background);
        let color = self.text_color.map(|color| linear(color.map(|v| f32::from(v) / 255.0)));
        [color.unwrap_or_else(|| readable_on(ground)), ground]
    }

    fn texts(&self) -> impl Iterator<Item = &String> {
        let texts = self.title.iter().chain(self.text.iter().map(|caption| &caption.text));
        texts.chain(&self.bar_title).chain(&self.bar_unit).chain(&self.scale_bar)
    }

    /// Whether a text has a placeholder of this name.
    pub fn has_placeholder(&self, name: &str) -> bool {
        self.texts().any(|text| pattern::has(Path::new(text), name))
    }

    /// Checks that what placeholders of the texts stand for is known.
    ///
    /// # Errors
    /// One sentence.
    pub fn check_texts(&self, names: &Names) -> Result<(), String> {
        self.texts().map(|text| pattern::expand_text(text, names, true)).try_for_each(|text| text.map(drop))
    }

    /// The planes that are needed.
    pub fn needed(&self) -> Outputs {
        Outputs { linear: self.is_behind(), ..Outputs::NONE }
    }

    /// The scalar bar of a model, if it has one; it explains the colour of what is no number if it `shows_nan`.
    pub fn bar(&self, model: &Instance, shows_nan: impl FnOnce() -> bool) -> Option<ScalarBar> {
        match model.data.as_deref() {
            Some(SurfaceData::Mapped { colors, .. }) if !self.no_bar => {
                Some(self.scalar_bar(colors, shows_nan()))
            }
            _ => None,
        }
    }

    /// What is drawn onto the picture of models with these scalar bars, on this background.
    pub fn annotation(&self, bars: Vec<ScalarBar>, background: &Background) -> Annotation {
        let [color, _] = self.text_and_ground(background);
        let title = self.title.as_deref().map(Caption::title);
        Annotation {
            captions: title.into_iter().chain(self.text.iter().cloned()).collect(),
            bars,
            axes: self.axes,
            scale_bar: self.scale_bar.as_ref().map(|unit| (Place { x: 1.0, y: 1.0 }, unit.clone())),
            bounds: self.bounds,
            grid: self.grid,
            text_scale: self.text_scale,
            color,
        }
    }

    fn scalar_bar(&self, colors: &DataColors, shows_nan: bool) -> ScalarBar {
        let place = self.bar.unwrap_or(Place { x: 1.0, y: 0.5 });
        let is_level = place.x == 0.5 && (place.y == 0.0 || place.y == 1.0);
        let is_upright = self.bar_orientation.map_or(!is_level, |given| given == Orientation::Vertical);
        // The name of an attribute has no placeholders.
        let name = || pattern::literal(&colors.title);
        let title = self.bar_title.clone().unwrap_or_else(name);
        let title = match &self.bar_unit {
            Some(unit) => format!("{title} ({unit})"),
            None => title,
        };
        ScalarBar {
            colors: colors.clone(),
            title: title.trim().to_owned(),
            format: self.bar_format,
            marks: self.bar_ticks.clone().unwrap_or_default(),
            place,
            is_upright,
            shows_nan,
        }
    }
}

/// Whether texts have placeholders to be filled in, or doubled braces that stand for braces.
pub fn has_braces(annotation: &Annotation) -> bool {
    let captions = annotation.captions.iter().map(|caption| &caption.text);
    let titles = annotation.bars.iter().map(|bar| &bar.title);
    let units = annotation.scale_bar.iter().map(|(_, unit)| unit);
    captions.chain(titles).chain(units).any(|text| text.contains(['{', '}']))
}

/// The annotation of one picture: with what the placeholders of its texts stand for there.
pub fn of_picture(annotation: &Annotation, names: &Names) -> Annotation {
    let mut annotation = annotation.clone();
    let captions = annotation.captions.iter_mut().map(|caption| &mut caption.text);
    let titles = annotation.bars.iter_mut().map(|bar| &mut bar.title);
    let units = annotation.scale_bar.iter_mut().map(|(_, unit)| unit);
    for text in captions.chain(titles).chain(units).filter(|text| text.contains(['{', '}'])) {
        // Checked before.
        if let Ok(filled) = pattern::expand_text(text, names, true) {
            *text = shown(&filled);
        }
    }
    annotation
}

/// A text with what the font has of it: names of files may have any characters.
pub fn shown(text: &str) -> String {
    text.chars().map(|c| if font::covers(c.encode_utf8(&mut [0; 4])).is_ok() { c } else { '?' }).collect()
}

/// What was drawn, for reports.
pub fn json(laid_out: &LaidOut) -> Value {
    if laid_out.placed.is_empty() && laid_out.left_out.is_empty() && laid_out.grid_step.is_none() {
        return Value::Null;
    }
    let placed: Vec<Value> =
        laid_out.placed.iter().map(|placed| json!({ "what": placed.what, "box": placed.rect })).collect();
    json!({
        "drawn": placed,
        "left_out": laid_out.left_out,
        "scale_bar": laid_out.scale.map(|scale| json!({ "length": scale.units, "pixels": scale.pixels })),
        "grid_step": laid_out.grid_step,
    })
}
