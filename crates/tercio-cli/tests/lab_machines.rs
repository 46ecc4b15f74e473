//! `tercio lab machines`, `predict`, `advise` and `simulate hybris`.

mod common;

use common::Place;

#[test]
fn machines_are_listed_and_shown_with_their_sources() {
    let place = Place::new();
    let all = place.run("lab machines").ok_silently();
    assert!(all.text().contains("hybris-asic") && all.text().contains("cluster-64"), "{}", all.text());
    let one = place.run("lab machines princeton-engine").ok_silently();
    assert!(one.text().contains("14 MHz") && one.text().contains("000, 2.3"), "{}", one.text());
}

#[test]
fn mistakes_in_a_description_are_reported_with_line_and_column() {
    let place = Place::new();
    let text = place.run("lab machines hybris-asic").ok_silently().text().to_string();
    std::fs::write(place.path("mine.toml"), text.replace("27 MHz", "27 MB")).unwrap();
    place.run("lab machines mine.toml").failed(1, &["mine.toml:", "clock rate", "MB"]);
    std::fs::write(place.path("bytes.toml"), b"name = \"a\"\nsummary = \"\xff\"\n").unwrap();
    place.run("lab machines bytes.toml").failed(1, &["bytes.toml:2:12: expected text"]);
    place.run("lab machines no-such").failed(1, &["no-such", "princeton-engine"]);
}

#[test]
fn predictions_are_reproducible() {
    let place = Place::new();
    for command in [
        "lab predict model.off --size 64x64 --ranks 2",
        "lab predict model.off --size 64x64 --ranks 6 --organisation sort-twice --group 4 --machine server-128 --json",
        "lab advise model.off --size 64x64 --processors 16 --machine cluster-64 --network ring",
        "lab simulate hybris model.off --size 64x64 --machine hybris-asic-two-engines",
    ] {
        let once = place.run(command).ok_silently();
        let again = place.run(command).ok_silently();
        assert_eq!(once.text(), again.text(), "{command}");
        assert!(!once.text().is_empty());
    }
    place
        .run("lab predict model.off --machine voodoo-sli -O sort-last")
        .failed(1, &["missing in its description: costs.polygon or"]);
}

#[test]
fn advice_searches_threads_and_ranks_with_threads() {
    let place = Place::new();
    let advice =
        place.run("lab advise model.off --size 64x64 --processors 4 --machine server-128").ok_silently();
    let text = advice.text();
    assert!(text.contains("(1, 2, 3, 4 threads, tiles of 8 to 128 pixels)"), "{text}");
    assert!(text.contains("(ranks x threads 2 x 1, 2 x 2, 3 x 1, 4 x 1;"), "{text}");
    let shared = ["sort-first", "sort-middle", "sort-last", "sort-twice, groups of "];
    assert!(shared.iter().all(|how| text.lines().any(|line| line.starts_with(how))), "{text}");
    assert!(text.contains("residuals of its costs that are assumed (11.5 %)"), "{text}");
    assert!(text.contains("and what is assumed of the machine's numbers"), "{text}");
    place
        .run("lab advise model.off --size 64x64 --processors 3 --machine two-core-2026")
        .failed(1, &["expected at most 2 processors, found 3"]);
    // What is limited are processors, not ranks.
    place.run("lab advise model.off --size 64x64 --ranks 2").failed(2, &["unexpected argument '--ranks'"]);
}

#[test]
fn software_has_no_tile_engines_and_nothing_has_no_rate() {
    let place = Place::new();
    let software =
        place.run("lab simulate hybris model.off --size 64x64 --machine hybris-single-cpu").ok_silently();
    let text = software.text();
    assert!(
        text.contains("software:") && !text.contains("tile engines") && !text.contains("set-up span"),
        "{text}"
    );
    let one = place.run("lab simulate hybris model.off --size 1x1 --machine hybris-asic").ok_silently();
    assert!(!one.text().contains("inf"), "{}", one.text());
}

