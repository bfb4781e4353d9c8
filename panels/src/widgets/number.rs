//! Fields of numbers that keep what isn't shown of a value.

use std::cell::RefCell;
use std::rc::Rc;

use egui::{DragValue, Id, Key, Response, Ui};

/// A field for a number. What is typed counts once the field is left, unless by Escape. One that is left with the text that it was entered
/// with keeps its value to the last bit: by itself it would have that of its text, which is rounded.
pub fn number_field(ui: &mut Ui, field: DragValue<'_>) -> Response {
    let formatter = ui.style().number_formatter.clone();
    // The field is left in one pass, and its text read in the next one, which knows nothing of the key.
    let (id, pass) = (
        Id::unique("number field left by Escape"),
        ui.ctx().cumulative_pass_nr(),
    );
    if ui.input(|input| input.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.insert_temp(id, pass));
    }
    let escaped = ui.data(|data| data.get_temp::<u64>(id));
    let is_given_up = escaped.is_some_and(|at| pass <= at + 1);
    let shown = Rc::new(RefCell::new(String::new()));
    let kept = Rc::clone(&shown);
    let field = field
        // A value that is set is shown, rounded, in place of the half of a number that has been typed.
        .update_while_editing(false)
        .custom_formatter(move |value, decimals| {
            let text = formatter.format(value, decimals);
            kept.borrow_mut().clone_from(&text);
            text
        })
        .custom_parser(
            move |text| match is_given_up || text == shown.borrow().as_str() {
                true => None,
                false => parse(text),
            },
        );
    ui.add(field)
}

/// A number that a value can be. Spaces don't count, and a true minus is as good as a hyphen.
fn parse(text: &str) -> Option<f64> {
    let text: String = text
        .chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| if c == '\u{2212}' { '-' } else { c })
        .collect();
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_people_write_them() {
        for (text, number) in [
            ("0.0004", Some(4e-4)),
            (" 12 000.5 ", Some(12_000.5)),
            ("\u{2212}3", Some(-3.0)),
            ("1e-7", Some(1e-7)),
            ("nan", None),
            ("-inf", None),
            ("1e999", None),
            ("", None),
            ("12 m", None),
        ] {
            assert_eq!(parse(text), number, "{text}");
        }
    }
}
