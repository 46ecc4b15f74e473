//! Options by the names that they have in F3D, PyVista, ParaView and VTK.
//!
//! Those with one counterpart are aliases in the definition of the options. Here are those that mean nothing, several options or
//! an option with a value, and what to say about those without a counterpart.

use std::ffi::{OsStr, OsString};

use tercio::annotate::Place;

/// Switches that F3D and PyVista also take with `=true` and `=false`.
const SWITCHES: [&str; 15] = [
    "axis",
    "bar",
    "camera-orthographic",
    "edges",
    "grid",
    "log-scale",
    "no-background",
    "off-screen",
    "parallel-projection",
    "point-sprites",
    "scalar-coloring",
    "show-edges",
    "show-scalar-bar",
    "translucency-support",
    "watch",
];

/// What is done anyway: there is no window, and what is translucent is always drawn in the right order.
const DONE_ANYWAY: [&str; 5] =
    ["off-screen", "offscreen", "headless", "translucency-support", "show-scalar-bar"];

/// The names of `--color-by`.
const COLOR_BY: [&str; 3] = ["color-by", "scalars", "coloring-array"];

/// The arguments of `tercio render` and `tercio sheet` with options of this program. Others stay as they are.
pub fn translated(arguments: Vec<OsString>) -> Vec<OsString> {
    if arguments.get(1).is_none_or(|command| command != "render" && command != "sheet") {
        return arguments;
    }
    let mut all = Vec::with_capacity(arguments.len());
    let mut component = None;
    let mut given = arguments.into_iter().peekable();
    while let Some(argument) = given.next() {
        if argument == "--" {
            all.push(argument);
            all.extend(given);
            break;
        }
        let Some((name, value)) = option(&argument) else {
            all.push(argument);
            continue;
        };
        if let ("bar" | "show-scalar-bar", Some("false")) = (&*name, value.as_deref()) {
            all.push("--no-bar".into());
            continue;
        }
        if let (true, Some("false")) = (SWITCHES.contains(&&*name), value.as_deref()) {
            continue;
        }
        if (&*name, value.as_deref()) == ("bar", Some("true")) {
            continue;
        }
        let value = value.filter(|value| !(SWITCHES.contains(&&*name) && value == "true"));
        // The value, which may be the next argument.
        let mut take = || value.clone().map(OsString::from).or_else(|| given.next());
        match &*name {
            done if DONE_ANYWAY.contains(&done) && value.is_none() => {}
            "no-background" if value.is_none() => all.push("--background=transparent".into()),
            "point-sprites" if value.is_none() => {
                all.extend(["--mode=points".into(), "--point-shape=sphere".into()]);
            }
            "input" => all.extend(take()),
            "coloring-component" | "comp" => component = take().and_then(|value| value.into_string().ok()),
            // A switch in F3D; the bar is there unless --no-bar is given.
            "bar" if value.is_none() && !given.peek().is_some_and(|next| is_place(next)) => {}
            _ => all.push(match value {
                Some(value) => format!("--{name}={value}").into(),
                None => format!("--{name}").into(),
            }),
        }
    }
    let is_colored = all.iter().filter_map(|a| option(a)).any(|(name, _)| COLOR_BY.contains(&&*name));
    if is_colored {
        // It colours by the first array unless one is named.
        all.retain(|argument| argument != "--scalar-coloring");
    }
    if let Some(component) = component {
        with_component(&mut all, &component);
    }
    all
}

/// The name of a long option, with hyphens, and its value after an equals sign.
fn option(argument: &OsStr) -> Option<(String, Option<String>)> {
    let text = argument.to_str()?.strip_prefix("--")?;
    let (name, value) = match text.split_once('=') {
        Some((name, value)) => (name, Some(value.to_owned())),
        None => (text, None),
    };
    Some((name.replace('_', "-"), value))
}

/// A value of `--bar`, or something that is meant to be one.
fn is_place(argument: &OsStr) -> bool {
    let text = argument.to_string_lossy();
    let are_numbers = text.contains(',') && text.split(',').all(|part| part.parse::<f64>().is_ok());
    Place::named(&text).is_some() || are_numbers || !text.starts_with('-') && !text.contains('.')
}

