//! A small table, for the terminal, for other programs (CSV) and for documents (Markdown, LaTeX).

use super::latex;

/// What stands in one place of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words; set flush left.
    Text(String),
    /// A number and how many decimals a reader is shown; CSV keeps all digits. Not finite: shown as missing.
    Number(f64, usize),
    /// A number that rests on little, marked for readers with an asterisk; say why in the caption. CSV has the number alone.
    Uncertain(f64, usize),
    /// A number with the ends of its interval, shown with so many decimals. CSV has the number alone.
    Interval(f64, [f64; 2], usize),
    /// A count.
    Count(u64),
    /// No value: a dash for readers, nothing in CSV. Say why in the caption.
    Missing,
    /// What should have given the value failed; the number is that of a [footnote](Table::footnote), which says why.
    Failed(usize),
}

impl Cell {
    /// A number with that many decimals, or a missing value.
    pub fn number(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Number(value, decimals))
    }

    /// A number with its interval, alone where there is none, or a missing value.
    pub fn interval(value: Option<f64>, ends: Option<[f64; 2]>, decimals: usize) -> Self {
        match (value, ends) {
            (Some(value), Some(ends)) => Cell::Interval(value, ends, decimals),
            (value, _) => Cell::number(value, decimals),
        }
    }

    fn shown(&self) -> String {
        match self {
            Cell::Text(text) => text.replace(['\n', '\r', '\t'], " "),
            Cell::Number(value, decimals) if value.is_finite() => {
                let shown = format!("{value:.decimals$}");
                let zero = shown
                    .trim_start_matches('-')
                    .bytes()
                    .all(|b| matches!(b, b'0' | b'.'));
                shown[usize::from(zero && shown.starts_with('-'))..].to_string() // −0.00 is 0.00
            }
            Cell::Uncertain(value, decimals) if value.is_finite() => {
                Cell::Number(*value, *decimals).shown() + "*"
            }
            Cell::Interval(value, [low, high], decimals) if value.is_finite() => {
                let shown = |end: f64| Cell::Number(end, *decimals).shown();
                format!("{} [{}, {}]", shown(*value), shown(*low), shown(*high))
            }
            Cell::Count(count) => count.to_string(),
            Cell::Number(..) | Cell::Uncertain(..) | Cell::Interval(..) | Cell::Missing => {
                "–".to_string()
            }
            Cell::Failed(note) => format!("failed [{note}]"),
        }
    }

    fn in_csv(&self) -> String {
        match self {
            Cell::Text(text) => quoted(text),
            Cell::Number(value, _) | Cell::Uncertain(value, _) | Cell::Interval(value, ..)
                if value.is_finite() =>
            {
                value.to_string()
            }
            Cell::Count(count) => count.to_string(),
            Cell::Number(..) | Cell::Uncertain(..) | Cell::Interval(..) | Cell::Missing => {
                String::new()
            }
            Cell::Failed(_) => "failed".to_string(),
        }
    }
}

/// Named columns, rows of cells, and a caption. Units stand in the headers.
///
/// ```
/// use ballmark::report::{Cell, Table};
/// let mut table = Table::new(["system", "error (m)"]);
/// table.row([Cell::Text("dead reckoning".into()), Cell::Number(12.5, 2)]);
/// table.row([Cell::Text("filters".into()), Cell::Missing]);
/// table.caption("–: did not converge");
/// assert_eq!(
///     table.text(),
///     "system          error (m)\n\
///      --------------  ---------\n\
///      dead reckoning      12.50\n\
///      filters                 –\n\
///      –: did not converge\n"
/// );
/// assert_eq!(table.csv(), "system,error (m)\ndead reckoning,12.5\nfilters,\n");
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<Cell>>,
    caption: Vec<String>,
    footnotes: Vec<String>,
}

