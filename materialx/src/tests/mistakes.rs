//! Mistakes in documents that are said, files that are not quite XML, and documents that are made to take long.

use std::path::Path;
use std::time::{Duration, Instant};

use scene::look;

use super::{Memory, PICTURE, graph, imported, warnings};
use crate::{Converted, Document, Wanted, convert, look_text};

fn read(files: &Memory, text: &str) -> Converted {
    let document = Document::parse(files, Path::new("a.mtlx"), text);
    let document = document.unwrap_or_else(|problems| panic!("{}", problems.render()));
    let converted = convert(&document, files, &Wanted::default());
    converted.unwrap_or_else(|problems| panic!("{}", problems.render()))
}

#[test]
fn outputs_and_inputs_that_nodes_have_not_are_named() {
    let rest = r#"<nodedef name="ND" node="own"><input name="amount" type="float" value="0.5"/>
        <output name="one" type="float"/><output name="two" type="float"/></nodedef>
        <nodegraph name="NG" nodedef="ND"><constant name="k" type="float"><input name="vlue" type="float" value="1"/></constant>
        <output name="one" type="float" nodename="k"/><output name="two" type="float" interfacename="amount"/></nodegraph>
        <own name="x" type="multioutput"><input name="amont" type="float" value="0.75"/></own>
        <position name="p" type="vector3"/>
        <separate3 name="s" type="multioutput"><input name="in" type="vector3" nodename="p"/></separate3>"#;
    let inputs = r#"<input name="metalness" type="float" nodename="x" output="three"/>
        <input name="coat" type="float" nodename="x" output="two"/>
        <input name="sheen" type="float" nodename="s" output="outq"/>"#;
    let converted = imported(&Memory::default(), rest, inputs);
    let said = warnings(&converted).join("\n");
    for wanted in [
        "`own` has no input `amont`: it has no effect; did you mean `amount`?",
        "`constant` has no input `vlue`: it has no effect; did you mean `value`?",
        "there is no output called `three` here",
        "there is no output called `outq` here",
    ] {
        assert!(said.contains(wanted), "{wanted}:\n{said}");
    }
    assert!(look_text(&converted).contains("\ncoat = 0.5\n"));
}

