//! What a look says about how its picture is shown.

use crate::view::{MAX_EXPOSURE, ViewChoice, ViewTransform, WhiteBalance};

use super::reader::{Reader, choice};
use super::value::{Field, Spanned, Value};

/// `[view]`: whatever is absent is left to the command line or the window.
pub(super) fn view(reader: &mut Reader, value: &Spanned<Value>) -> ViewChoice {
    const KEYS: [&str; 3] = ["transform", "exposure", "white_balance"];
    let mut view = ViewChoice::default();
    let Some(table) = reader.table(value, "a table headed [view]") else {
        return view;
    };
    for Field { key, value } in table {
        match key.value.as_str() {
            "transform" => {
                let all = ViewTransform::ALL.map(|view| (view.name(), view));
                view.transform = choice(reader, value, &all).map(|view| view.value);
            }
            "exposure" => {
                let wanted = format!("stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}");
                let is_valid = |x| (-MAX_EXPOSURE..=MAX_EXPOSURE).contains(&x);
                view.exposure = reader.number(value, &wanted, is_valid).map(|x| x.value);
            }
            "white_balance" => view.white_balance = white_balance(reader, value),
            _ => reader.unknown_key(key, "[view]", &KEYS),
        }
    }
    view
}

/// A temperature, or a temperature and a tint.
fn white_balance(reader: &mut Reader, value: &Spanned<Value>) -> Option<WhiteBalance> {
    let (temperatures, tints) = (WhiteBalance::TEMPERATURES, WhiteBalance::TINTS);
    let wanted = format!(
        "kelvins from {} to {}, or [kelvins, tint] with a tint from {} to {}",
        temperatures.start(),
        temperatures.end(),
        tints.start(),
        tints.end()
    );
    let (temperature, tint) = match value.value {
        Value::List(_) => {
            let [temperature, tint] = reader.numbers(value, &wanted)?.value;
            (temperature, Some(tint))
        }
        _ => (reader.number(value, &wanted, |_| true)?.value, None),
    };
    let balance = WhiteBalance::new(temperature, tint);
    if balance.is_none() {
        reader.problem(&value.span, format!("expected {wanted}"));
    }
    balance
}
