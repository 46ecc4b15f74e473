//! Processes that mpirun started draw one picture. Ranks share the processors of the machine, however few it has.

mod common;
#[path = "mpi/errors.rs"]
mod errors;
#[path = "mpi/shares.rs"]
mod shares;

use std::process::{Command, Stdio};
use std::sync::OnceLock;

use common::{Outcome, Place};

/// Seconds after which a job is considered to hang.
const HANGS: &str = "600";

/// A job of one or more `N ARGUMENTS`, also as root.
fn command(place: &Place, processes: &[(usize, &str)]) -> Command {
    let mut command = Command::new("timeout");
    command.current_dir(place.path("")).stdin(Stdio::null());
    command.args(["--kill-after=10", HANGS, "mpirun", "--oversubscribe"]);
    for (number, (count, arguments)) in processes.iter().enumerate() {
        command.args((number > 0).then_some(":")).arg("-n").arg(count.to_string());
        command.arg(env!("CARGO_BIN_EXE_tercio")).args(arguments.split_whitespace());
    }
    command
        .env("TERCIO_CONFIG", "none")
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command
}

/// Runs such a job.
fn mpirun(place: &Place, processes: &[(usize, &str)]) -> Outcome {
    command(place, processes).output().expect("timeout and mpirun start").into()
}

#[test]
fn the_picture_does_not_depend_on_processes() {
    let place = Place::new();
    let model = "render builtin:teapot@5k --size 200x150 --threads 1";
    let outputs =
        |name: &str| format!("-o {name}.png --output-depth {name}.depth.npy --output-ids {name}.ids.npy");
    place.run(&format!("{model} {}", outputs("alone"))).ok_silently();
    for organisation in ["sort-first", "sort-middle", "sort-last", "sort-twice"] {
        for count in [1, 2, 4] {
            let arguments = format!("{model} {} --organisation {organisation} --stats -", outputs("ranks"));
            let outcome = mpirun(&place, &[(count, &arguments)]).ok_silently();
            for file in ["png", "depth.npy", "ids.npy"] {
                let [alone, ranks] = ["alone", "ranks"].map(|name| place.read(&format!("{name}.{file}")));
                assert!(alone == ranks, "{organisation}, {count} processes: {file}");
                std::fs::remove_file(place.path(&format!("ranks.{file}"))).unwrap();
            }
            // Rank 0 alone writes, with the counts of all ranks.
            let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
            let (parallel, n) = (&stats["parallel"], count as u64);
            let ranks = parallel["ranks"].as_array().unwrap();
            assert_eq!((parallel["organisation"].as_str(), ranks.len()), (Some(organisation), count));
            let messages = match organisation {
                "sort-first" => n - 1..=n - 1,
                "sort-middle" => n * n - 1..=n * n - 1,
                // At most which tiles are touched, one message to each other rank, and finished pixels; and what any two ranks tell
                // each other of how near they draw, and what they have finished.
                _ => n - 1..=n * n + 2 * n + (2 + 4) * n * (n - 1),
            };
            assert!(
                messages.contains(&parallel["messages"].as_u64().unwrap()),
                "{organisation}, {n}: {parallel}"
            );
            let visible: u64 = ranks.iter().map(|r| r["pixels"]["visible"].as_u64().unwrap()).sum();
            assert_eq!(stats["frame"]["backend"]["pixels_visible"], visible);
            assert_eq!(stats["frame"]["threads"], n);
        }
    }
}

