//! `tercio lab`: formulas, published numbers, experiments.

mod common;

use common::Place;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_formula_is_evaluated_with_defaults_and_values() {
    let place = Place::new();
    assert_eq!(place.run("lab eval eldridge.5.6").ok_silently().text(), "27.35521326 processor\n");
    assert_eq!(place.run("lab eval eldridge.5.6 n=4096").ok_silently().text(), "54.71042651 processor\n");
    let outcome = place.run("lab eval common.bandwidth width=16 clock=14MHz --json").ok_silently();
    let value = json(outcome.text());
    assert_eq!((value["value"].as_f64(), value["unit"].as_str()), (Some(28e6), Some("B/s")));
    let outcome = place.run("lab eval parks.variance of=[[128,2]]").ok_silently();
    assert_eq!(outcome.text(), "0\n");
}

#[test]
fn every_formula_is_listed_with_parameters_units_and_place() {
    let place = Place::new();
    let outcome = place.run("lab eval --list --json").ok_silently();
    let all = json(outcome.text());
    let all = all.as_array().expect("a list");
    assert!(all.len() > 200, "{}", all.len());
    for model in all {
        for key in ["id", "place", "what"] {
            assert!(model[key].as_str().is_some_and(|t| !t.is_empty()), "{model}");
        }
        // A formula whose parameters all have defaults can be evaluated without any.
        let parameters = model["parameters"].as_array().expect("parameters");
        for parameter in parameters {
            assert!(parameter["name"].is_string() && parameter["unit"].is_string(), "{model}");
            for key in ["meaning", "form"] {
                assert!(parameter[key].as_str().is_some_and(|t| !t.is_empty()), "{key} of {model}");
            }
        }
    }
    let some = place.run("lab eval --list mcmanus.1").ok_silently();
    assert!(some.text().contains("P [polygon/s]       polygons a second of the renderer"), "{}", some.text());
    assert!(some.text().contains("(003 eq 1)") && some.text().contains("assumes: 0.000871 in2"));
    let one = place.run("lab eval --list eldridge.5.6").ok_silently();
    assert!(one.text().contains("n [processor] = 1024  processors\n"), "{}", one.text());
}

#[test]
fn mistakes_in_names_and_values_are_reported() {
    let place = Place::new();
    place.run("lab eval eldridge.5.66").failed(1, &["no formula is called 'eldridge.5.66'", "eldridge.5.6"]);
    place.run("lab eval eldridge.5.6 q=1").failed(1, &["eldridge.5.6 has no parameter 'q'", "n, a, b"]);
    place
        .run("lab eval eldridge.5.3 n=8")
        .failed(1, &["needs a value for 'd', distance of a pass, the stride (processor)"]);
    place.run("lab eval eldridge.5.6 n=0").failed(1, &["n: number of processors", "above zero", "found 0"]);
    place.run("lab eval eldridge.5.6 n=3MHz").failed(1, &["expected processor", "'MHz'"]);
    place
        .run("lab eval mcmanus.14 X=16 A=5 N=9")
        .failed(1, &["mcmanus.14: A: expected at most the root of X"]);
    place.run("lab eval ortega.rate N=5 t=0").failed(1, &["no finite value"]);
    place
        .run("lab eval eldrige.5.6")
        .failed(1, &["no formula is called 'eldrige.5.6'; near it: eldridge.5.6"]);
    place.run("lab eval --list quaternion").failed(1, &["no formula is called 'quaternion'"]);
    place.run("lab eval eldridge.5.8 m=0.5").failed(1, &["m: copies of the database: expected at least 1"]);
    place.run("lab eval eldridge.5.6 n").failed(2, &["expected NAME=VALUE, found 'n'"]);
    place.run("lab eval eldridge.5.6 n=1 n=2").failed(2, &["'n' is given twice"]);
    place.run("lab eval parks.variance of=[[1,").failed(1, &["of: expected a list"]);
    assert_eq!(place.run("lab eval").code, Some(2));
}

