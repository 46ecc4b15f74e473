//! `tercio render` from the outside.

mod common;

use std::io::Read;
use std::process::Stdio;

use common::{OCTAHEDRON, Place};
use tercio::image::{Picture, Pixels};

/// Runs fast and prints as little as possible.
const SMALL: &str = "--size 64x48 --quiet";

#[test]
fn every_format_is_written_and_holds_the_same_picture() {
    let place = Place::new();
    for name in ["a.png", "a.ppm", "a.webp", "A.PNG"] {
        place.run(&format!("render model.off -o {name} {SMALL}")).ok_silently();
    }
    let pictures =
        ["a.png", "a.ppm", "a.webp", "A.PNG"].map(|n| Picture::from_bytes(&place.read(n)).unwrap());
    assert_eq!((pictures[0].width, pictures[0].height), (64, 48));
    pictures.iter().for_each(|p| assert_eq!(p, &pictures[0]));

    place.run(&format!("render model.off -o a.jpg {SMALL}")).ok_silently();
    place.run(&format!("render model.off -o rough.jpeg --quality 20 {SMALL}")).ok_silently();
    place.run(&format!("render model.off -o named --format jpg --quality 90 {SMALL}")).ok_silently();
    assert!(place.read("named") == place.read("a.jpg"), "90 is the default");
    assert!(place.read("rough.jpeg").len() < place.read("a.jpg").len());
    let jpeg = Picture::from_bytes(&place.read("a.jpg")).unwrap();
    let similarity = tercio::image::similarity(&jpeg, &pictures[0]).unwrap();
    assert!(similarity.psnr > 36.0, "{similarity:?}");

    place.run(&format!("render model.off -o deep.png --depth 16 {SMALL}")).ok_silently();
    assert!(matches!(Picture::from_bytes(&place.read("deep.png")).unwrap().pixels, Pixels::Sixteen(_)));
    place.run(&format!("render model.off -o clear.png --background transparent {SMALL}")).ok_silently();
    assert!(!Picture::from_bytes(&place.read("clear.png")).unwrap().is_opaque());
}

#[test]
fn the_model_is_seen() {
    let place = Place::new();
    let outcome = place.run("render model.off -o a.png --size 64x48");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "no warning that nothing was drawn");
    let picture = Picture::from_bytes(&place.read("a.png")).unwrap();
    let Pixels::Eight(pixels) = picture.pixels else { panic!("8 bits") };
    let (corner, middle) = (pixels[0], pixels[24 * 64 + 32]);
    assert_ne!(corner, middle);
}

#[test]
fn pipes_in_and_out() {
    let place = Place::new();
    let outcome =
        place.run_with_input(&format!("render - -o - {SMALL}"), OCTAHEDRON.as_bytes()).ok_silently();
    assert_eq!(&outcome.stdout[..8], b"\x89PNG\r\n\x1a\n");
    place.run(&format!("render model.off -o a.png {SMALL}")).ok_silently();
    assert_eq!(outcome.stdout, place.read("a.png"));
    let ppm = place.run(&format!("render model.off -o - --format ppm {SMALL}")).ok_silently();
    assert!(ppm.stdout.starts_with(b"P6\n64 48\n255\n"));
    let empty = place.run_with_input(&format!("render - -o - {SMALL}"), b"");
    empty.failed(1, &["standard input"]);
    assert!(empty.stdout.is_empty());
}

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let place = Place::new();
    let arguments = "render model.off -o - --format ppm --size 2000x2000 --quiet";
    let mut child = place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut [0; 8]).unwrap();
    drop(stdout);
    let outcome = child.wait_with_output().unwrap();
    assert_eq!((outcome.status.code(), outcome.stderr), (Some(0), vec![]));
}

#[test]
fn errors_name_the_file_and_the_reason() {
    let place = Place::new();
    std::fs::write(place.path("junk.ply"), b"\x00\x01 this is no model").unwrap();
    place.run("render missing.ply -o a.png").failed(1, &["missing.ply: ", "No such file"]);
    place.run("render junk.ply -o a.png").failed(1, &["junk.ply: not a model", "PLY, OBJ, STL, OFF"]);
    place.run("render . -o a.png").failed(1, &[".: "]);
    place.run("render builtin:teapod@1k -o a.png").failed(1, &["teapod"]);
    place.run("render missing.ply -o no/a.png").failed(1, &["no/a.png: "]);
    place.run("render missing.ply -o a.png --stats no/s.json").failed(1, &["no/s.json: "]);
    place.run("render model.off -o a.png --eye 1,2,3 --target 1,2,3").failed(1, &["eye and target"]);
    for limit in ["--memory-limit 100", "--memory-limit 1M --size 1000x1000"] {
        place.run(&format!("render model.off -o a.png {limit}")).failed(1, &["--memory-limit"]);
    }
    // One line each, and the reason once.
    let outcome = place.run("render missing.ply -o a.png");
    assert_eq!((outcome.stderr.lines().count(), outcome.stderr.matches("No such").count()), (1, 1));
    assert_eq!(place.names(), ["junk.ply", "model.off"]);
}

