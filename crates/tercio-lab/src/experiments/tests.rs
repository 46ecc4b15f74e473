use std::collections::BTreeSet;
use std::sync::OnceLock;

use tempfile::TempDir;

use super::*;
use crate::published;

/// What each experiment is found to be: a change of any is seen here.
const VERDICTS: &[(&str, &str)] = &[
    ("eldridge-table-4-2", "contradicted in part"),
    ("eldridge-fig-4-3", "reproduced after correction"),
    ("eldridge-fig-5-4", "reproduced after correction"),
    ("eldridge-fig-5-5-analytic", "restated"),
    ("eldridge-fig-5-6-analytic", "reproduced after correction"),
    ("eldridge-fig-6-3", "restated"),
    ("eldridge-fig-6-4", "restated"),
    ("eldridge-fig-6-5", "contradicted in part"),
    ("eldridge-chapter-8", "contradicted in part"),
    ("eldridge-table-8-1", "contradicted in part"),
    ("eldridge-fig-4-1", "contradicted in part"),
    ("eldridge-fig-4-2", "qualitative"),
    ("eldridge-fig-4-3-pixels", "qualitative"),
    ("eldridge-fig-5-3", "qualitative"),
    ("eldridge-fig-5-5", "qualitative"),
    ("eldridge-fig-5-6", "contradicted"),
    ("eldridge-fig-5-7", "qualitative"),
    ("eldridge-fig-5-8", "contradicted"),
    ("eldridge-fig-5-9", "contradicted in part"),
    ("eldridge-fig-6-6", "contradicted in part"),
    ("eldridge-fig-6-7", "qualitative"),
    ("eldridge-chapter-7", "contradicted in part"),
    ("eldridge-fig-7-1", "contradicted"),
    ("eldridge-fig-a-2", "reproduced after correction"),
    ("eldridge-fig-a-6", "reproduced"),
    ("eldridge-fig-a-7", "qualitative"),
    ("hybris-fig-2-15", "restated"),
    ("hybris-fig-2-16", "restated"),
    ("hybris-fig-2-14", "qualitative"),
    ("hybris-fig-2-15-counted", "reproduced"),
    ("hybris-fig-3-18", "restated"),
    ("hybris-sec-2-1-2", "contradicted in part"),
    ("hybris-sec-4-5-2", "contradicted in part"),
    ("hybris-fig-4-11", "restated"),
    ("hybris-fig-4-12", "restated"),
    ("hybris-eq-4-7", "reproduced after correction"),
    ("hybris-sec-2-3-classes", "qualitative"),
    ("hybris-sec-2-4-measured", "qualitative"),
    ("hybris-sec-4-4-pages", "qualitative"),
    ("hybris-sec-3-6-fifos", "qualitative"),
    ("hybris-sec-4-6-asic", "qualitative"),
    ("hybris-sec-4-5-1-bus", "by construction"),
    ("hybris-fig-4-12-simulated", "contradicted"),
    ("hybris-sec-3-2-4-culling", "qualitative"),
    ("hybris-fig-3-23", "qualitative"),
    ("hybris-fig-3-26", "qualitative"),
    ("hybris-fig-3-25", "qualitative"),
    ("parks-table-2-2", "restated"),
    ("parks-fig-14", "contradicted"),
    ("parks-app-c", "reproduced after correction"),
    ("parks-fig-15-25", "qualitative"),
    ("parks-fig-28", "restated"),
    ("parks-fig-29", "restated"),
    ("parks-fig-31", "qualitative"),
    ("parks-app-c-scene", "contradicted"),
    ("parks-fig-15-scene", "by construction"),
    ("parks-fig-13", "qualitative"),
    ("parks-fig-27", "qualitative"),
    ("parks-fig-22-25-scenes", "qualitative"),
    ("mcmanus-table-1", "restated"),
    ("mcmanus-fig-5", "reproduced after correction"),
    ("mcmanus-fig-6", "restated"),
    ("mcmanus-table-2", "restated"),
    ("mcmanus-fig-2", "qualitative"),
    ("mcmanus-fig-3", "restated"),
    ("mcmanus-fig-4", "restated"),
    ("mcmanus-fig-7", "contradicted"),
    ("mcmanus-table-3", "restated"),
    ("mcmanus-table-1-scenes", "qualitative"),
    ("mcmanus-fig-3-scenes", "qualitative"),
    ("mcmanus-table-3-scenes", "qualitative"),
    ("ortega-tables", "contradicted in part"),
    ("ortega-fig-3", "qualitative"),
    ("ortega-fig-4", "qualitative"),
    ("ortega-time-model", "qualitative"),
    ("ortega-fig-3-steps", "contradicted"),
    ("ortega-fig-4-steps", "contradicted"),
    ("others-radix-k", "contradicted"),
    ("others-64-megapixels", "qualitative"),
    ("others-framebuffer", "no verdict"),
    ("others-slic", "no verdict"),
];

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// All experiments, run once for all tests, several at a time, on several threads, and the folder of their files.
fn outcomes_of_threads() -> &'static (TempDir, Vec<Outcome>) {
    static OUTCOMES: OnceLock<(TempDir, Vec<Outcome>)> = OnceLock::new();
    OUTCOMES.get_or_init(|| {
        let directory = tempfile::tempdir().unwrap();
        let experiments: Vec<_> = all().collect();
        let outcomes = pool(4).install(|| reproduce(&experiments, directory.path(), |_| {})).unwrap();
        (directory, outcomes)
    })
}

