//! Rows of words under each other.

use crate::console::grouped;

/// Most columns of blanks that one long word costs all the others.
const WIDEST: usize = 32;

/// A number of things.
pub(super) fn counted(count: usize, one: &str, many: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        _ => format!("{} {many}", grouped(count as u64)),
    }
}

/// Lines with two blanks before them, whose words stand in columns; the last one has all the room it needs.
pub(super) fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let words = rows.iter().filter_map(|row| row.get(column));
        let widths = words.map(|word| word.chars().count());
        widths.filter(|&width| width <= WIDEST).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::from("  ");
        for (word, width) in row.iter().zip(&widths) {
            line.push_str(&format!("{word:width$}  "));
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// A title with a table below it; nothing where there are no rows.
pub(super) fn section(title: &str, rows: &[Vec<String>]) -> String {
    match rows.is_empty() {
        true => String::new(),
        false => format!("\n{title} ({})\n{}", rows.len(), table(rows)),
    }
}

/// A number as people write it: not more digits than single precision has.
pub(super) fn number(value: f32) -> String {
    let text = format!("{value:.4}");
    match text.contains('.') && value.abs() < 1e6 {
        true if value != 0.0 && value.abs() < 1e-3 => format!("{value:.2e}"),
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => format!("{value:.3e}"),
    }
}

/// Numbers with blanks between.
pub(super) fn numbers(values: &[f32]) -> String {
    let words: Vec<_> = values.iter().copied().map(number).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_in_columns() {
        let row = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
        let rows = [row(&["a", "b", "c"]), row(&["long", "", "d"]), row(&["x"])];
        assert_eq!(table(&rows), "  a     b  c\n  long     d\n  x\n");
        assert_eq!(section("things", &rows[2..]), "\nthings (1)\n  x\n");
        assert_eq!(section("things", &[]), "");
    }

    #[test]
    fn numbers_are_short() {
        for (value, wanted) in [
            (0.0, "0"),
            (0.5, "0.5"),
            (-12.0, "-12"),
            (0.123_456, "0.1235"),
            (1e-5, "1.00e-5"),
            (1e10, "1.000e10"),
            (f32::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), wanted);
        }
    }
}
