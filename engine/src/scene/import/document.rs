//! A glTF file with its buffers in memory: JSON parsed leniently, byte ranges looked up strictly.
//!
//! Everything else in this folder reads through [`Document`]; nothing else touches files, except the pictures.

use super::accessor;
use super::budget::Budget;
use super::container;
use super::error::{At as _, Fault, ImportError, Warnings};
use super::files::{self, Source};
use gltf::json;
use json::validation::USize64;
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Extensions that are read. `KHR_mesh_quantization` needs nothing but an accessor reader that takes integers.
const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions that never change a picture at rest.
const INVISIBLE_EXTENSIONS: &[&str] = &["KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld"];

/// JSON takes up to twenty times its length in memory.
const MAX_JSON_BYTES: usize = 512 << 20;

/// Longest name of anything.
const MAX_NAME_CHARS: usize = 256;

/// A parsed file.
pub(super) struct Document {
    pub(super) path: PathBuf,
    pub(super) root: json::Root,
    /// `extras.environment` of each scene.
    pub(super) environments: Vec<Option<Value>>,
    /// What decoding may still take.
    pub(super) budget: Budget,
    file: Vec<u8>,
    buffers: Vec<Buffer>,
}

enum Buffer {
    Owned(Vec<u8>),
    /// Part of the GLB file itself.
    Glb(Range<usize>),
    /// Neither a URI nor a binary chunk: an error only where it is used.
    Absent,
}

impl Document {
    /// Reads the file and all its buffers.
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        let file = files::read_file(path, u64::MAX).map_err(|source| ImportError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(path, file)
    }

    /// As [`open`](Self::open), for the bytes of a file that is already in memory.
    pub(super) fn parse(path: &Path, file: Vec<u8>) -> Result<Self, ImportError> {
        let parts = container::split(&file).at(path, || "GLB container".into())?;
        if parts.json.len() > MAX_JSON_BYTES {
            return Err(ImportError::TooLarge {
                path: path.to_owned(),
                problem: "has more than 512 MiB of JSON; save it as .glb, or with its buffers in files of their own".into(),
            });
        }
        let (root, environments) =
            parse_json(&file[parts.json.clone()]).map_err(|source| ImportError::Json {
                path: path.to_owned(),
                source,
            })?;
        check_version(&root).at(path, || "asset".into())?;
        let mut document = Self {
            path: path.to_owned(),
            root,
            environments,
            budget: Budget::for_geometry(0),
            file,
            buffers: Vec::new(),
        };
        document.check_extensions()?;
        document.load_buffers(parts.bin)?;
        document.budget = Budget::for_geometry(document.size());
        document.decompress()?;
        document.check_layout()?;
        Ok(document)
    }

