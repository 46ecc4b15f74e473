//! `tercio lab workload` and `tercio lab simulate`.

mod common;

use common::Place;

#[test]
fn a_model_becomes_a_workload_for_every_machine() {
    let place = Place::new();
    place.run("lab workload model.off --size 64x64 -o model.boxes").ok_silently();
    place.run("lab workload model.off --size 64x64 -o model.polygons").ok_silently();
    let boxes = String::from_utf8(place.read("model.boxes")).unwrap();
    assert!(boxes.starts_with("NumPolygons=8\n"), "{boxes}");
    // Half of an octahedron's triangles show their front.
    assert_eq!(boxes.lines().filter(|l| l.starts_with("1 ")).count(), 4, "{boxes}");

    let ring = place.run("lab simulate ring model.boxes --size 64x64 --processors 64").ok_silently();
    assert!(
        ring.text().contains("8 polygons, 4 visible")
            && ring.text().contains("checks: 0 missing, 0 unneeded, 0 repeated")
    );
    let parks = place.run("lab simulate parks model.polygons").ok_silently();
    assert!(
        parks.text().contains("4 polygons, 64x64 pixels") && parks.text().contains("hybrid-16"),
        "{}",
        parks.text()
    );
    let mcmanus = place.run("lab simulate mcmanus model.polygons --regions 1,64").ok_silently();
    assert!(mcmanus.text().contains("64x64            4     1.00"), "{}", mcmanus.text());
    let ortega = place.run("lab simulate ortega model.polygons --processors 4").ok_silently();
    assert!(ortega.text().contains("4 processors"), "{}", ortega.text());
}

#[test]
fn the_runway_of_document_002() {
    let place = Place::new();
    place.run("lab workload parks:figure-15 -o runway.polygons").ok_silently();
    let all = place.run("lab simulate parks runway.polygons").ok_silently();
    assert!(
        all.text().contains("248 polygons, 731 vertices, 1411 segments (1411 charged), 251224 pixels"),
        "{}",
        all.text()
    );
    let one = place.run("lab simulate parks runway.polygons --chunks 4 --processor 1").ok_silently();
    assert!(one.text().contains("total scene time 731408.4"), "{}", one.text());
}

#[test]
fn random_scenes_are_reproducible() {
    let place = Place::new();
    let command = "lab workload random:500 --size 768x512 --box 3.8x12 --deviation 30 --visible 0.67";
    for name in ["a.boxes", "b.boxes"] {
        place.run(&format!("{command} -o {name}")).ok_silently();
    }
    assert_eq!(place.read("a.boxes"), place.read("b.boxes"));
    let json = place.run("lab simulate ring a.boxes --strides 16,1 --json").ok_silently();
    assert!(json.text().contains("\"communication_instructions\""), "{}", json.text());
}

#[test]
fn boxes_are_sorted_on_any_machine_in_sweeps() {
    let place = Place::new();
    // Four regions of 8x8 pixels on four processors: polygon 0 lies in all of them, polygon 1 in the last.
    let boxes = "NumPolygons=3\n1 (6,6) (9,9)\n1 (12,12) (12,12)\n0 (1,1) (2,2)\n";
    std::fs::write(place.path("two.boxes"), boxes).unwrap();
    let command = "lab simulate sorting two.boxes --size 16x16 --machine server-128 --processors 4 -O sort-middle,sort-last --json";
    let value: serde_json::Value = serde_json::from_str(place.run(command).ok_silently().text()).unwrap();
    let runs = value["runs"].as_array().unwrap();
    assert_eq!((value["machine"].as_str(), runs.len()), (Some("A server of 128 cores"), 2));
    let (middle, last) = (&runs[0], &runs[1]);
    assert_eq!(middle["report"]["overlap"], 2.5);
    assert_eq!(middle["report"]["redistribution"]["messages"], 4);
    assert_eq!(
        (last["report"]["overlap"].as_f64(), last["setting"]["processors"].as_u64()),
        (Some(1.0), Some(4))
    );
    assert_eq!(last["report"]["redistribution"]["messages"], 0);
    for run in runs {
        let phases = ["geometry", "raster"].map(|p| run["report"][p]["seconds"].as_f64().unwrap());
        let sent = ["redistribution_seconds", "composition_seconds", "delivery_seconds"]
            .map(|p| run["report"][p].as_f64().unwrap());
        let sum = phases.iter().chain(&sent).sum::<f64>();
        assert!((run["total_seconds"].as_f64().unwrap() / sum - 1.0).abs() < 1e-12, "{run}");
    }

    place.run("lab workload random:2000 --size 256x256 --box 9x9 -o made.boxes").ok_silently();
    let sweep = "lab simulate sorting made.boxes --size 256x256 --machine cluster-64 --network mesh \
        --processors 16,64 --group 2,8 --region 8,32 --assignment interleaved,blocks";
    let one = place.run(&format!("{sweep} --threads 1")).ok_silently();
    let four = place.run(&format!("{sweep} --threads 4")).ok_silently();
    assert_eq!(one.text(), four.text());
    // Which costs a fit leaves out may change with the description; tercio's machines have no costs of polygons,
    // which take their share of a cluster.
    let last = one.text().lines().last().unwrap_or_default();
    assert!(last.ends_with("charges nothing for polygon-set-up"), "{last}");
    let unbatched = place.run(&format!("{sweep} --unbatched")).ok_silently();
    assert_ne!(one.text(), unbatched.text());
    // Lines for machine, columns and uncharged work; four settings of the regions except for sort-last.
    assert_eq!(one.text().lines().count(), 3 + 2 * (4 * (1 + 1 + 2) + 1), "{}", one.text());
}

