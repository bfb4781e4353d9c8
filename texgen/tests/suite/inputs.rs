//! Parameters that take an attribute where nothing is linked, and shared files.

use std::sync::Arc;

use texgen::{
    Attribute, BuiltinAttribute, Graph, GraphError, HOST_STUB, SourceFile, TextureType, Value,
    emit_inlined,
};

use crate::common::{errors, library, valid_kernel, validate};

const PLACED: &str = "/// @param p where [attr LocalPos]
/// @param n the direction [attr Normal]
/// @param open how open it is [attr AO]
/// @param wet the mesh says so [attr _WETNESS]
/// @param scale size = 2
fn userProc(p: vec4f, n: vec3f, open: f32, wet: vec2f, scale: f32) -> vec4f {
    return vec4f(p.xyz * scale + n, p.w) * open + wet.xyxy;
}";

#[test]
fn a_parameter_takes_its_attribute_until_it_is_linked_or_set() {
    let library = library(&[
        ("t", PLACED),
        ("v", "fn userProc() -> vec3f { return vec3f(1.0); }"),
    ]);
    let texture = library.get("t").expect("is there");
    let local = Attribute::Builtin(BuiltinAttribute::LocalPos);
    assert!(texture.attributes().contains(&local));
    assert!(
        texture
            .attributes()
            .contains(&Attribute::Custom("_WETNESS".into()))
    );
    assert!(
        texture
            .attributes()
            .contains(&BuiltinAttribute::Footprint.into())
    );
    let kernel = valid_kernel(&library);
    assert!(
        kernel.contains("vec4f(patina_attr_LocalPos().xyz, 0.0)"),
        "{kernel}"
    );

    let mut graph = Graph::new(library);
    let t = graph.add_node("t", "t", [0, 0]).expect("known");
    let v = graph.add_node("v", "v", [0, 0]).expect("known");
    assert_eq!(graph.attribute(t, "p"), Some(&local));
    let unlinked = graph.compile(&[t]).expect("compiles").words;

    let edit = graph
        .set_value(t, "p", Value::Vec4([1.0; 4]))
        .expect("fits");
    assert!(edit.program && graph.attribute(t, "p").is_none());
    // Its last component is no width of a pixel.
    assert!(
        kernel.contains("p0 = vec4f(patina_arg_vec3f(args + 0u), 0.0);"),
        "{kernel}"
    );
    let again = graph
        .set_value(t, "p", Value::Vec4([2.0; 4]))
        .expect("fits");
    assert!(!again.program, "another constant is data");
    let set = graph.compile(&[t]).expect("compiles");
    assert_ne!(set.words, unlinked);
    assert!(
        set.instructions(graph.library()).expect("decodes")[0]
            .links
            .is_empty()
    );

    graph
        .set_link(t, "p", v, None)
        .expect("a place takes three components");
    let program = graph.compile(&[t]).expect("compiles");
    let links = &program.instructions(graph.library()).expect("decodes")[1].links;
    // The width of the pixel is not known there: 0, in the last component.
    assert_eq!(links[0].1 >> 25 & 7, 4);

    assert!(graph.reset(t, "p").expect("is there").program);
    assert_eq!(graph.compile(&[t]).expect("compiles").words, unlinked);
}

#[test]
fn the_inlined_form_takes_attributes_too() {
    let library = library(&[
        ("t", PLACED),
        ("v", "fn userProc() -> vec2f { return vec2f(1.0); }"),
    ]);
    let mut graph = Graph::new(Arc::clone(&library));
    let [a, b] = ["a", "b"].map(|name| graph.add_node(name, "t", [0, 0]).expect("known"));
    let v = graph.add_node("v", "v", [0, 0]).expect("known");
    graph.set_link(b, "p", v, None).expect("fits");
    graph
        .set_value(a, "n", Value::Vec3([0.0, 1.0, 0.0]))
        .expect("fits");
    let kernel = emit_inlined(&graph, &[vec![a.into(), b.into()]])
        .expect("compiles")
        .wgsl;
    validate(&format!("{kernel}\n{HOST_STUB}")).unwrap_or_else(|problem| panic!("{problem}"));
    assert!(kernel.contains("patina_attr_custom(patina_custom_WETNESS).xy"));
    assert!(kernel.contains("patina_place("));
}

