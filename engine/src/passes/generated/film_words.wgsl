// From the table of layers; `cargo test -p engine generated` writes it.
const LAYER_ROWS = 17u;