#[test]
fn a_description_with_absurd_numbers_is_refused() {
    let place = Place::new();
    let text = place.run("lab machines server-128").ok_silently().text().to_string();
    let absurd = text.replacen("value = \"128\"", "value = \"99999999999\"", 1);
    assert_ne!(text, absurd);
    std::fs::write(place.path("absurd.toml"), absurd).unwrap();
    place
        .run("lab predict model.off --size 16x16 --machine absurd.toml")
        .failed(1, &["absurd.toml:", "processors.count: expected at most 1048576, found 99999999999"]);
    let heaps = place.run("lab machines hybris-dual-cpu").ok_silently().text().to_string();
    let many = heaps.replace("[heap.heaps]\nvalue = \"2\"", "[heap.heaps]\nvalue = \"1000000\"");
    std::fs::write(place.path("heaps.toml"), many).unwrap();
    place
        .run("lab simulate hybris model.off --size 16x16 --machine heaps.toml")
        .failed(1, &["heaps.toml:", "heap.heaps: expected at most 64, found 1000000"]);
    // Work that costs nothing has no time.
    let costs = ["\"60 cycles\"", "\"394 cycles\"", "\"23 cycles\""];
    let free = costs.iter().fold(heaps, |text, cost| text.replace(cost, "\"0 cycles\""));
    std::fs::write(place.path("free.toml"), free).unwrap();
    place.run("lab predict model.off --size 16x16 --machine free.toml -n 1").failed(
        1,
        &["costs.polygon of more than 0 (found 0 cycles)", "costs.pixel of more than 0 (found 0 cycles)"],
    );
}

/// One more rank is never a step, and beyond those that are counted the parts that grow are named.
#[test]
fn predictions_have_no_steps_between_numbers_of_ranks() {
    let place = Place::new();
    let predict = |organisation: &str, ranks: u32, more: &str| {
        let model = "lab predict builtin:gyroid@6k --size 960x640 --machine cluster-64";
        place.run(&format!("{model} -O {organisation} -n {ranks} {more}")).ok_silently()
    };
    for organisation in ["sort-first", "sort-last"] {
        let frame = |ranks| -> (String, f64) {
            let json: serde_json::Value =
                serde_json::from_str(predict(organisation, ranks, "--json").text()).unwrap();
            (json["model"].as_str().unwrap().into(), json["total_seconds"].as_f64().unwrap())
        };
        for ranks in [256, 1024] {
            let ((model, fewer), (next_model, more)) = (frame(ranks), frame(ranks + 1));
            let next = if ranks == 1024 { "extrapolated" } else { "renderer" };
            assert_eq!((model.as_str(), next_model.as_str()), ("renderer", next), "{organisation}");
            assert!((more / fewer - 1.0).abs() < 0.1, "{organisation}, {ranks}: {fewer} and {more}");
        }
    }
    let text = predict("sort-first", 4096, "");
    assert!(
        text.text().contains("\nparts that grow with the number of ranks: messages\n"),
        "{}",
        text.text()
    );
    let simulated = predict("sort-last", 4096, "--simulate");
    assert!(simulated.text().contains("by the simulator of the sorting classes: as requested"));
}

/// One rule for all organisations.
#[test]
fn ranks_share_processors_only_if_that_is_asked_for() {
    let place = Place::new();
    let predict = |more: &str| place.run(&format!("lab predict model.off --size 64x64 {more}"));
    for organisation in ["sort-first", "sort-middle", "sort-last", "sort-twice"] {
        for (machine, most) in [("two-core-2026", 2), ("server-128", 128)] {
            let ranks = most + 1;
            predict(&format!("--machine {machine} -O {organisation} -n {ranks}"))
                .failed(1, &[&format!("expected at most {most} processors, found {ranks}")]);
        }
        predict(&format!("-O {organisation} -n 2")).ok_silently();
    }
    predict("-O sort-last -n 256").failed(1, &["found 256; with --share-processors ranks share them"]);
    let shared = predict("-O sort-last -n 3 --share-processors").ok_silently();
    assert!(shared.text().starts_with("3 ranks that share 2 processors, sort-last"), "{}", shared.text());
    let own = predict("-O sort-last -n 2 --share-processors").ok_silently();
    assert!(own.text().starts_with("2 ranks, sort-last"), "{}", own.text());
    predict("-O sort-middle -n 3 --share-processors")
        .failed(1, &["the simulator gives each rank a processor (of the renderer's", "found 3"]);
    predict("-n 2 --share-processors").failed(2, &["--share-processors is for ranks"]);
    // Nodes have no processors to share, however many ranks there are.
    for ranks in [2, 9000] {
        let command = format!(
            "lab predict model.off --size 64x64 --machine cluster-64 -O sort-last -n {ranks} --share-processors"
        );
        place
            .run(&command)
            .failed(2, &["is for a machine without nodes, found", "whose nodes have 128 processors"]);
    }
    let one = predict("-n 1").ok_silently();
    assert!(one.text().starts_with("1 thread\n"), "{}", one.text());
}