#[test]
fn mistakes_are_reported() {
    let place = Place::new();
    let write = |name, text| std::fs::write(place.path(name), text).unwrap();
    write("bad.boxes", "NumPolygons=1\n1 (3,4) (2,9)\n");
    write("bad.map", "0 (0, 0) (9, 9)\n1 (5, 0) (19, 9)\n");
    write("good.boxes", "NumPolygons=1\n1 (3,4) (3,9)\n");
    place.run("lab simulate ring bad.boxes").failed(1, &["bad.boxes: line 2: expected a last pixel"]);
    place
        .run("lab simulate ring good.boxes --map bad.map")
        .failed(1, &["bad.map: line 2: expected every pixel"]);
    place.run("lab simulate ring good.boxes --strides 4").failed(1, &["expected strides that fall"]);
    place
        .run("lab simulate ring good.boxes --duplication 3")
        .failed(1, &["duplication that divides the 1024 processors"]);
    let sorting = |more: &str| place.run(&format!("lab simulate sorting {more}"));
    sorting("bad.boxes").failed(1, &["bad.boxes: line 2: expected a last pixel"]);
    sorting("good.boxes --machine sgi-gtx").failed(
        1,
        &["machine \"Silicon Graphics GTX\": needed here, and missing in its description: network, "],
    );
    for machine in ["pomegranate", "voodoo-sli", "cm-200", "mcmanus-array"] {
        sorting(&format!("good.boxes --machine {machine}"))
            .failed(1, &["costs.pixel, costs.composite-pixel"]);
    }
    sorting("good.boxes --processors 4096").failed(1, &["expected at most 2048 processors, found 4096"]);
    // The usual group divides the ring, so that it takes no other class down with it.
    let usual = sorting("good.boxes --processors 20").ok_silently();
    let classes = ["sort-first ", "sort-middle ", "sort-last ", "sort-twice 10 "];
    let has = |class: &&str| usual.text().lines().any(|line| line.starts_with(*class));
    assert!(classes.iter().all(has), "{}", usual.text());
    // 17 has no divisor but itself and one.
    let alone = sorting("good.boxes --processors 17").ok_silently();
    let says = "sort-twice 1 on 17 processors is sort-last: each group is one processor (--group)";
    assert!(alone.text().lines().any(|line| line == says), "{}", alone.text());
    let one = sorting("good.boxes --processors 1 -O sort-twice").ok_silently();
    assert!(one.text().contains("sort-twice 1 on 1 processor is sort-middle"), "{}", one.text());
    let all = sorting("good.boxes --processors 13,17 -O sort-twice,sort-last --json").ok_silently();
    let runs: serde_json::Value = serde_json::from_str(all.text()).unwrap();
    let same: Vec<_> = (0..4).map(|run| runs["runs"][run]["same_as"].as_str()).collect();
    assert_eq!(same, [Some("sort-middle"), None, Some("sort-last"), None]);
    sorting("good.boxes -O sort-twice -g 3")
        .failed(1, &["a group that divides the 1024 processors, found 3"]);
    place
        .run("lab predict model.off --machine pomegranate --size 16x16")
        .failed(1, &["costs.polygon or", "costs.pixel or"]);
    place
        .run("lab predict model.off --machine two-core-2026 -n 3 --size 16x16")
        .failed(1, &["expected at most 2 processors that share a memory, found 3"]);
    sorting("good.boxes --machine nothing").failed(1, &["no machine \"nothing\""]);
    sorting("good.boxes --size 30000x30000").failed(1, &["expected a screen of at most"]);
    assert_eq!(sorting("good.boxes --processors 0").code, Some(2));
    assert_eq!(sorting("good.boxes -O sort-sometimes").code, Some(2));
    place.run("lab simulate parks good.boxes").failed(1, &["needs whole polygons, not boxes"]);
    place.run("lab simulate ring none.boxes").failed(1, &["none.boxes"]);
    place.run("lab workload model.off -o model.txt").failed(2, &["extension must be .boxes or .polygons"]);
    place.run("lab workload random:x -o a.boxes").failed(2, &["random:COUNT"]);
}
