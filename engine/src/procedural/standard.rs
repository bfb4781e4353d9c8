//! The standard textures, which are part of the program: `user_textures/` as it was when the program was built.

use std::path::Path;

use texgen::SourceFile;

/// Where messages say that such a texture lies: no file is called so.
const FOLDER: &str = "<built-in>";

macro_rules! texts {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../user_textures/", $name, ".wgsl")))),*]
    };
}

/// Names and texts.
const TEXTURES: &[(&str, &str)] = texts![
    "bark",
    "billow",
    "blackbody",
    "blend",
    "brick",
    "brushed_metal",
    "cell_noise",
    "checker",
    "color_correct",
    "combine",
    "concrete",
    "contrast",
    "coordinates",
    "cracks",
    "curve",
    "dirt",
    "dots",
    "dust",
    "edge_wear",
    "fabric",
    "facing",
    "fbm",
    "fingerprints",
    "flakes",
    "flip_book",
    "fresnel",
    "gabor_noise",
    "gradient",
    "granite",
    "grid",
    "height_to_normal",
    "herringbone",
    "hex_tile",
    "hexagons",
    "hue_saturation",
    "image",
    "instance_random",
    "invert",
    "leaks",
    "leather",
    "magic",
    "map_range",
    "mapping",
    "marble",
    "math",
    "mix_color",
    "mix_float",
    "moss",
    "moving_noise",
    "normal_map",
    "object_random",
    "peeling_paint",
    "perlin_noise",
    "place2d",
    "planks",
    "plaster",
    "polar",
    "ramp",
    "ramp4",
    "random_color",
    "random_pick",
    "rgb_curves",
    "ridged",
    "rotate3d",
    "rust",
    "rust_color",
    "rust_mask",
    "sand",
    "scales",
    "scratches",
    "separate",
    "simplex_noise",
    "snow",
    "streaks",
    "stripes",
    "terrazzo",
    "tiles",
    "time",
    "to_grey",
    "triplanar",
    "truchet",
    "turbulence",
    "twirl",
    "value_noise",
    "vector_math",
    "voronoi",
    "voronoi_edges",
    "voronoi_smooth",
    "warp",
    "warped_noise",
    "water",
    "wavelength",
    "waves",
    "weave",
    "white_noise",
    "wood_grain",
    "worley",
    "zigzag",
];

/// All of them, in the order of their names.
pub(super) fn files() -> impl Iterator<Item = SourceFile> {
    TEXTURES
        .iter()
        .map(|(name, text)| SourceFile::new(*name, format!("{FOLDER}/{name}.wgsl"), *text))
}

/// The one that messages call by this path.
pub(super) fn at(path: &Path) -> Option<SourceFile> {
    path.starts_with(FOLDER)
        .then(|| files().find(|file| Path::new(file.path()) == path))
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::{Procedural, TextureSources};
    use crate::scene::look::Look;
    use crate::scene::{Material, Scene};

    #[test]
    fn each_file_of_the_folder_is_part_of_the_program() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../user_textures");
        let entries = std::fs::read_dir(folder).expect("part of the project");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.extension().is_some_and(|ending| ending == "wgsl"))
            .map(|path| path.file_stem().expect("a name").display().to_string())
            .collect();
        names.sort();
        let built_in: Vec<String> = files().map(|file| file.name().to_owned()).collect();
        assert_eq!(built_in, names);
    }

    #[test]
    fn what_is_not_used_leaves_the_kernel_as_it_is() {
        let text = "[node.n]\ntexture = \"rust\"\n[material.M]\nbase_color = \"n.xyz\"\n";
        let look = Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let mut alone = TextureSources::default();
        alone.insert_file(at(&Path::new(FOLDER).join("rust.wgsl")).expect("a standard texture"));
        let nowhere: [&Path; 0] = [];
        let library = TextureSources::search(&nowhere).expect("no folder is read");
        let [alone, beside] = [alone, library].map(|sources| {
            let mut scene = Scene {
                materials: vec![Material {
                    name: "M".to_owned(),
                    ..Material::default()
                }],
                ..Scene::default()
            };
            let built = Procedural::build(&look, &mut scene, &sources);
            let built = built.unwrap_or_else(|e| panic!("{}", e.render()));
            (built.kernel().wgsl.clone(), built.programs().to_vec())
        });
        assert!(alone.0.contains("rust"));
        assert!(
            alone == beside,
            "the library is in the kernel, or its program differs"
        );
    }
}
