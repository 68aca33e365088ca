//! The name of a column, taken apart: its number in the spellings that people use, and what it states in brackets.

/// Characters of a name that a message quotes.
const SHOWN: usize = 40;

/// How a number stands behind a channel's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Spelling {
    /// `sonar.3`
    Dot,
    /// `sonar[3]`
    Bracket,
    /// `sonar(3)`
    Parenthesis,
    /// `sonar_3`
    Underscore,
    /// `sonar3`, `WAP003`
    Bare,
}

impl Spelling {
    /// Is a number in this spelling nothing but a number? `gas_2` and `co2` may be names of their own.
    pub(super) fn is_certain(self) -> bool {
        matches!(self, Self::Dot | Self::Bracket | Self::Parenthesis)
    }

    pub(super) fn column(self, name: &str, number: usize) -> String {
        match self {
            Self::Dot => format!("{name}.{number}"),
            Self::Bracket => format!("{name}[{number}]"),
            Self::Parenthesis => format!("{name}({number})"),
            Self::Underscore => format!("{name}_{number}"),
            Self::Bare => format!("{name}{number}"),
        }
    }
}

/// A sensor column: where it stands, what it is called, and what its name says in brackets.
pub(super) struct Column<'a> {
    pub position: usize,
    pub name: &'a str,
    pub stated: Stated<'a>,
    pub numbered: Option<Numbered<'a>>,
}

#[derive(Clone, Copy)]
pub(super) struct Numbered<'a> {
    pub stem: &'a str,
    pub number: usize,
    pub spelling: Spelling,
    /// Digits, where zeros were put before the number.
    pub padded: Option<usize>,
}

/// What a name states in brackets: `[mm @ 22.5 + 0.2]` is the unit, the bearing in degrees and the offset in metres.
#[derive(Default, Clone, Copy)]
pub(super) struct Stated<'a> {
    pub unit: Option<&'a str>,
    pub bearing_deg: Option<f64>,
    pub offset_m: Option<f64>,
}

/// Takes a column's name apart: what it states in brackets, and its number.
pub(super) fn column<'a>(
    position: usize,
    whole: &'a str,
) -> std::result::Result<Column<'a>, String> {
    let bracketed = whole
        .strip_suffix(']')
        .and_then(|name| name.rsplit_once('['));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let (name, stated) = match bracketed {
        Some((name, text)) if !is_number(text.trim()) && !name.is_empty() => {
            let stated = stated(text).ok_or_else(|| {
                format!(
                    "column `{}`: expected NAME[UNIT], NAME[UNIT @ DEGREES] or NAME[UNIT @ DEGREES + METRES]",
                    shown(whole)
                )
            })?;
            (name.trim_end(), stated)
        }
        _ => (whole, Stated::default()),
    };
    Ok(Column {
        position,
        name,
        stated,
        numbered: numbered(name),
    })
}

fn stated(text: &str) -> Option<Stated<'_>> {
    let (unit, direction) = match text.split_once('@') {
        None => (text, None),
        Some((unit, direction)) => (unit, Some(direction)),
    };
    let unit = Some(unit.trim()).filter(|unit| !unit.is_empty());
    let Some(direction) = direction else {
        return Some(Stated {
            unit,
            ..Stated::default()
        });
    };
    let (bearing, offset) = match direction
        .split_once('+')
        .filter(|(b, _)| !b.trim().is_empty())
    {
        None => (direction, None),
        Some((bearing, offset)) => (bearing, Some(offset)),
    };
    let number = |text: &str, units: [&str; 2]| {
        let text = text.trim();
        let bare = units.iter().find_map(|unit| text.strip_suffix(unit));
        let number = bare.unwrap_or(text).trim().parse::<f64>().ok();
        number.filter(|n| n.is_finite())
    };
    Some(Stated {
        unit,
        bearing_deg: Some(number(bearing, ["deg", "°"])?),
        offset_m: match offset {
            None => None,
            Some(offset) => Some(number(offset, ["m", " m"])?),
        },
    })
}

fn numbered(name: &str) -> Option<Numbered<'_>> {
    let closed = |end: char, start: char| {
        let (stem, number) = name.strip_suffix(end)?.rsplit_once(start)?;
        Some((stem, number.trim()))
    };
    let bare = || {
        let digits = name.bytes().rev().take_while(u8::is_ascii_digit).count();
        Some(name.split_at(name.len() - digits)).filter(|_| digits > 0)
    };
    let is_number = |(stem, number): &(&str, &str)| {
        !stem.is_empty() && !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    };
    let tried = [
        (name.rsplit_once('.'), Spelling::Dot),
        (closed(']', '['), Spelling::Bracket),
        (closed(')', '('), Spelling::Parenthesis),
        (name.rsplit_once('_'), Spelling::Underscore),
        (bare(), Spelling::Bare),
    ];
    let mut found = tried
        .into_iter()
        .filter_map(|(cut, spelling)| Some((cut.filter(is_number)?, spelling)));
    let ((stem, digits), spelling) = found.next()?;
    Some(Numbered {
        stem,
        number: digits.parse().ok()?,
        spelling,
        padded: (digits.len() > 1 && digits.starts_with('0')).then_some(digits.len()),
    })
}

/// A column's name without what it states in brackets, and without its number: what it may also be called.
pub(super) fn bare_and_stem(whole: &str) -> (&str, Option<&str>) {
    let bare = column(0, whole).map_or(whole, |column| column.name);
    (bare, numbered(bare).map(|n| n.stem))
}

/// A name as messages quote it.
pub(super) fn shown(name: &str) -> String {
    let cut: String = name.chars().take(SHOWN).collect();
    let rest = if cut.len() < name.len() { "…" } else { "" };
    format!("{}{rest}", cut.escape_debug())
}
