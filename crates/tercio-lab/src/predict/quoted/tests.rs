use super::*;

const PAGES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory");

/// Does something with each table and the page that shows it.
fn each(mut with: impl FnMut(&str, &str, &str, &[String], bool)) {
    fn one<R: QuotedRow>(
        name: &str,
        table: Quoted<R>,
        with: &mut impl FnMut(&str, &str, &str, &[String], bool),
    ) {
        let text = markdown(&table.rows);
        with(name, &text, &table.date, &table.why, table.holding() < table.rows.len());
    }
    one("prediction.md", of_threads().unwrap(), &mut with);
    one("ranks.md", of_ranks().unwrap(), &mut with);
    one("mpi.md", of_mpi().unwrap(), &mut with);
}

#[test]
fn pages_in_docs_show_the_same_tables() {
    each(|name, table, date, why, misses| {
        let page = std::fs::read_to_string(format!("{PAGES}/{name}")).unwrap();
        assert!(page.contains(date), "{name}: the day of the measurement");
        assert!(
            page.contains(table),
            "{name} has another table: 'cargo test -p tercio-lab quoted -- --ignored' writes it"
        );
        assert_eq!(misses, !why.is_empty(), "{name}: rows that miss, and only they, have a reason");
    });
}

/// Not a test: brings the pages up to date after `tercio lab validate -o`.
#[test]
#[ignore = "writes the tables into the pages"]
fn write_pages() {
    each(|name, table, _, _, _| {
        let path = format!("{PAGES}/{name}");
        let page = std::fs::read_to_string(&path).unwrap();
        let header = table.lines().next().unwrap();
        let (before, rest) = page.split_once(header).unwrap_or_else(|| panic!("{name} has no {header}"));
        let after: String =
            rest.lines().skip(1).skip_while(|l| l.starts_with('|')).map(|l| format!("{l}\n")).collect();
        std::fs::write(path, format!("{before}{table}{after}")).unwrap();
    });
}

fn row() -> ThreadsRow {
    ThreadsRow {
        model: "m".into(),
        size: [4, 3],
        threads: 1,
        counters: [2, 2],
        predicted: 1.3,
        measured: 1.0,
    }
}

#[test]
fn a_row_says_itself_whether_it_holds() {
    assert_eq!(row().cells()[6..], ["+30.0 %".to_string(), "misses".into()]);
    assert!(ThreadsRow { predicted: 0.8, ..row() }.holds());
    assert!(!ThreadsRow { predicted: 0.8, counters: [1, 2], ..row() }.holds());
    let ranks = of_ranks().unwrap().rows.remove(0);
    let [error, verdict] = &ranks.cells()[14..] else { panic!("{ranks:?}") };
    assert_eq!(verdict == "holds", error.trim_end_matches(" %").parse::<f64>().unwrap().abs() <= 25.0);
    let twice = RanksRow { frame: [2.0, 1.0], ..ranks.clone() };
    assert!(!twice.holds() && twice.cells()[14..] == ["+100.0 %".to_string(), "misses".into()]);
    assert!(!RanksRow { frame: [1.0; 2], counters: [1, 2], ..ranks }.holds());
}

#[test]
fn rows_take_the_place_of_those_of_the_same_picture() {
    let mut table = Quoted::new("a machine".into());
    let other = ThreadsRow { threads: 2, ..row() };
    table.add(vec![row(), other.clone()], "first".into(), "2026-01-01".into());
    table.add(vec![ThreadsRow { measured: 2.0, ..other.clone() }], "second".into(), "2026-01-02".into());
    assert_eq!(table.rows, [row(), ThreadsRow { measured: 2.0, ..other.clone() }]);
    assert_eq!((table.commands.join(" "), table.date.as_str()), ("first second".into(), "2026-01-02"));
    table.why = vec!["a reason".into()];
    let again = Quoted::parse(&table.to_toml().unwrap()).unwrap();
    assert_eq!(again, table);
    table.add(vec![other, row()], "third".into(), "2026-01-03".into());
    assert_eq!(table.commands, ["third"], "nothing is left of the others");
    assert_eq!(markdown(&table.rows).lines().count(), 4);
}
