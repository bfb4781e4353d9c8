//! Meshes in the layout of `geometry.wgsl`: triangles with their flags, and the heap of vertices.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};

use crate::{
    bvh::SceneBvh,
    scene::{Material, Mesh, Scene},
    texturing::ProgramTraits,
};

use super::materials;

pub(super) const TRIANGLE_ALPHA: u32 = 1 << 31;
const TRIANGLE_HAS_UV: u32 = 1 << 30;
const TRIANGLE_HAS_EXTRA: u32 = 1 << 29;
const TRIANGLE_HAS_TANGENT: u32 = 1 << 28;
const TRIANGLE_HAS_COLOR: u32 = 1 << 27;
const TRIANGLE_SINGLE_SIDED: u32 = 1 << 26;
const TRIANGLE_PROGRAM_ALPHA: u32 = 1 << 25;
const TRIANGLE_HAS_CUSTOM: u32 = 1 << 24;

/// Where each mesh lies in the heap of vertices.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    places: Vec<MeshPlace>,
    /// Records in the heap.
    records: u32,
}

/// Where a mesh lies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct MeshPlace {
    /// Its first record.
    base: u32,
    /// That of the table of its custom attributes.
    table: u32,
    stride: u32,
    flags: u32,
    vertices: usize,
    triangles: usize,
}

impl Geometry {
    /// Triangles in hierarchy order, and the heap of vertices: each mesh has records of one to three `vec4u`, and one more
    /// for each of the custom `attributes` that it has.
    pub(super) fn lay_out(
        scene: &Scene,
        bvh: &SceneBvh,
        program: impl Fn(u32) -> ProgramTraits,
        attributes: &[String],
    ) -> (Vec<[u32; 4]>, Vec<[u32; 4]>, Self) {
        let mut triangles =
            Vec::with_capacity(scene.meshes.iter().map(|m| m.triangles.len()).sum());
        let mut vertices = Vec::new();
        let mut tables = CustomTables::default();
        let mut places = Vec::with_capacity(scene.meshes.len());
        let flags = material_flags(scene, &program);
        for (mesh, order) in scene.meshes.iter().zip(&bvh.triangle_order) {
            if order.is_empty() {
                places.push(MeshPlace::default());
                continue;
            }
            let layout = VertexLayout::of(mesh, attributes);
            let table = tables.place(&layout, attributes, &mut vertices);
            let place = MeshPlace {
                base: vertices.len() as u32,
                table,
                ..MeshPlace::of(mesh, &layout)
            };
            layout.append(mesh, table, &mut vertices);
            place.append_triangles(mesh, order, &flags, &mut triangles);
            places.push(place);
        }
        let records = vertices.len() as u32;
        (triangles, vertices, Self { places, records })
    }

    /// Whether another scene's meshes fit where these lie, each in its own place.
    pub(super) fn has_place_for(&self, scene: &Scene, attributes: &[String]) -> bool {
        let fits = |(place, mesh): (&MeshPlace, &Mesh)| {
            let wanted = match mesh.triangles.is_empty() {
                true => MeshPlace::default(),
                false => MeshPlace {
                    base: place.base,
                    table: place.table,
                    ..MeshPlace::of(mesh, &VertexLayout::of(mesh, attributes))
                },
            };
            *place == wanted
        };
        self.places.len() == scene.meshes.len() && self.places.iter().zip(&scene.meshes).all(fits)
    }

    /// Records of all meshes: what lies behind them in the heap is not theirs.
    pub(super) fn records(&self) -> u32 {
        self.records
    }

    /// Where a mesh lies.
    pub(super) fn place(&self, mesh: usize) -> MeshPlace {
        self.places[mesh]
    }
}

/// Bytes of the heap of vertices of a scene whose textures read these attributes, but for the few tables in it.
pub(super) fn vertex_bytes(scene: &Scene, attributes: &[String]) -> u64 {
    let meshes = scene
        .meshes
        .iter()
        .filter(|mesh| !mesh.triangles.is_empty());
    let of = |mesh: &Mesh| {
        let stride = VertexLayout::of(mesh, attributes).stride;
        16 * u64::from(stride) * mesh.positions.len() as u64
    };
    meshes.map(of).sum()
}

