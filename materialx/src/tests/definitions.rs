//! Definitions of a document's own: which of them a node has, and what its inputs are.

use super::{Memory, imported, warnings};
use crate::look_text;

#[test]
fn definitions_inherit_inputs() {
    let rest = r#"<nodedef name="ND_base" node="base"><input name="far" type="float" value="0.25"/>
         <input name="near" type="float" value="0.75"/>
         <input name="place" type="vector2" defaultgeomprop="UV0"/>
         <output name="out" type="color3"/></nodedef>
         <nodedef name="ND_middle" node="middle" inherit="ND_base">
         <input name="near" type="float" value="0.5"/></nodedef>
         <nodedef name="ND_derived" node="derived" inherit="ND_middle"/>
         <nodegraph name="NG" nodedef="ND_derived">
         <combine3 name="c" type="color3"><input name="in1" type="float" interfacename="far"/>
         <input name="in2" type="float" interfacename="near"/>
         <input name="in3" type="float" nodename="y"/></combine3>
         <extract name="y" type="float"><input name="in" type="vector2" interfacename="place"/>
         <input name="index" type="integer" value="1"/></extract>
         <output name="out" type="color3" nodename="c"/></nodegraph>
         <derived name="x" type="color3"/>"#;
    let inputs = r#"<input name="base_color" type="color3" nodename="x"/>"#;
    let converted = imported(&Memory::default(), rest, inputs);
    assert_eq!(warnings(&converted), [""; 0]);
    let text = look_text(&converted);
    let wanted = "in1 = 0.25\nin2 = 0.5\nin3 = \"texcoord.y\"";
    assert!(text.contains(wanted), "{text}");
}

