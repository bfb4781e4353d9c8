//! Random edits of all kinds: every state is a look, and undoing all of them gives back the text to the byte.

use std::path::Path;
use std::rc::Rc;

use engine::procedural::{Output, TextureSources};
use engine::scene::look::{AoSettings, Look, LookDocument, Section, Value};
use engine::session::{Change, Document, Edit, written};
use texgen::{Interpolation, Ramp, Swizzle};

use crate::model::{Model, Target};
use crate::rename::{Renaming, rename};
use crate::{Textures, edits};

const LOOK: &str = "# An old valve.\nenvironment = { color = [1, 1, 1] } # white\n\n[ao.near]\ndistance = 0.1 # m\n\n\
                    [node.rust] # where it rusts\ntexture = 'mask'\namount   = 0.25 # a quarter\n\n\
                    [node.paint]\ntexture = 'tint'\ncolor = '#7a3b12'\nfactor = 'rust'\n\n\
                    # What rusts.\n[material.Iron]\nbase_color = 'paint' # driven\n  roughness = 0.5\n# The end.";

/// xorshift64*.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n.max(1)
    }

    fn unit(&mut self) -> f32 {
        self.below(1001) as f32 / 1000.0
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }
}

fn textures() -> Textures {
    let mut sources = TextureSources::default();
    let mask = "/// @param amount share [0 .. 1] = 0.5\nfn userProc(amount: f32, scale: f32) -> f32 { return amount * scale; }";
    let tint =
        "fn userProc(color: vec3f, shade: ramp1D, factor: f32) -> vec3f { return color * factor; }";
    sources.insert("mask", mask);
    sources.insert("tint", tint);
    let textures = Textures::load(&sources);
    assert!(textures.broken.is_empty(), "{:?}", textures.broken);
    textures
}

/// Does something; the outcome of what a user can't do doesn't matter.
fn act(random: &mut Random, document: &mut Document, textures: &Textures) {
    let model = Model::new(document, &textures.library);
    let nodes: Vec<String> = document
        .look()
        .nodes
        .iter()
        .map(|n| n.name.value.clone())
        .collect();
    let materials = ["Iron", "Paint", "New Metal"];
    let node = random.pick(&nodes).cloned().unwrap_or_default();
    let material = materials[random.below(3)].to_owned();
    let section = Section::Node(node.clone());
    let target = match random.below(3) {
        0 => Target::Mask {
            material: material.clone(),
        },
        1 => Target::Input {
            material: material.clone(),
            output: Output::ALL[random.below(Output::ALL.len())],
        },
        _ => Target::Parameter {
            node: node.clone(),
            parameter: ["amount", "scale", "color", "factor"][random.below(4)].to_owned(),
        },
    };
    let label = "step";
    let group = (random.below(2) == 0).then_some(3);
    if random.below(12) == 0 {
        let name = ["rust", "moss", "a b", "rust-2"][random.below(4)];
        let renaming = match random.below(2) {
            0 => Renaming::of_node(document, &model, &node, name),
            _ => Renaming::of_material(document, &model, &material, name, std::iter::empty()),
        };
        let _ = renaming.and_then(|renaming| rename(document, &renaming));
        return;
    }
    let made: Result<Vec<Edit>, String> = match random.below(14) {
        0 | 1 if model.texture(&node).is_some_and(|t| t.name() == "mask") => {
            let value = texgen::Value::F32(random.unit());
            Ok(vec![Edit::argument(&node, "amount", &value)])
        }
        2 if model.texture(&node).is_some_and(|t| t.name() == "tint") => {
            let ramp = Ramp {
                stops: vec![(random.unit(), [random.unit(); 4]), (1.0, [1.0; 4])],
                interpolation: Interpolation::Smooth,
            };
            Ok(vec![Edit::argument(
                &node,
                "shade",
                &texgen::Value::Ramp(ramp),
            )])
        }
        3 => Ok(vec![Edit::Clear {
            section,
            key: "amount".to_owned(),
        }]),
        4 => Ok(edits::add_node(document, ["mask", "tint", "odd name"][random.below(3)]).1),
        5 if !nodes.is_empty() => {
            let some: Vec<String> = nodes
                .iter()
                .filter(|_| random.below(3) == 0)
                .cloned()
                .collect();
            Ok(edits::remove_nodes(document, &model, &some))
        }
        6 if !nodes.is_empty() => {
            let some: Vec<String> = nodes
                .iter()
                .take(4)
                .filter(|_| random.below(2) == 0)
                .cloned()
                .collect();
            Ok(edits::duplicate(document, &model, &some).1)
        }
        7 | 8 => {
            let swizzle: Option<Swizzle> = ["x", "y", "xyz"][random.below(3)].parse().ok();
            let swizzle = swizzle.filter(|_| random.below(2) == 0);
            edits::connect(&model, &node, swizzle, &target)
        }
        9 => Ok(edits::disconnect(document, &target)),
        10 => {
            let other = materials[random.below(3)];
            Ok(edits::make_blend(&material, other))
        }
        11 => Ok(vec![Edit::reset_material(&material, "blend")]),
        12 => {
            let key = ["roughness", "ior", "alpha", "opacity", "coat"][random.below(5)];
            let value = written(&texgen::Value::F32(random.unit()));
            Ok(vec![Edit::material(&material, key, value)])
        }
        _ => {
            let settings = AoSettings {
                distance: random.unit(),
                ..AoSettings::default()
            };
            let name = ["near", "far"][random.below(2)];
            let intensity = Edit::environment("intensity", Value::number(random.unit()));
            Ok(Edit::ao(name, &settings)
                .into_iter()
                .chain([intensity])
                .collect())
        }
    };
    // What is refused leaves no trace; that is checked with everything else.
    if let Ok(edits) = made {
        let _ = document.apply(label, &edits, group);
    }
}

