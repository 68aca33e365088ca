//! A report as one HTML page that stands alone: nothing is fetched, nothing is built, and it can be read without JavaScript.
//!
//! Tables are those of the terminal, pictures the SVG files that stand beside the page. What a page shows comes from users' files,
//! too (names of systems and datasets), so the template escapes every word.

mod player;

pub use player::player;

use super::Table;
use crate::error::{Error, Result};
use askama::Template;
use base64::{Engine, prelude::BASE64_STANDARD};

/// What a page shows, from top to bottom.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    /// Above everything, and in the browser's tab.
    pub title: String,
    /// What came of it in words, a paragraph each.
    pub summary: Vec<String>,
    /// The call that made it, where there is one that always makes the same.
    pub command: Option<String>,
    /// Tables, pictures and what stands between them.
    pub parts: Vec<Part>,
    /// What decided the results (a name and a text each), folded away at the end.
    pub config: Vec<(String, String)>,
}

/// A part of a page.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Part {
    /// Begins a section.
    Heading(String),
    /// A paragraph.
    Words(String),
    /// A table below its title.
    Table {
        /// What it shows.
        title: String,
        /// Itself.
        table: Table,
        /// Is it shown only when asked for? For tables that are too long or too wide to read.
        is_folded: bool,
    },
    /// A picture as SVG.
    Picture {
        /// What stands below it.
        caption: String,
        /// What it shows, for those who can't see it.
        alt: String,
        /// Itself, as this crate draws pictures.
        svg: String,
    },
    /// A picture in the plane's colours of pixels, such as a map.
    Image {
        /// What stands below it.
        caption: String,
        /// What it shows, for those who can't see it.
        alt: String,
        /// Bytes of the PNG file.
        png: Vec<u8>,
    },
    /// What systems believed, to be played; see [`player`].
    Player {
        /// JSON that the player reads.
        data: String,
        /// SVG that stands there without JavaScript.
        still: String,
    },
}

impl Part {
    /// A table that is there to be read.
    pub fn table(title: impl Into<String>, table: Table) -> Self {
        Part::Table {
            title: title.into(),
            table,
            is_folded: false,
        }
    }

    /// A table that is shown when asked for.
    pub fn folded(title: impl Into<String>, table: Table) -> Self {
        Part::Table {
            title: title.into(),
            table,
            is_folded: true,
        }
    }

    /// A picture with its caption and its description.
    pub fn picture(caption: impl Into<String>, alt: impl Into<String>, svg: String) -> Self {
        Part::Picture {
            caption: caption.into(),
            alt: alt.into(),
            svg,
        }
    }
}

/// A page as the text of an HTML file.
///
/// ```
/// use ballmark::report::{Cell, Page, Part, Table, page};
/// let mut table = Table::new(["system", "error (m)"]);
/// table.row([Cell::Text("<filters>".into()), Cell::Number(0.4, 2)]);
/// let parts = vec![Part::table("Errors", table)];
/// let html = page(&Page { title: "Localisation".into(), parts, ..Page::default() })?;
/// assert!(html.starts_with("<!doctype html>") && html.contains("&#60;filters&#62;"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// None but where the template fails.
pub fn page(page: &Page) -> Result<String> {
    let parts: Vec<Shown> = page.parts.iter().enumerate().map(Shown::of).collect();
    let has_player = (page.parts.iter()).any(|part| matches!(part, Part::Player { .. }));
    let headings = parts.iter().filter_map(|part| match part {
        Shown::Heading { id, words } => Some((id.clone(), (*words).to_string())),
        _ => None,
    });
    let template = PageTemplate {
        version: env!("CARGO_PKG_VERSION"),
        style: include_str!("page.css"),
        script: if has_player { player::SCRIPT } else { "" },
        headings: headings.collect(),
        parts,
        page,
    };
    let html = template.render();
    html.map_err(|e| Error::work(format!("cannot make the page `{}`: {e}", page.title)))
}