#[test]
fn processes_choose_together() {
    let place = Place::new();
    let model = "render builtin:teapot@5k --size 200x150 --threads 1";
    place.run(&format!("{model} -o alone.png")).ok_silently();
    for count in [1, 2, 4] {
        let arguments = format!("{model} -o ranks.png --organisation auto --stats -");
        let outcome = mpirun(&place, &[(count, &arguments)]).ok_silently();
        assert!(place.read("alone.png") == place.read("ranks.png"), "{count} processes");
        let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
        let choice = &stats["choice"];
        assert_eq!(choice["candidates"][0]["organisation"], stats["parallel"]["organisation"]);
        // Alone there is nobody to send a message to.
        assert_eq!(choice["network"]["measured_here"], count > 1, "{choice}");
        assert_eq!(choice["network"]["bandwidth"].as_f64().is_some_and(|bytes| bytes > 1e5), count > 1);
    }
    // One process was started with an organisation.
    let of = |organisation: &str| format!("{model} -o other.png --quiet --organisation {organisation}");
    for how in [["auto", "sort-middle"], ["sort-middle", "auto"], ["auto", "auto --division rows"]] {
        let [first, second] = how.map(of);
        let outcome = mpirun(&place, &[(1, &first), (1, &second)]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        let errors = outcome.stderr.lines().filter(|line| line.starts_with("error: "));
        let errors: Vec<&str> = errors.collect();
        assert!(errors.len() == 1 && errors[0].contains("another organisation"), "{}", outcome.stderr);
    }
}

#[test]
fn a_process_that_fails_ends_the_job() {
    let place = Place::new();
    let draws = |model: &str| format!("render {model} -o a.png --quiet");
    let outcome = mpirun(&place, &[(2, &draws("model.off")), (1, &draws("missing.off"))]);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    let line = outcome.stderr.lines().find(|l| l.starts_with("error: ")).unwrap_or_default();
    assert!(line.contains("rank 2: ") && line.contains("missing.off"), "{}", outcome.stderr);
    assert_eq!(place.names(), ["model.off"], "a picture is there though a part of it is missing");
}

/// Rank 1 reads a pipe into which nobody writes.
#[test]
#[cfg(unix)]
fn a_silent_rank_is_named_and_ends_the_job_on_request() {
    let place = Place::new();
    let made = Command::new("mkfifo").arg(place.path("pipe.off")).status();
    assert!(made.expect("mkfifo starts").success());
    let draws = |model: &str| format!("render {model} -o a.png --quiet --timeout 2.5");
    let outcome = mpirun(&place, &[(1, &draws("model.off")), (1, &draws("pipe.off"))]);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    let line = outcome.stderr.lines().find(|line| line.starts_with("error: ")).unwrap_or_default();
    assert!(
        line.contains("rank 0: ") && line.contains("rank 1 has been silent for 2 s"),
        "{}",
        outcome.stderr
    );
    assert!(!place.names().contains(&"a.png".to_string()), "a picture");
}

/// The process of a rank among the descendants of mpirun's process: the environment of each process of a job has its rank.
#[cfg(target_os = "linux")]
fn process_of(rank: usize, of: u32) -> Option<u32> {
    let children = |id: u32| {
        let threads = std::fs::read_dir(format!("/proc/{id}/task")).into_iter().flatten().flatten();
        let of_thread = |thread: std::fs::DirEntry| std::fs::read_to_string(thread.path().join("children"));
        let text: String = threads.map(|thread| of_thread(thread).unwrap_or_default() + " ").collect();
        text.split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<u32>>()
    };
    let variable = format!("OMPI_COMM_WORLD_RANK={rank}");
    let mut open = children(of);
    while let Some(id) = open.pop() {
        let environment = std::fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        if environment.split(|&byte| byte == 0).any(|entry| entry == variable.as_bytes()) {
            return Some(id);
        }
        open.extend(children(id));
    }
    None
}

#[test]
fn processes_send_all_pixels() {
    let place = Place::new();
    let model = "render builtin:teapot@5k --size 200x150 --threads 1 --aa 1";
    place.run(&format!("{model} -o a.png --quiet")).ok_silently();
    let dense = format!("{model} -o b.png --quiet --organisation sort-last --encoding dense");
    mpirun(&place, &[(3, &dense)]).ok_silently();
    assert!(place.read("a.png") == place.read("b.png"));
    // Compared before anything is drawn.
    let sparse = dense.replace("dense", "sparse");
    let outcome = mpirun(&place, &[(1, &dense), (1, &sparse)]);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("rank 1 would"), "{}", outcome.stderr);
}

