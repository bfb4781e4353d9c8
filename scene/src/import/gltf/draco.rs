//! KHR_draco_mesh_compression: what a primitive keeps in a Draco stream becomes ordinary binary data, before anything
//! else reads it.
//!
//! The stream is foreign input to a foreign decoder: what it may allocate is bounded by the file's budget, what comes
//! out is held against the accessors, and a panic in it is an error of the file.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use gltf::json;
use json::accessor::{ComponentType, GenericComponentType, Type};
use json::mesh::{Mode, Primitive};
use json::validation::Checked;
use serde_json::Value;

use super::document::Document;
use crate::import::error::{At as _, Fault, ImportError};

/// The name in files.
const EXTENSION: &str = "KHR_draco_mesh_compression";

/// What decoding a byte takes from the file's budget, beside what comes out.
const DECODING: u64 = 8;

/// What an accessor stands for, as it would lie in a buffer.
struct Decoded {
    accessor: usize,
    component: ComponentType,
    bytes: Vec<u8>,
}

impl Document {
    /// Gives the accessors of compressed primitives their data. Primitives that come with an uncompressed copy keep
    /// it.
    pub(super) fn decompress(&mut self) -> Result<(), ImportError> {
        for mesh in 0..self.root.meshes.len() {
            for number in 0..self.root.meshes[mesh].primitives.len() {
                let primitive = &self.root.meshes[mesh].primitives[number];
                let Some(stream) = compressed(primitive) else {
                    continue;
                };
                if self.has_copy(primitive) {
                    continue;
                }
                let decoded = self
                    .decode(primitive, stream)
                    .at(&self.path, || format!("mesh {mesh}, primitive {number}"))?;
                for Decoded {
                    accessor,
                    component,
                    bytes,
                } in decoded
                {
                    self.add_data(accessor, bytes);
                    self.root.accessors[accessor].component_type =
                        Checked::Valid(GenericComponentType(component));
                }
                // Strips are compressed as lists.
                self.root.meshes[mesh].primitives[number].mode = Checked::Valid(Mode::Triangles);
            }
        }
        Ok(())
    }

    fn has_copy(&self, primitive: &Primitive) -> bool {
        let mut accessors = primitive.attributes.values().chain(&primitive.indices);
        accessors.all(|index| {
            let accessor = self.accessor(index.value());
            accessor.is_ok_and(|accessor| accessor.has_data())
        })
    }

    fn decode(&self, primitive: &Primitive, stream: &Value) -> Result<Vec<Decoded>, Fault> {
        let fault = |problem: &str| format!("{EXTENSION}: {problem}");
        let view = stream.get("bufferView").and_then(Value::as_u64);
        let view = view.ok_or_else(|| fault("has no bufferView"))?;
        let (bytes, _) = self.view(usize::try_from(view).unwrap_or(usize::MAX))?;
        // A stream may be named as often as there are primitives: each time it is decoded costs some of what a file may become.
        self.budget.take(bytes.len() as u64, DECODING)?;
        let limits = DecodeLimits::default()
            .with_max_faces(self.budget.left() / 12)
            .with_max_decoded_bytes(self.budget.left());
        let mesh = texgen::guarded(|| {
            let mut mesh = draco_core::Mesh::new();
            let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
            let outcome = MeshDecoder::new().decode(&mut buffer, &mut mesh);
            outcome.map(|()| mesh)
        })
        .map_err(|_| fault("the compressed data are damaged"))?
        .map_err(|error| fault(&format!("the compressed data can't be read: {error}")))?;

        let points = mesh.num_points() as u64;
        let mut decoded = Vec::new();
        let names = stream.get("attributes").and_then(Value::as_object);
        for (semantic, index) in &primitive.attributes {
            let Checked::Valid(semantic) = semantic else {
                continue;
            };
            let name = semantic.to_string();
            // What isn't in the stream has its own data, or is zero.
            let Some(id) = names.and_then(|names| names.get(&name)) else {
                continue;
            };
            let attribute = id
                .as_u64()
                .and_then(|id| mesh.attribute_by_unique_id(u32::try_from(id).ok()?))
                .ok_or_else(|| fault(&format!("{name}: attribute {id} is not in the stream")))?;
            self.budget.take(points, element_size(attribute) as u64)?;
            let component = self
                .component(index.value(), points, attribute)
                .map_err(|problem| fault(&format!("{name}: {problem}")))?;
            decoded.push(Decoded {
                accessor: index.value(),
                component,
                bytes: values(attribute, points)
                    .ok_or_else(|| fault(&format!("{name}: values are missing")))?,
            });
        }
        if let Some(index) = primitive.indices {
            let count = self.root.accessors.get(index.value()).map(|a| a.count.0);
            let corners = 3 * mesh.num_faces() as u64;
            if count != Some(corners) {
                return Err(fault(&format!(
                    "has {corners} indices, accessor {} another number",
                    index.value()
                )));
            }
            self.budget.take(corners, 4)?;
            let corners = mesh.faces().iter().flatten();
            decoded.push(Decoded {
                accessor: index.value(),
                component: ComponentType::U32,
                bytes: corners.flat_map(|point| point.0.to_le_bytes()).collect(),
            });
        }
        Ok(decoded)
    }

