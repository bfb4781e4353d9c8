//! The material tables of a look brought to the scene's materials: constants are set, new materials made, and what is
//! to be driven is noted down. No program is compiled here.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::Vec3;
use texgen::{Diagnostic, Diagnostics, Graph, SourceFile, did_you_mean};

use crate::scene::look::{Input, Look, MaterialLook, Span, Spanned};
use crate::scene::{AlphaMode, Material, Scene};

use super::traits::Surface;
use super::wiring::{Blend, Mask, Wiring, check_driver};
use super::{Kind, NodeOutput, Output, Procedural};

/// The materials of a scene with the look applied.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) wiring: Vec<Wiring>,
    /// All material indices, blends after what lies below them.
    pub(super) order: Vec<u32>,
    /// By the name that the look uses.
    pub(super) names: HashMap<String, u32>,
    /// Where the surface of a material that blends with itself went.
    pub(super) surfaces: HashMap<String, u32>,
    /// Without what the look's tables say.
    pub(super) originals: Arc<[Material]>,
    /// So many are the scene's; the look added the rest.
    pub(super) in_scene: usize,
}

/// Applies all material tables; mistakes are added to `problems`.
pub(super) fn resolve(
    look: &Look,
    scene: &mut Scene,
    graph: &Graph,
    problems: &mut Diagnostics,
) -> Materials {
    let mut resolver = Resolver {
        file: &look.file,
        graph,
        problems,
        out: Materials::default(),
    };
    for (index, material) in (0..).zip(&scene.materials) {
        resolver
            .out
            .names
            .entry(material.name.clone())
            .or_insert(index);
    }
    resolver.out.in_scene = scene.materials.len();
    resolver.declare(look, scene);
    resolver.out.originals = scene.materials.clone().into();
    resolver.out.wiring = (scene.materials.iter())
        .map(|material| Wiring::new(surface_of(material)))
        .collect();
    for table in &look.materials {
        resolver.surface(table, scene);
        resolver.blend(table);
    }
    resolver.sort(look);
    copy_bases(scene, &resolver.out.wiring, &resolver.out.order);
    resolver.out
}

/// Gives blends the records of their bases, without emission.
pub(super) fn copy_bases(scene: &mut Scene, wiring: &[Wiring], order: &[u32]) {
    for &index in order {
        if let Some(blend) = &wiring[index as usize].blend {
            let own = &mut scene.materials[index as usize];
            let (name, matte) = (std::mem::take(&mut own.name), own.matte.take());
            scene.materials[index as usize] = Material {
                name,
                matte,
                emission: Vec3::ZERO,
                emission_texture: None,
                ..scene.materials[blend.base as usize].clone()
            };
        }
    }
}

pub(super) struct Resolver<'a> {
    file: &'a SourceFile,
    graph: &'a Graph,
    problems: &'a mut Diagnostics,
    out: Materials,
}

