//! Numbers in a text, and which of them look measured.

use super::blocks::{Block, Kind};

/// Behind a number these make it one that somebody measured, or chose. Lengths, forces and the like are left out: they
/// mostly tell a scene.
const UNITS: [&str; 24] = [
    "%",
    "ns",
    "µs",
    "ms",
    "s",
    "min",
    "minute",
    "minutes",
    "hour",
    "hours",
    "kB",
    "MB",
    "GB",
    "MiB",
    "GiB",
    "bytes",
    "times",
    "rollout",
    "rollouts",
    "wrench",
    "wrenches",
    "evaluations",
    "steps a second",
    "steps per second",
];

struct Number<'t> {
    digits: &'t str,
    behind: &'t str,
}

impl Number<'_> {
    fn is_measured(&self) -> bool {
        let behind = self.behind.strip_prefix(' ').unwrap_or(self.behind);
        let has_unit = |unit: &&str| {
            let rest = behind.strip_prefix(*unit);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        // A product such as 4×4 is a size.
        let is_ratio = behind
            .strip_prefix('×')
            .is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_digit()));
        let is_small = ["e-", "e−"].iter().any(|sign| self.digits.contains(sign));
        self.digits.contains(',') || is_small || is_ratio || UNITS.iter().any(has_unit)
    }
}

/// Whether a block has figures. In a table every number is one, but for those of the first column, which names the rows.
pub fn has_figures(block: &Block) -> bool {
    match block.kind {
        Kind::Table => body_cells(&block.text).any(|cell| !numbers(&prose(cell)).is_empty()),
        Kind::Paragraph | Kind::Item => has_measured(&prose(&block.flat())),
        Kind::Output => has_measured(&block.text),
        Kind::Heading | Kind::Script | Kind::Program => false,
    }
}

/// An exponent of growth, which lies between 1 and 2, is measured too, though it has no unit.
fn has_measured(text: &str) -> bool {
    text.contains("to the power 1") || numbers(text).iter().any(Number::is_measured)
}

fn body_cells(table: &str) -> impl Iterator<Item = &str> {
    let rows = table.lines().skip(2);
    rows.flat_map(|row| row.trim().trim_matches('|').split('|').skip(1))
}

/// The text without code and without the targets of links.
fn prose(text: &str) -> String {
    let without_code: Vec<&str> = text.split('`').step_by(2).collect();
    let mut parts = without_code.join("`");
    while let Some(start) = parts.find("](") {
        let length = parts[start..].find(')').map_or(2, |end| end + 1);
        parts.replace_range(start..start + length, "");
    }
    parts
}

/// All numbers that are not part of a name, a fraction of symbols or a version.
fn numbers(text: &str) -> Vec<Number<'_>> {
    let (mut found, mut from) = (Vec::new(), 0);
    while let Some(offset) = text[from..].find(|next: char| next.is_ascii_digit()) {
        let start = from + offset;
        let end = start + number_length(&text[start..]);
        let is_reference = ["chapter ", "order "]
            .iter()
            .any(|before| text[..start].ends_with(before));
        let is_inside = |next: char| next.is_alphanumeric() || "_./^".contains(next);
        let is_name = text[..start].ends_with(is_inside)
            || text[end..].starts_with(|next: char| next.is_alphabetic() || next == '_');
        if !is_name && !is_reference {
            found.push(Number {
                digits: &text[start..end],
                behind: &text[end..],
            });
        }
        from = end;
    }
    found
}

/// Of a text that begins with a digit.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| {
        text.len()
            - text
                .trim_start_matches(|next: char| next.is_ascii_digit())
                .len()
    };
    let mut length = digits(text);
    while text[length..].starts_with(',') && digits(&text[length + 1..]) == 3 {
        length += 4;
    }
    if text[length..].starts_with('.') {
        let decimals = digits(&text[length + 1..]);
        length += if decimals > 0 { decimals + 1 } else { 0 };
    }
    if let Some(exponent) = text[length..].strip_prefix('e') {
        let unsigned = exponent.trim_start_matches(['-', '−', '+']);
        if digits(unsigned) > 0 {
            length += 1 + exponent.len() - unsigned.len() + digits(unsigned);
        }
    }
    length
}

#[test]
fn figures_are_told_from_names_sizes_and_formulas() {
    let is_figure = |text: &str| has_measured(&prose(text));
    for text in [
        "takes 254 µs",
        "3.4× as long",
        "1.9 to 2.3 times",
        "off by 7 %",
        "to 2.8e-5",
        "1,084 mutants",
        "−6e−8",
        "grows to the power 1.05",
        "in 50 min",
        "2.4 MB are enough",
        "0.6 ms; time",
        "(1.08 wrenches)",
    ] {
        assert!(is_figure(text), "{text}");
    }
    for text in [
        "grows to the power of two",
        "a 12×28 Jacobian",
        "`Plan::new(2e-4, 1,000)`",
        "[a run](run_2.6%20s.md)",
        "2√(m/k)",
        "E/4 times",
        "version 1.2.3",
        "10 steps",
        "chapter 3",
        "p^2 s",
        "10⁶ steps",
        "2s/d",
    ] {
        assert!(!is_figure(text), "{text}");
    }
}

#[test]
fn numbers_in_the_body_of_a_table_are_figures() {
    let table = |cell: &str| Block {
        line: 1,
        kind: Kind::Table,
        text: format!("| of 3 | in 2 steps |\n|---|---|\n| row 5 | {cell} |\n"),
    };
    for cell in ["7", "about 2.5 or so", "−3e-4", "(1)"] {
        assert!(has_figures(&table(cell)), "{cell}");
    }
    for cell in [
        "",
        "`5`",
        "2E/x",
        "min(x, y/2)",
        "κ = mg/(πRd²)",
        "[here](7.md)",
    ] {
        assert!(!has_figures(&table(cell)), "{cell}");
    }
}
