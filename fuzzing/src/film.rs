//! Partial renders: what is read and written again is the same, and its samples can be merged once.

use engine::film::{Part, PartError, sealed};

use crate::{check_message, memory};

/// Held beside what the file needs.
const SLACK: usize = 4 << 20;

pub(crate) fn run(data: &[u8]) -> bool {
    // A change is nearly always found by the checksum; what lies behind it is tried with the right one.
    check(data) | sealed(data).is_some_and(|sealed| check(&sealed))
}

fn read(data: &[u8]) -> Result<Part, PartError> {
    Part::read(&mut &data[..], data.len() as u64)
}

fn written(part: &Part) -> Vec<u8> {
    let mut bytes = Vec::new();
    part.write(&mut bytes).expect("memory takes everything");
    bytes
}

fn check(data: &[u8]) -> bool {
    let part = match memory::within(data.len(), SLACK, || read(data)) {
        Ok(part) => part,
        Err(error) => {
            check_message(&error.to_string());
            return false;
        }
    };
    let again = written(&part);
    let read_again = read(&again).expect("what was written is read");
    assert_eq!(part, read_again);
    assert_eq!(again, written(&read_again));
    assert!(part.film.mean().iter().flatten().all(|v| v.is_finite()));
    assert!(
        part.film
            .standard_error()
            .iter()
            .flatten()
            .all(|v| !v.is_nan())
    );
    for layer in part.film.layers().iter() {
        let channels = part.film.channels(layer).expect("it was gathered");
        // An error of less than two samples is infinite.
        assert!(channels.iter().flatten().all(|v| !v.is_nan()));
    }
    let mut merged = part.clone();
    assert!(merged.merge(&read_again).is_err(), "each sample once");
    assert_eq!(merged, part, "nothing was added");
    true
}
