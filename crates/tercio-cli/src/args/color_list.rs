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

/// Why a text that should be a list is none.
pub fn what_is_wrong(text: &str) -> String {
    let words = values::between_commas(text);
    let is_number = |word: &&str| values::number(word).is_ok();
    if words.iter().all(is_number) && words.len() != 2 {
        return match words.len() % 4 {
            0 => "values have to ascend, and red, green and blue are 0 to 1".into(),
            _ => format!("{} numbers are not a value, red, green and blue each", words.len()),
        };
    }
    let (points, rest) = words.as_chunks();
    for [at, color] in points {
        if !is_number(at) {
            return format!("\"{at}\" is no number");
        }
        match values::color(color) {
            Err(_) => return format!("\"{color}\" is no colour"),
            Ok([.., alpha]) if alpha < 255 => return format!("\"{color}\" is not opaque"),
            Ok(_) => {}
        }
    }
    match rest.first() {
        Some(at) => format!("the value {at} has no colour"),
        None => "values have to ascend".into(),
    }
}

type Points = Vec<(f64, [f64; 3])>;

fn of_numbers(words: &[&str]) -> Option<Points> {
    let (points, rest) = words.as_chunks::<4>();
    let point = |[at, color @ ..]: &[&str; 4]| {
        let [r, g, b] = color.map(|word| values::share(word).ok());
        Some((values::number(at).ok()?, [r?, g?, b?]))
    };
    // A single point is no map, but may be two colours of three digits.
    (rest.is_empty() && points.len() > 1).then(|| points.iter().map(point).collect())?
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
        assert_eq!(at("0,000,1,fff", 0.5), Some([0.5; 3]));
        assert_eq!(at("0,000,1,001", 1.0), Some([0.0, 0.0, 17.0 / 255.0]));
        assert_eq!(at("-10,black,30,white", 0.5), Some([0.5; 3]));
        for bad in
            ["", "viridis", "0,black,1", "1,black,0,white", "0,blakc,1,white", "0,2,0,0,1,1,1,1", "a,b"]
        {
            assert!(color_list(bad).is_none(), "{bad}");
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (text, expected) in [
            ("0,black,1,whyte", "\"whyte\" is no colour"),
            ("0.5,black,0.2,white", "values have to ascend"),
            ("0,black,0.5", "the value 0.5 has no colour"),
            ("a,black,1,white", "\"a\" is no number"),
            ("0,0,0,0,1,1,1", "7 numbers are not a value, red, green and blue each"),
            ("0,2,0,0,1,1,1,1", "values have to ascend, and red, green and blue are 0 to 1"),
            ("0,#ff000080,1,white", "\"#ff000080\" is not opaque"),
        ] {
            assert!(color_list(text).is_none());
            assert_eq!(what_is_wrong(text), expected, "{text}");
        }
    }
}
