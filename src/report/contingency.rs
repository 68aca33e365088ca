//! Responses against locations as a heat map (Duckett & Nehmzow 1998, Fig. 3).

use super::canvas::{GRID, WIDTH, at, font, picture, px, shortened};
use crate::{
    error::Result,
    score::{AnswerCount, Responses},
};
use plotters::{
    prelude::*,
    style::{
        RGBColor,
        text_anchor::{HPos, Pos, VPos},
    },
};
use std::collections::BTreeMap;

/// Most labels of each kind that are drawn: those that come most often.
pub const MOST_LABELS: usize = 60;

const SHADE: RGBColor = RGBColor(0, 114, 178);
/// Edge of a cell in pixels: as large as fits, but not larger.
const LARGEST: u32 = 36;
const LEFT: u32 = 150;
const BELOW: u32 = 110;

/// A row a location, a column a response; the darker, the larger the share of the response's answers that were given there. A response
/// that says where the robot is has one dark cell in its column.
///
/// # Errors
/// Where drawing fails.
///
/// ```
/// use ballmark::{report::contingency_plot, score::Responses};
/// let csv = "location,response\nhall,1\nhall,1\ndoor,2\ndoor,1\n";
/// let svg = contingency_plot("Answers", &Responses::from_reader("answers.csv", csv.as_bytes())?)?;
/// assert!(svg.contains("hall") && svg.contains("door"));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn contingency_plot(title: &str, responses: &Responses) -> Result<String> {
    let rows = responses.location().iter().zip(responses.response());
    plot(title, rows.map(|(at, response)| (&**at, &**response, 1)))
}

/// The same of answers that are counted already.
///
/// # Errors
/// Where drawing fails.
pub fn answers_plot(title: &str, answers: &[AnswerCount]) -> Result<String> {
    let named: Vec<(String, &AnswerCount)> = answers
        .iter()
        .map(|answer| (answer.location.to_string(), answer))
        .collect();
    let cells = named.iter();
    plot(
        title,
        cells.map(|(at, answer)| (&**at, &*answer.response, answer.count)),
    )
}

fn plot<'a>(title: &str, cells: impl Iterator<Item = (&'a str, &'a str, u64)>) -> Result<String> {
    let mut counts: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    let mut of_location: BTreeMap<&str, u64> = BTreeMap::new();
    let mut of_response: BTreeMap<&str, u64> = BTreeMap::new();
    for (location, response, count) in cells {
        *counts.entry((location, response)).or_default() += count;
        *of_location.entry(location).or_default() += count;
        *of_response.entry(response).or_default() += count;
    }
    let (locations, answers) = (labels(&of_location), labels(&of_response));
    let (rows, columns) = (locations.len().max(1) as u32, answers.len().max(1) as u32);
    let edge = ((WIDTH - LEFT - 30) / columns)
        .min(700 / rows)
        .clamp(6, LARGEST);
    // Names as far apart as letters are high.
    let (each_row, each_column) = (16u32.div_ceil(edge), 16u32.div_ceil(edge));
    picture(40 + rows * edge + BELOW, title, |canvas| {
        for (row, location) in locations.iter().enumerate() {
            let top = row as u32 * edge;
            if (row as u32).is_multiple_of(each_row) {
                let beside = font(13).pos(Pos::new(HPos::Right, VPos::Center));
                let corner = (at(LEFT - 6), at(top) + px(edge) as i32 / 2);
                canvas.draw(&Text::new(shortened(location, 20), corner, beside))?;
            }
            for (column, response) in answers.iter().enumerate() {
                let left = LEFT + column as u32 * edge;
                let count = counts.get(&(*location, *response)).copied().unwrap_or(0);
                let all = of_response.get(response).copied().unwrap_or(0).max(1);
                if count > 0 {
                    let share = count as f64 / all as f64;
                    canvas.draw(&Rectangle::new(
                        [(at(left), at(top)), (at(left + edge), at(top + edge))],
                        SHADE.mix(0.08 + 0.92 * share).filled(),
                    ))?;
                }
            }
        }
        // A line between any two, as a frame a cell makes a large picture of a large table.
        let (right, bottom) = (LEFT + columns * edge, rows * edge);
        let across = (0..=rows).map(|row| [(LEFT, row * edge), (right, row * edge)]);
        let down = (0..=columns).map(|column| LEFT + column * edge);
        for ends in across.chain(down.map(|x| [(x, 0), (x, bottom)])) {
            canvas.draw(&PathElement::new(
                ends.map(|(x, y)| (at(x), at(y))),
                ShapeStyle::from(&GRID).stroke_width(px(1)),
            ))?;
        }
        for (column, response) in answers.iter().enumerate() {
            if (column as u32).is_multiple_of(each_column) {
                let below = font(13)
                    .transform(FontTransform::Rotate90)
                    .pos(Pos::new(HPos::Left, VPos::Center));
                let x = at(LEFT + column as u32 * edge) + px(edge) as i32 / 2;
                let name = shortened(response, 10);
                canvas.draw(&Text::new(name, (x, at(rows * edge + 6)), below))?;
            }
        }
        let words = font(14).pos(Pos::new(HPos::Left, VPos::Top));
        canvas.draw(&Text::new(
            "response",
            (at(LEFT), at(rows * edge + BELOW - 24)),
            words.clone(),
        ))?;
        canvas.draw(&Text::new("location", (at(14), at(4)), words))?;
        Ok(())
    })
}