#[test]
fn of_materials_of_one_name_the_first_holds() {
    let surface = |name: &str, metalness: &str| {
        format!(
            r#"<standard_surface name="{name}" type="surfaceshader"><input name="metalness" type="float" value="{metalness}"/></standard_surface>"#
        )
    };
    let material = |name: &str, shader: &str| {
        format!(
            r#"<surfacematerial {name} type="material"><input name="surfaceshader" type="surfaceshader" nodename="{shader}"/></surfacematerial>"#
        )
    };
    let text = format!(
        r#"<materialx version="1.37">{}{}{}{}{}</materialx>"#,
        surface("S", "0.25"),
        surface("T", "0.75"),
        material(r#"name="M""#, "S"),
        material(r#"name="M""#, "T"),
        material("", "T"),
    );
    let converted = read(&Memory::default(), &text);
    let [material] = &converted.materials[..] else {
        panic!("{:?}", converted.materials);
    };
    assert_eq!(material.name, "M");
    assert!(look_text(&converted).contains("metallic = 0.25"));
    let said = warnings(&converted).join("\n");
    assert!(said.contains("another material called `M`"), "{said}");
    assert!(said.contains("has no name"), "{said}");
    assert!(said.contains("of version 1.37"), "{said}");
}

#[test]
fn images_of_other_formats_have_their_default() {
    let nodes = r#"<image name="i" type="color3"><input name="file" type="filename" value="a.tif"/>
         <input name="default" type="color3" value="0.25, 0.5, 0.75"/></image>"#;
    let (graph, input) = graph(nodes, "i");
    let files = Memory::default().with("a.tif", "II*\0");
    let converted = imported(&files, &graph, &input);
    assert!(warnings(&converted)[0].contains("a.tif is no PNG, JPEG or WebP"));
    assert!(look_text(&converted).contains("base_color = [0.25, 0.5, 0.75]"));
}

#[test]
fn colour_spaces_matter_to_colours() {
    let of = |ty: &str| {
        let nodes = format!(
            r#"<image name="i" type="{ty}"><input name="file" type="filename" value="a.webp" colorspace="acescg"/></image>
            <convert name="c" type="color3"><input name="in" type="{ty}" nodename="i"/></convert>"#
        );
        let (graph, input) = graph(&nodes, "c");
        let files = Memory::default().with("a.webp", PICTURE);
        imported(&files, &graph, &input).warnings.render()
    };
    assert_eq!(of("float"), "");
    assert!(of("color3").contains("`acescg`"));
}

#[test]
fn colours_with_opacity_of_gltf_have_the_other_order() {
    let of = |ty: &str, given: &str| {
        let nodes = format!(
            r#"<gltf_image name="i" type="{ty}"><input name="file" type="filename" value="a.webp"/>{given}</gltf_image>
            <convert name="c" type="color3"><input name="in" type="{ty}" nodename="i"/></convert>"#
        );
        let (graph, input) = graph(&nodes, "c");
        let files = Memory::default().with("a.webp", PICTURE);
        look_text(&imported(&files, &graph, &input))
    };
    let given = r#"<input name="operationorder" type="integer" value="0"/>"#;
    assert!(of("color4", "").contains("operationorder = 1"));
    assert!(of("color4", given).contains("operationorder = 0"));
    assert!(!of("color3", "").contains("operationorder"));
}

#[test]
fn normal_maps_of_the_object_are_its_vectors() {
    let nodes = |from: &str| {
        format!(
            r#"<noise3d name="n" type="vector3"/>
            <normalmap name="m" type="vector3"><input name="in" type="vector3" {from}/>
            <input name="space" type="string" value="object"/></normalmap>
            <convert name="c" type="color3"><input name="in" type="vector3" nodename="m"/></convert>"#
        )
    };
    let (driven, input) = graph(&nodes(r#"nodename="n""#), "c");
    let text = look_text(&imported(&Memory::default(), &driven, &input));
    assert!(
        text.contains("texture = \"mx_normalize_3\"\nin = \"g_m_vector"),
        "{text}"
    );
    assert!(!text.contains("mx_normalmap"), "{text}");
    let (constant, input) = graph(&nodes(r#"value="1, 0.5, 0.5""#), "c");
    let text = look_text(&imported(&Memory::default(), &constant, &input));
    assert!(text.contains("base_color = [1.0, 0.0, 0.0]"), "{text}");
}

#[test]
fn namespaces_of_materialx_are_read() {
    let files = Memory::default().with(
        "own.mtlx",
        r#"<materialx version="1.39" namespace="my"><nodedef name="ND" node="grey"><output name="out" type="color3"/></nodedef>
        <nodegraph name="NG" nodedef="ND"><constant name="k" type="color3"><input name="value" type="color3" value="0.25, 0.25, 0.25"/>
        </constant><output name="out" type="color3" nodename="k"/></nodegraph></materialx>"#,
    );
    let text = "<materialx version=\"1.39\">\n<xi:include href=\"own.mtlx\"/>\n<my:grey name=\"g\" type=\"color3\"/>\n\
        <nonsense name=\"n\" type=\"float\"/>\n<standard_surface name=\"S\" type=\"surfaceshader\">\
        <input name=\"base_color\" type=\"color3\" nodename=\"g\"/><input name=\"coat\" type=\"float\" nodename=\"n\"/>\
        </standard_surface>\n</materialx>";
    let converted = read(&files, text);
    let look = look_text(&converted);
    assert!(look.contains("base_color = [0.25, 0.25, 0.25]"), "{look}");
    // What has been added to the text moves no place.
    let said = converted.warnings.render();
    assert!(said.contains("a.mtlx:4:1"), "{said}");
    assert!(!said.contains("xmlns"), "{said}");
    // A file that ends too early is as wrong as without them, at its place.
    let broken = Document::parse(
        &files,
        Path::new("a.mtlx"),
        &text.replace("</standard_surface>", ""),
    );
    let broken = broken.expect_err("no XML").render();
    assert!(
        broken.contains("not valid XML") && broken.contains("a.mtlx:6"),
        "{broken}"
    );
    let many: String = (0..100).map(|i| format!("<p{i}:a/>")).collect();
    let many = format!("<materialx>{many}</materialx>");
    let refused = Document::parse(&files, Path::new("a.mtlx"), &many);
    assert!(
        refused
            .expect_err("too many")
            .render()
            .contains("not valid XML")
    );
}

#[test]
fn what_has_a_namespace_takes_no_ones_place() {
    let graph = |attributes: &str, value: &str| {
        format!(
            r#"<nodegraph name="NG" {attributes}><constant name="k" type="color3"><input name="value" type="color3" value="{value}"/>
            </constant><output name="out" type="color3" nodename="k"/></nodegraph>"#
        )
    };
    // Its own definition is found by either name.
    for definition in ["ND", "my:ND"] {
        let own = format!(
            r#"<materialx version="1.39" namespace="my"><nodedef name="ND" node="grey"><output name="out" type="color3"/></nodedef>{}
            <grey name="g" type="color3"/>
            <standard_surface name="S" type="surfaceshader"><input name="base_color" type="color3" nodename="g"/>
            <input name="metalness" type="float" value="1"/></standard_surface>
            <surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>
            <surfacematerial name="N" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>
            </materialx>"#,
            graph(&format!("nodedef=\"{definition}\""), "0.25, 0.25, 0.25")
        );
        let text = format!(
            r#"<materialx version="1.39"><xi:include href="own.mtlx"/>{}
            <standard_surface name="S" type="surfaceshader"><input name="base_color" type="color3" nodegraph="NG" output="out"/>
            </standard_surface>
            <surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>
            <surfacematerial name="O" type="material"><input name="surfaceshader" type="surfaceshader" nodename="my:S"/></surfacematerial>
            </materialx>"#,
            graph("", "1, 0, 0")
        );
        let converted = read(&Memory::default().with("own.mtlx", &own), &text);
        let materials: Vec<_> = (converted.materials.iter())
            .map(|material| {
                let color = material
                    .parameters
                    .iter()
                    .find(|(key, _)| *key == "base_color");
                (material.name.as_str(), &color.expect("a colour").1)
            })
            .collect();
        let red = look::Value::numbers(&[1.0, 0.0, 0.0]);
        let grey = look::Value::numbers(&[0.25, 0.25, 0.25]);
        assert_eq!(materials, [("M", &red), ("O", &grey), ("N", &grey)]);
    }
}

#[test]
fn attributes_of_other_programs_are_not_read() {
    let text = r#"<materialx version="1.39"><standard_surface ui:name="pretty" name="S" type="surfaceshader">
        <input name="metalness" type="float" ui:value="0.25" value="0.75"/></standard_surface></materialx>"#;
    let look = look_text(&read(&Memory::default(), text));
    assert!(look.contains("[material.S]"), "{look}");
    assert!(look.contains("metallic = 0.75"), "{look}");
}

#[test]
fn comments_before_the_root_may_name_it() {
    let text = "<!-- The <materialx> root holds all. -->\n<materialx version=\"1.39\">\n<xi:include href=\"stdlib/stdlib_defs.mtlx\"/>\n\
        <standard_surface name=\"S\" type=\"surfaceshader\"/></materialx>";
    assert_eq!(warnings(&read(&Memory::default(), text)), [""; 0]);
}

#[test]
fn libraries_of_materialx_need_not_be_there() {
    for href in [
        "stdlib/stdlib_defs.mtlx",
        "libraries/bxdf/standard_surface.mtlx",
        "../libraries/other.mtlx",
        "libraries/lights/lights_defs.mtlx",
    ] {
        let text = format!(
            r#"<materialx version="1.39"><xi:include href="{href}"/><standard_surface name="S" type="surfaceshader"/></materialx>"#
        );
        assert_eq!(warnings(&read(&Memory::default(), &text)), [""; 0]);
    }
    // Anyone's folder may be called so.
    let text = r#"<materialx version="1.39"><xi:include href="lights/own.mtlx"/></materialx>"#;
    let read = Document::parse(&Memory::default(), Path::new("a.mtlx"), text);
    let error = read.expect_err("it is not there").render();
    assert!(error.contains("cannot read lights/own.mtlx"), "{error}");
}

#[test]
fn many_definitions_and_names_do_not_multiply() {
    let start = Instant::now();
    let definitions: String = (0..3000)
        .map(|i| format!(r#"<nodedef name="D{i}" node="foo" inherit="D{}"/>"#, i + 1))
        .collect();
    // A tree of sums, whose leaves are nodes of that category and noises.
    let name = |i: usize| match i {
        0..2047 => format!("t{i}"),
        i if i % 2 == 0 => format!("f{i}"),
        i => format!("x{i}"),
    };
    let node = |i: usize| {
        let this = name(i);
        let (left, right) = (name(2 * i + 1), name(2 * i + 2));
        match this.as_bytes()[0] {
            b'f' => format!(r#"<foo name="{this}" type="color3"/>"#),
            b'x' => format!(r#"<noise3d name="{this}" type="vector3"/>"#),
            _ => format!(
                r#"<add name="{this}" type="color3"><input name="in1" type="color3" nodename="{left}" channels="r0g"/>
                <input name="in2" type="color3" nodename="{right}"/></add>"#
            ),
        }
    };
    let nodes: String = (0..4095).map(node).collect();
    let input = r#"<input name="base_color" type="color3" nodename="t0"/>"#;
    let converted = imported(&Memory::default(), &(definitions + &nodes), input);
    // Sums, noises, and a node for the channels of each sum.
    assert_eq!(converted.nodes.len(), 2047 + 1024 + 2047);
    let taken = start.elapsed();
    assert!(taken < Duration::from_secs(20), "{taken:?}");
}

#[test]
fn where_too_many_definitions_are_looked_at_nothing_else_is_said() {
    // Each has an input of its own, by which it is found among all the others.
    let definitions: String = (0..2000)
        .map(|i| {
            format!(
                r#"<nodedef name="D{i}" node="foo"><input name="i{i}" type="float" value="1"/><output name="out" type="float"/></nodedef>
                <nodegraph name="G{i}" nodedef="D{i}"><output name="out" type="float" value="0.5"/></nodegraph>"#
            )
        })
        .collect();
    let nodes: String = (0..150)
        .map(|i| {
            format!(
                r#"<foo name="f{i}" type="float"><input name="i{i}" type="float" value="1"/></foo>
                <output name="o{i}" type="float" nodename="f{i}"/>"#
            )
        })
        .collect();
    let rest = format!(
        r#"{definitions}
        <nodedef name="DA" node="all"><output name="o0" type="float"/></nodedef>
        <nodegraph name="GA" nodedef="DA">{nodes}</nodegraph><all name="x" type="float"/>"#
    );
    let input = r#"<input name="metalness" type="float" nodename="x" output="o0"/>"#;
    let converted = imported(&Memory::default(), &rest, input);
    assert_eq!(
        warnings(&converted),
        ["too many definitions and nodes to look at: the rest is left out"]
    );
    assert!(look_text(&converted).contains("metallic = 0.5"));
}

#[test]
fn more_attributes_than_any_element_has_are_refused() {
    let of = |count: usize| {
        let attributes: String = (0..count).map(|i| format!(" a{i}=\"=\"")).collect();
        let text = format!("<materialx version=\"1.39\"><a{attributes}/></materialx>");
        Document::parse(&Memory::default(), Path::new("a.mtlx"), &text)
    };
    assert!(of(1000).is_ok());
    let told = of(300_000).expect_err("it would take a minute").render();
    assert!(told.contains("too many attributes"), "{told}");
}
