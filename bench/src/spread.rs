//! A figure over several runs, and how it is written.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// A figure over several runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The one in the middle; the mean of two where their number is even.
    pub median: f64,
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
}

impl Spread {
    /// Of at least one value; zeros where there is none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let [Some(&low), Some(&high)] = [values.first(), values.last()] else {
            return Self {
                median: 0.0,
                low: 0.0,
                high: 0.0,
            };
        };
        let middle = values.len() / 2;
        let median = match values.len().is_multiple_of(2) {
            true => 0.5 * (values[middle - 1] + values[middle]),
            false => values[middle],
        };
        Self { median, low, high }
    }
}

/// Writes a figure as plain numbers beside its neighbours, easy to read for other programs: `ms_per_spp` is the median,
/// `ms_per_spp_low` and `ms_per_spp_high` are the bounds.
pub(crate) fn flat_ms_per_spp<S: Serializer>(value: &Spread, to: S) -> Result<S::Ok, S::Error> {
    flat(
        value,
        ["ms_per_spp", "ms_per_spp_low", "ms_per_spp_high"],
        to,
    )
}

/// As [`flat_ms_per_spp`], of plain gray.
pub(crate) fn flat_gray<S: Serializer>(value: &Spread, to: S) -> Result<S::Ok, S::Error> {
    let names = [
        "gray_ms_per_spp",
        "gray_ms_per_spp_low",
        "gray_ms_per_spp_high",
    ];
    flat(value, names, to)
}

/// As [`flat_ms_per_spp`], with how far the bounds are apart.
pub(crate) fn flat_increase<S: Serializer>(value: &Spread, to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(4))?;
    map.serialize_entry("increase_percent", &value.median)?;
    map.serialize_entry("increase_low", &value.low)?;
    map.serialize_entry("increase_high", &value.high)?;
    map.serialize_entry("increase_spread", &(value.high - value.low))?;
    map.end()
}

fn flat<S: Serializer>(value: &Spread, names: [&str; 3], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(3))?;
    for (name, value) in names.into_iter().zip([value.median, value.low, value.high]) {
        map.serialize_entry(name, &value)?;
    }
    map.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        let spread = |values: &[f64]| {
            let Spread { median, low, high } = Spread::of(values.iter().copied());
            (low, median, high)
        };
        assert_eq!(spread(&[3.0, 1.0, 7.0]), (1.0, 3.0, 7.0));
        assert_eq!(spread(&[4.0, 1.0]), (1.0, 2.5, 4.0));
        assert_eq!(spread(&[]), (0.0, 0.0, 0.0));
    }

    #[test]
    fn figures_are_plain_numbers_in_json() {
        #[derive(Serialize)]
        struct Row {
            mode: &'static str,
            #[serde(flatten, serialize_with = "flat_ms_per_spp")]
            ms: Spread,
            #[serde(flatten, serialize_with = "flat_increase")]
            increase: Spread,
        }
        let row = Row {
            mode: "stack",
            ms: Spread::of([2.0, 1.0, 4.0]),
            increase: Spread::of([10.0, 12.0, 20.0]),
        };
        let value = serde_json::to_value(&row).expect("it is JSON");
        let expected = serde_json::json!({
            "mode": "stack",
            "ms_per_spp": 2.0, "ms_per_spp_low": 1.0, "ms_per_spp_high": 4.0,
            "increase_percent": 12.0, "increase_low": 10.0, "increase_high": 20.0, "increase_spread": 10.0,
        });
        assert_eq!(value, expected);
    }
}