/// The labels that come most often, numbers by their size before words by their letters.
fn labels<'a>(counts: &BTreeMap<&'a str, u64>) -> Vec<&'a str> {
    let mut often: Vec<(&str, u64)> = counts.iter().map(|(label, n)| (*label, *n)).collect();
    often.sort_by_key(|(_, count)| std::cmp::Reverse(*count)); // stable: ties by their letters
    often.truncate(MOST_LABELS);
    let mut labels: Vec<&str> = often.into_iter().map(|(label, _)| label).collect();
    let number = |label: &str| label.parse::<f64>().unwrap_or(f64::INFINITY);
    labels.sort_by(|a, b| number(a).total_cmp(&number(b)).then_with(|| a.cmp(b)));
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_in_order_and_rare_labels_are_left_out() {
        let all = ["10", "9", "b", "a"].map(|label| (label, 1));
        assert_eq!(labels(&all.into()), ["9", "10", "a", "b"]);
        let names: Vec<String> = (0..100).map(|n| n.to_string()).collect();
        let many = names.iter().enumerate();
        let many = many.map(|(k, name)| (name.as_str(), 1 + u64::from(k >= 90)));
        let kept = labels(&many.collect());
        assert_eq!(kept.len(), MOST_LABELS);
        assert!(kept.contains(&"99") && kept.contains(&"0") && !kept.contains(&"89"));
    }

    /// A label may hold anything; XML may not.
    #[test]
    fn control_characters_are_replaced() {
        let csv = "location,response\na\u{0}b,1\nb,\u{12}<&>\n";
        let responses = Responses::from_reader("r.csv", csv.as_bytes()).unwrap();
        let svg = contingency_plot("t\u{1}", &responses).unwrap();
        assert!(svg.contains("a\u{fffd}b") && svg.contains("&lt;"), "{svg}");
        assert!(!svg.chars().any(|c| c.is_control() && c != '\n'));
    }

    /// Response 1 twice at a and once at b, 2 once at b: shares 2/3, 1/3 and 1.
    #[test]
    fn shades_are_shares_of_a_response() {
        let csv = "location,response\na,1\na,1\nb,1\nb,2\n";
        let responses = Responses::from_reader("r.csv", csv.as_bytes()).unwrap();
        let svg = contingency_plot("t", &responses).unwrap();
        let shades: Vec<&str> = svg
            .lines()
            .filter(|l| l.contains("fill=\"#0072B2\""))
            .collect();
        let opacity = |share: f64| format!("opacity=\"{}", 0.08 + 0.92 * share);
        assert_eq!(shades.len(), 3, "{svg}");
        for share in [2.0 / 3.0, 1.0 / 3.0, 1.0] {
            let start = &opacity(share);
            let start = &start[..start.len().min(13)];
            assert!(
                shades.iter().any(|line| line.contains(start)),
                "{start}: {shades:?}"
            );
        }
    }
}