#[test]
fn all_published_numbers_hold() {
    let place = Place::new();
    let outcome = place.run("lab check --json").ok_silently();
    let all = json(outcome.text());
    let all = all.as_array().expect("a list");
    assert_eq!(all.len(), 551);
    for number in all {
        assert_ne!(number["class"], "unexplained", "{number}");
        let why = number["class"] != "contradicts-print" || number["why"].is_string();
        assert!(why && number["tolerance_from"].is_string(), "{number}");
        for key in ["id", "expected", "by"] {
            assert!(!number[key].is_null(), "{key} of {number}");
        }
        // A reading is not compared with itself.
        let is_read = number["class"] == "read";
        for key in ["ours", "tolerance"] {
            assert_eq!(number[key].is_null(), is_read, "{key} of {number}");
        }
        assert_eq!(number["reading_error"].is_string(), is_read, "{number}");
    }
    let some = place.run("lab check E5.6 E4.2-").ok_silently();
    assert!(some.text().contains("printed 29, ours 24"), "{}", some.text());
    let summary = "6 numbers:\n    4  agrees with print\n    1  not printed\n    1  contradicts print\n";
    assert!(some.text().ends_with(summary), "{}", some.text());
    let read = place.run("lab check P-fig19").ok_silently();
    let says = "ours not computed, tolerance half of each last digit; 1.57 read as 1.37; 1 of 6 cells open (reading of the scan)";
    assert!(read.text().contains(says), "{}", read.text());
    place.run("lab check Z9").failed(1, &["'Z9'"]);
}

#[test]
fn an_experiment_leaves_data_plot_and_verdict() {
    let place = Place::new();
    let outcome = place.run("lab reproduce eldridge-fig-5-4 -o out").ok_silently();
    assert!(outcome.text().contains("eldridge-fig-5-4") && outcome.text().contains("reproduced"));
    let read = |name: &str| {
        std::fs::read_to_string(place.path("out").join("eldridge-fig-5-4").join(name))
            .expect("a file of the experiment")
    };
    assert!(read("pass-by-distance.csv").starts_with("distance (processor),"));
    assert!(read("pass-by-distance.svg").contains("<svg"));
    assert_eq!(json(&read("verdict.json"))["verdict"], "reproduced after correction");
    place.run("lab reproduce nothing -o out").failed(1, &["no experiment's name begins with 'nothing'"]);
}

#[test]
fn ranks_send_what_is_predicted() {
    let place = Place::new();
    // The costs are those of another machine, so rows may miss in time; messages and bytes must match.
    let outcome = place.run(
        "lab validate builtin:teapot@2k --machine princeton-engine --sizes 90x70 --ranks 1,3 --views 2 --frames 1 --rounds 1 \
         --json --progress never",
    );
    let rows = json(outcome.text());
    let rows = rows.as_array().expect("a list");
    assert_eq!(rows.len(), 4);
    for row in rows.iter().map(|r| &r["row"]) {
        assert_eq!(row["differing"], Value::Array(vec![]), "{row}");
        let (ranks, organisation) = (row["ranks"].as_u64().unwrap(), row["organisation"].as_str().unwrap());
        // 6 counters of the exchange and 22 of the renderer.
        assert_eq!(row["compared"], 2 * (6 + 22) * ranks);
        // Finished pixels of all ranks but one; in sort-last two messages of each of three ranks on which tiles they have
        // drawn, and at most one to each other rank of what they have drawn there.
        let messages = match (ranks, organisation) {
            (1, _) => 0..=0,
            (_, "sort-first") => 2 * 2..=2 * 2,
            _ => 2 * (6 + 1)..=2 * (6 + 6 + 2),
        };
        assert!(messages.contains(&row["messages"].as_u64().unwrap()), "{row}");
        assert_eq!(row["bytes"].as_u64().unwrap() > 0, ranks > 1);
        assert!(row["measured"]["frame"].as_f64().unwrap() > 0.0);
    }
    place
        .run("lab validate builtin:teapot@2k --machine princeton-engine --organisation sort-last")
        .failed(2, &["--ranks"]);
}