/// Adds a component of F3D to the name of the attribute: its number, -1 for the magnitude, -2 for colours.
fn with_component(all: &mut Vec<OsString>, component: &str) {
    let suffix = match component {
        "-1" => "magnitude",
        "-2" => "rgb",
        other => other,
    };
    let named = |name: &str| COLOR_BY.contains(&name);
    for at in 0..all.len() {
        match option(&all[at]) {
            Some((name, Some(value))) if named(&name) => {
                all[at] = format!("--{name}={value}:{suffix}").into();
                return;
            }
            Some((name, None)) if named(&name) && at + 1 < all.len() => {
                all[at + 1].push(format!(":{suffix}"));
                return;
            }
            _ => {}
        }
    }
    // The parser reports it, with the tip.
    all.push("--coloring-component".into());
}

/// Options of other programs without an exact counterpart, and what does here what they do there.
const TIPS: &[(&[&str], &str)] = &[
    (
        &["wireframe"],
        "'--mode wireframe' draws the edges alone, '--mode hidden-line' those that are not hidden, '--edges' those on the surface",
    ),
    (&["points", "vertices", "show-vertices"], "'--mode points' draws the vertices"),
    (&["representation"], "'--mode surface|wireframe|points', and '--edges' for a surface with edges"),
    (
        &["screenshot-filename", "out", "outfile", "file", "filename", "save"],
        "'--output FILE' is the picture; '--title {name}' writes the model's name in it",
    ),
    (
        &["scalar-coloring", "coloring", "color-array", "array", "-s"],
        "'--color-by NAME' colours by an attribute, and 'tercio info MODEL' lists those that there are",
    ),
    (
        &["coloring-component", "comp", "component", "-y"],
        "'--color-by NAME:N' takes a component by its number or name, NAME:magnitude or NAME:rgb",
    ),
    (&["cells", "coloring-by-cells", "-c"], "'--color-by NAME@cell' takes the data of cells"),
    (&["rgb", "rgba"], "'--color-by NAME:rgb' takes values as colours"),
    (
        &["scalar-bar", "colorbar", "legend", "-b"],
        "the scalar bar is there with '--color-by'; '--bar PLACE' moves it, '--no-bar' leaves it out",
    ),
    (&["scalar-bar-title"], "'--bar-title TEXT'"),
    (
        &["scalar-bar-args"],
        "'--bar-title', '--bar-unit', '--bar-format', '--bar-ticks', '--bar-orientation' and '--bar PLACE'",
    ),
    (&["invert-colormap", "flip-scalars", "invert"], "'--colormap NAME_r' reverses a colour map"),
    (&["vmin", "vmax", "scalar-range", "data-range"], "'--range MIN,MAX'; an empty end is that of the data"),
    (&["nan-opacity"], "'--nan-color #rrggbbaa' has an opacity"),
    (
        &["cube-axes", "show-bounds", "axes-grid", "bounding-box", "outline"],
        "'--bounds' draws the model's box with numbers",
    ),
    (&["show-axes", "orientation-axes", "add-axes", "-x"], "'--axes' shows the directions of the axes"),
    (&["show-grid", "-g"], "'--grid' draws a grid on the floor, '--bounds' the model's box with numbers"),
    (
        &["grid-unit", "grid-subdivisions", "grid-color"],
        "'--grid' has lines at round numbers, in the colour of '--text-color'",
    ),
    (
        &["-e", "mesh-edges", "line", "lines"],
        "'--edges' draws edges on the surface, '--mode wireframe' nothing else",
    ),
    (
        &["feature-edges", "boundary-edges", "silhouette"],
        "'--edges=feature', '--edges=boundary', '--edges=silhouette'",
    ),
    (
        &["edge-opacity", "line-color", "edges-color"],
        "'--edge-color #rrggbbaa' is the colour of edges, with its opacity",
    ),
    (
        &["render-points-as-spheres", "points-gaussian", "point-sprites-type"],
        "'--point-shape sphere' (square, round)",
    ),
    (
        &["point-sprites-size", "point-radius"],
        "'--point-size' takes pixels, or units of the model with a u: 0.1u",
    ),
    (
        &["render-lines-as-tubes", "tube", "tubes", "tube-radius"],
        "'--line-shape tube', as wide as '--line-width'",
    ),
    (&["transparent-background", "transparent"], "'--background transparent'"),
    (&["bgcolor", "bg", "background-top"], "'--background COLOR', or two colours TOP,BOTTOM for a gradient"),
    (&["alpha", "transparency"], "'--opacity ALPHA', 0 to 1"),
    (
        &["smooth-shading", "flat-shading", "interpolation", "split-sharp-edges"],
        "'--shading flat|gouraud|phong', and '--crease-angle DEG' for edges that stay sharp",
    ),
    (&["pbr"], "'--shading pbr', with '--roughness' and '--metallic'"),
    (
        &["lighting", "no-lighting", "ambient", "diffuse"],
        "'--shading unlit' leaves light out, '--light' chooses it",
    ),
    (&["light-intensity"], "'--exposure STOPS' makes the picture brighter"),
    (&["specular-power"], "'--specular STRENGTH', or '--shading pbr --roughness R'"),
    (&["culling", "backface-type", "backface-culling"], "'--cull back|front|none'"),
    (
        &["depth-peeling", "use-transparency", "-p"],
        "leave it out: what is translucent is always drawn in the right order",
    ),
    (&["ambient-occlusion", "ssao", "-q"], "'--ao' darkens what is occluded"),
    (&["eye-dome-lighting"], "'--edl'"),
    (
        &[
            "anti-aliasing",
            "anti-aliasing-mode",
            "antialiasing",
            "multi-samples",
            "msaa",
            "ssaa",
            "samples",
            "-a",
        ],
        "'--aa N' takes N samples per pixel",
    ),
    (&["tone-mapping", "-t"], "'--tone CURVE' and '--exposure STOPS'"),
    (
        &["hdri-file", "hdri-ambient", "hdri-skybox", "hdri", "environment-texture"],
        "'--environment FILE' lights with a panorama",
    ),
    (
        &["raytracing", "-r", "denoise", "volume"],
        "tercio has no ray tracing and no volume rendering: it draws surfaces, lines and points",
    ),
    (&["rendering-backend", "gpu", "egl", "osmesa"], "leave it out: tercio needs no GPU and no window"),
    (
        &["interactive", "trackball", "position", "fullscreen", "fps-counter", "-z"],
        "tercio opens no window: it draws into files; '--watch' draws again when the model changes",
    ),
    (&["metadata", "-m", "no-render", "list-readers"], "'tercio info MODEL' describes a file"),
    (&["-n"], "'--title {name}' writes the model's name in the picture"),
    (&["ref", "ref-threshold", "reference"], "'tercio compare A B' compares two pictures"),
    (&["max-size"], "'--memory-limit SIZE' refuses what needs more memory"),
    (&["no-config", "dry-run"], "'--config none' reads no configuration"),
    (&["multi-file-mode"], "'--together' draws all models in one picture; otherwise each has one"),
    (&["frame-rate", "framerate"], "'--fps RATE'"),
    (
        &["animation-speed-factor", "animation-index", "animation-indices", "animation-autoplay"],
        "'--fps RATE' is the speed of a film, '--step N' and '--time T' choose one of its times",
    ),
    (
        &["orbit", "spin", "animate"],
        "'--turntable N' turns the camera round the model, '--camera-path FILE' moves it",
    ),
    (&["focal-point"], "'--target X,Y,Z', with '--eye X,Y,Z'"),
    (&["viewup", "view-up", "up-direction"], "'--up X,Y,Z', or '--up +Z' for the axis of the model"),
    (
        &["cpos", "camera", "camera-index"],
        "'--view NAME', '--azimuth' and '--elevation', or '--eye' and '--target'",
    ),
    (&["perspective"], "leave it out: it is the default; '--orthographic' is the other one"),
    (&["width", "height", "image-size", "geometry", "window"], "'--size WIDTHxHEIGHT'"),
    (
        &["dpi", "magnification", "image-scale"],
        "'--size WIDTHxHEIGHT'; text grows with it, and '--text-scale' makes it larger",
    ),
    (&["font-size", "font-scale"], "'--text-scale FACTOR'"),
    (&["font-color"], "'--text-color COLOR'"),
    (
        &["contour", "contours", "isosurfaces"],
        "'--isolines N' draws lines of equal value, '--mode contours' bands with lines between them",
    ),
    (&["slice", "clip-plane", "clipping-plane"], "'--clip PLANE' cuts the model, '--clip-cap' closes it"),
    (&["vectors", "arrows", "glyph-vectors"], "'--glyphs NAME' draws arrows of a vector"),
    (&["jobs", "workers", "-j"], "'--threads N'"),
    (
        &["texture", "texture-base-color"],
        "textures are those of the model (MTL files); '--no-textures' leaves them out",
    ),
    (
        &["time-step", "timestep", "time-index"],
        "'--step N' chooses one of the times of a collection by its number, '--time T' by its time",
    ),
];

