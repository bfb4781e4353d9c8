//! The look and textures that these tests begin with.

/// Every kind of table, with comments.
pub(crate) const LOOK: &str = r##"# A look to be edited.
environment = { color = [0.9, 0.95, 1.0], intensity = 1.0 } # the sky

[camera]
position = [0.1, 0.9, 3.0]   # metres
look_at = [0, 0.4, 0]
y_fov = 45

[ao.crevices]
distance = 0.4
samples = 4

# Rings around the origin.
[node.rings]
texture = "rings"
count = 5.0 # of them

[node.other]
texture = "rings"
count = 2.5

[node.paint]
texture = "tint"
color = [0.8, 0.3, 0.1]
amount = "rings"

[node.worn]
texture = "worn"
occlusion = "crevices"
ramp = [[0.0, "#20100a"], [0.6, "#7a3b12"], [1.0, "#c46a2a"]]

[material.Floor]
base_color = "paint"
roughness = "rings"

[material.Wall]
roughness = 0.35
coat = 0.5
blend = { base = "Wall", over = "Worn", mask = "rings" }

# Not in the scene.
[material.Worn]
base_color = "worn"
roughness = 0.9
"##;

pub(crate) const RINGS: &str = "/// @param count rings = 3
fn userProc(count: f32) -> f32 {
    return 0.5 + 0.5 * sin(count * length(readAttr(WorldPos).xyz));
}
";

pub(crate) const TINT: &str = "/// @param color colour [color] = (1, 1, 1)
/// @param amount how much = 0.5
fn userProc(color: vec3f, amount: f32) -> vec3f {
    return color * amount * amount;
}
";

pub(crate) const WORN: &str = "/// @param scale how often = 3
fn userProc(ramp: ramp1D, scale: f32) -> vec4f {
    let p = readAttr(WorldPos).xyz * scale;
    return rampEval(ramp, fract(p.x + p.y) * readAttr(AO).x);
}
";

/// Another rings, with a parameter more.
pub(crate) const SQUARES: &str = "/// @param count squares = 3
/// @param edge = 0.25
fn userProc(count: f32, edge: f32) -> f32 {
    let p = fract(readAttr(WorldPos).xz * count);
    return select(0.2, 0.9, min(p.x, p.y) > edge);
}
";

pub(crate) const TEXTURES: [(&str, &str); 3] = [("rings", RINGS), ("tint", TINT), ("worn", WORN)];