#[test]
fn places_take_links_of_any_size_and_others_do_not() {
    let library = library(&[
        (
            "t",
            "/// @param p where [attr WorldPos]\nfn userProc(p: vec3f, q: vec3f) -> f32 { return p.x + q.x; }",
        ),
        ("v", "fn userProc() -> vec4f { return vec4f(1.0); }"),
    ]);
    let mut graph = Graph::new(library);
    let t = graph.add_node("t", "t", [0, 0]).expect("known");
    let v = graph.add_node("v", "v", [0, 0]).expect("known");
    graph.set_link(t, "p", v, None).expect("its w is left out");
    let refused = graph.set_link(t, "q", v, None);
    assert!(matches!(refused, Err(GraphError::LinkType { .. })));
}

#[test]
fn wrong_attributes_are_errors_with_their_place() {
    let error =
        errors("/// @param p where [attr LocalPoss]\nfn userProc(p: vec3f) -> f32 { return p.x; }");
    assert!(
        error.contains("t.wgsl:1:21") && error.contains("did you mean `LocalPos`"),
        "{error}"
    );
    let error = errors(
        "/// @param r curve [attr UV]\nfn userProc(r: ramp1D) -> f32 { return rampEval(r, 0.0).x; }",
    );
    assert!(error.contains("can't take an attribute"), "{error}");
    for wild in ["_A B", "_A;", "_A(", "_", "_/*"] {
        let text = format!(
            "/// @param p where [attr {wild}]\nfn userProc(p: vec3f) -> f32 {{ return p.x; }}"
        );
        assert!(errors(&text).contains("no attribute called"), "{wild}");
    }
}

fn file(name: &str, text: &str) -> SourceFile {
    SourceFile::new(name, format!("lib/{name}.wgsl"), text)
}

fn texture(text: &str, libraries: &[(&str, &str)]) -> Result<TextureType, texgen::Diagnostics> {
    let libraries: Vec<SourceFile> = libraries.iter().map(|(n, t)| file(n, t)).collect();
    TextureType::parse(SourceFile::new("t", "t.wgsl", text).with_libraries(libraries))
}

fn problems(text: &str, libraries: &[(&str, &str)]) -> String {
    texture(text, libraries).expect_err("is wrong").render()
}

const USER: &str =
    "/// @use waves\n/// Waves.\nfn userProc() -> f32 { return wave(readAttr(WorldPos).x); }";
const WAVES: &str =
    "/// @use more\n//! Not the texture's.\nfn wave(x: f32) -> f32 { return helper(sin(x)); }";
const MORE: &str = "fn helper(x: f32) -> f32 { return x * readAttr(AO).x; }";

#[test]
fn a_texture_takes_functions_from_shared_files() {
    let texture = texture(USER, &[("waves", WAVES), ("more", MORE)]).expect("is right");
    assert_eq!(texture.docs(), "Waves.");
    assert!(texture.attributes().contains(&BuiltinAttribute::AO.into()));
    let library = Arc::new(texgen::Library::new(vec![texture]).expect("one"));
    let kernel = valid_kernel(&library);
    assert!(
        kernel.contains("fn t__wave(") && kernel.contains("t__helper(sin(x))"),
        "{kernel}"
    );
    // A driver's error in a shared file is shown there.
    let emitted = library.emit(1);
    let at = emitted.wgsl.find("sin(x)").expect("is in the text");
    let (file, offset) = emitted.source_map.origin(at).expect("is a user's");
    assert_eq!(
        (file.path(), offset),
        ("lib/waves.wgsl", WAVES.find("sin").expect("is there"))
    );
}

