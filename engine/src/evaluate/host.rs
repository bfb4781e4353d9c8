//! The host of the generated kernel for evaluation: what texgen's host stub declares, read from a buffer of points.

use std::fmt::Write;

use texgen::{GeneratedKernel, HOST_STUB};

use crate::passes::wgsl::ComposedWgsl;

use super::point::Layout;

/// Resources and the entry point. `points` begins with a header: how many there are, the row of the image table where
/// the texture's images begin, and how many results are wanted; `links` says where each of them lies.
const FRAME: &str = "
@group(0) @binding(0) var<storage, read> programs: array<u32>;
@group(0) @binding(1) var<storage, read> args: array<u32>;
@group(0) @binding(2) var<storage, read> points: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> values: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> overrun: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> links: array<u32>;

var<private> point: u32;

fn point_value(i: u32) -> vec4f {
    return bitcast<vec4f>(points[1u + point * POINT_STRIDE + i]);
}

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3u) {
    point = id.x;
    if (point >= points[0].x) {
        return;
    }
    patina_run_program(0u);
    let results = points[0].z;
    for (var i = 0u; i < results; i++) {
        values[point * results + i] = patina_link(links[i]);
    }
    if (patina_overrun != 0u) {
        atomicMax(&overrun[0], patina_overrun);
    }
}
";

/// What points have for the tables of ambient occlusion.
#[derive(Debug, Clone, Copy)]
pub(super) enum Occlusion {
    /// `AO`, and `AO1` for the table that the subject reads by that name, where it is another one.
    Named(Option<u32>),
    /// `AO` has a component for each table.
    Tables,
}

/// The whole kernel.
pub(super) fn source(
    layout: &Layout,
    occlusion: Occlusion,
    generated: &GeneratedKernel,
) -> ComposedWgsl {
    // Images are sampled by the code that renders.
    let mut source = ComposedWgsl::of("shared/images.wgsl");
    source.text.push_str(FRAME);
    let _ = writeln!(source.text, "const POINT_STRIDE = {}u;", layout.stride());
    for line in HOST_STUB.lines() {
        match line.strip_prefix("fn ").and_then(|l| l.split_once('(')) {
            Some((name, _)) => {
                let head = line.split_once('{').map_or(line, |(head, _)| head);
                match body(layout, occlusion, name) {
                    Some(body) => {
                        let _ = writeln!(source.text, "{head}{{ {body} }}");
                    }
                    None => {
                        let _ = writeln!(source.text, "{line}");
                    }
                }
            }
            None => {
                let _ = writeln!(source.text, "{line}");
            }
        }
    }
    source.append_generated(generated);
    source
}

/// Where an image of the texture stands in the table, and how it is sampled.
const ROW: &str = "let row = points[0].y + image; \
    let sampling = textureLoad(image_table, vec2u(row % IMAGE_TABLE_WIDTH, row / IMAGE_TABLE_WIDTH), 0).w;";

/// What a host function does; `None` leaves it to do nothing.
fn body(layout: &Layout, occlusion: Occlusion, name: &str) -> Option<String> {
    let read = |place: usize| format!("return point_value({place}u);");
    Some(match name {
        "patina_program_word" => "return programs[i];".to_owned(),
        "patina_arg_word" => "return args[i];".to_owned(),
        "patina_sample_image" => format!("{ROW} return sample_image(row, sampling, uv);"),
        "patina_sample_image_lod" => {
            format!("{ROW} return sample_image_level(row, sampling, uv, lod);")
        }
        "patina_image_size" => "return vec2f(image_rect(points[0].y + image).size);".to_owned(),
        "patina_attr_AO" => {
            let (first, second) = (layout.attribute("AO")?, layout.attribute("AO1")?);
            match occlusion {
                Occlusion::Named(Some(slot)) => {
                    format!("return point_value(select({first}u, {second}u, slot == {slot}u));")
                }
                Occlusion::Named(None) => read(first),
                Occlusion::Tables => format!(
                    "let tables = point_value({first}u); \
                     let pair = select(tables.xy, tables.zw, slot >= 2u); \
                     return vec4f(select(pair.x, pair.y, (slot & 1u) != 0u));"
                ),
            }
        }
        "patina_attr_custom" => {
            format!("return point_value({}u + index);", layout.custom_start())
        }
        _ => {
            if let Some(attribute) = name.strip_prefix("patina_attr_") {
                read(layout.attribute(attribute)?)
            } else {
                read(layout.global(name.strip_prefix("patina_global_")?)?)
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texgen::{Library, SourceFile, TextureType};

    #[test]
    fn every_host_function_has_a_body_and_the_kernel_is_valid() {
        let layout = Layout::new(vec!["_A".into()]);
        let functions = HOST_STUB.lines().filter_map(|l| l.strip_prefix("fn "));
        for name in functions.filter_map(|l| l.split_once('(').map(|(name, _)| name)) {
            assert!(
                body(&layout, Occlusion::Named(Some(1)), name).is_some(),
                "{name}"
            );
        }
        let text = "fn userProc(image: sam2D) -> vec4f {
            return readAttr(_A) + readAttr(AO) + tex2D(image, texSize(image)) + tex2DLod(image, vec2f(0.0), 1.0) + readGlobal(Time); }";
        let texture = TextureType::parse(SourceFile::new("t", "t.wgsl", text))
            .unwrap_or_else(|problems| panic!("{problems}"));
        let library = Library::new(vec![texture]).unwrap_or_else(|problem| panic!("{problem}"));
        let source = source(&layout, Occlusion::Tables, &library.emit(1));
        let module = naga::front::wgsl::parse_str(&source.text)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source.text)));
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), texgen::CAPABILITIES)
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source.text)));
    }
}
