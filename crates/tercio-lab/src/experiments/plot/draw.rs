//! Drawing a plot as SVG.

use plotters::prelude::*;

use super::scale::Division;
use super::{Mark, Plot, Role, Series};

/// Width and height of a plot in SVG units. Coordinates are rounded to whole units, so a plot is drawn large and
/// displayed smaller.
const SIZE: (u32, u32) = (1280, 880);
const TITLE_SIZE: u32 = 30;
const LABEL_SIZE: u32 = 26;
/// The palette of Okabe and Ito, which colour-blind readers can distinguish, too.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

impl Plot {
    /// The points of a series in axis coordinates, without those that cannot be drawn.
    fn placed(&self, series: &Series) -> Vec<(f64, f64)> {
        let place = |&(x, y): &(f64, f64)| (self.x.scale.place(x), self.y.scale.place(y));
        series.points.iter().map(place).filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
    }

    /// The plot as SVG.
    ///
    /// # Errors
    /// What the plotting library cannot draw.
    pub fn to_svg(&self) -> Result<String, String> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|e| format!("plot {}: {e}", self.name))?;
        // The displayed size follows the page, not the units in which it is drawn.
        let fixed = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        Ok(svg.replacen(&fixed, "", 1))
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let placed: Vec<_> = self.series.iter().map(|s| self.placed(s)).collect();
        let x = Division::new(self.x.scale, false, placed.iter().flatten().map(|p| p.0));
        // The vertical axis starts at zero, so that heights can be compared.
        let y = Division::new(self.y.scale, true, placed.iter().flatten().map(|p| p.1));
        let (x_ends, y_ends) = ((x.low, x.high), (y.low, y.high));
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(&self.title, ("sans-serif", TITLE_SIZE))
            .margin(24)
            .margin_right(72)
            .x_label_area_size(80)
            .y_label_area_size(150)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .axis_desc_style(("sans-serif", LABEL_SIZE))
            .label_style(("sans-serif", LABEL_SIZE - 4))
            .draw()?;
        for (i, (series, points)) in self.series.iter().zip(placed).enumerate() {
            let color = COLORS[i % COLORS.len()];
            let published = series.role == Role::Published;
            let mut labelled = false;
            if series.mark != Mark::Points {
                let style = color.stroke_width(3);
                let drawn = if published {
                    chart.draw_series(DashedLineSeries::new(points.iter().copied(), 10, 8, style))?
                } else {
                    chart.draw_series(LineSeries::new(points.iter().copied(), style))?
                };
                drawn.label(&series.label).legend(move |(x, y)| {
                    let end = if published { x + 14 } else { x + 30 };
                    PathElement::new(vec![(x, y), (end, y)], color.stroke_width(3))
                });
                labelled = true;
            }
            if series.mark != Mark::Line {
                let style = if published { color.stroke_width(3) } else { color.filled() };
                let drawn = chart.draw_series(points.iter().map(|&p| Circle::new(p, 7, style)))?;
                if !labelled {
                    drawn.label(&series.label).legend(move |(x, y)| Circle::new((x + 15, y), 7, style));
                }
            }
        }
        if self.series.len() > 1 {
            chart
                .configure_series_labels()
                .position(self.empty_corner(x_ends, y_ends))
                .legend_area_size(44)
                .label_font(("sans-serif", LABEL_SIZE - 4))
                .background_style(WHITE.mix(0.7))
                .border_style(BLACK.mix(0.3))
                .draw()?;
        }
        root.present()?;
        Ok(())
    }

    /// The corner in which the legend covers fewest points.
    fn empty_corner(&self, x: (f64, f64), y: (f64, f64)) -> SeriesLabelPosition {
        /// Width of the legend as a share of the plot, and its height per series.
        const WIDTH: f64 = 0.4;
        const HEIGHT: f64 = 0.05;
        let height = HEIGHT * (self.series.len() + 1) as f64;
        let points: Vec<_> = self.series.iter().flat_map(|s| self.placed(s)).collect();
        let share = |place: f64, (low, high): (f64, f64)| (place - low) / (high - low);
        let hidden = |right: bool, upper: bool| {
            let within = |p: &&(f64, f64)| {
                let (across, up) = (share(p.0, x), share(p.1, y));
                let across = if right { 1.0 - across } else { across };
                let up = if upper { 1.0 - up } else { up };
                across < WIDTH && up < height
            };
            points.iter().filter(within).count()
        };
        let corners = [
            (hidden(true, true), SeriesLabelPosition::UpperRight),
            (hidden(false, true), SeriesLabelPosition::UpperLeft),
            (hidden(true, false), SeriesLabelPosition::LowerRight),
            (hidden(false, false), SeriesLabelPosition::LowerLeft),
        ];
        let best = corners.into_iter().min_by_key(|c| c.0);
        best.map_or(SeriesLabelPosition::UpperRight, |c| c.1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Axis;
    use super::*;

    #[test]
    fn a_plot_has_its_labels_and_is_the_same_each_time() {
        let plot = || {
            Plot::new("p", "Passes < all", Axis::log2("d"), Axis::linear("instructions"))
                .with(Series::line("ours", vec![(1.0, 2.0), (4.0, 8.0)]))
                .with(Series::points("printed", vec![(2.0, 4.0), (f64::NAN, 1.0), (0.0, 1.0)]).published())
        };
        let svg = plot().to_svg().unwrap();
        assert!(svg.contains("Passes &lt; all") && svg.contains("printed") && svg.contains("viewBox"));
        assert_eq!(svg, plot().to_svg().unwrap());
    }

    #[test]
    fn a_plot_without_points_is_drawn() {
        assert!(Plot::new("p", "t", Axis::log10("x"), Axis::linear("y")).to_svg().is_ok());
    }
}