    /// Checks all buffer views and accessors, also those that nothing shows: where one reaches beyond its data, the
    /// file has been cut or its numbers are garbage, and what it shows can't be trusted either.
    fn check_layout(&self) -> Result<(), ImportError> {
        let place = || "binary data".to_owned();
        for (index, view) in self.root.buffer_views.iter().enumerate() {
            if !self.is_absent(view) {
                self.view(index).map(drop).at(&self.path, place)?;
            }
        }
        for (index, accessor) in self.root.accessors.iter().enumerate() {
            let sparse = accessor.sparse.as_ref();
            let mut views = accessor
                .buffer_view
                .into_iter()
                .chain(
                    sparse
                        .into_iter()
                        .flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]),
                )
                .filter_map(|view| self.root.buffer_views.get(view.value()));
            if !views.any(|view| self.is_absent(view)) && accessor::is_readable(accessor) {
                self.accessor(index).map(drop).at(&self.path, place)?;
            }
        }
        Ok(())
    }

    /// A buffer without data is legal as long as nothing reads it: it stands for what an extension would decompress.
    fn is_absent(&self, view: &json::buffer::View) -> bool {
        matches!(self.buffers.get(view.buffer.value()), Some(Buffer::Absent))
    }

    /// The folder that relative URIs start from.
    pub(super) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Bytes of the file and its buffers, which everything that is decoded is held against.
    fn size(&self) -> u64 {
        let owned = self.buffers.iter().map(|buffer| match buffer {
            Buffer::Owned(bytes) => bytes.len() as u64,
            Buffer::Glb(_) | Buffer::Absent => 0,
        });
        self.file.len() as u64 + owned.sum::<u64>()
    }

    /// Bytes of a buffer view, and its stride.
    pub(super) fn view(&self, index: usize) -> Result<(&[u8], Option<u64>), Fault> {
        let view = self
            .root
            .buffer_views
            .get(index)
            .ok_or_else(|| format!("buffer view {index} does not exist"))?;
        let stride = view.byte_stride.map(|stride| stride.0 as u64);
        if stride.is_some_and(|stride| !(1..=4096).contains(&stride)) {
            return Err(format!("buffer view {index} has an absurd byteStride"));
        }
        let buffer = self.buffer(view.buffer.value())?;
        let bytes =
            slice(buffer, offset(view.byte_offset), view.byte_length.0).ok_or_else(|| {
                format!(
                    "buffer view {index} reaches beyond the {} bytes of buffer {}",
                    buffer.len(),
                    view.buffer.value()
                )
            })?;
        Ok((bytes, stride))
    }

    fn buffer(&self, index: usize) -> Result<&[u8], Fault> {
        match self.buffers.get(index) {
            None => Err(format!("buffer {index} does not exist")),
            Some(Buffer::Absent) => Err(format!(
                "buffer {index} has no data, neither a uri nor a binary chunk"
            )),
            Some(Buffer::Owned(bytes)) => Ok(bytes),
            Some(Buffer::Glb(range)) => Ok(&self.file[range.clone()]),
        }
    }

    /// Makes `bytes` the data of an accessor that exists.
    pub(super) fn add_data(&mut self, accessor: usize, bytes: Vec<u8>) {
        let view = json::buffer::View {
            buffer: json::Index::new(self.buffers.len() as u32),
            byte_length: bytes.len().into(),
            byte_offset: None,
            byte_stride: None,
            name: None,
            target: None,
            extensions: None,
            extras: Default::default(),
        };
        let index = json::Index::new(self.root.buffer_views.len() as u32);
        self.root.buffer_views.push(view);
        self.buffers.push(Buffer::Owned(bytes));
        let accessor = &mut self.root.accessors[accessor];
        accessor.buffer_view = Some(index);
        accessor.byte_offset = None;
    }

    fn load_buffers(&mut self, mut bin: Option<Range<usize>>) -> Result<(), ImportError> {
        for (index, buffer) in self.root.buffers.iter().enumerate() {
            let place = || format!("buffer {index}");
            let length = buffer.byte_length.0;
            let too_short = |have: u64| Err(format!("says {length} bytes, only {have} are there"));
            // Only the first buffer can be the binary chunk (section 4.4.3.3).
            let loaded = match (&buffer.uri, bin.take()) {
                (Some(uri), _) => {
                    let bytes = match files::resolve(self.folder(), uri).at(&self.path, place)? {
                        Source::Data(mut bytes) => {
                            bytes.truncate(usize::try_from(length).unwrap_or(usize::MAX));
                            bytes
                        }
                        Source::File(path) => files::read_file(&path, length)
                            .map_err(|source| ImportError::Read { path, source })?,
                    };
                    match bytes.len() as u64 {
                        have if have < length => too_short(have),
                        _ => Ok(Buffer::Owned(bytes)),
                    }
                }
                // The chunk may be padded by up to three bytes.
                (None, Some(chunk)) => match chunk.len() as u64 {
                    have if have < length => too_short(have),
                    _ => Ok(Buffer::Glb(chunk.start..chunk.start + length as usize)),
                },
                (None, None) => Ok(Buffer::Absent),
            };
            self.buffers.push(loaded.at(&self.path, place)?);
        }
        Ok(())
    }

    fn check_extensions(&self) -> Result<(), ImportError> {
        let unsupported = self
            .root
            .extensions_required
            .iter()
            .find(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str()));
        match unsupported {
            None => Ok(()),
            Some(name) => Err(self.unsupported(name)),
        }
    }

    /// One warning for each optional extension that would change the picture.
    pub(super) fn warn_of_extensions(&self, warnings: &mut Warnings) {
        let of_materials = self
            .root
            .materials
            .iter()
            .filter_map(|m| m.extensions.as_ref());
        let mut names: Vec<&str> = of_materials
            .flat_map(|extensions| extensions.others.keys())
            .chain(&self.root.extensions_used)
            .map(String::as_str)
            .filter(|name| {
                !SUPPORTED_EXTENSIONS.contains(name) && !INVISIBLE_EXTENSIONS.contains(name)
            })
            .collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            warnings.push(format!(
                "the extension {name} is not supported and is ignored"
            ));
        }
    }

    /// The error for an extension that the content cannot do without.
    pub(super) fn unsupported(&self, extension: &str) -> ImportError {
        let remedy = match extension {
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
                "export it without mesh compression (gltf-transform copies a file decompressed)"
            }
            "KHR_texture_basisu" => "export its textures as PNG, JPEG or WebP",
            _ => "export it without this extension",
        };
        ImportError::Extension {
            path: self.path.clone(),
            extension: extension.to_owned(),
            remedy,
        }
    }
}

