//! The one buffer of a file, with what lies where in it.

use serde_json::{Value, json};

/// Floats.
const FLOAT: u32 = 5126;
/// Indices of two bytes.
const SHORT: u32 = 5123;
/// Indices of four bytes.
const LONG: u32 = 5125;
/// A view of attributes of vertices.
const VERTICES: u32 = 34962;
/// A view of indices.
const INDICES: u32 = 34963;

/// Bytes, their views, and accessors of these.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

impl Buffer {
    /// Adds bytes; the number of their view.
    pub(super) fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an attribute of vertices; the number of its accessor. Bounds are those that glTF demands of positions.
    pub(super) fn attribute<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        has_bounds: bool,
    ) -> usize {
        let bytes: &[u8] = bytemuck::cast_slice(values.as_flattened());
        let view = self.view(bytes, Some(VERTICES));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
        });
        if has_bounds {
            let bound = |fold: fn(f32, f32) -> f32| -> Vec<f32> {
                let of = |i: usize| values.iter().map(|v| v[i]).reduce(fold).unwrap_or(0.0);
                (0..N).map(of).collect()
            };
            accessor["min"] = json!(bound(f32::min));
            accessor["max"] = json!(bound(f32::max));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds the indices of triangles among `vertices`; the number of their accessor.
    pub(super) fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let indices = triangles.as_flattened();
        // The greatest index of each kind is that of no vertex (glTF 2.0, section 3.7.2.1).
        let (view, kind) = match vertices <= usize::from(u16::MAX) {
            true => {
                let short: Vec<u16> = indices.iter().map(|&i| i as u16).collect();
                (
                    self.view(bytemuck::cast_slice(&short), Some(INDICES)),
                    SHORT,
                )
            }
            false => (
                self.view(bytemuck::cast_slice(indices), Some(INDICES)),
                LONG,
            ),
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": kind, "count": indices.len(), "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }
}