#[test]
fn costs_that_a_description_lacks_are_named() {
    let place = Place::new();
    for command in ["predict builtin:soup@3k --size 64x64 -n 1", "advise builtin:soup@3k --size 64x64 -n 1"] {
        let said = place.run(&format!("lab {command}"));
        assert_eq!((said.code, said.stderr.lines().count()), (Some(0), 1), "{}", said.stderr);
        let parts = [
            "warning: Two cores of 2026: no costs of work in this picture, hidden-stamp (",
            " times)",
            "by 25 to 43 %",
        ];
        assert!(parts.iter().all(|part| said.stderr.contains(part)), "{}", said.stderr);
        place.run(&format!("lab {command} --quiet")).ok_silently();
    }
    place.run("lab predict builtin:sphere@1k --size 64x64 -n 1").ok_silently();
}

#[test]
fn predictions_by_a_doubtful_measurement_say_so() {
    let place = Place::new();
    let text = place.run("lab machines two-core-2026").ok_silently().text().to_string();
    let share = |key: &str| format!("{key} = {{ value = \"5 %\", source = \"x\" }}\n");
    let measured = format!(
        "{text}\n[calibration]\ndate = \"2026-01-01\"\nprocessor = \"x\"\nversion = \"0\"\n\
         frames = {{ value = \"9\", source = \"x\" }}\n{}",
        ["residual", "worst-residual", "spread"].map(share).concat()
    );
    std::fs::write(place.path("quiet.toml"), &measured).unwrap();
    std::fs::write(place.path("noisy.toml"), format!("{measured}doubt = \"the serial share is 23.0 %\"\n"))
        .unwrap();
    for command in ["predict model.off --size 16x16", "advise model.off --size 16x16 --processors 2"] {
        place.run(&format!("lab {command} --machine quiet.toml")).ok_silently();
        place.run(&format!("lab {command} --machine noisy.toml --quiet")).ok_silently();
        let said = place.run(&format!("lab {command} --machine noisy.toml"));
        assert_eq!((said.code, said.stderr.lines().count()), (Some(0), 1), "{}", said.stderr);
        assert!(
            said.stderr.starts_with("warning: noisy.toml: its measurement is doubtful"),
            "{}",
            said.stderr
        );
        assert!(said.stderr.contains("the serial share is 23.0 %"), "{}", said.stderr);
    }
}

/// What is between the fences of a language, without the indentation of a list.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = page.lines().map(str::trim);
    while lines.any(|line| line == format!("```{language}")) {
        let block = lines.by_ref().take_while(|line| *line != "```").map(|line| format!("{line}\n"));
        blocks.push(block.collect());
    }
    blocks
}

#[test]
fn the_commands_of_the_handbook_run_and_its_numbers_hold() {
    let page = tercio_testkit::workspace_root().join("docs/laboratory/handbook.md");
    let page = std::fs::read_to_string(page).unwrap();
    let place = Place::new();
    std::fs::write(place.path("chip.toml"), &blocks(&page, "toml")[0]).unwrap();
    let commands: Vec<String> =
        blocks(&page, "sh").iter().flat_map(|b| b.lines().map(str::to_owned)).collect();
    assert_eq!(commands.len(), 11);
    let run = |command: &String| {
        let done = place.run(command.strip_prefix("tercio ").expect("a command of tercio"));
        (command.clone(), done.ok_silently().text().to_string())
    };
    let outputs: Vec<_> = commands.iter().map(run).collect();
    let output = |part: &str| &outputs.iter().find(|o| o.0.contains(part)).expect("a command").1;
    let boxes = std::fs::read_to_string(place.path("teapot.boxes")).unwrap();
    let visible = boxes.lines().filter(|line| line.starts_with("1 ")).count();
    assert!(boxes.starts_with("NumPolygons=9888\n") && visible == 4893, "{visible} visible");
    // The busiest processor takes longer than the mean, by a little.
    let row = output("simulate sorting").lines().find(|line| line.starts_with("sort-middle")).unwrap();
    let geometry: f64 = row.split_whitespace().nth(4).unwrap().parse().unwrap();
    assert!((0.0986..0.0986 * 1.05).contains(&geometry), "{row}");
    let formula: f64 = output("mcmanus.6 A=16").trim().parse().unwrap();
    assert!((formula - 1.545).abs() < 0.001, "{formula}");
    let predicted = output("lab predict");
    let after = |text: &str| -> f64 {
        let rest = predicted.split_once(text).expect("a line of the prediction").1;
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let memory = after("fullest rank: ") / 65536.0;
    assert!(after(", rasterization ") > 4.0, "{predicted}");
    assert!((4.5..5.5).contains(&memory), "{memory}");
    assert!(output("simulate mcmanus").contains(" 1.53 "));
    let scenes = ["figures/mcmanus-table-1/verdict.json", "figures/mcmanus-table-1-scenes/verdict.json"];
    assert!(scenes.iter().all(|file| place.path(file).is_file()));
}