#[test]
fn a_failed_run_leaves_the_old_picture() {
    let place = Place::new();
    std::fs::write(place.path("a.png"), "old").unwrap();
    std::fs::write(place.path("d.npy"), "old").unwrap();
    place.run("render missing.ply -o a.png").failed(1, &[]);
    // The second output is a folder: the first one must not be there either.
    std::fs::create_dir(place.path("folder.npy")).unwrap();
    place
        .run(&format!("render model.off -o a.png --output-ids folder.npy {SMALL}"))
        .failed(1, &["folder.npy"]);
    assert_eq!((place.read("a.png"), place.read("d.npy")), (b"old".to_vec(), b"old".to_vec()));
    assert_eq!(place.names(), ["a.png", "d.npy", "folder.npy", "model.off"]);
}

#[test]
fn stats_have_their_keys() {
    let place = Place::new();
    let outcome =
        place.run(&format!("render model.off -o a.png --stats - --threads 2 {SMALL}")).ok_silently();
    let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    let keys = [
        "/tercio_version",
        "/load/model",
        "/load/format",
        "/load/file_bytes",
        "/load/vertices",
        "/load/triangles",
        "/load/bounds/min",
        "/load/repaired/degenerate_triangles",
        "/load/repaired/welded_vertices",
        "/load/milliseconds/read",
        "/load/milliseconds/clean",
        "/load/milliseconds/weld",
        "/load/milliseconds/normals",
        "/load/milliseconds/partition",
        "/load/milliseconds/total",
        "/camera/eye",
        "/camera/target",
        "/camera/up",
        "/camera/projection/fov_degrees",
        "/frame/frontend/triangles_in",
        "/frame/frontend/triangles_outside",
        "/frame/binning/overlap",
        "/frame/binning/cluster_overlap",
        "/frame/backend/pixels_shaded",
        "/frame/backend/overdraw",
        "/frame/milliseconds/total",
        "/output_milliseconds",
        "/total_milliseconds",
        "/peak_memory_bytes",
        "/simd",
    ];
    keys.into_iter().for_each(|k| assert!(stats.pointer(k).is_some(), "{k} is missing in {stats:#}"));
    assert_eq!(stats["load"]["triangles"], 8);
    assert_eq!(stats["threads"], 2);
    assert_eq!(
        stats["picture"],
        serde_json::json!({
            "width": 64,
            "height": 48,
            "anti_aliasing": { "samples": 4, "pattern": "4", "shading": "pixel", "filter": "box" },
        })
    );
    assert_eq!(stats["look"]["shading"], "phong");
    assert_eq!(stats["look"]["lights"][0]["kind"], "wide");
    if cfg!(target_os = "linux") {
        assert!(stats["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
    }

    place.run(&format!("render model.off -o a.png --stats s.json --simd scalar {SMALL}")).ok_silently();
    let stats: serde_json::Value = serde_json::from_slice(&place.read("s.json")).unwrap();
    assert_eq!(stats["simd"], "scalar");
}

#[test]
fn statistics_tell_the_look() {
    let place = Place::new();
    let options = "--shading pbr --roughness 0.3 --opacity 0.25 --color #ffffff --no-mesh-colors --cull back \
        --light spot:0,1,2:0,-1,0:20:#808080 --light dir:1,2,3 --shadows=64 --background #000000,#ffffff00 \
        --exposure -1 --tone filmic --ao=0.5 --edl --environment gradient --environment-strength 0.5";
    let outcome = place.run(&format!("render model.off -o a.png --stats - {SMALL} {options}"));
    let stats: serde_json::Value = serde_json::from_str(outcome.ok_silently().text()).unwrap();
    let mut look = stats["look"].clone();
    let lights = look["lights"].take();
    let gray = lights[0]["color"][0].as_f64().unwrap();
    assert!((gray - 0.2158605).abs() < 1e-6, "{gray}");
    assert_eq!(
        lights,
        serde_json::json!([
            {
                "kind": "spot", "position": [0.0, 1.0, 2.0], "direction": [0.0, -1.0, 0.0], "space": "world",
                "angle": 20.0, "color": [gray, gray, gray],
            },
            { "kind": "directional", "to_light": [1.0, 2.0, 3.0], "space": "world", "color": [1.0, 1.0, 1.0] },
        ])
    );
    assert_eq!(
        look,
        serde_json::json!({
            "color": [1.0, 1.0, 1.0], "mesh_colors": false, "opacity": 0.25, "specular": 0.2,
            "roughness": 0.3, "metallic": 0.0, "shading": "pbr", "cull": "back", "shadows": 64, "lights": null,
            "data": null, "annotation": null,
            "background": { "top": [0.0, 0.0, 0.0, 1.0], "bottom": [1.0, 1.0, 1.0, 0.0] },
            "environment": {
                "source": { "gradient": [[0.75, 0.95, 1.25], [1.0, 1.0, 1.0], [0.22, 0.20, 0.18]] },
                "strength": 0.5, "rotation": 0.0,
            },
            "effects": {
                "exposure": -1.0, "tone": "filmic", "ao": { "strength": 0.5, "radius": 0.2 },
                "edl": { "strength": 1.0, "radius": null },
            },
        })
    );
}

#[test]
fn the_frame_is_counted() {
    let place = Place::new();
    let outcome = place.run(&format!("render model.off -o a.png --stats - {SMALL}")).ok_silently();
    let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    assert_eq!(stats["frame"]["frontend"]["triangles_in"], 8);
    assert!(stats["frame"]["backend"]["pixels_shaded"].as_u64().unwrap() > 500);
}

/// Type, shape and content of an NPY file.
fn npy(bytes: &[u8]) -> (String, Vec<usize>, &[u8]) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((end % 64, bytes[end - 1]), (0, b'\n'));
    let header = std::str::from_utf8(&bytes[10..end]).unwrap();
    assert!(header.contains("'fortran_order': False"));
    let after = |key: &str| header.split_once(key).unwrap().1;
    let descr = after("'descr': '").split('\'').next().unwrap().to_owned();
    let shape = after("'shape': (").split(')').next().unwrap();
    let shape = shape.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    (descr, shape, &bytes[end..])
}

#[test]
fn verbose_output_has_a_line_for_each_rank() {
    let place = Place::new();
    let outcome = place.run(
        "render builtin:teapot@2k -o a.png --size 90x60 --ranks 3 --organisation sort-twice --group 2 -v",
    );
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let lines: Vec<&str> = outcome.stderr.lines().collect();
    let title =
        lines.iter().position(|line| line.contains("clusters") && line.contains("wait ms")).expect("a table");
    assert!(lines[title - 1].contains("3 ranks, sort-twice in groups of 2, sent "), "{}", lines[title - 1]);
    let column = |line: &str, number: usize| line.split_whitespace().rev().nth(12 - number).map(String::from);
    for (rank, line) in lines[title + 1..title + 4].iter().enumerate() {
        assert_eq!(column(line, 0), Some(rank.to_string()), "{line}");
    }
    let sum = |number: usize| -> u64 {
        let cells = lines[title + 1..title + 4].iter().filter_map(|line| column(line, number));
        cells.map(|cell| cell.replace(',', "").parse::<u64>().expect("a number")).sum()
    };
    // What is sent is received.
    assert_eq!((sum(4), sum(5)), (sum(6), sum(7)));
    assert!(sum(4) > 0);
    // By kind, and from each rank to each other one.
    let titled = |title: &str| lines.iter().position(|line| line.contains(title)).expect("a table");
    let number = |cell: &str| cell.replace(',', "").parse::<u64>().ok();
    let kinds = &lines[titled("messages  ")..titled("bytes from, to")];
    let of_kinds = kinds.iter().filter_map(|line| number(line.split_whitespace().last()?)).sum::<u64>();
    let from = titled("bytes from, to") + 1;
    let cells = lines[from..from + 3].iter().flat_map(|line| line.split_whitespace().rev().take(3));
    let partners = cells.filter_map(number).sum::<u64>();
    assert_eq!((of_kinds, partners), (sum(5), sum(5)), "{}", outcome.stderr);
    assert!(
        kinds.iter().any(|line| line.contains("bins")) && kinds.iter().any(|line| line.contains("barrier"))
    );
}

#[test]
fn auto_chooses_how_ranks_share_the_picture_and_says_why() {
    let place = Place::new();
    let model = "render builtin:teapot@5k --size 200x150";
    place.run(&format!("{model} -o alone.png")).ok_silently();
    for (ranks, limits) in
        [(1, ""), (2, ""), (5, ""), (4, "--composition tree"), (3, "--group 2 --division rows")]
    {
        let auto = format!("{model} -o a.png --ranks {ranks} --organisation auto {limits}");
        let outcome = place.run(&format!("{auto} --stats -")).ok_silently();
        assert!(place.read("alone.png") == place.read("a.png"), "{auto}");
        let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
        let (choice, parallel) = (&stats["choice"], &stats["parallel"]);
        assert_eq!((&choice["ranks"], &choice["network"]["measured_here"]), (&ranks.into(), &false.into()));
        assert!(
            choice["choosing_milliseconds"].as_f64().unwrap() > 0.0
                && choice["processors"].as_u64() > Some(0)
        );
        let candidates = choice["candidates"].as_array().unwrap();
        let time = |candidate: &serde_json::Value| candidate["milliseconds"].as_f64().unwrap();
        assert!(candidates.is_sorted_by(|a, b| time(a) <= time(b)), "{auto}: {candidates:?}");
        for candidate in candidates {
            let terms = ["front_end", "exchange", "draw", "composite", "collect"];
            let sum: f64 = terms.iter().map(|term| candidate[term].as_f64().unwrap()).sum();
            assert!((sum - time(candidate)).abs() < 1e-9 * sum, "{candidate}");
            assert!(candidate["bytes"].as_f64().is_some() && candidate["messages"].as_f64().is_some());
        }
        // What was drawn is what was chosen, and its options draw the same.
        let first = &candidates[0];
        for key in ["organisation", "group"] {
            assert_eq!(first[key], parallel.get(key).cloned().unwrap_or_default(), "{auto}: {first}");
        }
        let options = first["options"].as_str().unwrap();
        assert!(limits.is_empty() || limits.split(" --").all(|limit| options.contains(limit)), "{options}");
        place.run(&format!("{model} -o b.png --ranks {ranks} {options}")).ok_silently();
        assert!(place.read("a.png") == place.read("b.png"), "{options}");
        let outcome = place.run(&format!("{auto} -v"));
        let lines: Vec<&str> = outcome.stderr.lines().collect();
        let chose =
            lines.iter().position(|line| line.contains(&format!("chose {options} of "))).expect("why");
        assert!(lines[chose + 1].contains("not measured"), "{}", lines[chose + 1]);
        assert!(lines[chose + 2].contains("predicted ms") && lines[chose + 2].contains("composite"));
        assert!(lines[chose + 3].ends_with(options), "{}", lines[chose + 3]);
    }
    // Nothing was chosen.
    let outcome = place.run(&format!("{model} -o a.png --ranks 2 --stats -")).ok_silently();
    let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    assert_eq!(stats.get("choice"), Some(&serde_json::Value::Null));
}

#[test]
fn auto_refuses_what_leaves_it_no_choice() {
    let place = Place::new();
    let auto = "render model.off -o a.png --organisation auto";
    place.run(auto).failed(2, &["--organisation", "--ranks N"]);
    for (options, reason) in [
        (
            "--ranks 2 --division rows --composition tree",
            "sort-twice, which needs 3 ranks or more: there are 2",
        ),
        ("--ranks 2 --group 3", "--group 3: there are 2 ranks"),
        ("--ranks 4 --radix 3", "--radix is for --composition radix-k"),
    ] {
        place.run(&format!("{auto} {options}")).failed(2, &[reason]);
    }
}

#[test]
fn verbose_output_says_how_triangles_are_counted() {
    let place = Place::new();
    // Every tile of 8 pixels that a triangle reaches sets it up again.
    let outcome = place.run("render model.off -o a.png --size 640x480 --tile-size 8 -v");
    assert_eq!(outcome.code, Some(0));
    assert!(outcome.stderr.contains("OFF: 8 triangles, "), "{}", outcome.stderr);
    let count =
        outcome.stderr.split(" triangles set up (counted once a tile and once a clipped piece)").next();
    let count = count.and_then(|text| text.rsplit(' ').next()).unwrap().replace(',', "");
    assert!(count.parse::<u64>().unwrap() >= 4, "{}", outcome.stderr);
}

#[test]
fn arrays_are_as_numpy_reads_them() {
    let place = Place::new();
    let arrays = "--output-depth d.npy --output-ids i.npy --output-normals n.npy";
    place.run(&format!("render model.off {arrays} {SMALL}")).ok_silently();
    assert_eq!(place.names(), ["d.npy", "i.npy", "model.off", "n.npy"]);
    let files = ["d.npy", "i.npy", "n.npy"].map(|n| place.read(n));
    let [depth, ids, normals] = [npy(&files[0]), npy(&files[1]), npy(&files[2])];
    assert_eq!((depth.0.as_str(), &depth.1[..], depth.2.len()), ("<f4", &[48, 64][..], 64 * 48 * 4));
    assert_eq!((ids.0.as_str(), &ids.1[..], ids.2.len()), ("<u4", &[48, 64][..], 64 * 48 * 4));
    assert_eq!(
        (normals.0.as_str(), &normals.1[..], normals.2.len()),
        ("<f4", &[48, 64, 3][..], 64 * 48 * 12)
    );
    // The corner is background.
    assert_eq!(depth.2[..4], f32::INFINITY.to_le_bytes());
    assert_eq!((&ids.2[..4], &normals.2[..12]), (&[255; 4][..], &[0; 12][..]));
}

#[test]
fn cameras_and_looks_are_accepted() {
    let place = Place::new();
    let cases = [
        "--view iso --up-axis z --orthographic",
        "--azimuth -30 --elevation -90 --roll 45 --zoom 2",
        "--fov 100 --zoom 0.5",
        "--eye -3,2,1 --target 0,0,0 --up 0,0,1 --fov 60 --near 0.5",
        "--shading flat --cull none --color 808080 --no-mesh-colors --background #fff,#000",
        "--light head --light ambient:#fff*0.2 --specular 0 --crease-angle 30",
        "--light dir:1,-1,1:#ff0 --light camera-dir:-1,0,1 --light point:3,3,3",
        "--tile-size 8 --binning bbox --no-cluster-culling --simd scalar --threads 3",
        "--memory-limit 2Gi --progress never",
        "--shading gouraud --cull back",
        "--shading unlit",
    ];
    for case in cases {
        place.run(&format!("render model.off -o a.png {case} {SMALL}")).ok_silently();
    }
}

#[test]
fn the_picture_does_not_depend_on_threads_tiles_and_levels() {
    let place = Place::new();
    place.run(&format!("render model.off -o a.png {SMALL}")).ok_silently();
    for tuning in ["--threads 1", "--threads 7 --tile-size 8", "--simd scalar --binning bbox", "--cull none"]
    {
        place.run(&format!("render model.off -o b.png {tuning} {SMALL}")).ok_silently();
        assert!(place.read("a.png") == place.read("b.png"), "{tuning}");
    }
}

#[test]
fn the_picture_does_not_depend_on_ranks() {
    let place = Place::new();
    let arrays = |k: u32| format!("-o {k}.png --output-depth d{k}.npy --output-ids i{k}.npy");
    let model = "render builtin:teapot@5k --size 200x150 --quiet";
    place.run(&format!("{model} {}", arrays(0))).ok_silently();
    for ranks in [
        "--ranks 1",
        "--ranks 5",
        "--ranks 3 --organisation sort-first --threads 4",
        "--ranks 3 --organisation sort-last --composition radix-k --radix 2",
        "--ranks 5 --organisation sort-twice --group 2 --division blocks --composition binary-swap",
    ] {
        let outcome = place.run(&format!("{model} {} {ranks} --stats -", arrays(1))).ok_silently();
        for [plain, ranked] in [["0.png", "1.png"], ["d0.npy", "d1.npy"], ["i0.npy", "i1.npy"]] {
            assert!(place.read(plain) == place.read(ranked), "{ranks}: {plain}");
        }
        let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
        let parallel = &stats["parallel"];
        let count = parallel["ranks"].as_array().unwrap().len() as u64;
        // Finished pixels; before that, bins, or which tiles are drawn and what is composited; and what any two ranks tell each other
        // of how near they draw, and what they have finished.
        let messages = match parallel["organisation"].as_str() {
            Some("sort-first") => count - 1..=count - 1,
            Some("sort-middle") => (count + 1) * (count - 1)..=(count + 1) * (count - 1),
            _ => 2 * count + 1..=8 * count + (2 + 4) * count * (count - 1),
        };
        assert!(
            messages.contains(&parallel["messages"].as_u64().unwrap()),
            "{ranks}: {}",
            parallel["messages"]
        );
        assert_eq!(parallel["bytes"].as_u64().unwrap() > 0, count > 1);
        assert_eq!(stats["frame"]["backend"]["pixels_visible"], visible(parallel));
    }
    place.run(&format!("{model} -o a.png --organisation sort-last")).failed(2, &["--ranks"]);
    // All pixels: only where each is one sample, and nothing translucent.
    let dense = "--ranks 3 --organisation sort-last --encoding dense";
    place.run(&format!("{model} -o a.png {dense}")).failed(2, &["--encoding dense", "--aa 1"]);
    place
        .run(&format!("{model} -o a.png {dense} --aa 1 --opacity 0.5"))
        .failed(1, &["encoding of composited pixels", "not opaque", "dense"]);
    place.run(&format!("{model} -o a.png --aa 1")).ok_silently();
    for how in ["sort-last", "sort-last --composition ring", "sort-twice --group 2"] {
        let options = format!("--ranks 3 --organisation {how} --encoding dense");
        place.run(&format!("{model} -o b.png --aa 1 {options}")).ok_silently();
        assert!(place.read("a.png") == place.read("b.png"), "{options}");
    }
    for ranks in ["--ranks 0", "--ranks 1025", "--ranks many"] {
        place.run(&format!("{model} -o a.png {ranks}")).failed(2, &["expected 1 to 1024"]);
    }
    place.run(&format!("{model} -o a.png --ranks 256 --memory-limit 20M")).failed(1, &["--memory-limit"]);
}

/// Visible pixels of the owners after compositing.
fn visible(parallel: &serde_json::Value) -> u64 {
    let ranks = parallel["ranks"].as_array().unwrap();
    ranks.iter().map(|rank| rank["pixels"]["visible"].as_u64().unwrap()).sum()
}

/// The names of the steps of each rank in a trace, after checks of its form.
fn steps_of_ranks(trace: &[u8]) -> Vec<Vec<String>> {
    let trace: serde_json::Value = serde_json::from_slice(trace).expect("JSON");
    let mut ranks = Vec::new();
    for event in trace["traceEvents"].as_array().expect("events") {
        let rank = event["pid"].as_u64().expect("a rank") as usize;
        match event["ph"].as_str() {
            Some("M") => ranks.resize(rank + 1, Vec::new()),
            Some("X") => {
                let times = ["ts", "dur"].map(|key| event[key].as_f64().expect("microseconds"));
                assert!(times.iter().all(|&time| (0.0..600e6).contains(&time)), "{event}");
                ranks[rank].push(event["name"].as_str().expect("a name").to_string());
            }
            other => panic!("{other:?}"),
        }
    }
    ranks
}

#[test]
fn a_trace_shows_what_each_rank_did() {
    let place = Place::new();
    let draws = "render builtin:teapot@2k --size 90x60 --quiet";
    place.run(&format!("{draws} -o plain.png")).ok_silently();
    let traced = format!("{draws} -o a.png --ranks 3 --organisation sort-last --trace trace.json");
    place.run(&traced).ok_silently();
    assert!(place.read("plain.png") == place.read("a.png"));
    let ranks = steps_of_ranks(&place.read("trace.json"));
    assert_eq!(ranks.len(), 3);
    assert_eq!(ranks[0][0], "load");
    for (rank, steps) in ranks.iter().enumerate() {
        for step in ["front end", "draw", "composite", "collect", "wait"] {
            assert!(steps.iter().any(|found| found == step), "rank {rank}: {step} is not in {steps:?}");
        }
    }
    // Without ranks there is one, which draws twice for two eyes.
    place.run(&format!("{draws} -o a.png --stereo anaglyph --trace trace.json")).ok_silently();
    assert_eq!(steps_of_ranks(&place.read("trace.json")), [["load", "draw", "draw"]]);
    // An output like others.
    let same = format!("{draws} -o a.png --stats s.json --trace ./s.json");
    place.run(&same).failed(2, &["--trace", "the same file"]);
    place.run("render model.off -o a.png --trace model.off").failed(2, &["must not be an input"]);
    place.run(&format!("{draws} -o - --trace -")).failed(2, &["only one output can go to standard output"]);
    place.run(&format!("{draws} -o a.png --trace missing/t.json")).failed(1, &["missing"]);
    let before = place.names();
    place.run("render missing.off -o b.png --trace b.json").failed(1, &["missing.off"]);
    assert_eq!(place.names(), before, "a trace of nothing");
}