#[test]
fn a_file_that_breaks_off_is_blamed_itself() {
    for word in ["const", "fn", "@", "struct", "alias"] {
        let said = format!("something is missing behind `{word}`");
        let text = format!("{USER}\n{word} // no more\n");
        let error = problems(&text, &[("waves", WAVES), ("more", MORE)]);
        assert!(
            error.contains(&said) && error.contains("t.wgsl:4:1"),
            "{error}"
        );
        assert!(!error.contains("lib/"), "{error}");
        let more = format!("{MORE} {word}");
        let error = problems(USER, &[("waves", WAVES), ("more", &more)]);
        assert!(
            error.contains(&said) && error.contains("lib/more.wgsl:1:"),
            "{error}"
        );
        let error = problems(
            &format!("fn userProc() -> f32 {{ return 1.0; }} {word}"),
            &[],
        );
        assert!(
            error.contains(&said) && !error.contains("struct` is a reserved"),
            "{error}"
        );
    }
    // What is open says more.
    let error = problems("fn userProc() -> f32 { let", &[]);
    assert!(error.contains("this `{` is not closed"), "{error}");
}

#[test]
fn errors_of_shared_files_lie_in_them() {
    let wrong = "fn other() -> f32 { return 1.0; }\nfn wave(x: f32) -> f32 { return sinn(x); }";
    let error = problems(USER, &[("waves", wrong)]);
    assert!(error.contains("lib/waves.wgsl:2:33"), "{error}");
    let error = problems(USER, &[("wave", WAVES)]);
    assert!(
        error.contains("t.wgsl:1:10") && error.contains("did you mean `wave`?"),
        "{error}"
    );
    let error = problems(USER, &[("waves", WAVES)]);
    assert!(
        error.contains("lib/waves.wgsl:1:10") && error.contains("no shared file `more`"),
        "{error}"
    );
    let error = problems(
        USER,
        &[
            ("waves", WAVES),
            (
                "more",
                "/// @use waves\nfn helper(x: f32) -> f32 { return x; }",
            ),
        ],
    );
    assert!(
        error.contains("lib/more.wgsl:1:10") && error.contains("uses itself"),
        "{error}"
    );
    let error = problems(
        USER,
        &[(
            "waves",
            "fn wave(x: f32) -> f32 { return x; }\nfn userProc() -> f32 { return 1.0; }",
        )],
    );
    assert!(error.contains("lib/waves.wgsl:2:4"), "{error}");
    let both = "/// @use waves\nfn wave(x: f32) -> f32 { return x; }\nfn userProc() -> f32 { return wave(1.0); }";
    let error = problems(both, &[("waves", "fn wave(x: f32) -> f32 { return x; }")]);
    assert!(
        error.contains("t.wgsl:2:4") && error.contains("lib/waves.wgsl:1:4"),
        "{error}"
    );
}

#[test]
fn errors_of_a_texture_are_not_told_of_its_shared_files() {
    let libraries = [("waves", WAVES), ("more", MORE)];
    let own = "/// @use waves\n/// Waves.\nfn userProc(x: f32) -> f32 {\n    return wave(x[1]);\n}";
    let error = problems(own, &libraries);
    assert!(
        error.contains("t.wgsl:4:17") && error.contains("`x` is `f32`"),
        "{error}"
    );
    assert!(!error.contains("lib/"), "{error}");

    let own = "/// @use waves\n/// Waves.\nfn userProc() -> f32 {\n    if true {\n        return wave(1.0);\n}\n";
    let error = problems(own, &libraries);
    assert!(
        error.contains("this `{` is not closed") && error.contains("t.wgsl:3:22"),
        "{error}"
    );
    let open = "fn helper(x: f32) -> f32 { return x;";
    let error = problems(USER, &[("waves", WAVES), ("more", open)]);
    assert!(error.contains("lib/more.wgsl:1:26"), "{error}");
}
