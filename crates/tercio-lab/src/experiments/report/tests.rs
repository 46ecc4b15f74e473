use std::collections::BTreeSet;

use super::*;

fn site() -> (tempfile::TempDir, Vec<Outcome>) {
    let directory = tempfile::tempdir().unwrap();
    let some: Vec<_> =
        super::super::all().filter(|e| ["hybris-fig-2-16", "parks-fig-28"].contains(&e.id)).collect();
    let outcomes = super::super::reproduce(&some, directory.path(), |_| {}).unwrap();
    write(&outcomes, &crate::published::check_all().unwrap(), directory.path()).unwrap();
    (directory, outcomes)
}

/// Values of an attribute in the text of a page.
fn attributes<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let begin = format!(" {name}=\"");
    page.split(&begin).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn every_link_of_the_site_leads_to_something_in_its_folder() {
    let (directory, _) = site();
    let read = |name: &str| std::fs::read_to_string(directory.path().join(name)).unwrap();
    let pages: Vec<_> =
        std::fs::read_dir(directory.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    let pages: BTreeSet<_> =
        pages.iter().filter_map(|p| p.to_str()).filter(|p| p.ends_with(".html")).collect();
    let expected =
        ["hybris.html", "index.html", "machines.html", "numbers.html", "parks.html", "prediction.html"];
    assert_eq!(pages, BTreeSet::from(expected), "documents without experiments have no page");
    for page in pages {
        let text = read(page);
        assert!(!text.contains("<script") && !text.contains("<link"), "{page}");
        for link in attributes(&text, "href").into_iter().chain(attributes(&text, "src")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let file = if file.is_empty() { page } else { file };
            assert!(directory.path().join(file).is_file(), "{page}: {link}");
            assert!(anchor.is_empty() || attributes(&read(file), "id").contains(&anchor), "{page}: {link}");
        }
    }
}

#[test]
fn elements_of_pages_are_closed() {
    let (directory, _) = site();
    for page in ["hybris.html", "parks.html", "machines.html"] {
        let text = std::fs::read_to_string(directory.path().join(page)).unwrap();
        for element in
            ["math", "mrow", "mfrac", "msqrt", "msup", "msub", "figure", "svg", "table", "details", "p"]
        {
            let begun =
                text.matches(&format!("<{element}>")).count() + text.matches(&format!("<{element} ")).count();
            assert_eq!(begun, text.matches(&format!("</{element}>")).count(), "{page}: {element}");
        }
        assert!(text.contains("<svg"), "{page}");
    }
}

#[test]
fn a_verdict_lists_all_files_of_its_folder() {
    let (directory, outcomes) = site();
    for outcome in outcomes {
        let folder = directory.path().join(outcome.experiment.id);
        let verdict = std::fs::read_to_string(folder.join("verdict.json")).unwrap();
        let verdict: serde_json::Value = serde_json::from_str(&verdict).unwrap();
        let listed = ["tables", "plots"].map(|key| verdict[key].as_array().unwrap().clone()).concat();
        let listed: BTreeSet<_> = listed.iter().map(|f| f.as_str().unwrap().to_owned()).collect();
        let files =
            std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let files: BTreeSet<_> = files.filter(|f| f != "verdict.json").collect();
        assert_eq!(listed, files);
        assert!(files.iter().any(|f| f.ends_with(".pdf")), "{files:?}");
    }
}

#[test]
fn what_is_a_sign_of_the_markup_is_escaped() {
    let mut html = Html::default();
    html.labelled("a < b", "\"c\" & d");
    html.table(&["x"], &[vec![Text::from("<script>".to_owned())]]);
    assert_eq!(html.end().matches("&lt;").count(), 2);
}
