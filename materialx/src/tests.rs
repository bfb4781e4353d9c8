//! Documents written here, and what becomes of them.

mod definitions;
mod mistakes;
mod surfaces;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use scene::input::Files;
use scene::look::Look;

use crate::{Converted, Document, Wanted, convert, look_text};

/// As a picture begins; nothing decodes it here.
const PICTURE: &str = "RIFF\0\0\0\0WEBP";

/// Files in memory.
#[derive(Debug, Default)]
struct Memory(BTreeMap<PathBuf, String>);

impl Memory {
    fn with(mut self, path: &str, text: &str) -> Self {
        self.0.insert(path.into(), text.to_owned());
        self
    }

    fn bytes(&self, path: &Path) -> io::Result<Vec<u8>> {
        let text = self.0.get(path).ok_or(io::ErrorKind::NotFound)?;
        Ok(text.clone().into_bytes())
    }
}

impl Files for Memory {
    fn read_start(&self, path: &Path, _: u64) -> io::Result<Vec<u8>> {
        self.bytes(path)
    }

    fn read(&self, path: &Path, _: u64) -> io::Result<Vec<u8>> {
        self.bytes(path)
    }

    fn has(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }

    fn list(&self, _: &Path) -> io::Result<Vec<PathBuf>> {
        Ok(Vec::new())
    }

