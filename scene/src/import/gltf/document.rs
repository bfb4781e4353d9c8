//! A glTF file with its buffers in memory: JSON parsed leniently, byte ranges looked up strictly.
//!
//! Everything else in this folder reads through [`Document`]; nothing else touches files, except the pictures.

use super::container;
use super::files::{self, UriTarget};
use super::json_text::{self, JsonError, Parsed};
use super::layers;
use crate::import::budget::Budget;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use crate::input::{FileId, Files};
use gltf::json;
use json::validation::USize64;
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Extensions that are read, but for those of [`layers`]. `KHR_mesh_quantization` needs nothing but an accessor reader that
/// takes integers.
const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// The extensions that are read.
fn supported_extensions() -> impl Iterator<Item = &'static str> {
    let others = SUPPORTED_EXTENSIONS.iter().copied();
    others.chain(layers::names())
}

/// Whether an extension is read.
fn is_read(name: &str) -> bool {
    supported_extensions().any(|known| known == name)
}

/// Extensions that never change a picture at rest.
const INVISIBLE_EXTENSIONS: &[&str] = &["KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld"];

/// Longest JSON.
const MAX_JSON_BYTES: u64 = 512 << 20;

/// A parsed file.
pub(super) struct Document {
    pub(super) path: PathBuf,
    pub(super) root: json::Root,
    /// `extras.environment` of each scene.
    pub(super) environments: Vec<Option<Value>>,
    /// `animations`, whatever that is; null where none are wanted.
    pub(super) animations: Value,
    /// It has animations, wanted or not.
    pub(super) has_animations: bool,
    /// Its morph targets have more than positions, normals and tangents.
    morphs_others: bool,
    /// Where it lies.
    pub(super) files: Arc<dyn Files>,
    /// What decoding may still take.
    pub(super) budget: Arc<Budget>,
    id: FileId,
    /// Bytes of the file itself.
    length: u64,
    file: Vec<u8>,
    buffers: Vec<Buffer>,
}

enum Buffer {
    Owned(Vec<u8>),
    /// The start of a file, which other buffers may show as well.
    Shared(Arc<Vec<u8>>, usize),
    /// Part of the GLB file itself.
    Glb(Range<usize>),
    /// Neither a URI nor a binary chunk: an error only where it is used.
    Absent,
}

enum BufferSource {
    Data(Vec<u8>),
    File(FileId, PathBuf),
}

impl Document {
    /// Understands the bytes of a file and reads all its buffers; animations are kept where they are wanted. What decoding takes
    /// comes out of `budget`.
    pub(super) fn new(
        files: &Arc<dyn Files>,
        path: &Path,
        file: Vec<u8>,
        budget: &Arc<Budget>,
        with_animations: bool,
    ) -> Result<Self, ImportError> {
        let parts = container::split(&file).at(path, || "GLB container".into())?;
        if parts.json.len() as u64 > MAX_JSON_BYTES {
            return Err(ImportError::TooLarge {
                path: path.to_owned(),
                problem: "has more than 512 MiB of JSON; save it as .glb, or with its buffers in files of their own".into(),
            });
        }
        let Parsed {
            root,
            environments,
            animations,
            has_animations,
            morphs_others,
        } =
            json_text::parse(&file[parts.json.clone()], is_read, with_animations).map_err(|error| match error {
                JsonError::Invalid(source) => ImportError::Json {
                    path: path.to_owned(),
                    source,
                },
                JsonError::TooLarge => ImportError::TooLarge {
                    path: path.to_owned(),
                    problem: "its JSON would take more than 512 MiB and 16 times its length in memory; split the scene, or place \
                              repeated meshes by EXT_mesh_gpu_instancing"
                        .into(),
                },
            })?;
        let length = file.len() as u64;
        check_version(&root).at(path, || "asset".into())?;
        let mut document = Self {
            files: Arc::clone(files),
            path: path.to_owned(),
            root,
            environments,
            animations,
            has_animations,
            morphs_others,
            budget: Arc::clone(budget),
            id: files.id(path),
            length,
            // Without a binary chunk nothing in it is needed any more.
            file: if parts.bin.is_some() {
                file
            } else {
                Vec::new()
            },
            buffers: Vec::new(),
        };
        document.check_extensions()?;
        document.load_buffers(parts.bin)?;
        document.allow();
        Ok(document)
    }

    /// Takes its own size for a reason to decode so much more, and so for each pose of a mesh beyond the first.
    pub(super) fn allow(&self) {
        let bytes = self.length + self.size();
        self.budget.allow(self.id.clone(), bytes);
        self.budget.allow_poses(bytes, self.further_poses());
    }

    /// How often a mesh is shown in another pose: by a further skin, or with further weights.
    fn further_poses(&self) -> u64 {
        let nodes = self.root.nodes.iter();
        let posed = nodes.filter(|node| node.skin.is_some() || node.weights.is_some());
        let mut seen = HashSet::new();
        let meshes = posed.filter_map(|node| node.mesh);
        meshes.filter(|mesh| !seen.insert(mesh.value())).count() as u64
    }

    /// A buffer without data is legal as long as nothing reads it: it stands for what an extension would decompress.
    pub(super) fn is_absent(&self, view: &json::buffer::View) -> bool {
        matches!(self.buffers.get(view.buffer.value()), Some(Buffer::Absent))
    }