#[test]
fn inputs_that_no_definition_knows_are_named() {
    // A circle of definitions, none of which has it; one that has no value for it; one whose value is an empty text.
    let graph = r#"<dot name="d" type="float"><input name="in" type="float" interfacename="in"/></dot>
         <output name="out" type="float" nodename="d"/>"#;
    let of = |definitions: &str| {
        let rest = format!(
            r#"{definitions}<nodegraph name="NG" nodedef="ND">{graph}</nodegraph><n name="x" type="float"/>"#
        );
        let inputs = r#"<input name="metalness" type="float" nodename="x"/>"#;
        let converted = imported(&Memory::default(), &rest, inputs);
        converted.warnings.render()
    };
    let output = r#"<output name="out" type="float"/>"#;
    let said = of(&format!(
        r#"<nodedef name="ND" node="n" inherit="ND_b">{output}</nodedef><nodedef name="ND_b" inherit="ND"/>"#
    ));
    assert!(said.contains("no input called `in` here"), "{said}");
    let with = |attributes: &str| {
        format!(r#"<nodedef name="ND" node="n"><input name="in" {attributes}/>{output}</nodedef>"#)
    };
    let said = of(&with(r#"type="float""#));
    assert!(
        said.contains("`in` is given nothing, and its definition has no value"),
        "{said}"
    );
    assert_eq!(of(&with(r#"type="string" value="""#)), "");
}

#[test]
fn of_overloaded_definitions_the_one_counts_that_takes_what_is_given() {
    let graph = |name: &str, value: &str| {
        format!(
            r#"<nodegraph name="NG_{name}" nodedef="ND_{name}"><constant name="k" type="float">
            <input name="value" type="float" value="{value}"/></constant>
            <output name="out" type="float" nodename="k"/></nodegraph>"#
        )
    };
    let rest = format!(
        r#"<nodedef name="ND_number" node="pick"><input name="in" type="float" value="0"/>
        <output name="out" type="float"/></nodedef>
        <nodedef name="ND_wide"><input name="in" type="vector3" value="0, 0, 0"/></nodedef>
        <nodedef name="ND_vector" node="pick" inherit="ND_wide"><output name="out" type="float"/></nodedef>
        <nodedef name="ND_more" node="pick"><input name="in" type="float" value="0"/>
        <input name="more" type="float" value="0"/><output name="out" type="float"/></nodedef>
        <nodedef name="ND_color" node="pick"><input name="in" type="float" value="0"/>
        <output name="out" type="color3"/></nodedef>{}{}{}"#,
        graph("number", "0.25"),
        graph("vector", "0.5"),
        graph("more", "0.75"),
    );
    for (given, wanted) in [
        (r#"<input name="in" type="float" value="1"/>"#, "0.25"),
        (
            r#"<input name="in" type="vector3" value="1, 1, 1"/>"#,
            "0.5",
        ),
        (r#"<input name="more" type="float" value="1"/>"#, "0.75"),
        ("", "0.25"),
        // None takes this: the first that gives a number.
        (
            r#"<input name="in" type="color3" value="1, 1, 1"/>"#,
            "0.25",
        ),
        (r#"<input name="other" type="float" value="1"/>"#, "0.25"),
    ] {
        let rest = format!(r#"{rest}<pick name="x" type="float">{given}</pick>"#);
        let inputs = r#"<input name="metalness" type="float" nodename="x"/>"#;
        let text = look_text(&imported(&Memory::default(), &rest, inputs));
        let wanted = format!("metallic = {wanted}");
        assert!(text.contains(&wanted), "{given}: {wanted}\n{text}");
    }
}

#[test]
fn inputs_that_a_node_inherits_choose_its_definition_too() {
    let definition = |name: &str, ty: &str, value: &str| {
        format!(
            r#"<nodedef name="ND_{name}" node="pick"><input name="in" type="{ty}"/><output name="out" type="float"/></nodedef>
            <nodegraph name="NG_{name}" nodedef="ND_{name}"><constant name="k" type="float">
            <input name="value" type="float" value="{value}"/></constant>
            <output name="out" type="float" nodename="k"/></nodegraph>"#
        )
    };
    let rest = format!(
        r#"{}{}<pick name="base" type="float"><input name="in" type="vector3" value="1, 1, 1"/></pick>
        <pick name="x" type="float" inherit="base"/>
        <pick name="y" type="float" inherit="base"><input name="in" type="float" value="1"/></pick>
        <constant name="k" type="float"><input name="vlue" type="float" value="1"/></constant>
        <constant name="l" type="float" inherit="k"/>"#,
        definition("number", "float", "0.25"),
        definition("vector", "vector3", "0.5"),
    );
    let inputs = r#"<input name="metalness" type="float" nodename="x"/><input name="coat" type="float" nodename="y"/>
        <input name="sheen" type="float" nodename="l"/>"#;
    let converted = imported(&Memory::default(), &rest, inputs);
    let text = look_text(&converted);
    for wanted in ["metallic = 0.5", "coat = 0.25"] {
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
    let said = warnings(&converted).join("\n");
    assert!(
        said.contains("`constant` has no input `vlue`: it has no effect"),
        "{said}"
    );
}

#[test]
fn of_several_versions_the_nodes_own_counts_or_the_default() {
    let definition = |name: &str, attributes: &str, input: &str| {
        format!(
            r#"<nodedef name="ND_{name}" node="pick" {attributes}><input name="{input}" type="float" value="0"/>
            <output name="out" type="float"/></nodedef>
            <nodegraph name="NG_{name}" nodedef="ND_{name}"><constant name="k" type="float">
            <input name="value" type="float" value="{name}"/></constant>
            <output name="out" type="float" nodename="k"/></nodegraph>"#
        )
    };
    let all = [
        definition("0.25", r#"version="1.0""#, "in"),
        definition("0.5", r#"version="2.0" isdefaultversion="true""#, "in"),
        definition("0.75", r#"version="3""#, "more"),
    ];
    let given = r#"<input name="more" type="float" value="1"/>"#;
    for (node, wanted) in [
        (r#"<pick name="x" type="float"/>"#.to_owned(), "0.5"),
        (
            r#"<pick name="x" type="float" version="1.0"/>"#.to_owned(),
            "0.25",
        ),
        (
            r#"<pick name="x" type="float" version="1"/>"#.to_owned(),
            "0.25",
        ),
        (
            r#"<pick name="x" type="float" version="3.0"/>"#.to_owned(),
            "0.75",
        ),
        // There is no such version.
        (
            r#"<pick name="x" type="float" version="4.0"/>"#.to_owned(),
            "0.5",
        ),
        // Only the third takes this.
        (
            format!(r#"<pick name="x" type="float">{given}</pick>"#),
            "0.75",
        ),
    ] {
        let rest = format!("{}{node}", all.concat());
        let inputs = r#"<input name="metalness" type="float" nodename="x"/>"#;
        let text = look_text(&imported(&Memory::default(), &rest, inputs));
        let wanted = format!("metallic = {wanted}");
        assert!(text.contains(&wanted), "{node}: {wanted}\n{text}");
    }
}