#[test]
fn every_experiment_runs_and_has_the_verdict_that_is_known() {
    let (directory, outcomes) = outcomes_of_threads();
    let ids: BTreeSet<_> = outcomes.iter().map(|o| o.experiment.id).collect();
    assert_eq!(ids.len(), all().count(), "names are folders");
    let mut colliding = Vec::new();
    for outcome in outcomes {
        let id = outcome.experiment.id;
        let findings = outcome.findings.as_ref().unwrap_or_else(|e| panic!("{id}: {e}"));
        assert!(findings.tables.iter().all(|t| !t.rows.is_empty()), "{id} has an empty table");
        for plot in &findings.plots {
            let on_zero = plot.x.categories.is_none() || plot.y.scale == Scale::Linear;
            assert!(on_zero, "{id}/{}: bars stand on zero, which no logarithmic axis has", plot.name);
            let file = |extension| directory.path().join(id).join(format!("{}.{extension}", plot.name));
            assert!(file("svg").is_file() && file("pdf").is_file());
            let collisions = plot.collisions().into_iter().map(|c| format!("{id}/{}: {c}", plot.name));
            colliding.extend(collisions);
        }
    }
    let found: Vec<_> = outcomes
        .iter()
        .map(|o| (o.experiment.id, o.findings.as_ref().map_or("failed", |f| f.verdict.name())))
        .collect();
    every_contradiction_is_in_a_verdict(outcomes);
    printed_levels_are_drawn(outcomes);
    nothing_agrees_by_a_hair(outcomes);
    if found != VERDICTS {
        let text = |o: &Outcome| o.findings.as_ref().map_or_else(ToString::to_string, |f| f.verdict.text());
        let lines = outcomes.iter().zip(&found).filter(|(_, f)| !VERDICTS.contains(f));
        let lines: Vec<_> = lines.map(|(o, f)| format!("{f:?}, // {}", text(o))).collect();
        panic!("verdicts that are not in the list:\n{}", lines.join("\n"));
    }
    assert!(colliding.is_empty(), "{colliding:#?}");
    report::write(outcomes, &published::check_all().unwrap(), directory.path()).unwrap();
    let page = std::fs::read_to_string(directory.path().join("index.html")).unwrap();
    let markdown = std::fs::read_to_string(directory.path().join("report.md")).unwrap();
    assert!(ids.iter().all(|id| page.contains(id) && markdown.contains(id)));
    swept_inputs_are_joined(outcomes, &markdown);
    assert!(page.contains(&summary(outcomes)) && markdown.contains(&summary(outcomes)));
    // Nothing else removes what a static has made.
    std::fs::remove_dir_all(directory.path()).unwrap();
}

/// Verdicts name numbers that contradict print.
fn every_contradiction_is_in_a_verdict(outcomes: &[Outcome]) {
    let texts: Vec<_> = outcomes.iter().flat_map(|o| &o.findings).map(|f| f.verdict.text()).collect();
    let checks = published::check_all().unwrap();
    let contradicting: Vec<_> =
        checks.iter().filter(|c| c.agreement() == published::Agreement::ContradictsPrint).collect();
    let in_none = contradicting.iter().map(|c| c.number.id.as_str()).filter(|id| {
        let says = format!("{id}: printed ");
        !texts.iter().any(|text| text.contains(&says))
    });
    assert_eq!(in_none.collect::<Vec<_>>(), WITHOUT_EXPERIMENT.map(|w| w.0));
}

