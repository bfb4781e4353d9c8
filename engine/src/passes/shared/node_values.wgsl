// The values of nodes of the look that the film keeps, of the surface that a path met last: a field each, behind all results of its
// program. The surface may have none of them.

override node_layers: u32 = 0u; // how many
override first_node_field: u32 = 0u; // from the first field of results on

fn node_field(number: u32) -> u32 {
    return results_field() + first_node_field + number;
}