impl MeshPlace {
    fn of(mesh: &Mesh, layout: &VertexLayout<'_>) -> Self {
        Self {
            stride: layout.stride,
            flags: layout.flags,
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            ..Self::default()
        }
    }

    /// Its first record in the heap.
    pub(super) fn first_record(&self) -> u32 {
        self.base
    }

    /// Records of a vertex.
    pub(super) fn stride(&self) -> u32 {
        self.stride
    }

    /// How many vertices it has.
    pub(super) fn vertices(&self) -> usize {
        self.vertices
    }

    /// The records of a mesh that fits here.
    pub(super) fn append_vertices(
        &self,
        mesh: &Mesh,
        attributes: &[String],
        heap: &mut Vec<[u32; 4]>,
    ) {
        VertexLayout::of(mesh, attributes).append(mesh, self.table, heap);
    }

    /// Its triangles in an order; `flags` are [`material_flags`].
    pub(super) fn append_triangles(
        &self,
        mesh: &Mesh,
        order: &[u32],
        flags: &[[u32; 2]],
        triangles: &mut Vec<[u32; 4]>,
    ) {
        let has_colors = !mesh.colors.is_empty();
        triangles.extend(order.iter().map(|&t| {
            let [a, b, c] = mesh.triangles[t as usize].map(|v| self.base + v * self.stride);
            let material = mesh.triangle_materials[t as usize];
            let material_flags = flags[material as usize][usize::from(has_colors)];
            [a, b, c, material | self.flags | material_flags]
        }));
    }
}

/// What a material means for the rays that meet its triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayRules {
    /// Rays pass its back.
    pub is_single_sided: bool,
    /// Its opacity, or what it lets through, decides whether a ray ends at its front.
    pub may_let_pass: bool,
}

