use super::*;

fn name(comparison: &Comparison) -> &'static str {
    comparison.verdict().name()
}

#[test]
fn nothing_compared_is_nothing_shown() {
    assert_eq!(name(&Comparison::new()), "contradicted");
    let error = Comparison::of_published(&["no such number"]).unwrap_err().to_string();
    assert_eq!(error, "no published number is called 'no such number'");
}

#[test]
fn a_simulated_number_within_the_last_digit_is_reproduced_and_beyond_it_contradicted() {
    let mut comparison = Comparison::new();
    comparison.add_printed("a", 1.962, "1.96");
    assert_eq!(name(&comparison), "reproduced");
    comparison.add_printed("b", 1.97, "1.96");
    assert_eq!(name(&comparison), "contradicted in part");
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
    assert_eq!(name(&comparison), "contradicted in part");
}

#[test]
fn a_print_that_is_contradicted_counts_whatever_else_agrees() {
    let of = |prefixes: &[&str]| Comparison::of_published(prefixes).unwrap().verdict();
    // 29 for 24, alone and beside one, three and all other numbers of its chapter.
    assert_eq!(of(&["E4.2-sl-dense"]).name(), "contradicted");
    for with in [&["E4.2-sl-dense", "E4.2-sl-sparse"][..], &["E4.2-sl-*", "E4.fo", "E4.10-fo"]] {
        let verdict = of(with);
        assert_eq!(verdict.name(), "contradicted in part", "{with:?}");
        assert!(
            verdict.text().contains("Does not agree: E4.2-sl-dense: printed 29, ours 24 ("),
            "{}",
            verdict.text()
        );
    }
    assert_eq!(of(&["E4.2-sl-sparse"]).name(), "restated");
    // Nor does what holds of a shape soften it.
    let mut shapes = Comparison::of_published(&["E4.2-sl-dense"]).unwrap();
    shapes.claim("the curve falls", true);
    assert_eq!(name(&shapes), "contradicted");
}

#[test]
fn one_print_is_compared_once() {
    // 50,503 has three rows, none of which gives it; 3.02 two, one of which does.
    let text = |prefixes: &[&str]| Comparison::of_published(prefixes).unwrap().verdict().text();
    let mut comparison = Comparison::of_published(&["E6-50503", "E6-cross84", "E6-cross78"]).unwrap();
    assert_eq!((name(&comparison), comparison.contradicted.len()), ("contradicted", 1));
    comparison.add_printed("a", 24.0, "24");
    assert_eq!(name(&comparison), "contradicted in part");
    assert_eq!(Comparison::of_published(&["E8.17", "E8.17-460"]).unwrap().verdict().name(), "restated");
    let of = text(&["E8.17", "E8.17-460"]);
    assert!(
        of.contains("Agrees: 1 by") && of.contains("in another form or reading: E8.17-460: printed 3.02"),
        "{of}"
    );
    let of = text(&["E4.12-as-printed", "E4.12-as-computed", "E4.12-f4.4"]);
    assert!(of.contains("Agrees: 1 by"), "{of}");
}

#[test]
fn a_correction_is_one_only_if_the_printed_form_does_not_give_print() {
    let of = |prefixes: &[&str]| Comparison::verdict_of_published(prefixes, "It is f A R.").unwrap().name();
    assert_eq!(of(&["E4.12-as-printed", "E4.12-as-computed"]), "reproduced after correction");
    assert_eq!(of(&["E4.11", "E4.11b"]), "restated");
    // The optimum that is printed comes from the equation that is wrong.
    assert_eq!(of(&["M-eq11", "M-fig7-eq11", "M-fig7-true"]), "contradicted");
    // The factor of 2 comes from an equation without the terms that are wrong in another one.
    let factor = ["E4.sf-sm-4.9", "E4.sf-sm", "E4.sf-sm-corrected"];
    assert_eq!(of(&factor), "restated");
    assert_eq!(of(&[&factor[..], &["E4.12-as-computed"]].concat()), "reproduced after correction");
    assert_eq!(of(&["E4.12-as-computed", "E4.2-sl-dense"]), "contradicted in part");
}

#[test]
fn an_equation_that_is_printed_wrong_makes_no_print_agree() {
    for with in [&["M-fig7-eq11"][..], &["M-fig7-eq11", "M-fig7-true"]] {
        let verdict = Comparison::of_published(with).unwrap().verdict();
        assert_eq!(verdict.name(), "contradicted", "{with:?}: {}", verdict.text());
        let says = "M-fig7-eq11: printed 16, ours 15.8801, but by a wrong equation (";
        assert!(verdict.text().contains(says), "{}", verdict.text());
        assert!(!verdict.text().contains("Agrees"), "{}", verdict.text());
    }
    let verdict = Comparison::of_published(&["M-fig7-eq11", "M-fig7-true", "M-T2P-1"]).unwrap().verdict();
    assert_eq!(verdict.name(), "contradicted in part");
    assert!(verdict.text().contains("M-fig7-true: printed 16, ours 18.2762 ("), "{}", verdict.text());
}