#[test]
fn random_edits_are_looks_and_can_be_undone() {
    let textures = textures();
    let path = Path::new("a.look.toml");
    for (seed, text) in [LOOK.to_owned(), LOOK.replace('\n', "\r\n"), String::new()]
        .iter()
        .enumerate()
    {
        let mut random = Random(0x9e37_79b9_7f4a_7c15 + seed as u64);
        let mut document = Document::new(path, text).unwrap_or_else(|e| panic!("{e}"));
        // As the renderer has it: changed only by what it is told.
        let mut told = LookDocument::parse(path, text).unwrap_or_else(|e| panic!("{e}"));
        let mut model = Rc::new(Model::new(&document, &textures.library));
        for _ in 0..400 {
            match random.below(12) {
                0 => {
                    document.undo();
                }
                1 => {
                    document.redo();
                }
                2 => document.end_group(),
                _ => act(&mut random, &mut document, &textures),
            }
            let now = document.text();
            Look::parse(path, now).unwrap_or_else(|e| panic!("no look: {e}\n{now}"));
            model = Rc::new(model.renewed(&document, &textures.library));
            let new = Model::new(&document, &textures.library);
            assert_eq!(model.wires, new.wires);
            assert_eq!(model.graph.args(), new.graph.args());
            for change in document.take_changes() {
                match change {
                    Change::Edit {
                        edit:
                            Edit::Set {
                                section,
                                key,
                                value,
                            },
                        ..
                    } => told.set(&section, &key, &value).expect("it was no mistake"),
                    change => {
                        told = LookDocument::parse(path, change.text())
                            .unwrap_or_else(|e| panic!("{e}"));
                    }
                }
            }
            let (told, now) = (told.fields(), document.text());
            let now = LookDocument::parse(path, now).unwrap_or_else(|e| panic!("{e}"));
            let now = Value::Table(now.fields());
            assert!(
                Value::Table(told).is_same(&now),
                "the renderer has another look"
            );
        }
        let mut steps = 0;
        while document.undo() {
            steps += 1;
        }
        assert_eq!(document.text(), text);
        assert!(steps > 50, "{steps} steps are few");
        while document.redo() {}
        // What had been undone at the end is done again, too.
        let ends = document.text().to_owned();
        while document.undo() {}
        assert_eq!(document.text(), text);
        while document.redo() {}
        assert_eq!(document.text(), ends);
    }
}
