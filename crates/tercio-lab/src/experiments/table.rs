//! Tables of data, written as CSV.

/// A table: one row per case, columns with units.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file's name without extension.
    pub name: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// The unit of its numbers; empty for texts, counts and ratios.
    pub unit: &'static str,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number, written with as many digits as an exact round trip needs.
    Number(f64),
    /// A text.
    Text(String),
    /// Unknown.
    Empty,
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        if number.is_nan() { Self::Empty } else { Self::Number(number) }
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::from)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl Column {
    /// The name, with the unit if there is one.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.unit) }
    }
}

impl Table {
    /// An empty table with columns of `(name, unit)`.
    pub fn new(name: impl Into<String>, columns: &[(&str, &'static str)]) -> Self {
        let column = |&(name, unit): &(&str, &'static str)| Column { name: name.into(), unit };
        Self { name: name.into(), columns: columns.iter().map(column).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If the row has the wrong number of cells: a bug in the experiment, not in its input.
    pub fn push<const N: usize>(&mut self, row: [Cell; N]) {
        self.push_row(row.to_vec());
    }

    /// Adds a row of any length.
    ///
    /// # Panics
    /// As [`Table::push`].
    pub fn push_row(&mut self, row: Vec<Cell>) {
        assert_eq!(
            row.len(),
            self.columns.len(),
            "table {}: a row has as many cells as there are columns",
            self.name
        );
        self.rows.push(row);
    }

    /// The table as CSV (RFC 4180): a header with `name (unit)`, then the rows.
    pub fn to_csv(&self) -> String {
        let header = self.columns.iter().map(Column::heading);
        let text = |cell: &Cell| match cell {
            Cell::Number(number) => number.to_string(),
            Cell::Text(text) => text.clone(),
            Cell::Empty => String::new(),
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Writing into memory fails only if rows differ in length, which `push` excludes.
        let written = writer
            .write_record(header)
            .and_then(|()| self.rows.iter().try_for_each(|row| writer.write_record(row.iter().map(text))));
        assert!(written.is_ok(), "{written:?}");
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let mut table = Table::new("t", &[("scene", ""), ("time", "s")]);
        table.push(["a, b".into(), 0.5.into()]);
        table.push(["c".into(), f64::NAN.into()]);
        assert_eq!(table.to_csv(), "scene,time (s)\n\"a, b\",0.5\nc,\n");
    }
}