impl Table {
    /// A table of these columns without rows.
    pub fn new<S: Into<String>>(headers: impl IntoIterator<Item = S>) -> Self {
        Self {
            headers: headers.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Adds a row. What a short row lacks is missing; what is beyond the last column is left out.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let mut row: Vec<Cell> = cells.into_iter().collect();
        row.resize(self.headers.len(), Cell::Missing);
        self.rows.push(row);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Is there no row?
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Adds a line below the table.
    pub fn caption(&mut self, line: impl Into<String>) {
        self.caption.push(line.into());
    }

    /// The number of a footnote that says this; the same words get the same number.
    pub fn footnote(&mut self, words: impl Into<String>) -> usize {
        let words = words.into();
        let known = self.footnotes.iter().position(|known| *known == words);
        1 + known.unwrap_or_else(|| {
            self.footnotes.push(words);
            self.footnotes.len() - 1
        })
    }

    /// What stands below the table: footnotes, then the caption.
    pub(super) fn below(&self) -> impl Iterator<Item = String> {
        let numbered = |(index, words): (usize, &String)| format!("[{}] {words}", index + 1);
        let footnotes = self.footnotes.iter().enumerate().map(numbered);
        footnotes.chain(self.caption.iter().cloned())
    }

    /// For the terminal: columns aligned, numbers flush right.
    pub fn text(&self) -> String {
        let shown = self.shown();
        let widths: Vec<usize> = (0..self.headers.len())
            .map(|c| {
                shown
                    .iter()
                    .map(|row| row[c].chars().count())
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        let rule: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
        let mut text = String::new();
        for (index, row) in shown.iter().enumerate() {
            for line in [Some(row), (index == 0).then_some(&rule)]
                .into_iter()
                .flatten()
            {
                let cells: Vec<String> = (0..widths.len())
                    .map(|c| match (self.is_numeric(c), widths[c]) {
                        (true, width) => format!("{:>width$}", line[c]),
                        (false, width) => format!("{:<width$}", line[c]),
                    })
                    .collect();
                text.push_str(cells.join("  ").trim_end());
                text.push('\n');
            }
        }
        self.below()
            .for_each(|line| text.extend([line.as_str(), "\n"]));
        text
    }

    /// For other programs: RFC 4180 with line feeds, numbers with all their digits, no caption.
    pub fn csv(&self) -> String {
        let headers: Vec<String> = self.headers.iter().map(|header| quoted(header)).collect();
        let mut text = headers.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::in_csv).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }

    /// For documents: a Markdown table, then the caption as paragraphs.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        for (index, row) in self.shown().iter().enumerate() {
            let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
            text.push_str(&format!("| {} |\n", cells.join(" | ")));
            if index == 0 {
                let rule = (0..row.len()).map(|c| if self.is_numeric(c) { "--:" } else { ":--" });
                text.push_str(&format!("| {} |\n", rule.collect::<Vec<_>>().join(" | ")));
            }
        }
        self.below()
            .for_each(|line| text.extend(["\n", line.as_str(), "\n"]));
        text
    }

    /// For LaTeX documents, to be `\input`: a plain `tabular` that asks for no package, then footnotes and caption as a
    /// paragraph.
    ///
    /// ```
    /// use ballmark::report::{Cell, Table};
    /// let mut table = Table::new(["system", "50 % & more"]);
    /// table.row([Cell::Text("nearest_1".into()), Cell::Number(0.5, 2)]);
    /// assert_eq!(table.latex(), "\\begin{tabular}{lr}\n\\hline\nsystem & 50 \\% \\& more \\\\\n\\hline\n\
    ///     nearest\\_1 & 0.50 \\\\\n\\hline\n\\end{tabular}\n");
    /// ```
    pub fn latex(&self) -> String {
        let numeric = (0..self.headers.len())
            .map(|c| self.is_numeric(c))
            .collect();
        latex::tabular(&self.shown(), numeric, self.below())
    }

    /// Headers and cells as a reader sees them.
    pub(super) fn shown(&self) -> Vec<Vec<String>> {
        let rows = self
            .rows
            .iter()
            .map(|row| row.iter().map(Cell::shown).collect());
        std::iter::once(self.headers.clone()).chain(rows).collect()
    }

    /// Does a column hold numbers and nothing else?
    pub(super) fn is_numeric(&self, column: usize) -> bool {
        !self.rows.is_empty()
            && !self
                .rows
                .iter()
                .any(|row| matches!(row[column], Cell::Text(_)))
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn awkward_words_survive_in_every_format() {
        let mut table = Table::new(["name", "n"]);
        table.row([Cell::Text("a|b, \"c\"\nd".into()), Cell::Count(3)]);
        assert_eq!(table.csv(), "name,n\n\"a|b, \"\"c\"\"\nd\",3\n");
        assert_eq!(
            table.markdown(),
            "| name | n |\n| :-- | --: |\n| a\\|b, \"c\" d | 3 |\n"
        );
        assert_eq!(table.text().lines().count(), 3);
    }

    #[test]
    fn odd_numbers_are_dashes_and_short_rows_are_filled() {
        let mut table = Table::new(["a", "b"]);
        table.row([Cell::Number(f64::NAN, 1)]);
        table.row([Cell::Number(-0.001, 2), Cell::number(Some(0.1 + 0.2), 1)]);
        assert_eq!(table.text(), "   a    b\n----  ---\n   –    –\n0.00  0.3\n");
        assert_eq!(table.csv(), "a,b\n,\n-0.001,0.30000000000000004\n");
    }

    #[test]
    fn intervals_stand_behind_their_numbers() {
        let mut table = Table::new(["a", "b", "c"]);
        table.row([
            Cell::interval(Some(1.25), Some([-0.001, 2.0]), 1),
            Cell::interval(Some(1.25), None, 1),
            Cell::interval(None, None, 1),
        ]);
        let text = table.text();
        assert!(text.ends_with("1.2 [0.0, 2.0]  1.2  –\n"), "{text}");
        assert_eq!(table.csv(), "a,b,c\n1.25,1.25,\n");
    }

    #[test]
    fn failures_are_numbered_and_told_below() {
        let mut table = Table::new(["A", "B"]);
        let (one, other) = (table.footnote("no compass"), table.footnote("one lap"));
        assert_eq!((one, other, table.footnote("no compass")), (1, 2, 1));
        table.row([Cell::Failed(one), Cell::Failed(other)]);
        table.row([Cell::Count(3), Cell::Missing]);
        table.caption("seed 1");
        assert_eq!(
            table.text(),
            "         A           B\n----------  ----------\nfailed [1]  failed [2]\n         3           –\n\
             [1] no compass\n[2] one lap\nseed 1\n"
        );
        assert_eq!(table.csv(), "A,B\nfailed,failed\n3,\n");
        assert!(
            table
                .markdown()
                .ends_with("\n[1] no compass\n\n[2] one lap\n\nseed 1\n")
        );
        assert!(table.latex().contains("failed {[}1] & failed {[}2] \\\\"));
        assert!(
            table
                .latex()
                .ends_with("\\end{tabular}\n\n{[}1] no compass\\\\\n{[}2] one lap\\\\\nseed 1\n")
        );
    }

    #[test]
    fn a_table_without_rows_has_its_headers() {
        assert_eq!(Table::new(["x (m)"]).text(), "x (m)\n-----\n");
    }
}
