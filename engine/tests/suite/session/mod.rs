//! Live rendering: after whatever edits, failures and losses the film is, bit by bit, that of a fresh render of the look
//! as it is then.

#[expect(dead_code, reason = "other tests use the rest")]
#[path = "../support/mod.rs"]
mod support;

mod edits;
mod files;
mod look;
mod losses;
mod random;
mod stage;
mod view;
mod watch;