    /// The folder that relative URIs start from.
    pub(super) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Bytes of the buffers that aren't in the file itself, each file once.
    fn size(&self) -> u64 {
        let mut shared: Vec<&Arc<Vec<u8>>> = Vec::new();
        let bytes = self.buffers.iter().map(|buffer| match buffer {
            Buffer::Owned(bytes) => bytes.len() as u64,
            Buffer::Shared(file, _) if shared.iter().any(|known| Arc::ptr_eq(known, file)) => 0,
            Buffer::Shared(file, _) => {
                shared.push(file);
                file.len() as u64
            }
            Buffer::Glb(_) | Buffer::Absent => 0,
        });
        bytes.sum()
    }

    /// What tells this file from others.
    pub(super) fn id(&self) -> &FileId {
        &self.id
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
            Some(Buffer::Shared(bytes, length)) => Ok(&bytes[..*length]),
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
        let mut sources = self.buffer_sources()?;
        // A file that several buffers name is read once, as far as any of them wants it.
        let mut wanted: HashMap<FileId, u64> = HashMap::new();
        for (source, buffer) in sources.iter().zip(&self.root.buffers) {
            if let Some(BufferSource::File(id, _)) = source {
                let longest = wanted.entry(id.clone()).or_default();
                *longest = buffer.byte_length.0.max(*longest);
            }
        }
        let mut read: HashMap<FileId, Arc<Vec<u8>>> = HashMap::new();
        for (index, buffer) in self.root.buffers.iter_mut().enumerate() {
            let length = buffer.byte_length.0;
            let at = usize::try_from(length).unwrap_or(usize::MAX);
            // Only the first buffer can be the binary chunk (section 4.4.3.3).
            let (loaded, have) = match (sources[index].take(), bin.take()) {
                (Some(BufferSource::Data(mut bytes)), _) => {
                    // A data URI is as long as the data, and has done its work.
                    buffer.uri = None;
                    bytes.truncate(at);
                    let have = bytes.len();
                    (Buffer::Owned(bytes), have)
                }
                (Some(BufferSource::File(id, path)), _) => {
                    let file = match read.get(&id) {
                        Some(file) => Arc::clone(file),
                        None => {
                            let file = (self.files.read_start(&path, wanted[&id]))
                                .map_err(|source| ImportError::Read { path, source })?;
                            Arc::clone(read.entry(id).or_insert(Arc::new(file)))
                        }
                    };
                    let have = file.len();
                    (Buffer::Shared(file, at.min(have)), have)
                }
                // The chunk may be padded by up to three bytes.
                (None, Some(chunk)) => {
                    let have = chunk.len();
                    (Buffer::Glb(chunk.start..chunk.start + at.min(have)), have)
                }
                (None, None) => (Buffer::Absent, at),
            };
            if (have as u64) < length {
                return Err(format!("says {length} bytes, only {have} are there"))
                    .at(&self.path, || format!("buffer {index}"));
            }
            self.buffers.push(loaded);
        }
        Ok(())
    }

    /// Where the bytes of each buffer come from; `None` where it names nothing.
    fn buffer_sources(&self) -> Result<Vec<Option<BufferSource>>, ImportError> {
        let source = |(index, buffer): (usize, &json::Buffer)| {
            let Some(uri) = &buffer.uri else {
                return Ok(None);
            };
            let place = || format!("buffer {index}");
            Ok(Some(
                match files::resolve(&*self.files, self.folder(), uri).at(&self.path, place)? {
                    UriTarget::Data(bytes) => BufferSource::Data(bytes),
                    UriTarget::File(path) => BufferSource::File(self.files.id(&path), path),
                },
            ))
        };
        self.root.buffers.iter().enumerate().map(source).collect()
    }

    fn check_extensions(&self) -> Result<(), ImportError> {
        let unsupported = self
            .root
            .extensions_required
            .iter()
            // What changes no picture at rest is missed by none; what it moves has its own warning.
            .find(|name| !is_read(name) && !INVISIBLE_EXTENSIONS.contains(&name.as_str()));
        match unsupported {
            None => Ok(()),
            Some(name) => Err(self.unsupported(name)),
        }
    }

    /// One warning for each optional extension that would change the picture, and one for what morph targets can't change.
    pub(super) fn warn_of_unread(&self, warnings: &mut Warnings) {
        if self.morphs_others {
            warnings.push(
                "morph targets change positions, normals and tangents; their colours and texture coordinates are ignored",
            );
        }
        let of_materials = self
            .root
            .materials
            .iter()
            .filter_map(|m| m.extensions.as_ref());
        let mut names: Vec<&str> = of_materials
            .flat_map(|extensions| extensions.others.keys())
            .chain(&self.root.extensions_used)
            .map(String::as_str)
            .filter(|name| !is_read(name) && !INVISIBLE_EXTENSIONS.contains(name))
            .collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            warnings.push(match name {
                "KHR_texture_basisu" => {
                    format!(
                        "{name} is not supported: the fallback pictures of its textures are used"
                    )
                }
                _ => format!("the extension {name} is not supported and is ignored"),
            });
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

/// Reads a `.glb` as far as its header says, or a `.gltf`, which is all JSON.
pub(super) fn read(files: &dyn Files, path: &Path) -> io::Result<Vec<u8>> {
    let start = files.read_start(path, container::HEADER)?;
    match container::length(&start) {
        Some(length) => files.read_start(path, length),
        None => files.read(path, MAX_JSON_BYTES),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_of_formats_lists_the_extensions() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
        let page = std::fs::read_to_string(page).expect("part of the project");
        let lines = page.lines().filter_map(|line| line.strip_prefix("- `"));
        let listed: Vec<_> = lines.map(|line| line.trim_end_matches('`')).collect();
        let mut read: Vec<_> = supported_extensions().collect();
        read.sort_unstable();
        assert_eq!(listed, read);
    }
}