/// An optional byte offset, absent meaning zero.
pub(super) fn offset(offset: Option<USize64>) -> u64 {
    offset.map_or(0, |offset| offset.0)
}

/// `bytes[offset..offset + length]`, or `None` where that is not inside.
pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}

/// Parses the JSON by way of a tree, because the typed reader is stricter than glTF is: it wants an array of nodes in
/// every scene, refuses integers written as `3.0`, and can't read `extras` inside of extensions.
fn parse_json(text: &[u8]) -> Result<(json::Root, Vec<Option<Value>>), serde_json::Error> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let mut tree: Value = serde_json::from_slice(text)?;
    let mut environments = Vec::new();
    if let Some(scenes) = tree.get_mut("scenes").and_then(Value::as_array_mut) {
        for scene in scenes {
            environments.push(scene.pointer("/extras/environment").cloned());
            if let Value::Object(scene) = scene {
                scene.entry("nodes").or_insert_with(|| Value::Array(vec![]));
            }
        }
    }
    if let Value::Object(root) = &mut tree {
        // Animations are not rendered, so they need not be valid.
        root.remove("animations");
    }
    mend(&mut tree);
    match serde_json::from_value(tree) {
        Ok(root) => Ok((root, environments)),
        // Reading the text directly gives the same error with line and column.
        Err(error) => Err(serde_json::from_slice::<json::Root>(text)
            .err()
            .unwrap_or(error)),
    }
}

/// Drops `extras`, writes whole numbers as integers and cuts absurd names, which would be copied for every instance.
/// Depth is bounded: serde_json refuses more than 128 levels.
fn mend(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let float = number.as_f64().filter(|_| number.is_f64());
            if let Some(float) = float
                && float.fract() == 0.0
                && (0.0..9e15).contains(&float)
            {
                *number = (float as u64).into();
            }
        }
        Value::Array(items) => items.iter_mut().for_each(mend),
        Value::Object(members) => {
            members.remove("extras");
            if let Some(Value::String(name)) = members.get_mut("name")
                && let Some((end, _)) = name.char_indices().nth(MAX_NAME_CHARS)
            {
                name.truncate(end);
            }
            members.values_mut().for_each(mend);
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// glTF 2.x is read as 2.0 unless the file says that it needs more (section 3.2).
fn check_version(root: &json::Root) -> Result<(), Fault> {
    let number = |text: &str| -> Result<(u32, u32), Fault> {
        text.split_once('.')
            .and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)))
            .ok_or_else(|| format!("\"{text}\" is not a version"))
    };
    let (major, _) = number(&root.asset.version)?;
    if major != 2 {
        return Err(format!(
            "is glTF {}, only 2.0 is supported",
            root.asset.version
        ));
    }
    match &root.asset.min_version {
        Some(least) if number(least)? > (2, 0) => {
            Err(format!("needs glTF {least}, 2.0 is supported"))
        }
        _ => Ok(()),
    }
}