impl Resolver<'_> {
    /// Brings one material, whose record is its original, to its table, without compiling it. `own` has its surface.
    pub(super) fn update(
        procedural: &mut Procedural,
        scene: &mut Scene,
        file: &SourceFile,
        table: &MaterialLook,
        own: u32,
    ) -> Diagnostics {
        let mut problems = Diagnostics::new();
        let mut resolver = Resolver {
            file,
            graph: &procedural.graph,
            problems: &mut problems,
            out: Materials {
                wiring: std::mem::take(&mut procedural.wiring),
                names: std::mem::take(&mut procedural.material_names),
                surfaces: std::mem::take(&mut procedural.surface_names),
                ..Materials::default()
            },
        };
        resolver.out.wiring[own as usize] = Wiring::new(surface_of(&scene.materials[own as usize]));
        resolver.surface(table, scene);
        resolver.blend(table);
        procedural.wiring = resolver.out.wiring;
        procedural.material_names = resolver.out.names;
        procedural.surface_names = resolver.out.surfaces;
        problems
    }

    fn problem(&mut self, span: &Span, message: String, note: Option<String>) {
        let mut problem = Diagnostic::error(message).with_label(self.file, span.clone(), "");
        if let Some(note) = note {
            problem = problem.with_note(note);
        }
        self.problems.push(problem);
    }

    /// Makes the materials that the look adds: those that are new, and the surfaces of those that blend with themselves.
    fn declare(&mut self, look: &Look, scene: &mut Scene) {
        let blends = || look.materials.iter().filter_map(|m| m.blend.as_ref());
        let used: HashSet<&str> = blends()
            .flat_map(|b| [b.value.base.value.as_str(), b.value.over.value.as_str()])
            .collect();
        let known: Vec<String> = scene.materials.iter().map(|m| m.name.clone()).collect();
        for table in &look.materials {
            let name = &table.name.value;
            if !self.out.names.contains_key(name) {
                if !used.contains(name.as_str()) {
                    let near = did_you_mean(name, known.iter().map(String::as_str));
                    self.problem(
                        &table.name.span,
                        format!("the scene has no material `{name}`, and no blend uses it"),
                        Some(near.map_or_else(
                            || list_of(&known),
                            |near| format!("did you mean `{near}`? {}", list_of(&known)),
                        )),
                    );
                }
                let index = scene.materials.len() as u32;
                scene.materials.push(new_material(name));
                self.out.names.insert(name.clone(), index);
            }
            let blends_itself = table
                .blend
                .as_ref()
                .is_some_and(|b| b.value.base.value == *name);
            if blends_itself {
                let original = &scene.materials[self.out.names[name] as usize];
                let surface = Material {
                    name: unique_name(&format!("{name} (surface)"), scene),
                    // Whoever picks the material in a picture means what is seen of it.
                    matte: Some(name.clone()),
                    ..original.clone()
                };
                self.out
                    .surfaces
                    .insert(name.clone(), scene.materials.len() as u32);
                scene.materials.push(surface);
            }
        }
    }

    /// Sets the constants of a table and notes its links.
    fn surface(&mut self, table: &MaterialLook, scene: &mut Scene) {
        let name = &table.name.value;
        let index = *self.out.surfaces.get(name).unwrap_or(&self.out.names[name]);
        let material = &mut scene.materials[index as usize];
        table.apply(material);
        if let (Some(cutoff), false) = (
            table.input("alpha_cutoff"),
            matches!(material.alpha_mode, AlphaMode::Mask { .. }),
        ) {
            self.problem(
                &cutoff.span,
                format!("`alpha_cutoff` has no effect: `{name}` has no alpha mask"),
                Some("add alpha_mode = \"mask\"".to_owned()),
            );
        }
        for output in Output::ALL {
            let Some(input) = table.input(output.key()) else {
                continue;
            };
            if let Input::Link(_) = input.value {
                let source = self.source(input, output.kind());
                self.out.wiring[index as usize].set_output(output, source);
            }
        }
        let material = &mut scene.materials[index as usize];
        if table.is_driven("opacity") {
            material.alpha_mode = AlphaMode::Opaque;
        }
        let mut surface = Surface {
            emission: material.emission,
            has_emission_image: material.emission_texture.is_some(),
            ..surface_of(material)
        };
        if table.is_driven("emission") {
            material.emission = Vec3::ZERO;
            material.emission_texture = None;
            surface.emission = table.constant("emission_strength").unwrap_or(Vec3::ONE);
        }
        surface.bump_scale = table.constant("bump_scale").map_or(1.0, |scale| scale.x);
        if material.unlit {
            surface.emission = Vec3::ZERO;
        }
        self.out.wiring[index as usize].surface = surface;
    }

    fn source(&mut self, input: &Spanned<Input>, kind: Kind) -> Option<NodeOutput> {
        let Input::Link(link) = &input.value else {
            return None;
        };
        // A node that isn't there had a mistake of its own, which has been reported.
        let node = self.graph.node(&link.node)?;
        let source = NodeOutput {
            node,
            swizzle: link.swizzle,
        };
        match check_driver(self.graph, source, kind) {
            Ok(()) => Some(source),
            Err(message) => {
                self.problem(&input.span, message, None);
                None
            }
        }
    }

    fn blend(&mut self, table: &MaterialLook) {
        let Some(blend) = &table.blend else {
            return;
        };
        let name = &table.name.value;
        let blend = &blend.value;
        let base = match self.out.surfaces.get(name) {
            Some(&surface) => Some(surface),
            None => self.material(&blend.base),
        };
        let over = self.material(&blend.over);
        let mask = match &blend.mask.value {
            Input::Constant(value) => Some(Mask::Constant(value.x)),
            Input::Link(_) => self.source(&blend.mask, Kind::Scalar).map(Mask::Driven),
        };
        if let (Some(base), Some(over), Some(mask)) = (base, over, mask) {
            self.out.wiring[self.out.names[name] as usize].blend = Some(Blend { base, over, mask });
        }
    }

    fn material(&mut self, name: &Spanned<String>) -> Option<u32> {
        let found = self.out.names.get(&name.value).copied();
        if found.is_none() {
            let mut known: Vec<String> = self.out.names.keys().cloned().collect();
            known.sort();
            let near = did_you_mean(&name.value, known.iter().map(String::as_str));
            let note =
                near.map_or_else(|| list_of(&known), |near| format!("did you mean `{near}`?"));
            self.problem(
                &name.span,
                format!("there is no material `{}`", name.value),
                Some(note),
            );
        }
        found
    }

    /// Orders the materials so that blends come after what lies below them; a circle is a problem.
    fn sort(&mut self, look: &Look) {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let mut marks = vec![Mark::New; self.out.wiring.len()];
        let mut order = Vec::with_capacity(marks.len());
        let mut circles = Vec::new();
        for start in 0..marks.len() as u32 {
            // An explicit stack: nested blends may be deeper than the thread's.
            let mut open = vec![start];
            while let Some(&index) = open.last() {
                let below = self.out.wiring[index as usize]
                    .blend
                    .as_ref()
                    .map(|b| [b.base, b.over]);
                let next = below
                    .iter()
                    .flatten()
                    .find(|&&m| marks[m as usize] != Mark::Done);
                match (marks[index as usize], next) {
                    (Mark::Done, _) => {
                        open.pop();
                    }
                    (_, Some(&next)) if marks[next as usize] == Mark::Open || next == index => {
                        circles.push(next);
                        marks[index as usize] = Mark::Done;
                        open.pop();
                    }
                    (_, Some(&next)) => {
                        marks[index as usize] = Mark::Open;
                        open.push(next);
                    }
                    (_, None) => {
                        marks[index as usize] = Mark::Done;
                        order.push(index);
                        open.pop();
                    }
                }
            }
        }
        for circle in circles {
            let table = look
                .materials
                .iter()
                .find(|t| self.out.names[&t.name.value] == circle);
            if let Some((table, blend)) = table.and_then(|t| Some((t, t.blend.as_ref()?))) {
                self.problem(
                    &blend.span,
                    format!(
                        "`{}` is blended from itself, through other blends",
                        table.name.value
                    ),
                    Some(
                        "only `base` may name the material itself; it means its glTF surface"
                            .to_owned(),
                    ),
                );
            }
        }
        self.out.order = order;
    }
}

/// A material that only the look has: white, rough, no metal.
fn new_material(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        metallic: 0.0,
        roughness: 0.5,
        ..Material::default()
    }
}

/// What a program must know of a material that no table of the look describes.
fn surface_of(material: &Material) -> Surface {
    let alpha = material.base_color.w;
    Surface {
        emission: if material.unlit {
            Vec3::ZERO
        } else {
            material.emission
        },
        has_emission_image: material.emission_texture.is_some(),
        opacity: match material.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
            AlphaMode::Blend => alpha,
        },
        ..Surface::default()
    }
}

fn unique_name(wanted: &str, scene: &Scene) -> String {
    let taken = |name: &str| scene.materials.iter().any(|m| m.name == name);
    let mut name = wanted.to_owned();
    let mut number = 2;
    while taken(&name) {
        name = format!("{wanted} {number}");
        number += 1;
    }
    name
}

/// The names there are, a few of them if they are many.
fn list_of(names: &[String]) -> String {
    const SHOWN: usize = 12;
    if names.is_empty() {
        return "there are none".to_owned();
    }
    let shown: Vec<_> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    let more = match names.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("there are {}{more}", shown.join(", "))
}
