// What the host supplies in the same module as a generated kernel, doing nothing. Everything the kernel calls
// and does not define itself is here; a host replaces the bodies and may have anything else beside them, as long
// as its names neither begin with `patina_` nor hold a double underscore, nor are those of the prelude.

// Word i of the program buffer.
fn patina_program_word(i: u32) -> u32 { return 0u; }

// Word i of the fake stack. Has to survive any i.
fn patina_arg_word(i: u32) -> u32 { return 0u; }

// Images, by the handle that the graph's `Value::Image` carries. Have to survive any handle.
fn patina_sample_image(image: u32, uv: vec2f) -> vec4f { return vec4f(1.0); }
fn patina_sample_image_lod(image: u32, uv: vec2f, lod: f32) -> vec4f { return vec4f(1.0); }
fn patina_image_size(image: u32) -> vec2f { return vec2f(1.0); }

// `AO` and `AO1` are one function of the AO slot that the node asks for.
fn patina_attr_AO(slot: u32) -> vec4f { return vec4f(0.0); }

// Custom mesh attributes, by their index in `Library::custom_attributes`.
fn patina_attr_custom(index: u32) -> vec4f { return vec4f(0.0); }

// The other attributes of the current hit, and settings of the render: from the tables of `attribute.rs`.
