//! patina
fn main() {}
