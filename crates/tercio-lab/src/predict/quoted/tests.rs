use super::*;

const PAGES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory");

/// Calls `with` for each table and the page that shows it.
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
    one("advice.md", of_advice().unwrap(), &mut with);
}

/// With `TERCIO_BLESS` set, after `tercio lab validate -o`, the pages are updated instead.
#[test]
fn pages_in_docs_show_the_same_tables() {
    let bless = std::env::var_os("TERCIO_BLESS").is_some();
    each(|name, table, date, why, misses| {
        let path = format!("{PAGES}/{name}");
        let mut page = std::fs::read_to_string(&path).unwrap();
        if bless {
            page = with_table(&page, table).unwrap_or_else(|| panic!("{name} has no such table"));
            std::fs::write(path, &page).unwrap();
        }
        assert!(page.contains(date), "{name}: the day of the measurement");
        let write = "'TERCIO_BLESS=1 cargo test -p tercio-lab --lib quoted' writes it";
        assert!(page.contains(table), "{name} has another table: {write}");
        assert_eq!(misses, !why.is_empty(), "{name}: rows that miss, and only they, have a reason");
    });
}

/// A page with the table below the same header replaced.
fn with_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(table.lines().next()?)?;
    let after = rest.lines().skip(1).skip_while(|line| line.starts_with('|'));
    Some(format!("{before}{table}{}", after.map(|line| format!("{line}\n")).collect::<String>()))
}

#[test]
fn a_table_takes_the_place_of_another() {
    let page = "# page\n\n| a |\n|---|\n| 1 |\n| 2 |\n\nEnd.\n";
    let expected = "# page\n\n| a |\n|---|\n| 3 |\n\nEnd.\n";
    assert_eq!(with_table(page, "| a |\n|---|\n| 3 |\n").as_deref(), Some(expected));
    assert_eq!(with_table(page, "| b |\n"), None);
}

fn row() -> ThreadsRow {
    ThreadsRow {
        model: "m".into(),
        size: [4, 3],
        threads: 1,
        counters: [2, 2],
        predicted: 1.3,
        measured: 1.0,
        loose: false,
        terms: crate::predict::difference::terms(["culling", "shading"], [0.6, 0.7], [0.5, 0.5]),
    }
}

#[test]
fn a_row_has_its_verdict() {
    let cells = |row: ThreadsRow| row.cells()[6..].join("; ");
    assert_eq!(cells(row()), "shading +0.20, culling +0.10; +30.0 %; misses (15 %)");
    let low = ThreadsRow { predicted: 0.82, ..row() };
    assert!(!low.holds() && ThreadsRow { predicted: 0.86, ..row() }.holds());
    let loose = ThreadsRow { loose: true, ..low };
    assert_eq!(cells(loose), "shading +0.20, culling +0.10; -18.0 %; holds (20 %)");
    assert!(!ThreadsRow { predicted: 0.8, counters: [1, 2], ..row() }.holds());
    let ranks = of_ranks().unwrap().rows.remove(0);
    let [error, verdict] = &ranks.cells()[15..] else { panic!("{ranks:?}") };
    let error: f64 = error.trim_end_matches(" %").parse().unwrap();
    assert_eq!(verdict == "holds (15 %)", error.abs() <= 15.0);
    let twice = RanksRow { frame: [2.0, 1.0], ..ranks.clone() };
    assert!(!twice.holds() && twice.cells()[15..] == ["+100.0 %".to_string(), "misses (15 %)".into()]);
    let processes = |frame| RanksRow { frame, mpi: true, ..ranks.clone() };
    assert!(processes([1.24, 1.0]).holds() && !processes([1.26, 1.0]).holds());
    assert!(!RanksRow { frame: [1.0; 2], counters: [1, 2], ..ranks }.holds());
}

/// In each measured row, what is named makes up the difference of the frame but for a tenth or 0.01 ms, and rounding.
#[test]
fn explanations_of_measured_rows_make_up_their_differences() {
    fn check<R: QuotedRow>(table: Quoted<R>, column: &str, difference: fn(&R) -> f64) {
        let column = R::HEADER.iter().position(|title| *title == column).unwrap();
        for row in &table.rows {
            let cells = row.cells();
            let sizes = cells[column].split(", ").map(|term| term.rsplit(' ').next().unwrap());
            let named: Vec<f64> = sizes.map(|size| size.parse().unwrap()).collect();
            let (net, rounding) = (difference(row), 0.005 * named.len() as f64 + 0.005);
            let rest = (net - named.iter().sum::<f64>()).abs();
            assert!(rest <= (0.1 * net.abs()).max(0.01) + rounding, "{net:.3}: {cells:?}");
        }
    }
    check(of_threads().unwrap(), "difference by stage, ms", |row| row.predicted - row.measured);
    let of_frame = |row: &RanksRow| row.frame[0] - row.frame[1];
    check(of_ranks().unwrap(), "difference on rank 0, ms", of_frame);
    check(of_mpi().unwrap(), "difference on rank 0, ms", of_frame);
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
