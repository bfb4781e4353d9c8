//! What lies on the model: the texture graphs of the paper, as looks.

/// What is put on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Texture {
    Gray,
    Rust,
    Scratches,
}

impl Texture {
    pub(crate) const ALL: [Self; 3] = [Self::Gray, Self::Rust, Self::Scratches];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gray => "gray",
            Self::Rust => "rust",
            Self::Scratches => "scratches",
        }
    }

    /// A node and its parameter that an edit changes.
    pub(crate) fn edited(self) -> Option<(&'static str, &'static str, f32)> {
        match self {
            Self::Gray => None,
            Self::Rust => Some(("rust_mask", "amount", 0.3)),
            Self::Scratches => Some(("scratches", "amount", 0.6)),
        }
    }

    /// Whether it reads ambient occlusion, so that the number of rays matters.
    pub(crate) fn reads_ao(self) -> bool {
        self == Self::Rust
    }

    /// The look that puts it on a material: the paper's graphs. Rust is gray blended with rust by a mask of noise and
    /// ambient occlusion; scratches brighten gray.
    pub(crate) fn look(self, material: &str, ao_rays: u32) -> String {
        let head = format!("[ao.crevices]\ndistance = 0.25\nsamples = {ao_rays}\n");
        // Quoted as a TOML string.
        let table = format!("[material.{material:?}]\n");
        let surface = "metallic = 0.0\nroughness = 0.8\n";
        match self {
            Self::Gray => format!("{table}base_color = [0.5, 0.5, 0.5]\n{surface}"),
            Self::Rust => format!(
                "{head}[node.rust]\ntexture = \"rust_color\"\nscale = 7.0\n\
                 [node.rust_mask]\ntexture = \"rust_mask\"\nscale = 2.2\namount = 0.42\nocclusion = \"crevices\"\n\
                 [node.rusty]\ntexture = \"mix_color\"\na = [0.5, 0.5, 0.5, 1.0]\nb = \"rust\"\nfactor = \"rust_mask\"\n\
                 {table}base_color = \"rusty\"\n{surface}"
            ),
            Self::Scratches => format!(
                "[node.scratches]\ntexture = \"scratches\"\nscale = 6.0\namount = 0.8\n\
                 [node.scratched]\ntexture = \"mix_color\"\na = [0.5, 0.5, 0.5, 1.0]\nb = [0.8, 0.8, 0.8, 1.0]\n\
                 factor = \"scratches\"\n{table}base_color = \"scratched\"\n{surface}"
            ),
        }
    }
}
