//! A colour map on the command line: values and their colours, as F3D's `--colormap` has them.

use tercio::scene::color_map::ColorMap;

use super::values;

/// The map of a list `VALUE,COLOR,VALUE,COLOR` or `VALUE,R,G,B,VALUE,R,G,B`, of which components are 0 to 1; `None` if a text is
/// none. Values within 0 to 1 are shares of the range, and what is beyond the first or the last of them has its colour; of others
/// the first and the last are the ends of the range.
pub fn color_list(text: &str) -> Option<ColorMap> {
    let words = values::between_commas(text);
    let mut points = of_numbers(&words).or_else(|| of_colors(&words))?;
    let (first, last) = (*points.first()?, *points.last()?);
    if points.iter().all(|(at, _)| (0.0..=1.0).contains(at)) {
        if first.0 > 0.0 {
            points.insert(0, (0.0, first.1));
        }
        if last.0 < 1.0 {
            points.push((1.0, last.1));
        }
    }
    ColorMap::from_points(text, &points).ok()
}

type Points = Vec<(f64, [f64; 3])>;

fn of_numbers(words: &[&str]) -> Option<Points> {
    let (points, rest) = words.as_chunks::<4>();
    let point = |[at, color @ ..]: &[&str; 4]| {
        let [r, g, b] = color.map(|word| values::share(word).ok());
        Some((values::number(at).ok()?, [r?, g?, b?]))
    };
    rest.is_empty().then(|| points.iter().map(point).collect())?
}

fn of_colors(words: &[&str]) -> Option<Points> {
    let (points, rest) = words.as_chunks::<2>();
    let point = |[at, color]: &[&str; 2]| {
        let [r, g, b, alpha] = values::color(color).ok()?;
        let color = [r, g, b].map(|level| f64::from(level) / 255.0);
        Some((values::number(at).ok().filter(|_| alpha == 255)?, color))
    };
    rest.is_empty().then(|| points.iter().map(point).collect())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_those_of_f3d() {
        let at = |text: &str, position: f64| color_list(text).map(|map| map.at(position));
        assert_eq!(at("0,black,1,white", 0.5), Some([0.5; 3]));
        assert_eq!(at("0.0,0.0,0.0,0.0,1.0,1.0,0.0,1.0", 0.5), Some([0.5, 0.0, 0.5]));
        assert_eq!(at("0,#000,0.5,rgb(255, 0, 0),1,#ffffff", 0.5), Some([1.0, 0.0, 0.0]));
        // Beyond the ends of a list.
        assert_eq!(at("0.25,red,0.75,lime", 0.1), Some([1.0, 0.0, 0.0]));
        assert_eq!(at("0.25,red,0.75,lime", 0.9), Some([0.0, 1.0, 0.0]));
        assert_eq!(at("-10,black,30,white", 0.5), Some([0.5; 3]));
        for bad in
            ["", "viridis", "0,black,1", "1,black,0,white", "0,blakc,1,white", "0,2,0,0,1,1,1,1", "a,b"]
        {
            assert!(color_list(bad).is_none(), "{bad}");
        }
    }
}
