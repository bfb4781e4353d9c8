// Where the values of each layer lie in what is recorded of a path, by the layer's number; 0: it is not asked for. One kernel serves
// whatever layers a film has.
//!include generated/film_words.wgsl

@group(0) @binding(56) var<uniform> layer_words: array<vec4u, LAYER_ROWS>;
