// The values of nodes of the look that the film keeps, of the surface that a path met last: a field each, behind all results of its
// program. The surface may have none of them.
//!include generated/node_fields.wgsl

override node_layers: u32 = 0u; // how many

fn node_field(number: u32) -> u32 {
    return results_field() + FIRST_NODE_FIELD + number;
}