/// A process is stopped, or killed, while the job draws a series.
#[test]
#[cfg(target_os = "linux")]
fn a_process_that_is_stopped_or_killed_ends_the_job() {
    // With three processes, one that is itself waiting for the stopped one may be named.
    for (signal, rank, count) in [("-STOP", 1, 2), ("-KILL", 1, 3), ("-KILL", 0, 3)] {
        let place = Place::new();
        let draws = "render builtin:teapot@2k --size 60x40 --turntable 9999 -o {}.png --quiet --timeout 2.5";
        let mut job = command(&place, &[(count, draws)]);
        let mut job = job.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("mpirun starts");
        let pictures =
            || -> Vec<String> { place.names().into_iter().filter(|name| name.ends_with(".png")).collect() };
        let id = loop {
            if pictures().len() > 2
                && let Some(id) = process_of(rank, job.id())
            {
                break id;
            }
            let has_ended = job.try_wait().expect("a state").is_some();
            assert!(!has_ended, "no process of rank {rank} was found before the job ended");
            std::thread::sleep(std::time::Duration::from_millis(50));
        };
        assert!(Command::new("kill").args([signal, &id.to_string()]).status().expect("kill").success());
        let outcome: Outcome = job.wait_with_output().expect("the job ends").into();
        let what = format!("{signal} of rank {rank}: {}", outcome.stderr);
        assert!(outcome.code.is_some_and(|code| code != 0 && code != 124), "{what}");
        if signal == "-STOP" {
            assert!(outcome.stderr.contains("rank 1 has been silent for"), "{what}");
        }
        // What has the name of a picture is whole. Who is killed cannot remove what it has begun to write.
        let pictures = pictures();
        assert!(pictures.len() < 9999, "{what}");
        for name in &pictures {
            assert!(place.read(name).ends_with(b"IEND\xae\x42\x60\x82"), "{name}, {what}");
        }
        let others = place.names().into_iter().filter(|name| !pictures.contains(name) && name != "model.off");
        let others: Vec<String> = others.collect();
        let may_remain = usize::from((signal, rank) == ("-KILL", 0));
        assert!(
            others.len() <= may_remain && others.iter().all(|name| name.ends_with(".part")),
            "{others:?}"
        );
    }
}

#[test]
fn a_picture_goes_through_mpirun() {
    let place = Place::new();
    place.run("render builtin:teapot@2k --size 60x40 -o alone.png").ok_silently();
    let outcome = mpirun(&place, &[(2, "render builtin:teapot@2k --size 60x40 -o - --quiet")]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout == place.read("alone.png"), "{} bytes", outcome.stdout.len());
}

#[test]
fn commands_that_are_no_job_say_so_once() {
    let place = Place::new();
    for command in ["prepare model.off -o a.tercio", "info model.off", "lab check"] {
        let outcome = mpirun(&place, &[(3, command)]);
        assert_ne!(outcome.code, Some(0), "{command}");
        let lines = outcome.stderr.lines().filter(|line| line.contains("this command is not run by several"));
        assert_eq!(lines.count(), 1, "{}", outcome.stderr);
    }
    assert_eq!(place.names(), ["model.off"]);
}