    fn write(&self, _: &Path, _: &[u8]) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

/// What a surface with these inputs becomes, beside what else stands in the document.
fn imported(files: &Memory, rest: &str, inputs: &str) -> Converted {
    imported_as("standard_surface", files, rest, inputs)
}

/// The same of any model.
fn imported_as(model: &str, files: &Memory, rest: &str, inputs: &str) -> Converted {
    let text = format!(
        "<materialx version=\"1.39\">\n{rest}\n<{model} name=\"S\" type=\"surfaceshader\">\n{inputs}\n\
         </{model}>\n<surfacematerial name=\"M\" type=\"material\">\n\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\n</surfacematerial>\n</materialx>"
    );
    let document = Document::parse(files, Path::new("a.mtlx"), &text);
    let document = document.unwrap_or_else(|problems| panic!("{}", problems.render()));
    let converted = convert(&document, files, &Wanted::default());
    let converted = converted.unwrap_or_else(|problems| panic!("{}", problems.render()));
    // Whatever comes out is a look.
    let text = look_text(&converted);
    let look = Look::parse(Path::new("a.look.toml"), &text);
    look.unwrap_or_else(|problems| panic!("{text}\n{}", problems.render()));
    converted
}

/// A node, an output of its graph that has it, and an input that is connected to that.
fn graph(nodes: &str, output: &str) -> (String, String) {
    let graph = format!(
        "<nodegraph name=\"g\">\n{nodes}\n<output name=\"out\" type=\"color3\" nodename=\"{output}\"/>\n</nodegraph>"
    );
    let input = "<input name=\"base_color\" type=\"color3\" nodegraph=\"g\" output=\"out\"/>";
    (graph, input.to_owned())
}

fn warnings(converted: &Converted) -> Vec<&str> {
    (converted.warnings.iter())
        .map(|warning| &*warning.message)
        .collect()
}

#[test]
fn constants_become_constants() {
    let inputs = "<input name=\"base\" type=\"float\" value=\"0.5\"/>\
         <input name=\"base_color\" type=\"color3\" value=\"1, 0.5, 0.25\"/>\
         <input name=\"metalness\" type=\"float\" value=\"1\"/>\
         <input name=\"thin_film_thickness\" type=\"float\" value=\"400\"/>";
    let text = look_text(&imported(&Memory::default(), "", inputs));
    for wanted in [
        "[material.M]",
        "base_color = [0.5, 0.25, 0.125]",
        "metallic = 1.0",
        "roughness = 0.2",
        "iridescence_thickness = 400.0",
    ] {
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
    assert!(!text.contains("[node"), "{text}");
}

#[test]
fn a_graph_becomes_nodes_whose_values_can_be_edited() {
    let nodes = "<input name=\"scale\" type=\"float\" value=\"7\"/>\
         <texcoord name=\"uv\" type=\"vector2\"/>\
         <multiply name=\"tiled\" type=\"vector2\"><input name=\"in1\" type=\"vector2\" nodename=\"uv\"/>\
         <input name=\"in2\" type=\"float\" interfacename=\"scale\"/></multiply>\
         <noise2d name=\"noise\" type=\"float\"><input name=\"texcoord\" type=\"vector2\" nodename=\"tiled\"/>\
         <input name=\"amplitude\" type=\"float\" value=\"0.3\"/></noise2d>\
         <mix name=\"color\" type=\"color3\"><input name=\"fg\" type=\"color3\" value=\"1, 0, 0\"/>\
         <input name=\"mix\" type=\"float\" nodename=\"noise\"/></mix>";
    let (graph, input) = graph(nodes, "color");
    let converted = imported(&Memory::default(), &graph, &input);
    assert_eq!(warnings(&converted), [""; 0]);
    let text = look_text(&converted);
    for wanted in [
        "[node.g_tiled]",
        "texture = \"mx_multiply\"",
        "in1 = \"texcoord\"",
        "in2 = [7.0, 7.0, 7.0, 7.0]",
        "texture = \"mx_noise2d_float\"",
        "amplitude = 0.3",
        "texcoord = \"g_tiled\"",
        "fg = [1.0, 0.0, 0.0, 1.0]",
        "mix = \"g_noise\"",
        "base_color = \"g_color\"",
    ] {
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
}

#[test]
fn components_are_swizzles_of_links() {
    let nodes = "<position name=\"p\" type=\"vector3\"/>\
         <separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" type=\"vector3\" nodename=\"p\"/></separate3>\
         <combine3 name=\"c\" type=\"color3\"><input name=\"in1\" type=\"float\" nodename=\"s\" output=\"outz\"/>\
         <input name=\"in2\" type=\"float\" nodename=\"s\" output=\"outx\"/>\
         <input name=\"in3\" type=\"float\" nodename=\"s\" output=\"outx\"/></combine3>";
    let (graph, input) = graph(nodes, "c");
    let converted = imported(&Memory::default(), &graph, &input);
    let text = look_text(&converted);
    assert!(text.contains("base_color = \"position.zxxx\""), "{text}");
    assert_eq!(converted.nodes.len(), 1);
}

#[test]
fn images_have_their_paths_and_colour_spaces() {
    let nodes = "<image name=\"i\" type=\"color3\">\
         <input name=\"file\" type=\"filename\" value=\"a.png\" colorspace=\"srgb_texture\"/>\
         <input name=\"uaddressmode\" type=\"string\" value=\"mirror\"/></image>";
    let (graph, input) = graph(nodes, "i");
    let graph = graph.replace("<nodegraph", "<nodegraph fileprefix=\"maps/\"");
    let files = Memory::default().with("maps/a.png", PICTURE);
    let text = look_text(&imported(&files, &graph, &input));
    let wanted =
        "file = { file = \"maps/a.png\", color_space = \"srgb\", wrap = [\"mirror\", \"repeat\"] }";
    assert!(text.contains(wanted), "{text}");
    // One that isn't there is warned of, and its default stands for it.
    let converted = imported(&Memory::default(), &graph, &input);
    assert!(warnings(&converted)[0].contains("maps/a.png is not there"));
    assert!(look_text(&converted).contains("base_color = [0.0, 0.0, 0.0]"));
}

#[test]
fn definitions_of_ones_own_are_followed() {
    let rest = "<nodedef name=\"ND_twice\" node=\"twice\"><input name=\"in\" type=\"float\" value=\"0.25\"/>\
         <output name=\"out\" type=\"float\"/></nodedef>\
         <nodegraph name=\"NG\" nodedef=\"ND_twice\"><add name=\"sum\" type=\"float\">\
         <input name=\"in1\" type=\"float\" interfacename=\"in\"/><input name=\"in2\" type=\"float\" interfacename=\"in\"/>\
         </add><output name=\"out\" type=\"float\" nodename=\"sum\"/></nodegraph>\
         <position name=\"p\" type=\"vector3\"/>\
         <extract name=\"x\" type=\"float\"><input name=\"in\" type=\"vector3\" nodename=\"p\"/></extract>\
         <twice name=\"t\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"x\"/></twice>";
    let inputs = "<input name=\"metalness\" type=\"float\" nodename=\"t\"/>";
    let text = look_text(&imported(&Memory::default(), rest, inputs));
    assert!(
        text.contains("[node.t_sum]") && text.contains("in1 = \"position.x\""),
        "{text}"
    );
    assert!(text.contains("metallic = \"t_sum.x\""), "{text}");
}

#[test]
fn what_can_not_be_expressed_is_named_with_its_line() {
    let nodes = "<nonsense name=\"n\" type=\"color3\"/>";
    let (graph, input) = graph(nodes, "n");
    let inputs =
        format!("{input}\n<input name=\"diffuse_roughness\" type=\"float\" value=\"0.5\"/>");
    let converted = imported(&Memory::default(), &graph, &inputs);
    let rendered = converted.warnings.render();
    assert!(rendered.contains("`nonsense` are not known"), "{rendered}");
    assert!(rendered.contains("a.mtlx:3:1"), "{rendered}");
    assert!(
        rendered.contains("`diffuse_roughness` has no counterpart"),
        "{rendered}"
    );
}

#[test]
fn inputs_that_a_model_has_not_are_named_with_their_lines() {
    let inputs = "<input name=\"base\" type=\"float\" value=\"0.5\"/>\n\
         <input name=\"metalnes\" type=\"float\" value=\"1\"/>\n\
         <input name=\"base_color\" type=\"string\" value=\"red\"/>";
    let rendered = imported(&Memory::default(), "", inputs).warnings.render();
    for wanted in [
        "`standard_surface` has no input `metalnes`: it has no effect; did you mean `metalness`?",
        "a.mtlx:5:1",
        "`base_color` doesn't take this",
        "a.mtlx:6:1",
    ] {
        assert!(rendered.contains(wanted), "{wanted}:\n{rendered}");
    }
}

#[test]
fn matrices_become_nodes_of_their_rows() {
    let nodes = "<position name=\"p\" type=\"vector3\"/>\
         <creatematrix name=\"m\" type=\"matrix33\"><input name=\"in1\" type=\"vector3\" nodename=\"p\"/></creatematrix>\
         <transpose name=\"t\" type=\"matrix33\"><input name=\"in\" type=\"matrix33\" nodename=\"m\"/></transpose>\
         <invertmatrix name=\"i\" type=\"matrix33\"><input name=\"in\" type=\"matrix33\" nodename=\"t\"/></invertmatrix>\
         <multiply name=\"x\" type=\"matrix33\"><input name=\"in1\" type=\"matrix33\" nodename=\"i\"/>\
         <input name=\"in2\" type=\"matrix33\" value=\"1,0,0, 0,2,0, 0,0,3\"/></multiply>\
         <add name=\"a\" type=\"matrix33\"><input name=\"in1\" type=\"matrix33\" nodename=\"x\"/>\
         <input name=\"in2\" type=\"float\" value=\"0.5\"/></add>\
         <transformmatrix name=\"v\" type=\"vector2\"><input name=\"in\" type=\"vector2\" value=\"0.1, 0.2\"/>\
         <input name=\"mat\" type=\"matrix33\" nodename=\"a\"/></transformmatrix>\
         <convert name=\"c\" type=\"color3\"><input name=\"in\" type=\"vector2\" nodename=\"v\"/></convert>";
    let (graph, input) = graph(nodes, "c");
    let converted = imported(&Memory::default(), &graph, &input);
    assert_eq!(warnings(&converted), [""; 0]);
    let text = look_text(&converted);
    for wanted in [
        // The first column of a matrix whose other rows are the identity's.
        "in1 = \"position.x\"\nin2 = 0.0\nin3 = 0.0",
        "texture = \"mx_invertmatrix_3\"",
        "row3 = [0.0, 0.0, 3.0]",
        "in = [0.1, 0.2, 1.0]",
    ] {
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
    let sums = text.matches("texture = \"mx_add\"").count();
    assert_eq!(sums, 3, "a sum for each row:\n{text}");
}

#[test]
fn a_bump_node_is_the_materials_bump() {
    let nodes = "<noise3d name=\"h\" type=\"float\"/>\
         <bump name=\"b\" type=\"vector3\"><input name=\"height\" type=\"float\" nodename=\"h\"/>\
         <input name=\"scale\" type=\"float\" value=\"0.02\"/></bump>";
    let inputs = "<input name=\"normal\" type=\"vector3\" nodename=\"b\"/>";
    let text = look_text(&imported(&Memory::default(), nodes, inputs));
    assert!(text.contains("bump = \"h\"\nbump_scale = 0.02"), "{text}");
}

#[test]
fn files_include_others() {
    let files = Memory::default()
        .with("lib/b.mtlx", "<materialx fileprefix=\"maps/\"><xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"../a.mtlx\"/>\
             <constant name=\"c\" type=\"color3\"><input name=\"value\" type=\"color3\" value=\"1, 0, 0\"/></constant></materialx>");
    let rest = "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"lib/b.mtlx\"/>";
    let inputs = "<input name=\"base_color\" type=\"color3\" nodename=\"c\"/>";
    let text = look_text(&imported(&files, rest, inputs));
    assert!(text.contains("base_color = [1.0, 0.0, 0.0]"), "{text}");
}

fn refused(text: &str) -> String {
    let document = Document::parse(&Memory::default(), Path::new("a.mtlx"), text);
    let problems = match document {
        Err(problems) => problems,
        Ok(document) => convert(&document, &Memory::default(), &Wanted::default())
            .err()
            .unwrap_or_else(|| panic!("{text}")),
    };
    problems.render()
}

#[test]
fn hostile_documents_are_refused() {
    let deep = format!("<materialx>{}", "<a>".repeat(100_000));
    let dtd = "<!DOCTYPE a [<!ENTITY b \"c\">]><materialx>&b;</materialx>";
    for (text, says) in [
        ("", "not valid XML"),
        ("<materialx", "not valid XML"),
        ("<materialx>\n<a></b></materialx>", "a.mtlx:2"),
        (&deep, "too deep"),
        (dtd, "not valid XML"),
        ("<svg/>", "no MaterialX"),
        ("<materialx/>", "no material"),
        (
            "<materialx><xi:include xmlns:xi=\"x\" href=\"../../etc/nothing\"/></materialx>",
            "cannot read",
        ),
    ] {
        let error = refused(text);
        assert!(error.contains(says), "{says}: {error}");
    }
}

#[test]
fn outputs_that_lead_to_themselves_and_graphs_that_multiply_end() {
    let rest = "<nodegraph name=\"g\"><output name=\"o\" type=\"color3\" nodegraph=\"g\" output=\"o\"/></nodegraph>";
    let inputs = "<input name=\"base_color\" type=\"color3\" nodegraph=\"g\" output=\"o\"/>";
    let converted = imported(&Memory::default(), rest, inputs);
    assert!(warnings(&converted)[0].contains("lead back"));
    // Each stands for two of the next, without a node of its own.
    let level = |i: usize| {
        let next = i + 1;
        format!(
            "<nodedef name=\"D{i}\" node=\"n{i}\"><output name=\"out\" type=\"color3\"/></nodedef>\
             <nodegraph name=\"G{i}\" nodedef=\"D{i}\"><n{next} name=\"a\" type=\"color3\"/><n{next} name=\"b\" type=\"color3\"/>\
             <output name=\"p\" type=\"color3\" nodename=\"a\"/><output name=\"q\" type=\"color3\" nodename=\"b\"/></nodegraph>"
        )
    };
    let levels: String = (0..30).map(level).collect();
    let rest = format!("{levels}<n0 name=\"x\" type=\"color3\"/>");
    let inputs = "<input name=\"base_color\" type=\"color3\" nodename=\"x\"/>";
    let converted = imported(&Memory::default(), &rest, inputs);
    assert!(
        warnings(&converted)
            .iter()
            .any(|warning| warning.contains("the rest is left out"))
    );
}

#[test]
fn circles_end() {
    let nodes = "<add name=\"a\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"b\"/></add>\
         <add name=\"b\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"a\"/></add>";
    let inputs = "<input name=\"base_color\" type=\"color3\" nodename=\"a\"/>";
    let converted = imported(&Memory::default(), nodes, inputs);
    assert!(
        warnings(&converted)
            .iter()
            .any(|warning| warning.contains("in a circle"))
    );
    // A graph that stands for a node of itself.
    let rest = "<nodedef name=\"D\" node=\"r\"><output name=\"out\" type=\"color3\"/></nodedef>\
         <nodegraph name=\"G\" nodedef=\"D\"><r name=\"r\" type=\"color3\"/><r name=\"q\" type=\"color3\"/>\
         <add name=\"s\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"r\"/>\
         <input name=\"in2\" type=\"color3\" nodename=\"q\"/></add>\
         <output name=\"out\" type=\"color3\" nodename=\"s\"/></nodegraph><r name=\"x\" type=\"color3\"/>";
    let inputs = "<input name=\"base_color\" type=\"color3\" nodename=\"x\"/>";
    let converted = imported(&Memory::default(), rest, inputs);
    assert!(
        warnings(&converted)
            .iter()
            .any(|warning| warning.contains("graphs in graphs"))
    );
}

#[test]
fn a_coats_colour_lies_on_what_is_below_it() {
    let inputs = "<input name=\"base_color\" type=\"color3\" value=\"0.5, 0.5, 1\"/>\n\
                  <input name=\"coat\" type=\"float\" value=\"0.5\"/>\n\
                  <input name=\"coat_color\" type=\"color3\" value=\"1, 0.5, 0\"/>";
    let converted = imported(&Memory::default(), "", inputs);
    let text = look_text(&converted);
    assert!(text.contains("base_color = [0.5, 0.375, 0.5]"), "{text}");
    assert!(text.contains("specular_color = [1.0, 0.75, 0.5]"), "{text}");
    assert_eq!(warnings(&converted), [""; 0]);
}

#[test]
fn reflections_are_as_wide_as_the_models() {
    let inputs = "<input name=\"specular_roughness\" type=\"float\" value=\"0.5\"/>\n\
                  <input name=\"specular_anisotropy\" type=\"float\" value=\"0.75\"/>";
    let converted = imported(&Memory::default(), "", inputs);
    let known = |key: &str| {
        let parameters = &converted.materials[0].parameters;
        let (_, value) = parameters.iter().find(|(name, _)| *name == key).expect(key);
        value.as_number().expect("a number")
    };
    // Widths of 0.25 / 0.5 and 0.25 * 0.5; glTF's of a roughness and a strength.
    let across = known("roughness").powi(2);
    let along = across + (1.0 - across) * known("anisotropy").powi(2);
    assert!(
        (across - 0.125).abs() < 1e-5 && (along - 0.5).abs() < 1e-5,
        "{along} {across}"
    );
}

#[test]
fn texts_with_brackets_are_not_deep() {
    let many = r#"<constant name="c" type="float" doc="a > b"/>"#.repeat(200);
    let converted = imported(&Memory::default(), &many, "");
    assert_eq!(converted.materials.len(), 1);
}

#[test]
fn inputs_of_atan2_have_their_former_names_too() {
    let input = r#"<input name="specular_rotation" type="float" nodename="a"/>"#;
    let of = |names: [&str; 2]| {
        let given = |name| format!(r#"<input name="{name}" type="float" value="0.25"/>"#);
        let node = format!(
            r#"<atan2 name="a" type="float">{}{}</atan2>"#,
            given(names[0]),
            given(names[1])
        );
        let converted = imported(&Memory::default(), &node, input);
        let said = converted.warnings.render();
        assert!(!said.contains("no effect"), "{said}");
        look_text(&converted)
    };
    assert_eq!(of(["in1", "in2"]), of(["iny", "inx"]));
}

#[test]
fn the_nearest_prefix_of_file_names_counts() {
    let nodes = r#"<image name="i" type="color3">
         <input name="file" type="filename" fileprefix="textures/" value="color2/color2.png"/>
         </image>"#;
    let (graph, input) = graph(nodes, "i");
    let graph = graph.replace("<nodegraph", "<nodegraph fileprefix=\"textures/color/\"");
    let files = Memory::default().with("textures/color2/color2.png", PICTURE);
    let converted = imported(&files, &graph, &input);
    assert_eq!(warnings(&converted), [""; 0]);
    let text = look_text(&converted);
    assert!(text.contains("\"textures/color2/color2.png\""), "{text}");
}

#[test]
fn included_files_have_their_own_prefix_or_that_of_the_file() {
    let files = Memory::default()
        .with(
            "own.mtlx",
            r#"<materialx fileprefix="maps/"><image name="own"/></materialx>"#,
        )
        .with(
            "none.mtlx",
            r#"<materialx><image name="none"/></materialx>"#,
        );
    let text = r#"<materialx fileprefix="outer/" xmlns:xi="http://www.w3.org/2001/XInclude">
        <xi:include href="own.mtlx"/><xi:include href="none.mtlx"/>
        <nodegraph name="inner" fileprefix="inner/"><image name="empty" fileprefix=""/></nodegraph>
        </materialx>"#;
    let document = Document::parse(&files, Path::new("a.mtlx"), text);
    let document = document.unwrap_or_else(|problems| panic!("{}", problems.render()));
    for (name, prefix) in [
        ("own", "maps/"),
        ("none", "outer/"),
        ("inner", "inner/"),
        ("empty", ""),
    ] {
        let mut elements = document.elements.iter();
        let id = elements.position(|element| element.name() == name);
        let id = id.unwrap_or_else(|| panic!("{name}"));
        assert_eq!(document.file_prefix(id), prefix, "{name}");
    }
}

#[test]
fn properties_of_the_surface_are_defaults_of_definitions() {
    let of = |ty: &str, property: &str| {
        let rest = format!(
            r#"<nodedef name="ND" node="shown"><input name="in" type="{ty}" defaultgeomprop="{property}"/>
            <output name="out" type="color3"/></nodedef><nodegraph name="NG" nodedef="ND">
            <convert name="c" type="color3"><input name="in" type="{ty}" interfacename="in"/></convert>
            <output name="out" type="color3" nodename="c"/></nodegraph><shown name="x" type="color3"/>"#
        );
        let input = r#"<input name="base_color" type="color3" nodename="x"/>"#;
        let converted = imported(&Memory::default(), &rest, input);
        (look_text(&converted), converted.warnings.render())
    };
    for (ty, property, texture) in [
        ("vector2", "UV0", "mx_texcoord"),
        ("vector2", "UV1", "mx_texcoord1"),
        ("vector3", "Pobject", "mx_position"),
        ("vector3", "Pworld", "mx_position_world"),
        ("vector3", "Nobject", "mx_normal"),
        ("vector3", "Nworld", "mx_normal_world"),
        ("vector3", "Tworld", "mx_tangent_world"),
        ("vector3", "Bworld", "mx_bitangent_world"),
        ("vector3", "Vworld", "mx_viewdirection_world"),
    ] {
        let (text, said) = of(ty, property);
        let wanted = format!("texture = \"{texture}\"");
        assert!(text.contains(&wanted), "{property}:\n{text}");
        assert_eq!(said, "", "{property}");
    }
    // Those that there are in the world alone, and those that there aren't.
    let (text, said) = of("vector3", "Tobject");
    assert!(text.contains("texture = \"mx_tangent_world\""), "{text}");
    assert!(said.contains("not in the object's own space"), "{said}");
    let (text, said) = of("vector3", "Curvature");
    assert!(!text.contains("[node"), "{text}");
    assert!(said.contains("`Curvature` is not known"), "{said}");
}

/// A body that lets light through, with further inputs: numbers and colours, or the nodes that drive them. What is said of it,
/// and its look.
fn body(model: &str, inputs: &[(&str, &str)]) -> (String, String) {
    let rest = r#"<noise3d name="n" type="float"/>
         <convert name="c" type="color3"><input name="in" type="float" nodename="n"/></convert>"#;
    let weight = match model {
        "open_pbr_surface" => "transmission_weight",
        _ => "transmission",
    };
    let input = |(name, given): &(&str, &str)| {
        let ty = if name.ends_with("color") {
            "color3"
        } else {
            "float"
        };
        let is_node = matches!(*given, "n" | "c");
        let from = if is_node { "nodename" } else { "value" };
        format!(r#"<input name="{name}" type="{ty}" {from}="{given}"/>"#)
    };
    let inputs: String = inputs.iter().map(input).collect();
    let inputs = input(&(weight, "1")) + &inputs;
    let converted = imported_as(model, &Memory::default(), rest, &inputs);
    (warnings(&converted).join("\n"), look_text(&converted))
}

#[test]
fn what_a_body_absorbs_is_constant() {
    let (distance, color) = ("attenuation_distance", "attenuation_color");
    let (depth, tint) = ("transmission_depth", "transmission_color");
    let red = "1, 0, 0";
    let is_red = "base_color = [1.0, 0.0, 0.0]";
    // The model and its inputs; which of them are lost, and what is there all the same.
    type Case<'a> = (&'a str, &'a [(&'a str, &'a str)], &'a [&'a str], &'a str);
    let cases: [Case<'_>; 11] = [
        ("gltf_pbr", &[(distance, "0.5"), (color, "c")], &[color], ""),
        (
            "gltf_pbr",
            &[(distance, "n"), (color, red)],
            &[distance],
            "",
        ),
        (
            "gltf_pbr",
            &[(distance, "n"), (color, "c")],
            &[color, distance],
            "",
        ),
        // Nothing is lost where nothing is absorbed.
        ("gltf_pbr", &[(distance, "n")], &[], ""),
        ("gltf_pbr", &[(distance, "0"), (color, "c")], &[], ""),
        (
            "standard_surface",
            &[(depth, "n"), (tint, red)],
            &[depth],
            is_red,
        ),
        (
            "standard_surface",
            &[(depth, "0.5"), (tint, "c")],
            &[tint],
            "base_color = \"",
        ),
        ("standard_surface", &[(tint, "c")], &[], "base_color = \""),
        (
            "standard_surface",
            &[(depth, "n")],
            &[],
            "base_color = [1.0, 1.0, 1.0]",
        ),
        (
            "standard_surface",
            &[(depth, "n"), (tint, red), ("thin_walled", "1")],
            &[],
            is_red,
        ),
        (
            "open_pbr_surface",
            &[(depth, "n"), (tint, red)],
            &[depth],
            is_red,
        ),
    ];
    for (model, inputs, lost, kept) in cases {
        let (said, text) = body(model, inputs);
        assert_eq!(said.lines().count(), lost.len(), "{inputs:?}: {said}");
        for lost in lost {
            let wanted = format!("`{lost}` has no counterpart where a node drives it");
            assert!(said.contains(&wanted), "{inputs:?}: {said}");
        }
        assert!(text.contains(kept), "{inputs:?}: {kept}\n{text}");
        assert!(
            !text.contains("attenuation_distance"),
            "{inputs:?}:\n{text}"
        );
    }
}

#[test]
fn dispersion_is_constant() {
    let own = "transmission_dispersion";
    let scale = "transmission_dispersion_scale";
    let abbe = "transmission_dispersion_abbe_number";
    for (model, input, why) in [
        ("gltf_pbr", "dispersion", "refracted alike"),
        ("standard_surface", own, "refracted alike"),
        ("open_pbr_surface", scale, "refracted alike"),
    ] {
        let (said, text) = body(model, &[(input, "n")]);
        let wanted = format!("`{input}` has no counterpart where a node drives it");
        assert!(said.contains(&wanted) && said.contains(why), "{said}");
        assert!(text.contains("dispersion = 0.0"), "{text}");
    }
    let (said, text) = body("open_pbr_surface", &[(scale, "0.5"), (abbe, "n")]);
    assert!(said.contains(abbe) && said.contains("20 stands"), "{said}");
    assert!(text.contains("dispersion = 0.5"), "{text}");
    let (said, _) = body("open_pbr_surface", &[(abbe, "n")]);
    assert_eq!(said, "");
}

/// What a node without its image gives: the look of a surface whose colour, metalness and specular weight are these outputs.
fn without_image(kind: &str, fallback: &str, outputs: [&str; 3]) -> String {
    let node = format!(
        r#"<{kind} name="t" type="multioutput">
        <input name="file" type="filename" value="missing.png"/>{fallback}</{kind}>"#
    );
    let [color, metalness, specular] = outputs;
    let inputs = format!(
        r#"<input name="base_color" type="color3" nodename="t" output="{color}"/>
        <input name="metalness" type="float" nodename="t" output="{metalness}"/>
        <input name="specular" type="float" nodename="t" output="{specular}"/>"#
    );
    let converted = imported(&Memory::default(), &node, &inputs);
    let said = warnings(&converted).join("\n");
    assert!(said.contains("missing.png is not there"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    look_text(&converted)
}

#[test]
fn each_output_of_a_missing_image_has_its_part_of_the_fallback() {
    let four =
        |name: &str| format!(r#"<input name="{name}" type="color4" value="1, 0.5, 0.25, 0.125"/>"#);
    let (usd, gltf) = (["rgb", "a", "b"], ["outcolor", "outa", "outa"]);
    // A direction, here along the tangent, and a strength.
    let direction = r#"<input name="default" type="vector3" value="1, 0.5, 0.75"/>"#;
    let strength = "anisotropy_strength_out";
    let anisotropy = [strength, strength, "anisotropy_rotation_out"];
    for (kind, fallback, outputs, [color, metallic, specular]) in [
        (
            "UsdUVTexture",
            &*four("fallback"),
            usd,
            ["[1.0, 0.5, 0.25]", "0.125", "0.25"],
        ),
        // USD's own fallback is opaque.
        ("UsdUVTexture", "", usd, ["[0.0, 0.0, 0.0]", "1.0", "0.0"]),
        (
            "gltf_colorimage",
            &*four("default"),
            gltf,
            ["[1.0, 0.5, 0.25]", "0.125", "0.125"],
        ),
        (
            "gltf_colorimage",
            "",
            gltf,
            ["[0.0, 0.0, 0.0]", "0.0", "0.0"],
        ),
        (
            "gltf_anisotropy_image",
            direction,
            anisotropy,
            ["[0.75, 0.75, 0.75]", "0.75", "0.0"],
        ),
        (
            "gltf_anisotropy_image",
            "",
            anisotropy,
            ["[0.0, 0.0, 0.0]", "0.0", "0.0"],
        ),
    ] {
        let text = without_image(kind, fallback, outputs);
        for (key, value) in [
            ("base_color", color),
            ("metallic", metallic),
            ("specular", specular),
        ] {
            let wanted = format!("\n{key} = {value}\n");
            assert!(text.contains(&wanted), "{kind} {fallback}: {wanted}{text}");
        }
    }
}
