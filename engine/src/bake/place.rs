//! A point of a surface as textures see it: the attributes that a hit there would have, looked at from straight above.
//!
//! The formulas are those of `passes/proctex/site.wgsl` and `passes/shared/surface.wgsl`.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use texgen::{BUILTIN_ATTRIBUTES, BuiltinAttribute as A, GLOBALS, Global};

use crate::evaluate::Layout;
use crate::scene::{Mesh, Scene};

/// A point of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) triangle: u32,
    /// Of its corners.
    pub(super) weights: Vec3,
    /// In the world, metres.
    pub(super) position: Vec3,
    /// Shading normal in the world.
    pub(super) normal: Vec3,
    /// Of the triangle, in the world.
    pub(super) geometric: Vec3,
    /// Two edges of the triangle in the world, from its first corner.
    pub(super) edges: [Vec3; 2],
    /// Width of what a sample stands for, metres.
    pub(super) footprint: f32,
    /// Which sides differences are taken to, two bits.
    pub(super) sides: u32,
}

/// A mesh where an instance puts it.
pub(super) struct Placed<'a> {
    pub(super) mesh: &'a Mesh,
    instance: u32,
    to_world: Affine3A,
    to_object: Affine3A,
    /// -1 where the instance mirrors.
    handedness: f32,
    /// Mean scale from the world to the object's space.
    scale: f32,
    /// What all places have in common.
    plain: Vec<[f32; 4]>,
}

impl<'a> Placed<'a> {
    pub(super) fn new(
        scene: &Scene,
        mesh: &'a Mesh,
        instance: u32,
        layout: &Layout,
        view: &super::Moment,
    ) -> Self {
        let to_world = scene.instances[instance as usize].transform;
        let to_object = to_world.inverse();
        // As `site.wgsl` has it: from the rows of the map to the object's space.
        let rows = to_object.matrix3.transpose();
        let lengths = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.length());
        Self {
            mesh,
            instance,
            to_world,
            to_object,
            handedness: match to_world.matrix3.determinant() < 0.0 {
                true => -1.0,
                false => 1.0,
            },
            scale: lengths.iter().sum::<f32>() / 3.0,
            plain: plain(scene, instance, layout, view),
        }
    }

    /// A point of a triangle; a sample there stands for `share` of the unit square of `uv` coordinates, those of its corners.
    pub(super) fn at(&self, triangle: u32, weights: Vec3, uv: [Vec2; 3], side: f32) -> Place {
        let corners = self.mesh.triangles[triangle as usize].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| self.to_world.transform_point3(self.mesh.positions[i]));
        let edges = [b - a, c - a];
        let cross = edges[0].cross(edges[1]) * self.handedness;
        let geometric = cross.normalize_or(Vec3::Y);
        let local: Vec3 = (0..3)
            .map(|i| self.mesh.normals[corners[i]] * weights[i])
            .sum();
        let area = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
        let metres = (cross.length() / area.max(1e-30)).sqrt();
        Place {
            triangle,
            weights,
            position: a + edges[0] * weights.y + edges[1] * weights.z,
            normal: self.normal_to_world(local).normalize_or(geometric),
            geometric,
            edges,
            footprint: if metres.is_finite() {
                metres * side
            } else {
                0.0
            },
            sides: 0,
        }
    }

    /// A place beside another one, in the plane of its triangle: all that is interpolated moves with it.
    pub(super) fn moved(&self, place: &Place, by: Vec3) -> Place {
        let [e1, e2] = place.edges;
        let (g11, g12, g22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let (b1, b2) = (by.dot(e1), by.dot(e2));
        let scale = 1.0 / (g11 * g22 - g12 * g12).max(1e-37);
        let second = (g22 * b1 - g12 * b2) * scale;
        let third = (g11 * b2 - g12 * b1) * scale;
        Place {
            weights: place.weights + Vec3::new(-second - third, second, third),
            position: place.position + by,
            ..*place
        }
    }

    fn normal_to_world(&self, local: Vec3) -> Vec3 {
        Vec3::from(self.to_object.matrix3.transpose() * glam::Vec3A::from(local))
    }

    /// Texture coordinates, of the first set where there is no second one.
    pub(super) fn uv(&self, place: &Place, set: u32) -> Vec2 {
        let uv = match set {
            1 if !self.mesh.uv1.is_empty() => &self.mesh.uv1,
            _ => &self.mesh.uv0,
        };
        match uv.is_empty() {
            true => Vec2::ZERO,
            false => self.interpolated(place, |i| uv[i]),
        }
    }

    pub(super) fn color(&self, place: &Place) -> Vec4 {
        match self.mesh.colors.is_empty() {
            true => Vec4::ONE,
            false => self.interpolated(place, |i| self.mesh.colors[i]),
        }
    }

    /// Unit tangent in the world, perpendicular to the normal, and handedness of the bitangent.
    pub(super) fn tangent(&self, mesh: &Mesh, place: &Place) -> Vec4 {
        if !mesh.tangents.is_empty() {
            let corners =
                mesh.triangles[place.triangle as usize].map(|i| mesh.tangents[i as usize]);
            let local: Vec4 = (0..3).map(|i| corners[i] * place.weights[i]).sum();
            let sign = self.handedness * corners[0].w.signum();
            let world = self.to_world.transform_vector3(local.truncate());
            let across = world - place.normal * world.dot(place.normal);
            if across.length() > 1e-20 {
                return (across / across.length()).extend(sign);
            }
        }
        place.normal.any_orthonormal_vector().extend(1.0)
    }

    fn interpolated<T>(&self, place: &Place, value: impl Fn(usize) -> T) -> T
    where
        T: std::ops::Mul<f32, Output = T> + std::iter::Sum,
    {
        let corners = self.mesh.triangles[place.triangle as usize];
        (0..3)
            .map(|i| value(corners[i] as usize) * place.weights[i])
            .sum()
    }

    /// Half the divergence of the interpolated normal over the triangle, 1/metres.
    fn curvature(&self, place: &Place) -> f32 {
        let corners = self.mesh.triangles[place.triangle as usize].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| self.mesh.positions[i]);
        let [na, nb, nc] = corners.map(|i| self.mesh.normals[i]);
        let (ab, ac) = (b - a, c - a);
        let across = ab.cross(ac);
        let turn = (nb - na).dot(ac.cross(across)) + (nc - na).dot(across.cross(ab));
        let along = 0.5 * turn / across.length_squared().max(1e-37);
        let local = across.length().max(1e-30);
        let world = place.edges[0].cross(place.edges[1]).length().max(1e-30);
        along / (world / local).sqrt()
    }

    /// Writes what textures read at a place; `occlusion` has a component for each table.
    pub(super) fn write(
        &self,
        place: &Place,
        layout: &Layout,
        occlusion: [f32; 4],
        values: &mut [[f32; 4]],
    ) {
        values.copy_from_slice(&self.plain);
        let tangent = self.tangent(self.mesh, place);
        let local = |v: Vec3| {
            let back = self.to_world.matrix3.transpose();
            Vec3::from(back * glam::Vec3A::from(v)).normalize_or(Vec3::Y)
        };
        let uv = |set| self.uv(place, set).extend(0.0).extend(1.0);
        let across = place.normal.cross(tangent.truncate()) * tangent.w;
        for (at, attribute) in BUILTIN_ATTRIBUTES.iter().enumerate() {
            let value = match attribute {
                A::WorldPos => place.position.extend(1.0),
                A::LocalPos => self.to_object.transform_point3(place.position).extend(1.0),
                A::Normal | A::ViewDir => place.normal.extend(0.0),
                A::GeomNormal => place.geometric.extend(0.0),
                A::LocalNormal => local(place.normal).extend(0.0),
                A::Tangent => tangent,
                A::Bitangent => across.extend(0.0),
                A::TexCoord0 => uv(0),
                A::TexCoord1 => uv(1),
                A::Color0 => self.color(place),
                A::AO => Vec4::from(occlusion),
                A::Curvature => Vec4::splat(self.curvature(place)),
                A::Footprint => self.footprint(place),
                A::InstanceId => Vec4::splat(self.instance as f32),
                A::MaterialId => {
                    let materials = &self.mesh.triangle_materials;
                    Vec4::splat(materials[place.triangle as usize] as f32)
                }
                _ => continue,
            };
            values[at] = value.to_array();
        }
        for (attribute, value) in layout
            .custom()
            .iter()
            .zip(&mut values[layout.custom_start()..])
        {
            if let Some(custom) = self.mesh.custom(attribute) {
                *value = self.interpolated(place, |i| custom.values[i]).to_array();
            }
        }
    }

    fn footprint(&self, place: &Place) -> Vec4 {
        let per_metre = match self.mesh.uv0.is_empty() {
            true => 0.0,
            false => {
                let corners = self.mesh.triangles[place.triangle as usize];
                let [a, b, c] = corners.map(|i| self.mesh.uv0[i as usize]);
                let area = place.edges[0].cross(place.edges[1]).length().max(1e-30);
                ((b - a).perp_dot(c - a).abs() / area).sqrt()
            }
        };
        let width = place.footprint;
        Vec4::new(width, width * per_metre, width * self.scale, 0.0)
    }
}

