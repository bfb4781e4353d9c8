//! What swatches show of textures whose defaults give one plain colour, or leave everything as it is: a look for each.

use std::path::Path;

use engine::scene::look::Look;

use crate::failure::Failure;

/// The node of those looks that is shown.
pub(super) const NODE: &str = "shown";
/// The node that their left half shows, where they have it: what goes in.
pub(super) const INPUT: &str = "input";

/// Colours from the top to the bottom, to be changed.
const COLOURS: &str = "\
[node.uv]
texture = \"coordinates\"
space = 2
[node.input]
texture = \"ramp\"
t = \"uv.y\"
";

/// Textures, which nodes theirs is linked to, and its arguments.
const LOOKS: &[(&str, &str, &str)] = &[
    (
        "blackbody",
        "[node.across]\ntexture = \"map_range\"\nto_min = 1000.0\nto_max = 12000.0\n",
        "temperature = \"across\"\nintensity = 0.6\n",
    ),
    (
        "wavelength",
        "[node.across]\ntexture = \"map_range\"\nto_min = 380.0\nto_max = 780.0\n",
        "nanometres = \"across\"\n",
    ),
    (
        "combine",
        "[node.uv]\ntexture = \"coordinates\"\nspace = 2\n",
        "x = \"uv.x\"\ny = 0.7\nz = \"uv.y\"\nmode = 1\n",
    ),
    (
        "mix_color",
        "[node.across]\ntexture = \"map_range\"\n",
        "a = \"#3a6ea5\"\nb = \"#e8a13c\"\nfactor = \"across\"\n",
    ),
    (
        "mix_float",
        "[node.across]\ntexture = \"map_range\"\n",
        "a = 0.1\nb = 0.8\nfactor = \"across\"\n",
    ),
    (
        "math",
        "[node.across]\ntexture = \"map_range\"\nto_max = 25.13\n",
        "operation = 26\na = \"across\"\n",
    ),
    (
        "time",
        "[node.across]\ntexture = \"map_range\"\nto_max = 3.0\n",
        "kind = 2\ntime = \"across\"\n",
    ),
    (
        "normal_map",
        "[node.across]\ntexture = \"map_range\"\nto_max = 50.27\n\
         [node.waves]\ntexture = \"math\"\noperation = 26\na = \"across\"\n\
         [node.slope]\ntexture = \"map_range\"\nvalue = \"waves\"\nfrom_min = -1.0\nto_min = 0.25\nto_max = 0.75\n\
         [node.map]\ntexture = \"combine\"\nx = \"slope\"\ny = 0.5\nz = 0.93\n",
        "color = \"map.xyz\"\n",
    ),
    (
        "mapping",
        "",
        "rotation = [0.0, 0.0, 0.5]\nscale = [2.0, 2.0, 2.0]\n",
    ),
    ("place2d", "", "rotate = 0.6\nscale = [0.6, 0.6]\n"),
    (
        "blend",
        COLOURS,
        "base = \"input\"\nmode = 8\nfactor = 1.0\n",
    ),
    (
        "color_correct",
        COLOURS,
        "color = \"input\"\nsaturation = 1.5\ncontrast = 1.4\nexposure = 0.7\n",
    ),
    ("contrast", COLOURS, "color = \"input\"\namount = 2.0\n"),
    ("hue_saturation", COLOURS, "color = \"input\"\nhue = 0.75\n"),
    ("invert", COLOURS, "color = \"input\"\n"),
    ("rgb_curves", COLOURS, "color = \"input\"\n"),
    ("separate", COLOURS, "color = \"input\"\n"),
    ("to_grey", COLOURS, "color = \"input\"\n"),
];

/// The look that a texture is shown by, if its defaults say too little.
///
/// # Errors
/// Mistakes in the look.
pub(super) fn look(texture: &str) -> Result<Option<Look>, Failure> {
    let Some((name, nodes, arguments)) = LOOKS.iter().find(|(name, ..)| *name == texture) else {
        return Ok(None);
    };
    let text = format!("{nodes}[node.{NODE}]\ntexture = \"{name}\"\n{arguments}");
    Ok(Some(Look::parse(Path::new("swatch.look.toml"), &text)?))
}

/// Whether the look has a node of what goes in.
pub(super) fn has_input(look: &Look) -> bool {
    look.nodes.iter().any(|node| node.name.value == INPUT)
}

#[cfg(test)]
mod tests {
    use engine::isolated::{Isolated, Subject};
    use engine::procedural::TextureSources;

    use super::*;

    #[test]
    fn every_look_shows_its_texture() {
        let sources = TextureSources::search::<&Path>(&[]).expect("no folder is read");
        for (name, ..) in LOOKS {
            let look = look(name).ok().flatten().expect("it is in the list");
            for node in [NODE, INPUT] {
                if node == NODE || has_input(&look) {
                    let built = Isolated::new(Subject::Node(node, &look), &sources);
                    built.unwrap_or_else(|e| panic!("{name}: {}", e.render()));
                }
            }
        }
    }
}
