//! A table's cells as LaTeX: every character that means something there is written so that it is seen instead.

/// A `tabular` of the cells, the first row its head, and lines below it; `numeric` columns are set flush right.
pub(super) fn tabular(
    rows: &[Vec<String>],
    numeric: Vec<bool>,
    below: impl Iterator<Item = String>,
) -> String {
    let columns: String = numeric.iter().map(|&n| if n { 'r' } else { 'l' }).collect();
    let mut text = format!("\\begin{{tabular}}{{{columns}}}\n\\hline\n");
    for (index, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().map(|cell| escaped(cell)).collect();
        text.push_str(&format!("{} \\\\\n", cells.join(" & ")));
        if index == 0 || index + 1 == rows.len() {
            text.push_str("\\hline\n");
        }
    }
    text.push_str("\\end{tabular}\n");
    let below: Vec<String> = below.map(|line| escaped(&line)).collect();
    if !below.is_empty() {
        text.push_str(&format!("\n{}\n", below.join("\\\\\n")));
    }
    text
}

/// Words as LaTeX shows them, letter by letter. Letters beyond those below are left to the document's input encoding,
/// which is UTF-8 unless it says otherwise.
pub(super) fn escaped(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '\\' => text.push_str("\\textbackslash{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => text.extend(['\\', letter]),
            '~' => text.push_str("\\textasciitilde{}"),
            '^' => text.push_str("\\textasciicircum{}"),
            '<' => text.push_str("$<$"),
            '>' => text.push_str("$>$"),
            '|' => text.push_str("$|$"),
            // Behind the end of a row these two would be taken for its options.
            '[' => text.push_str("{[}"),
            '*' => text.push_str("{*}"),
            // Two of them in a row would be drawn as one other sign.
            '`' | '\'' | '-' | ',' if text.ends_with(letter) => text.extend(['{', '}', letter]),
            '"' => text.push_str("\\char34{}"),
            '–' => text.push_str("--"),
            '±' => text.push_str("$\\pm$"),
            '≥' => text.push_str("$\\geq$"),
            '×' => text.push_str("$\\times$"),
            'µ' | 'μ' => text.push_str("$\\mu$"),
            '·' => text.push_str("$\\cdot$"),
            '…' => text.push_str("\\ldots{}"),
            letter if letter.is_control() => text.push(' '),
            letter => text.push(letter),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    const AWKWARD: &str =
        "a\\b & 50 % of $x_1^2$ {#3} ~ \"it's\" <b> | `` -- ,, [4] * ± – × ≥ µs … é\n.";

    #[test]
    fn nothing_means_anything() {
        assert_eq!(
            escaped("R&D_1: 50 % #2 ${a}$ ~^\\"),
            "R\\&D\\_1: 50 \\% \\#2 \\$\\{a\\}\\$ \\textasciitilde{}\\textasciicircum{}\\textbackslash{}"
        );
        assert_eq!(escaped("[1] *a--b"), "{[}1] {*}a-{}-b");
        assert_eq!(escaped("\"x\"\n–"), "\\char34{}x\\char34{} --");
        let text = escaped(AWKWARD);
        // What is left of the signs after the ways in which they may stand are taken away.
        let plain = [
            "\\&", "\\%", "\\$", "\\#", "\\_", "\\{", "\\}", "$<$", "$>$", "$|$",
        ];
        let math = ["$\\pm$", "$\\geq$", "$\\times$", "$\\mu$", "$\\cdot$"];
        let left = plain
            .iter()
            .chain(&math)
            .fold(text, |text, known| text.replace(known, ""));
        assert!(
            !left.contains(['&', '%', '$', '#', '_', '^', '~', '\n']),
            "{left}"
        );
    }

    /// The compiler is asked where there is one.
    #[test]
    fn it_compiles() {
        let rows = [
            vec![AWKWARD.to_string(), "[n]".into()],
            vec!["[x]".into(), "*".into()],
            vec!["* y".into(), "[1]".into()],
            vec!["[3pt]".into(), "–".into()],
        ];
        let table = tabular(
            &rows,
            vec![false, true],
            ["seed 1 & 2".to_string()].into_iter(),
        );
        assert_eq!(table.matches("\\hline").count(), 3);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("table.tex"), table).unwrap();
        let document = "\\documentclass{article}\\begin{document}\\input{table}\\end{document}\n";
        std::fs::write(folder.path().join("paper.tex"), document).unwrap();
        let ran = Command::new("pdflatex")
            .args(["-interaction=nonstopmode", "-halt-on-error", "paper.tex"])
            .current_dir(folder.path())
            .output();
        match ran {
            Err(_) => eprintln!("SKIPPED: no pdflatex here"),
            Ok(ran) => assert!(
                ran.status.success(),
                "{}",
                String::from_utf8_lossy(&ran.stdout)
            ),
        }
    }
}