#[test]
fn processes_that_would_draw_different_pictures_end_the_job() {
    let place = Place::new();
    let draws = |model: &str, options: &str| format!("render {model} -o a.png --quiet {options}");
    for (other, says) in [
        (draws("builtin:teapot@1k", ""), "rank 2 would draw another model"),
        (draws("model.off", "--size 90x90"), "rank 2 would draw a picture of another size"),
        (draws("model.off", "--azimuth 10"), "rank 2 would draw another camera"),
        (draws("model.off", "--color #ff0000"), "rank 2 would draw a scene with other"),
    ] {
        let outcome = mpirun(&place, &[(2, &draws("model.off", "")), (1, &other)]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        let lines: Vec<&str> = outcome.stderr.lines().filter(|l| l.starts_with("error: ")).collect();
        assert!(matches!(lines[..], [line] if line.contains(says)), "{says}: {}", outcome.stderr);
        assert_eq!(place.names(), ["model.off"], "a picture is there: {other}");
    }
}

#[test]
fn what_cannot_be_drawn_by_these_processes_is_wrong_usage() {
    let place = Place::new();
    for (arguments, says) in [
        ("render model.off -o a.png --ranks 3", "mpirun started 2 processes"),
        ("render - -o a.png", "standard input"),
        ("render model.off -o ./model.off --format png", "an output must not be an input"),
        ("render model.off --output-ids a.npy --output-depth ./a.npy", "the same file"),
    ] {
        let outcome = mpirun(&place, &[(2, arguments)]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    }
}

/// A place with a description of this machine, `m.toml`, which is measured once for all tests that need it. Other tests run
/// meanwhile, so its measurement may be doubtful, which commands say unless they are to be quiet.
fn calibrated() -> Place {
    static DESCRIPTION: OnceLock<Vec<u8>> = OnceLock::new();
    let place = Place::new();
    let description = DESCRIPTION.get_or_init(|| {
        // The third process has nothing to measure, and only rank 0 writes.
        let calibrate = "lab calibrate --frames 1 --rounds 2 --repeats 0 --accept-noise -o m.toml --quiet";
        let measured = || {
            let outcome = mpirun(&place, &[(3, calibrate)]).ok_silently();
            assert_eq!(outcome.text(), "");
            place.read("m.toml")
        };
        // From few frames beside other tests no cost of triangles and clusters may be found, without which nothing is predicted.
        let has_costs = |description: &Vec<u8>| {
            let text = String::from_utf8_lossy(description);
            text.lines().any(|line| matches!(line, "[costs.polygon]" | "[costs.cluster-drawn]"))
        };
        (0..3).map(|_| measured()).find(has_costs).expect("costs of triangles or clusters")
    });
    std::fs::write(place.path("m.toml"), description).unwrap();
    place
}

#[test]
fn messages_over_mpi_are_measured_and_predicted_with() {
    let place = calibrated();
    let described = |what: &str| -> serde_json::Value {
        serde_json::from_str(place.run(&format!("lab {what} --json")).ok_silently().text()).unwrap()
    };
    let machine = described("machines m.toml");
    // Those of the whole machine: the other processes have ended when threads are measured.
    let processors = std::thread::available_parallelism().map_or(1, |all| all.get().min(256));
    assert_eq!(machine["processors"]["count"]["value"], processors.to_string());
    for (section, says) in [("network", "two threads"), ("mpi", "ranks 0 and 1 on one machine")] {
        for (key, unit) in [("message", " us"), ("bandwidth", " GB/s")] {
            let number = &machine[section][key];
            let (value, source) = (number["value"].as_str().unwrap(), number["source"].as_str().unwrap());
            let value: f64 = value.strip_suffix(unit).unwrap_or_else(|| panic!("{value}")).parse().unwrap();
            assert!(value > 0.0 && source.contains(says), "{section}.{key}: {number}");
        }
    }
    // Predictions of ranks use the requested network, and nothing else differs if a cache holds all pictures and messages.
    // Otherwise messages that are copied leave less of it to the keys, which are part of drawing.
    let text = String::from_utf8(place.read("m.toml")).unwrap();
    let (before, after) = text.split_once("[processors.exchange-cache]\n").expect("a cache of ranks");
    let (_, after) = after.split_once('\n').unwrap();
    let held = format!("{before}[processors.exchange-cache]\nvalue = \"1000 GB\"\n{after}");
    std::fs::write(place.path("held.toml"), held).unwrap();
    let predicted = |options: &str| {
        let of = format!(
            "predict model.off --size 512x512 -n 2 -O sort-last --machine held.toml --quiet {options}"
        );
        let frame = described(&of);
        let of_rank = |what: &str| frame["prediction"]["ranks"][0][what].as_f64().unwrap();
        (frame["prediction"]["carrier"].clone(), of_rank("message"), of_rank("draw"))
    };
    let [threads, processes] = ["", "--mpi"].map(predicted);
    assert_eq!([&threads.0, &processes.0], ["threads", "processes"]);
    assert!(threads.1 > 0.0 && processes.1 > 0.0 && threads.1 != processes.1, "{threads:?} {processes:?}");
    // The drawing time is summed over other time slices, so the sums may differ by rounding.
    assert!((threads.2 / processes.2 - 1.0).abs() < 1e-9, "{threads:?} {processes:?}");
    place.run("lab predict model.off --mpi").failed(1, &["mpi"]);
}

#[test]
fn processes_count_and_send_what_is_predicted() {
    let place = calibrated();
    let validate = "lab validate builtin:gyroid@3k model.off --machine m.toml --sizes 120x90,64x64 --views 2 \
                    --frames 2 --rounds 2 -o rows.toml --json --threads 1";
    for count in [2, 3] {
        let outcome = mpirun(&place, &[(count, validate)]);
        // Times of such small frames need not hold; everything else must.
        assert!(matches!(outcome.code, Some(0 | 1)), "{}", outcome.stderr);
        let rows: serde_json::Value =
            serde_json::from_str(outcome.text()).unwrap_or_else(|e| panic!("{e}: {}", outcome.stderr));
        let rows = rows.as_array().unwrap();
        assert_eq!(rows.len(), 2 * 2 * 2, "models, sizes, organisations");
        for row in rows.iter().map(|r| &r["row"]) {
            assert_eq!(row["ranks"], count as u64);
            assert_eq!(row["differing"], serde_json::json!([]), "{row}");
            // 6 counters of the exchange and 22 of the renderer, 4 frames of each view, every rank.
            assert_eq!(row["compared"], 2 * 4 * 28 * count as u64);
            let frame = row["measured"]["frame"].as_f64().unwrap();
            assert!(frame > 0.0 && frame.is_finite(), "{row}");
        }
        let last = rows.iter().map(|r| &r["row"]).filter(|row| row["organisation"] == "sort-last");
        assert!(last.clone().all(|row| row["bytes"].as_u64() > Some(0)));
        // Rank 0 alone writes the table, and it has the rows of both jobs.
        let kept = String::from_utf8(place.read("rows.toml")).unwrap();
        assert_eq!(kept.matches("[[rows]]").count(), 8 * (count - 1), "{kept}");
        assert!(
            kept.contains(&format!("mpirun -n {count} --bind-to none tercio lab validate builtin:gyroid@3k"))
        );
    }
    let outcome = mpirun(&place, &[(2, "lab validate model.off --machine m.toml --ranks 1,2")]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("mpirun started 2 processes"), "{}", outcome.stderr);
    place
        .run("lab validate model.off --machine two-core-2026 --organisation sort-last")
        .failed(2, &["--ranks"]);
}

/// A binary PLY file of a height field with a fold, `n` by `n` points; the quads of some rows only.
fn field(n: u32, rows: std::ops::Range<u32>) -> Vec<u8> {
    let (first, last) = (rows.start, rows.end + 1);
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        (last - first) * n,
        rows.len() as u32 * (n - 1)
    )
    .into_bytes();
    for y in first..last {
        for x in 0..n {
            let (u, v) = (x as f32 / n as f32, y as f32 / n as f32);
            let height = if u < v { (u - v) * 0.5 } else { (u * 9.0) * (v * 7.0) * 0.004 };
            out.extend([u, v, height].iter().flat_map(|c| c.to_le_bytes()));
        }
    }
    for y in 0..rows.len() as u32 {
        for x in 0..n - 1 {
            let v = y * n + x;
            out.push(4);
            out.extend([v, v + 1, v + n + 1, v + n].iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    out
}

#[test]
fn processes_with_parts_of_a_model_draw_the_whole() {
    let place = Place::new();
    const N: u32 = 90;
    std::fs::write(place.path("whole.ply"), field(N, 0..N - 1)).unwrap();
    place.run("prepare whole.ply -o whole.tercio").ok_silently();
    let look = "--size 160x120 --threads 1 --shadows --aa 4";
    let outputs =
        |name: &str| format!("-o {name}.png --output-ids {name}.ids.npy --output-normals {name}.n.npy");
    place.run(&format!("render whole.ply {look} {}", outputs("alone"))).ok_silently();
    let compare = |model: &str, count: usize, options: &str| {
        let arguments = format!("render {model} {look} {} --parts {options}", outputs("ranks"));
        mpirun(&place, &[(count, &arguments)]).ok_silently();
        for file in ["png", "ids.npy", "n.npy"] {
            let [alone, ranks] = ["alone", "ranks"].map(|name| place.read(&format!("{name}.{file}")));
            assert!(alone == ranks, "{model}, {count} processes, {options}: {file}");
            std::fs::remove_file(place.path(&format!("ranks.{file}"))).unwrap();
        }
    };
    for options in
        ["", "--organisation sort-middle", "--organisation sort-first", "--organisation sort-twice --group 2"]
    {
        compare("whole.ply", 3, options);
        compare("whole.tercio", 3, options);
    }
    compare("whole.ply", 1, "");
    // The box of a turned model is that of all vertices.
    let boxed = "--rotate 20,0,30 --bounds --size 160x120 --threads 1 -q -o";
    place.run(&format!("render whole.ply {boxed} alone_box.png")).ok_silently();
    mpirun(&place, &[(3, &format!("render whole.ply {boxed} ranks_box.png --parts"))]).ok_silently();
    assert!(place.read("alone_box.png") == place.read("ranks_box.png"));
    // Files of their own: those at a seam have vertices at the same places.
    for rank in 0..3 {
        let rows = (N - 1) * rank / 3..(N - 1) * (rank + 1) / 3;
        std::fs::write(place.path(&format!("part_{rank}.ply")), field(N, rows)).unwrap();
    }
    // One model of these would have more vertices, but the same triangles.
    compare("part_{rank}.ply", 3, "--opacity 1");

    let wrong = mpirun(&place, &[(2, "render model.off -o a.png --quiet --parts")]);
    assert_eq!(wrong.code, Some(1), "{}", wrong.stderr);
    assert!(wrong.stderr.contains("an OFF file in parts"), "{}", wrong.stderr);
    let own = mpirun(&place, &[(2, "render part_{rank}.ply -o part_1.ply --quiet --parts")]);
    assert!(own.code != Some(0) && own.stderr.contains("part_1.ply"), "{}", own.stderr);
    assert!(place.read("part_1.ply").starts_with(b"ply"), "the model is still there");
}