/// What to say about an option of another program, such as `--wireframe` or `-e`.
pub fn tip(argument: &str) -> Option<&'static str> {
    let name = argument.split('=').next().unwrap_or_default();
    let name = name.strip_prefix("--").map_or_else(|| name.to_owned(), |long| long.replace('_', "-"));
    TIPS.iter().find(|(names, _)| names.contains(&&*name)).map(|(_, tip)| *tip)
}

#[cfg(test)]
mod tests {
    use clap::Arg;

    use super::*;

    fn words(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn options_of_others_are_translated() {
        let cases = [
            ("--off-screen --point_sprites", "--mode=points --point-shape=sphere"),
            ("--input x.vtp --window_size 4,3", "x.vtp --window-size 4,3"),
            ("--input=x.vtp --grid=true --edges=false", "x.vtp --grid"),
            ("--scalar-coloring --coloring-array p x", "--coloring-array p x"),
            ("--scalar-coloring x", "--scalar-coloring x"),
            ("--coloring-component -1 --scalars=v x", "--scalars=v:magnitude x"),
            ("--color-by v x --coloring-component=2", "--color-by v:2 x"),
            ("--bar --color-by p x", "--color-by p x"),
            ("--bar left x", "--bar left x"),
            ("--bar=true x", "x"),
            ("--bar=false x", "--no-bar x"),
            ("--show-scalar-bar=false x", "--no-bar x"),
            ("--show_scalar_bar=true x", "x"),
            ("--no-background -- --off-screen", "--background=transparent -- --off-screen"),
            ("--title a_b --edges=feature", "--title a_b --edges=feature"),
        ];
        for (given, expected) in cases {
            let all = translated(words(&format!("tercio render {given}")));
            assert_eq!(all, words(&format!("tercio render {expected}")), "{given}");
            let other = words(&format!("tercio info {given}"));
            assert_eq!(translated(other.clone()), other);
        }
    }

    /// Tips are for what is no option, and name options that there are.
    #[test]
    fn tips_name_what_there_is() {
        let program = crate::definition();
        let render = program.find_subcommand("render").expect("a command");
        let is_known = |name: &str| {
            let is_named = |option: &Arg| {
                option.get_long() == Some(name)
                    || option.get_all_aliases().is_some_and(|all| all.contains(&name))
                    || option.get_short().is_some_and(|short| name == format!("-{short}"))
            };
            render.get_arguments().any(is_named)
        };
        for (names, tip) in TIPS {
            for name in *names {
                assert!(!is_known(name) || ["-s", "-q"].contains(name), "{name} is an option");
            }
            for option in tip.split('\'').filter_map(|word| word.strip_prefix("--")) {
                let name: String = option.chars().take_while(|c| c.is_alphanumeric() || *c == '-').collect();
                assert!(is_known(&name), "{tip}: there is no --{name}");
            }
        }
    }
}