/// The rules of each material, for meshes without and with vertex colours. `program` says what is known of a material's
/// texture program.
pub fn ray_rules(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Vec<[RayRules; 2]> {
    let rules = |flags: u32| RayRules {
        is_single_sided: flags & TRIANGLE_SINGLE_SIDED != 0,
        may_let_pass: flags & (TRIANGLE_ALPHA | TRIANGLE_PROGRAM_ALPHA) != 0,
    };
    let flags = material_flags(scene, program).into_iter();
    flags.map(|flags| flags.map(rules)).collect()
}

/// What each material means for its triangles, without and with vertex colours.
pub(super) fn material_flags(
    scene: &Scene,
    program: impl Fn(u32) -> ProgramTraits,
) -> Vec<[u32; 2]> {
    let flags_of = |index: u32, m: &Material, has_colors: bool| {
        // The back of a transparent body is where rays leave it.
        let has_back = m.double_sided || materials::is_body(m, &program(index));
        let sides = if has_back { 0 } else { TRIANGLE_SINGLE_SIDED };
        let alpha = match program(index).decides_opacity {
            true => TRIANGLE_PROGRAM_ALPHA,
            // Shadow rays look up what a clear wall lets through.
            false
                if materials::needs_alpha(m, has_colors)
                    || materials::is_clear(m, &program(index)) =>
            {
                TRIANGLE_ALPHA
            }
            false => 0,
        };
        sides | alpha
    };
    (0..)
        .zip(&scene.materials)
        .map(|(index, m)| [false, true].map(|has_colors| flags_of(index, m, has_colors)))
        .collect()
}

struct VertexLayout<'a> {
    stride: u32,
    flags: u32,
    /// Indices into the list of attributes, and values that stand behind each vertex in this order.
    custom: Vec<(usize, &'a [Vec4])>,
}

impl<'a> VertexLayout<'a> {
    fn of(mesh: &'a Mesh, attributes: &[String]) -> Self {
        let custom: Vec<(usize, &[Vec4])> = (attributes.iter().enumerate())
            .filter_map(|(index, name)| Some((index, &*mesh.custom(name)?.values)))
            .collect();
        let mut flags = 0;
        let mut stride = 1;
        // The second record says where the table of the custom attributes is.
        if !mesh.uv0.is_empty() || !mesh.tangents.is_empty() || !custom.is_empty() {
            flags |= TRIANGLE_HAS_UV;
            stride = 2;
        }
        if !mesh.uv1.is_empty() || !mesh.colors.is_empty() {
            flags |= TRIANGLE_HAS_UV | TRIANGLE_HAS_EXTRA;
            stride = 3;
        }
        if !mesh.tangents.is_empty() {
            flags |= TRIANGLE_HAS_TANGENT;
        }
        if !mesh.colors.is_empty() {
            flags |= TRIANGLE_HAS_COLOR;
        }
        if !custom.is_empty() {
            flags |= TRIANGLE_HAS_CUSTOM;
        }
        Self {
            stride: stride + custom.len() as u32,
            flags,
            custom,
        }
    }

    /// Records of a vertex before the custom ones.
    fn fixed(&self) -> u32 {
        self.stride - self.custom.len() as u32
    }

    fn append(&self, mesh: &Mesh, table: u32, heap: &mut Vec<[u32; 4]>) {
        let fixed = self.fixed();
        heap.reserve(mesh.positions.len() * self.stride as usize);
        for (i, p) in mesh.positions.iter().enumerate() {
            let normal = mesh.normals.get(i).copied().unwrap_or(Vec3::Y);
            heap.push([
                p.x.to_bits(),
                p.y.to_bits(),
                p.z.to_bits(),
                octahedral(normal),
            ]);
            if fixed >= 2 {
                let uv = mesh.uv0.get(i).copied().unwrap_or(Vec2::ZERO);
                let tangent = mesh.tangents.get(i).copied().unwrap_or(Vec4::X);
                heap.push([
                    uv.x.to_bits(),
                    uv.y.to_bits(),
                    octahedral(tangent.truncate()),
                    u32::from(tangent.w >= 0.0) | table << 1,
                ]);
            }
            if fixed >= 3 {
                // A second set that isn't there is the first one, as textures are told.
                let uv = mesh
                    .uv1
                    .get(i)
                    .or(mesh.uv0.get(i))
                    .copied()
                    .unwrap_or(Vec2::ZERO);
                let color = mesh.colors.get(i).copied().unwrap_or(Vec4::ONE);
                heap.push([
                    uv.x.to_bits(),
                    uv.y.to_bits(),
                    unorm16(color.x, color.y),
                    unorm16(color.z, color.w),
                ]);
            }
            heap.extend(
                (self.custom.iter()).map(|(_, values)| values[i].to_array().map(f32::to_bits)),
            );
        }
    }
}

/// The tables in the heap that tell where in a vertex an attribute is; meshes that agree share one.
#[derive(Default)]
struct CustomTables {
    places: HashMap<Vec<u32>, u32>,
}

impl CustomTables {
    /// Where the mesh's table is; 0 for a mesh that needs none. A word for each attribute: the number of its record in
    /// a vertex, or 0.
    fn place(
        &mut self,
        layout: &VertexLayout<'_>,
        attributes: &[String],
        heap: &mut Vec<[u32; 4]>,
    ) -> u32 {
        if layout.custom.is_empty() {
            return 0;
        }
        let mut table = vec![0; attributes.len().next_multiple_of(4)];
        for (record, (index, _)) in (layout.fixed()..).zip(&layout.custom) {
            table[*index] = record;
        }
        *self.places.entry(table).or_insert_with_key(|table| {
            let place = heap.len() as u32;
            heap.extend(table.as_chunks().0);
            place
        })
    }
}

fn unorm16(x: f32, y: f32) -> u32 {
    let q = |v: f32| (v.clamp(0.0, 1.0) * 65535.0 + 0.5) as u32;
    q(x) | q(y) << 16
}

/// A unit vector as two signed 16-bit numbers; `octahedral_decode` in `geometry.wgsl`.
fn octahedral(v: Vec3) -> u32 {
    let sum = v.abs().element_sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return octahedral(Vec3::Y);
    }
    let mut e = Vec2::new(v.x, v.y) / sum;
    if v.z < 0.0 {
        let sign = |s: f32| if s >= 0.0 { 1.0 } else { -1.0 };
        e = Vec2::new((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y));
    }
    let q = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    q(e.x) | q(e.y) << 16
}