    /// The component type of an accessor that agrees with the stream.
    fn component(
        &self,
        index: usize,
        points: u64,
        attribute: &PointAttribute,
    ) -> Result<ComponentType, Fault> {
        let accessor = self.root.accessors.get(index);
        let accessor = accessor.ok_or_else(|| format!("accessor {index} does not exist"))?;
        let components = match accessor.type_ {
            Checked::Valid(Type::Scalar) => 1,
            Checked::Valid(Type::Vec2) => 2,
            Checked::Valid(Type::Vec3) => 3,
            Checked::Valid(Type::Vec4) => 4,
            _ => 0,
        };
        let component = match attribute.data_type() {
            DataType::Int8 => Some(ComponentType::I8),
            DataType::Uint8 => Some(ComponentType::U8),
            DataType::Int16 => Some(ComponentType::I16),
            DataType::Uint16 => Some(ComponentType::U16),
            DataType::Uint32 => Some(ComponentType::U32),
            DataType::Float32 => Some(ComponentType::F32),
            _ => None,
        };
        let stated = match accessor.component_type {
            Checked::Valid(GenericComponentType(stated)) => Some(stated),
            Checked::Invalid => None,
        };
        match component {
            Some(component)
                if stated == Some(component)
                    && components == attribute.num_components()
                    && accessor.count.0 == points =>
            {
                Ok(component)
            }
            _ => Err(format!(
                "the stream has {points} values of another type or number than accessor {index}"
            )),
        }
    }
}

/// The extension of a compressed primitive.
fn compressed(primitive: &Primitive) -> Option<&Value> {
    primitive.extensions.as_ref()?.others.get(EXTENSION)
}

fn element_size(attribute: &PointAttribute) -> usize {
    usize::from(attribute.num_components()) * attribute.data_type().byte_length()
}

/// The values of all points, one behind the other; `None` where one is not there.
fn values(attribute: &PointAttribute, points: u64) -> Option<Vec<u8>> {
    let size = element_size(attribute);
    let stride = usize::try_from(attribute.byte_stride()).ok()?;
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(size * usize::try_from(points).ok()?);
    for point in 0..u32::try_from(points).ok()? {
        let value = attribute.mapped_index(PointIndex(point)).0 as usize;
        let start = value.checked_mul(stride)?;
        bytes.extend_from_slice(data.get(start..start.checked_add(size)?)?);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::Imported;
    use super::*;
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    use glam::{Vec2, Vec3};
    use serde_json::json;

    /// A unit square of two triangles with normals (1) and texture coordinates (2), positions in 11 bits (0).
    const SQUARE: &str = "RFJBQ08CAgEBAAAABAICAgAAAR//ARH/ARH/ARED/wAAAAAAAQAAAQAJAwAAAgEBCQMAAQMBAwkCAAICAQEBAAMD\
        ATABEAMAKIKYAAAAAAD/BwAAAAAAAAAAAAAAAAAAAACAPwsGAwEBAQEBQAEA/wAAAH8AAAD/AkRACAUBAQADAwEwARADACSCJgACAAAAAQEg\
        AAAAAP8DAAAAAAAAAAAAAAAAgD8K";

    fn stream() -> Vec<u8> {
        STANDARD.decode(SQUARE).expect("base64")
    }

    fn import(stream: &[u8], points: u32, ids: Value) -> Result<Imported, ImportError> {
        let file = json!({
            "extensionsRequired": [EXTENSION],
            "buffers": [{
                "byteLength": stream.len(),
                "uri": format!("data:;base64,{}", STANDARD.encode(stream)),
            }],
            "bufferViews": [{ "buffer": 0, "byteLength": stream.len() }],
            "accessors": [
                { "componentType": 5123, "count": 6, "type": "SCALAR" },
                { "componentType": 5126, "count": points, "type": "VEC3" },
                { "componentType": 5126, "count": points, "type": "VEC3" },
                { "componentType": 5126, "count": points, "type": "VEC2" },
            ],
            "meshes": [{ "primitives": [{
                "attributes": { "POSITION": 1, "NORMAL": 2, "TEXCOORD_0": 3 },
                "indices": 0,
                "extensions": { EXTENSION: { "bufferView": 0, "attributes": ids } },
            }] }],
            "nodes": [{ "mesh": 0 }],
        });
        super::super::tests::import(file)
    }

    fn ids() -> Value {
        json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 })
    }

    #[test]
    fn a_compressed_square_is_a_square() {
        let imported = import(&stream(), 4, ids()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(imported.warnings, [""; 0]);
        let mesh = &imported.scene.meshes[0];
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        for (&position, (&uv, &normal)) in mesh
            .positions
            .iter()
            .zip(mesh.uv0.iter().zip(&mesh.normals))
        {
            // Each corner has its own texture coordinates; quantization keeps 0 and 1.
            let expected = Vec2::new(position.x, 1.0 - position.y);
            assert!(uv.abs_diff_eq(expected, 1e-3), "{position} {uv}");
            assert!(normal.abs_diff_eq(Vec3::Z, 0.02), "{normal}");
        }
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).abs_diff_eq(Vec3::Z, 0.01));
        }
    }

    #[test]
    fn what_disagrees_with_the_stream_is_an_error() {
        for (points, ids, mentions) in [
            (5, ids(), "accessor"),
            (4, json!({ "POSITION": 7 }), "attribute 7"),
            (4, json!({ "POSITION": "x" }), "not in the stream"),
            (4, json!({ "POSITION": 2 }), "accessor 1"),
        ] {
            let message = import(&stream(), points, ids).unwrap_err().to_string();
            assert!(message.contains(mentions), "{message}");
            assert!(message.contains("mesh 0, primitive 0"), "{message}");
        }
        let message = import(&stream()[..90], 4, ids()).unwrap_err().to_string();
        assert!(message.contains(EXTENSION), "{message}");
    }

    #[test]
    fn damaged_streams_neither_panic_nor_hang() {
        let whole = stream();
        for length in 0..whole.len() {
            let _ = import(&whole[..length], 4, ids());
        }
        for at in 0..whole.len() {
            for value in [
                0,
                1,
                0x7f,
                0xff,
                whole[at] ^ 0x10,
                whole[at].wrapping_add(1),
            ] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                let _ = import(&damaged, 4, ids());
            }
        }
    }
}