#[derive(Template)]
#[template(path = "page.html", config = "src/report/page/askama.toml")]
struct PageTemplate<'a> {
    version: &'static str,
    style: &'static str,
    script: &'static str,
    page: &'a Page,
    headings: Vec<(String, String)>,
    parts: Vec<Shown<'a>>,
}

/// A part as the template sees it.
enum Shown<'a> {
    Heading {
        id: String,
        words: &'a str,
    },
    Words {
        words: &'a str,
    },
    Table {
        title: &'a str,
        head: Vec<Shell>,
        rows: Vec<Vec<Shell>>,
        below: Vec<String>,
        is_folded: bool,
    },
    Picture {
        caption: &'a str,
        alt: &'a str,
        svg: &'a str,
    },
    Image {
        caption: &'a str,
        alt: &'a str,
        uri: String,
    },
    Player {
        data: &'a str,
        still: &'a str,
    },
}

/// A cell as the template sees it.
struct Shell {
    words: String,
    is_number: bool,
    is_head: bool,
}

impl<'a> Shown<'a> {
    fn of((index, part): (usize, &'a Part)) -> Self {
        match part {
            Part::Heading(words) => Shown::Heading {
                id: format!("part-{index}"),
                words,
            },
            Part::Words(words) => Shown::Words { words },
            Part::Table {
                title,
                table,
                is_folded,
            } => {
                let mut rows = table.shown().into_iter().map(|row| {
                    let cells = row.into_iter().enumerate();
                    let shell = |(column, words): (usize, String)| Shell {
                        words,
                        is_number: table.is_numeric(column),
                        is_head: column == 0 && !table.is_numeric(0),
                    };
                    cells.map(shell).collect()
                });
                Shown::Table {
                    title,
                    head: rows.next().unwrap_or_default(),
                    rows: rows.collect(),
                    below: table.below().collect(),
                    is_folded: *is_folded,
                }
            }
            Part::Picture { caption, alt, svg } => Shown::Picture { caption, alt, svg },
            Part::Image { caption, alt, png } => Shown::Image {
                caption,
                alt,
                uri: format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png)),
            },
            Part::Player { data, still } => Shown::Player { data, still },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Cell, Curve, line_plot};

    const AWKWARD: &str = "<script>alert(\"1\")</script> & 'b' | `c`";

    /// Whatever systems and datasets are called, it is text.
    #[test]
    fn awkward_names_stay_text_everywhere() {
        let mut table = Table::new([AWKWARD, "n"]);
        table.row([Cell::Text(AWKWARD.into()), Cell::Count(1)]);
        table.caption(AWKWARD);
        let curve = |name: &str| Curve {
            name: name.into(),
            x: vec![0.0, 1.0],
            y: vec![0.0, 1.0],
            band: None,
        };
        let svg = line_plot(AWKWARD, AWKWARD, AWKWARD, &[curve(AWKWARD), curve("b")]).unwrap();
        let all = Page {
            title: AWKWARD.into(),
            summary: vec![AWKWARD.into()],
            command: Some(AWKWARD.into()),
            parts: vec![
                Part::Heading(AWKWARD.into()),
                Part::Words(AWKWARD.into()),
                Part::table(AWKWARD, table.clone()),
                Part::folded(AWKWARD, table),
                Part::picture(AWKWARD, AWKWARD, svg),
            ],
            config: vec![(AWKWARD.into(), AWKWARD.into())],
        };
        let html = page(&all).unwrap();
        assert!(!html.contains("<script>alert"), "{html}");
        assert!(!html.contains("\"1\")"), "{html}");
        assert!(html.matches("alert(").count() >= 15);
        assert!(html.ends_with("</html>\n") || html.ends_with("</html>"));
    }

    #[test]
    fn numbers_stand_right_and_names_head_their_rows() {
        let mut table = Table::new(["system", "m"]);
        table.row([Cell::Text("a".into()), Cell::Number(1.25, 1)]);
        let html = page(&Page {
            parts: vec![Part::table("t", table)],
            ..Page::default()
        });
        let html = html.unwrap();
        assert!(html.contains("<th scope=\"row\">a</th>"), "{html}");
        assert!(html.contains("<td class=\"number\">1.2</td>"), "{html}");
    }
}
