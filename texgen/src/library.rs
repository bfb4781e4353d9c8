//! The set of textures one kernel is made of. A texture's place in it is its type number in programs.

use std::collections::{BTreeSet, HashMap};

use crate::attribute::Attribute;
use crate::diagnostic::Diagnostic;
use crate::suggest::did_you_mean;
use crate::texture::{TextureType, custom_names};

/// Texture types by number and name.
#[derive(Clone, Debug, Default)]
pub struct Library {
    textures: Vec<TextureType>,
    by_name: HashMap<String, usize>,
}

impl Library {
    /// A library of these textures; type numbers are their places in the list.
    ///
    /// # Errors
    /// Two textures of one name; more than 65,536 textures.
    pub fn new(textures: Vec<TextureType>) -> Result<Self, Diagnostic> {
        if textures.len() > 1 << 16 {
            return Err(Diagnostic::error(format!(
                "{} textures are too many: a kernel holds at most 65536",
                textures.len()
            ))
            .with_note("keep only the textures that the scene uses"));
        }
        let mut by_name = HashMap::new();
        for (index, texture) in textures.iter().enumerate() {
            if let Some(first) = by_name.insert(texture.name().to_owned(), index) {
                return Err(Diagnostic::error(format!(
                    "two textures are called `{}`",
                    texture.name()
                ))
                .with_label(texture.file(), 0..0, "the second one")
                .with_secondary(textures[first].file(), 0..0, "the first one")
                .with_note("a texture is called like its file: rename one of the files"));
            }
        }
        Ok(Self { textures, by_name })
    }

    /// The texture of a library that holds one; textures can hold megabytes of defaults.
    pub(crate) fn into_only(mut self) -> TextureType {
        self.textures.swap_remove(0)
    }

    /// All textures; the index is the type number.
    pub fn textures(&self) -> &[TextureType] {
        &self.textures
    }

    /// The texture of that name.
    pub fn get(&self, name: &str) -> Option<&TextureType> {
        self.index_of(name).map(|index| &self.textures[index])
    }

    /// Type number of the texture of that name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// The name most like `name`, for messages.
    pub fn suggest(&self, name: &str) -> Option<&str> {
        did_you_mean(name, self.textures.iter().map(TextureType::name))
    }

    /// Every attribute that some texture reads.
    pub fn attributes(&self) -> BTreeSet<Attribute> {
        self.textures
            .iter()
            .flat_map(|texture| texture.attributes())
            .cloned()
            .collect()
    }

    /// Names of the custom mesh attributes that some texture reads, sorted: the host's
    /// `patina_attr_custom(index)` gets the index into this list.
    pub fn custom_attributes(&self) -> Vec<String> {
        custom_names(&self.attributes())
    }
}
