//! How much memory per thread the variables of a texture take, for tools: by function, and along the deepest chain of calls.

use std::collections::HashMap;

use naga::{Function, Handle};

use crate::parse;
use crate::private_memory::{bytes_of, deepest};
use crate::scope::Outline;
use crate::texture::{TextureType, custom_names};

/// Bytes of parameters and variables of a texture's functions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrivateMemory {
    /// Every function of the file in its order.
    pub functions: Vec<FunctionMemory>,
    /// The chain of calls from `userProc` on whose functions need most together, by name.
    pub deepest: Vec<String>,
    /// Bytes of the functions of that chain together.
    pub bytes: u32,
}

/// Bytes of one function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionMemory {
    /// As the file calls it.
    pub name: String,
    /// Its parameters (but not the arrays of `userProc`, which are read in place) and its variables.
    pub bytes: u32,
}

impl PrivateMemory {
    /// Works it out from the texture's source.
    pub fn of(texture: &TextureType) -> Self {
        // With the files that it uses.
        let whole = texture.whole();
        let outline = Outline::new(whole.file.text());
        let custom = custom_names(texture.attributes());
        // It was parsed before, so it can be parsed again.
        let Ok(module) = parse::parse(whole, &outline, &custom, &[]) else {
            return Self::default();
        };
        let mut sizes: HashMap<Handle<Function>, u32> = HashMap::new();
        let mut functions = Vec::new();
        for (handle, function) in module.functions.iter() {
            let name = function.name.clone().unwrap_or_default();
            let Some(place) = outline
                .functions
                .iter()
                .position(|decl| outline.word(decl.name) == name)
            else {
                continue; // of the prelude
            };
            let bytes = bytes_of(&module, function, name == "userProc");
            sizes.insert(handle, bytes);
            functions.push((place, FunctionMemory { name, bytes }));
        }
        functions.sort_by_key(|(place, _)| *place);
        let (bytes, deepest) = deepest(&module, &sizes);
        Self {
            functions: functions
                .into_iter()
                .map(|(_, function)| function)
                .collect(),
            deepest,
            bytes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SourceFile;

    #[test]
    fn the_heaviest_chain_of_calls_counts() {
        let text = "
            fn light(x: f32) -> f32 { return x; }
            fn heavy(x: f32) -> f32 { var table: array<vec4f, 8>; table[i32(x)] = vec4f(x); return light(table[1].x); }
            fn userProc(a: array<f32, 100>, k: vec3f) -> f32 {
                if k.x > 0.0 { return heavy(k.x); }
                return light(a[2]);
            }
            fn unused(m: mat4x4f) -> f32 { return m[0][0]; }";
        let texture = TextureType::parse(SourceFile::new("t", "t.wgsl", text))
            .unwrap_or_else(|problems| panic!("{problems}"));
        let memory = PrivateMemory::of(&texture);
        assert_eq!(memory.deepest, ["userProc", "heavy", "light"]);
        // A vec3f; a number and a table of eight vec4f; a number.
        assert_eq!(memory.bytes, 12 + 4 + 128 + 4);
        let names: Vec<&str> = memory.functions.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["light", "heavy", "userProc", "unused"]);
        assert_eq!(memory.functions[3].bytes, 64);
    }
}