/// Ranges have two ends, and the speed-up of large polygons is compared with how much less it is in print.
fn nothing_agrees_by_a_hair(outcomes: &[Outcome]) {
    for outcome in outcomes {
        let text = outcome.findings.as_ref().unwrap().verdict.text();
        let words: Vec<_> = text.split_whitespace().collect();
        let bare = |word: &str| word.trim_matches(['(', ')', ',', ';']).to_owned();
        let same = words.windows(3).find(|w| w[1] == "to" && bare(w[0]) == bare(w[2]));
        assert_eq!(same, None, "{}: {text}", outcome.experiment.id);
        if outcome.experiment.id == "ortega-fig-3-steps" {
            let says = "speed-up with large polygons over that of small ones 0.48: no number";
            assert!(text.contains(says) && !text.contains("Agrees"), "{text}");
        }
    }
}

/// The report refers to the table of inputs that are not stated, a verdict, which is also read alone, does not; other views of a
/// scene are other inputs.
fn swept_inputs_are_joined(outcomes: &[Outcome], report: &str) {
    let has_sweeps =
        |o: &&Outcome| o.findings.as_ref().unwrap().tables.iter().any(|t| t.name == unstated::INTERVALS);
    assert_eq!(report.matches(unstated::REFERENCE).count(), outcomes.iter().filter(has_sweeps).count());
    for outcome in outcomes {
        let text = outcome.findings.as_ref().unwrap().verdict.text();
        assert!(!text.contains(unstated::HEADING), "{}", outcome.experiment.id);
    }
    let joined = unstated::joined(outcomes.iter());
    let teapot = joined.iter().find(|i| i.name == "deviation of the teapot's columns").unwrap();
    let places: BTreeSet<_> = teapot.prints.iter().flat_map(|p| p.place.split("; ")).collect();
    let figures = ["4-1", "4-2", "5-3", "5-5", "5-6", "5-7", "5-9"].map(|f| format!("figure {f}"));
    assert_eq!(places, figures.iter().map(String::as_str).collect());
    let views = joined.iter().filter(|i| i.name.contains("'s columns, figure 7-"));
    let views: Vec<_> = views.map(|i| (i.prints.len(), i.prints[0].place.as_str())).collect();
    assert_eq!(views, [(1, "figures 7-1 to 7-4"); 4]);
    assert!(teapot.conclusion().unwrap().contains("no value gives all"), "{:?}", teapot.conclusion());
    for name in ["deviation of the crocodile's columns", "deviation of Beethoven's columns"] {
        assert!(joined.iter().any(|i| i.name == name && i.conclusion().is_some()), "{name}");
    }
}

/// What figures 4-1 and 5-9 print of their scenes is in their plots, as published.
fn printed_levels_are_drawn(outcomes: &[Outcome]) {
    for (id, printed) in [("eldridge-fig-4-1", &[394.0, 23.3][..]), ("eldridge-fig-5-9", &[176.0])] {
        let outcome = outcomes.iter().find(|o| o.experiment.id == id).unwrap();
        let series = &outcome.findings.as_ref().unwrap().plots[0].series;
        for level in printed {
            let is_drawn = |s: &&Series| s.role == Role::Published && s.points.iter().all(|p| p.1 == *level);
            assert_eq!(series.iter().filter(is_drawn).count(), 1, "{id}: {level}");
        }
    }
}

#[test]
fn what_is_found_is_the_same_from_run_to_run_on_any_number_of_threads() {
    let text = |findings: Result<&Findings, &ExperimentError>| {
        format!("{:?}", findings.map_err(ToString::to_string))
    };
    // First, while the other test waits for its own.
    let of_one_thread =
        pool(1).install(|| all().map(|experiment| text((experiment.run)().as_ref())).collect::<Vec<_>>());
    let (_, outcomes) = outcomes_of_threads();
    assert_eq!(of_one_thread.len(), outcomes.len());
    for (outcome, of_one_thread) in outcomes.iter().zip(of_one_thread) {
        assert_eq!(text(outcome.findings.as_ref()), of_one_thread, "{}", outcome.experiment.id);
    }
}