/// Values that don't differ from place to place.
fn plain(scene: &Scene, instance: u32, layout: &Layout, moment: &super::Moment) -> Vec<[f32; 4]> {
    let mut values = layout.plain();
    let mut set = |place: Option<usize>, value: Vec4| {
        if let Some(place) = place {
            values[place] = value.to_array();
        }
    };
    let (low, high) = scene.bounds().unwrap_or_default();
    set(layout.attribute("ObjectRandom"), object_random(instance));
    set(layout.attribute("Time"), Vec4::splat(moment.time));
    for global in GLOBALS {
        let value = match global {
            Global::Time => Vec4::splat(moment.time),
            Global::FrameIndex => Vec4::splat(moment.frame as f32),
            Global::CameraPos => moment.camera.extend(1.0),
            Global::SceneMin => low.extend(1.0),
            Global::SceneMax => high.extend(1.0),
            _ => continue,
        };
        set(layout.global(global.name()), value);
    }
    values
}

/// As the attribute of that name.
fn object_random(instance: u32) -> Vec4 {
    let hash = |x: u32| {
        let mut v = x;
        v = (v ^ (v >> 16)).wrapping_mul(0x7feb_352d);
        v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
        v ^ (v >> 16)
    };
    let part = |word: u32| (word >> 8) as f32 / 16_777_216.0;
    let number = hash(instance.wrapping_mul(0x9e37_79b9).wrapping_add(0x7f4a_7c15));
    let x = part(number);
    let y = hash(x.to_bits());
    let z = hash(y);
    Vec4::new(x, part(y), part(z), part(hash(z)))
}
