use super::*;

fn name(comparison: &Comparison) -> &'static str {
    comparison.verdict().name()
}

#[test]
fn nothing_compared_is_nothing_shown() {
    assert_eq!(name(&Comparison::new()), "contradicted");
    assert_eq!(Comparison::of_published(&["no such number"]).unwrap().verdict().name(), "contradicted");
}

#[test]
fn a_simulated_number_within_the_last_digit_is_reproduced_and_beyond_it_contradicted() {
    let mut comparison = Comparison::new();
    comparison.add_printed("a", 1.962, "1.96");
    assert_eq!(name(&comparison), "reproduced");
    comparison.add_printed("b", 1.97, "1.96");
    assert_eq!(name(&comparison), "contradicted");
    assert!(
        comparison.verdict().text().contains("b: ours 1.97, published 1.96 ± 0.005 (rounding of the print)")
    );
}

#[test]
fn one_number_by_the_documents_own_formula_is_a_restatement() {
    let mut comparison = Comparison::of_published(&["E5.6"]).unwrap();
    assert_eq!(name(&comparison), "restated");
    comparison.add_printed("counted", 27.36, "27.36");
    assert_eq!(name(&comparison), "restated");
    assert!(comparison.verdict().text().contains("1 simulated or counted, 1 by the document's formula"));
    assert_eq!(Comparison::of_published(&["M-brute-7-2"]).unwrap().verdict().name(), "reproduced");
}

#[test]
fn what_an_input_was_chosen_for_is_by_construction() {
    let mut comparison = Comparison::new();
    comparison.add_constructed("a", 2.0, 2.0, 0.0, ToleranceSource::Exact);
    assert_eq!(name(&comparison), "by construction");
    comparison.add_constructed("b", 2.0, 3.0, 0.0, ToleranceSource::Exact);
    assert_eq!(name(&comparison), "contradicted");
}

#[test]
fn a_correction_counts_only_where_it_is_needed() {
    let mut comparison = Comparison::new();
    comparison.add_printed("a", 24.0, "24");
    comparison.correct("a sign", false);
    assert_eq!(name(&comparison), "reproduced");
    comparison.correct("a sign", true);
    assert_eq!(name(&comparison), "reproduced after correction");
    comparison.add_printed("b", 1.0, "2");
    assert_eq!(name(&comparison), "contradicted");
}

#[test]
fn prints_that_are_contradicted_and_not_outnumbered_are_a_contradiction() {
    let of = |prefixes: &[&str]| Comparison::verdict_of_published(prefixes, "29 is 24.").unwrap().name();
    assert_eq!(of(&["E4.2-s"]), "reproduced after correction");
    assert_eq!(of(&["E4.2-sl-dense"]), "contradicted");
    assert_eq!(of(&["E4.2-sl-dense", "E4.2-sl-sparse"]), "contradicted");
}

#[test]
fn shapes_are_qualitative_and_a_false_claim_is_not() {
    let mut comparison = Comparison::new();
    comparison.claim("the curve falls", true);
    assert_eq!(name(&comparison), "qualitative");
    let text = comparison.qualitative("No scene.").text();
    assert!(text.starts_with("No scene.") && text.ends_with("the curve falls."), "{text}");
    comparison.claim("the curve ends", false);
    assert_eq!(comparison.qualitative("").name(), "contradicted");
    assert!(comparison.verdict().text().contains("ot so: the curve ends"));
}

fn line(number: &str, printed: &str, slope: f64) -> Fit {
    let points = (0..=10).map(|i| (f64::from(i), slope * f64::from(i))).collect();
    Fit::new(number, "clumping", printed, points)
}

#[test]
fn one_input_has_to_explain_all_numbers_that_depend_on_it() {
    let mut comparison = Comparison::new();
    comparison.fit(line("a", "20", 10.0));
    assert_eq!(name(&comparison), "qualitative");
    let mut both = comparison.clone();
    both.fit(line("b", "40", 20.0));
    assert_eq!(name(&both), "qualitative");
    assert!(both.verdict().text().contains("gives all 2 numbers"), "{}", both.verdict().text());
    comparison.fit(line("b", "50", 10.0));
    assert_eq!(name(&comparison), "contradicted");
    assert!(
        comparison.verdict().text().contains("no clumping gives all 2"),
        "{}",
        comparison.verdict().text()
    );
}

#[test]
fn a_number_that_no_input_gives_is_contradicted_unless_it_can_mean_something_else() {
    let mut comparison = Comparison::new();
    comparison.fit(line("a", "500", 10.0));
    assert_eq!(name(&comparison), "contradicted");
    let mut either = Comparison::new();
    either.fit_one_of(vec![line("visible", "500", 10.0), line("all", "500", 100.0)]);
    assert_eq!(name(&either), "qualitative");
    let text = either.verdict().text();
    assert!(text.contains("visible: no clumping") && text.contains("all: with clumping"), "{text}");
}

#[test]
fn a_whole_name_does_not_take_a_longer_one() {
    assert!(
        is_named("E5.9fig", &["E5.9"]) && !is_named("E5.9fig", &["E5.9="]) && is_named("E5.9", &["E5.9="])
    );
}
