//! The textures that MaterialX's nodes become: one file each, in `textures/`, with the files that they share in `textures/lib`.
//! The engine finds them by their names, but shows them in no list: nobody begins with them.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use texgen::{SourceFile, TextureType, used_libraries};

/// Where messages say that such a texture lies: no file is called so.
const FOLDER: &str = "<built-in>/materialx";

macro_rules! texts {
    ($folder:literal: $($name:ident)*) => {
        &[$((stringify!($name), include_str!(concat!("../textures/", $folder, stringify!($name), ".wgsl")))),*]
    };
}

/// Names and texts, in their order.
const TEXTURES: &[(&str, &str)] = texts!("":
    mx_absval mx_acos mx_add mx_and mx_asin mx_atan2 mx_bitangent_world mx_burn mx_ceil mx_cellnoise2d
    mx_cellnoise3d mx_checkerboard mx_circle mx_clamp mx_cloverleaf mx_colorcorrect mx_combine mx_constant
    mx_contrast mx_convert_color4 mx_cos mx_crosshatch mx_crossproduct mx_determinant_3 mx_determinant_4
    mx_difference mx_disjointover mx_distance_2 mx_distance_3 mx_distance_4 mx_divide mx_dodge
    mx_dotproduct_2 mx_dotproduct_3 mx_dotproduct_4 mx_exp mx_extract mx_facingratio mx_flake2d mx_flake2d_normal mx_flake3d
    mx_flake3d_normal mx_floor mx_fract
    mx_fractal2d_float mx_fractal2d_vector2 mx_fractal2d_vector3 mx_fractal2d_vector4 mx_fractal3d_float
    mx_fractal3d_vector2 mx_fractal3d_vector3 mx_fractal3d_vector4 mx_frame mx_geomcolor
    mx_gltf_anisotropy_image mx_gltf_colorimage mx_gltf_image mx_gltf_iridescence_thickness
    mx_gltf_normalmap mx_grid mx_hexagon mx_hextiledimage mx_hextilednormalmap mx_hsvadjust mx_hsvtorgb mx_ifequal mx_ifequal_boolean
    mx_ifgreater mx_ifgreater_boolean mx_ifgreatereq mx_ifgreatereq_boolean mx_image mx_in mx_inside
    mx_invert mx_invertmatrix_3 mx_invertmatrix_4 mx_latlongimage mx_line mx_ln mx_luminance mx_magnitude_2
    mx_magnitude_3 mx_magnitude_4 mx_mask mx_matte mx_max mx_min mx_minus mx_mix mx_modulo mx_multiply
    mx_noise2d_float mx_noise2d_vector2 mx_noise2d_vector3 mx_noise2d_vector4 mx_noise3d_float
    mx_noise3d_vector2 mx_noise3d_vector3 mx_noise3d_vector4 mx_normal mx_normal_world mx_normalize_2
    mx_normalize_3 mx_normalize_4 mx_normalmap mx_not mx_or mx_out mx_outside mx_over mx_overlay mx_place2d
    mx_plus mx_position mx_position_world mx_power mx_premult mx_ramp mx_ramp4 mx_ramp_gradient mx_ramplr
    mx_ramptb mx_randomcolor mx_randomfloat mx_randomfloat_integer mx_range mx_reflect mx_refract mx_remap
    mx_rgbtohsv mx_rotate2d mx_rotate3d mx_round mx_safepower mx_saturate mx_screen mx_sign mx_sin
    mx_smoothstep mx_splitlr mx_splittb mx_sqrt mx_subtract mx_switch mx_tan mx_tangent_world mx_texcoord
    mx_texcoord1 mx_tiledcircles mx_tiledcloverleafs mx_tiledhexagons mx_tiledimage mx_time mx_toboolean
    mx_transformmatrix_3 mx_transformmatrix_4 mx_trianglewave mx_triplanarprojection mx_unifiednoise2d
    mx_unifiednoise3d mx_unpremult mx_usdtransform2d mx_usduvtexture mx_viewdirection_world
    mx_worleynoise2d mx_worleynoise2d_float mx_worleynoise3d mx_worleynoise3d_float mx_xor
);

/// The files that they share.
const SHARED: &[(&str, &str)] =
    texts!("lib/": mx_flakes mx_hextile mx_hsv mx_jenkins mx_picture mx_shapes mx_worley);

/// The names of all textures.
pub fn names() -> impl Iterator<Item = &'static str> {
    TEXTURES.iter().map(|(name, _)| *name)
}

/// The texture of that name, with the files that it uses.
pub fn find(name: &str) -> Option<SourceFile> {
    let at = TEXTURES
        .binary_search_by_key(&name, |(name, _)| name)
        .ok()?;
    let (name, text) = TEXTURES[at];
    let mut wanted = used_libraries(text);
    let mut found: Vec<SourceFile> = Vec::new();
    while let Some(name) = wanted.pop() {
        let known = found.iter().any(|file| file.name() == name);
        if let Some((name, text)) = SHARED.iter().find(|(shared, _)| !known && *shared == name) {
            wanted.extend(used_libraries(text));
            found.push(SourceFile::new(
                *name,
                format!("{FOLDER}/lib/{name}.wgsl"),
                *text,
            ));
        }
    }
    let file = SourceFile::new(name, format!("{FOLDER}/{name}.wgsl"), text);
    Some(match found.is_empty() {
        true => file,
        false => file.with_libraries(found),
    })
}

/// The texture that messages call by this path.
pub fn at(path: &std::path::Path) -> Option<SourceFile> {
    let name = path.strip_prefix(FOLDER).ok()?.file_stem()?.to_str()?;
    find(name).filter(|file| std::path::Path::new(file.path()) == path)
}

/// What a texture takes and gives. Each is parsed once in a run of the program.
pub(crate) fn interface(name: &str) -> Option<Arc<TextureType>> {
    static KNOWN: OnceLock<std::sync::Mutex<HashMap<&'static str, Arc<TextureType>>>> =
        OnceLock::new();
    let known = KNOWN.get_or_init(Default::default);
    let mut known = known
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    if let Some(texture) = known.get(name) {
        return Some(Arc::clone(texture));
    }
    let at = TEXTURES
        .binary_search_by_key(&name, |(name, _)| name)
        .ok()?;
    let texture = Arc::new(TextureType::parse(find(name)?).ok()?);
    known.insert(TEXTURES[at].0, Arc::clone(&texture));
    Some(texture)
}

#[cfg(test)]
mod tests {
    use texgen::Library;

    use super::*;

    #[test]
    fn each_file_of_the_folder_is_listed_and_valid() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("textures");
        let entries = std::fs::read_dir(folder).expect("part of the project");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let mut files: Vec<String> = paths
            .filter(|path| path.is_file())
            .map(|path| path.file_stem().expect("a name").display().to_string())
            .collect();
        files.sort();
        assert_eq!(names().collect::<Vec<_>>(), files);
        let mut types = Vec::new();
        for name in names() {
            let file = find(name).expect("it is listed");
            match TextureType::parse(file) {
                Ok(texture) => {
                    assert!(
                        texture.warnings().is_empty(),
                        "{}",
                        texture.warnings().render()
                    );
                    types.push(texture);
                }
                Err(problems) => panic!("{}", problems.render()),
            }
        }
        assert!(Library::new(types).is_ok());
    }
}
