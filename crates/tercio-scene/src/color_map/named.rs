//! Colour maps by name.
//!
//! Sources of `named.txt`: matplotlib 3.11 (`lib/matplotlib/_cm.py` and `_cm_listed.py`): viridis, magma, inferno and plasma by
//! N. Smith, S. van der Walt and E. Firing (CC0); cividis by Nuñez, Anderton and Renslow (2018); turbo by A. Mikhailov (2019,
//! Apache 2.0); twilight by B. Bechtold (CC0); coolwarm by K. Moreland (2009); those of ColorBrewer by C. Brewer (Apache 2.0);
//! cubehelix by D. Green (2011); okabe_ito by Okabe and Ito (2008); the rest after MATLAB, gnuplot, Yorick and Tableau.
//! twilight_shifted is matplotlib's, too; berlin, managua and vanimo by F. Crameri (2018), as matplotlib has them.
//! `rainbow_desaturated`, `rainbow_uniform` (C. Ware) and `fast` (F. Samsel, A. W. Scott) are ParaView's (BSD,
//! `Remoting/Views/ColorMaps.json`); the last one, which it interpolates in CIELAB, has colours between its own. Maps that change
//! faster than a table of 4080 colours shows (flag, prism, Cold and Hot) or jump (Cool to Warm (Extended)) are left out.
//!
//! A line is a name, what it is, and its colours: evenly spaced, six digits each, or with their positions.

use super::ColorMap;

const MAPS: &str = include_str!("named.txt");

/// Other names, without capitals, spaces, hyphens and underlines: those of other programs and spellings.
const OTHER_NAMES: [(&str, &str); 15] = [
    ("grey", "gray"),
    ("grayscale", "gray"),
    ("greyscale", "gray"),
    ("xray", "gray_r"),
    ("gistgray", "gray"),
    ("gistyarg", "gray_r"),
    ("binary", "gray_r"),
    ("cooltowarm", "coolwarm"),
    ("warmtocool", "coolwarm_r"),
    ("bluetoredrainbow", "jet"),
    ("redtobluerainbow", "jet_r"),
    ("blackbodyradiation", "hot"),
    ("blackbody", "hot"),
    ("category10", "tab10"),
    ("category20", "tab20"),
];

impl ColorMap {
    /// The names of all maps; each of them also exists with `_r`, reversed.
    pub fn names() -> impl Iterator<Item = &'static str> {
        MAPS.lines().filter_map(|line| line.split(' ').next())
    }

    /// The map of this name. Names of matplotlib and many of ParaView are known; capitals, spaces, hyphens, underlines and
    /// parentheses do not matter. `_r` at the end reverses it.
    pub fn named(name: &str) -> Option<Self> {
        let plain = |name: &str| -> String {
            let letters = name.chars().filter(|c| !matches!(c, ' ' | '-' | '_' | '(' | ')'));
            letters.flat_map(char::to_lowercase).collect()
        };
        let name = name.strip_suffix(" (matplotlib)").unwrap_or(name).trim();
        let find = |name: &str| {
            let plain_name = plain(name);
            let exact = MAPS.lines().find(|line| line.split(' ').next() == Some(name));
            exact.or_else(|| {
                MAPS.lines().find(|line| line.split(' ').next().map(plain) == Some(plain_name.clone()))
            })
        };
        if let Some(line) = find(name) {
            return Some(read(line));
        }
        if let Some(forward) = name.strip_suffix("_r").or_else(|| name.strip_suffix("_R")) {
            return Self::named(forward).map(Self::reversed);
        }
        let wanted = plain(name);
        let known = OTHER_NAMES.iter().find(|(other, _)| *other == wanted);
        known.and_then(|(_, name)| Self::named(name))
    }
}

/// Reads a line of the list.
fn read(line: &str) -> ColorMap {
    let mut words = line.split(' ');
    let (name, kind) = (words.next().unwrap_or(""), words.next());
    let digits = |text: &str| -> [u8; 3] {
        [0, 2, 4].map(|i| {
            u8::from_str_radix(&text[i..i + 2], 16).unwrap_or_else(|_| unreachable!("tests read all"))
        })
    };
    let colors: Vec<&str> = words.collect();
    let map = if colors.iter().any(|color| color.contains(':')) {
        let place = |word: &&str| {
            let (at, color) = word.split_once(':')?;
            Some((at.parse().ok()?, digits(color).map(|c| f64::from(c) / 255.0)))
        };
        let points: Vec<(f64, [f64; 3])> = colors.iter().filter_map(place).collect();
        ColorMap::from_points(name, &points)
    } else {
        let run = colors.first().copied().unwrap_or("");
        let colors: Vec<[u8; 3]> = (0..run.len() / 6).map(|i| digits(&run[i * 6..i * 6 + 6])).collect();
        ColorMap::from_colors(name, &colors, kind == Some("categories"))
    };
    map.unwrap_or_else(|_| unreachable!("tests read all"))
}
