// From the tables of `material_record`; `cargo test -p engine generated` writes it.
const FIRST_NODE_FIELD = 10u;