#[test]
fn where_nothing_printed_is_computed_there_is_no_verdict() {
    let verdict = Comparison::of_published(&["O-T3-su#-#"]).unwrap().verdict();
    assert_eq!(verdict.name(), "no verdict");
    assert!(!verdict.text().contains("grees"), "{}", verdict.text());
}

#[test]
fn nothing_that_fails_is_said_to_agree() {
    let mut comparison = Comparison::of_published(&["E4.2-sl-*", "E5.8-m#"]).unwrap();
    comparison.claim("the curve ends", false);
    comparison.claim("the curve falls", true);
    comparison.fit_one_of(vec![line("visible", "500", 10.0), line("all", "500", 100.0)]);
    let text = comparison.verdict().text();
    let parts: Vec<_> = ["Does not agree: ", ". Agrees: ", "another form or reading: ", ". Not printed: "]
        .map(|head| text.find(head).unwrap_or_else(|| panic!("{head}: {text}")))
        .into();
    assert!(parts.is_sorted());
    let within = |words: &str| parts.iter().rposition(|&at| at < text.find(words).unwrap()).unwrap();
    assert_eq!(["the curve ends", "the curve falls", "all: with", "visible: no"].map(within), [0, 1, 1, 2]);
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
    assert!(comparison.verdict().text().starts_with("Does not agree: the curve ends."));
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
fn readings_of_one_print_are_alternatives_and_one_holds_with_the_other_numbers() {
    let mut comparison = Comparison::new();
    comparison.fit_one_of(vec![line("few", "20", 10.0), line("many", "40", 5.0)]);
    let text = comparison.verdict().text();
    assert!(text.contains("one of 2 readings of a print: either few: with clumping 1.95 to 2.05"), "{text}");
    comparison.fit(line("b", "80", 10.0));
    assert_eq!(name(&comparison), "qualitative");
    // 5 of the input gives neither reading.
    let mut apart = comparison.clone();
    apart.fit(line("c", "50", 10.0));
    assert_eq!(name(&apart), "contradicted");
    let mut second = Comparison::new();
    second.fit_one_of(vec![line("few", "20", 10.0), line("many", "40", 5.0)]);
    second.fit(line("b", "50", 10.0));
    assert_eq!(name(&second), "contradicted");
    assert!(
        second.verdict().text().contains("no clumping gives all 2 numbers (one of 2"),
        "{}",
        second.verdict().text()
    );
}

#[test]
fn an_input_that_misses_one_number_may_give_another() {
    let mut comparison = Comparison::new();
    comparison.fit(line("a", "20", 10.0));
    comparison.fit(line("b", "500", 10.0));
    let text = comparison.verdict().text();
    assert!(
        text.starts_with("Does not agree: b: no clumping") && text.contains("Agrees: a: with clumping"),
        "{text}"
    );
    assert!(!text.contains("all 2"), "{text}");
    // Those that it gives, but not together, do not agree either.
    comparison.fit(line("c", "50", 10.0));
    let text = comparison.verdict().text();
    assert!(text.contains("no clumping gives all 2 other numbers (a: with clumping"), "{text}");
    assert!(!text.contains("Agrees"), "{text}");
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
fn a_verdict_says_of_a_tolerance_what_the_table_says() {
    let mut seen = std::collections::BTreeSet::new();
    for check in crate::published::check_all().unwrap() {
        let source = check.tolerance_source().map_or("none", ToleranceSource::text);
        let id = check.number.id.as_str();
        let agrees = check.agreement() == crate::published::Agreement::AgreesWithPrint;
        // One number of each source.
        if agrees && seen.insert(source) {
            let text = Comparison::of_published(&[id]).unwrap().verdict().text();
            assert!(text.contains(&format!("tolerances: {source})")), "{id}: {source}: {text}");
        }
    }
    assert!(
        seen.contains(ToleranceSource::CutOff.text()) && seen.contains(ToleranceSource::LastDigitOff.text())
    );
}

#[test]
fn no_name_takes_another() {
    let ids: Vec<_> = crate::published::numbers().unwrap().into_iter().map(|n| n.id).collect();
    for name in &ids {
        let taken: Vec<_> = ids.iter().filter(|id| is_named(id, &[name])).collect();
        assert_eq!(taken, [name]);
    }
}

#[test]
fn a_star_is_one_part_of_a_name_and_a_number_sign_its_digits() {
    let count = |name: &str| named(&[name]).unwrap().len();
    assert_eq!(["H2.15-*-#-#", "H2.15-*-32-#", "E8.#", "E8.T1-#", "M-C-#"].map(count), [72, 12, 17, 9, 10]);
    for (id, name) in
        [("E8.17-460", "E8.#"), ("E8.2sum", "E8.#"), ("E8.T1-1-rest", "E8.T1-*"), ("a-", "a-*"), ("d", "d#")]
    {
        assert!(!is_named(id, &[name]), "{name} takes {id}");
    }
}
