//! Which transparent bodies a camera or a lamp is in. A path knows the bodies that it has gone into; where it begins in some, the frame tells
//! it of them, so that what else is in there is seen through what they are made of.

use std::sync::OnceLock;

use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

use crate::{
    bvh::{Bounds, Crossings},
    pick::{Ray, intersect},
    scene::{Instance, Material, Mesh, Scene},
    texturing::ProgramTraits,
};

use super::{inverse, lights::Lamp, materials};

/// Bodies that a path remembers, as in `media.wgsl`.
const MOST: usize = 4;
/// Directions that a body is looked for in.
const DIRECTIONS: u32 = 8;
/// In so many of them what is left of a place must be the body's back: a ray along an edge may miss it, and a sheet that bounds no body is
/// seen in half of them.
const ENOUGH: usize = 7;

/// Surfaces of transparent bodies, kept to be asked for places.
#[derive(Debug, Default)]
pub(crate) struct Bodies {
    /// Of each material, whether it bounds bodies: in meshes without and with vertex colours.
    bounds: Vec<[bool; 2]>,
    /// One for each mesh that has such surfaces.
    surfaces: Vec<Surface>,
    placed: Vec<Placed>,
}

#[derive(Debug)]
struct Surface {
    /// In object space, each with its material.
    triangles: Vec<([Vec3; 3], u32)>,
    /// Over them: made where many places are asked for. One place alone is asked for sooner without it.
    hierarchy: OnceLock<Crossings>,
}

/// A ray's number, how far away it meets a triangle, which material that has, and whether it is its front.
type Hit = (usize, f32, u32, bool);

/// Lamps, and which bodies they are in once somebody has asked.
#[derive(Debug)]
pub(super) struct Lamps {
    lamps: Vec<Lamp>,
    media: OnceLock<Vec<[u32; MOST]>>,
}

impl Lamps {
    pub(super) fn new(lamps: Vec<Lamp>) -> Self {
        Self {
            lamps,
            media: OnceLock::new(),
        }
    }

    /// Bodies have changed.
    pub(super) fn forget_bodies(&mut self) {
        self.media.take();
    }

    /// For each light with a place the bodies that hold it, as [`Bodies::around`] has them.
    pub(super) fn media(&self, bodies: &Bodies) -> &[[u32; MOST]] {
        self.media.get_or_init(|| bodies.around_lamps(&self.lamps))
    }
}

/// One of them in the world.
#[derive(Debug)]
struct Placed {
    surface: usize,
    object_from_world: Affine3A,
    /// Corners of a box around it, metres.
    bounds: [Vec3; 2],
}

impl Bodies {
    /// Those of a scene.
    pub(super) fn of(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Self {
        let bounds = bounding(scene, program);
        let (mut surfaces, mut placed) = (Vec::new(), Vec::new());
        let mut of_mesh = vec![None; scene.meshes.len()];
        if bounds.as_flattened().contains(&true) {
            for (mesh, place) in scene.meshes.iter().zip(&mut of_mesh) {
                let surface = Surface::of(mesh, &bounds);
                if !surface.triangles.is_empty() {
                    *place = Some(surfaces.len());
                    surfaces.push(surface);
                }
            }
        }
        for instance in &scene.instances {
            if let Some(surface) = of_mesh[instance.mesh as usize] {
                placed.push(Placed::of(instance, surface, &surfaces[surface]));
            }
        }
        Self {
            bounds,
            surfaces,
            placed,
        }
    }

    /// Whether the same materials bound bodies: all that a change of materials can change here.
    pub(super) fn have_bounds_of(
        &self,
        scene: &Scene,
        program: impl Fn(u32) -> ProgramTraits,
    ) -> bool {
        self.bounds == bounding(scene, program)
    }

    /// For each light those that hold it, as [`Self::around`] has them; none for lights of a lamp that isn't in the same ones
    /// throughout.
    fn around_lamps(&self, lamps: &[Lamp]) -> Vec<[u32; MOST]> {
        let may_be_in = |placed: &&Placed| {
            let mut first = lamps.iter().filter_map(|lamp| lamp.places.first());
            first.any(|&place| placed.may_hold(place))
        };
        for placed in self.placed.iter().filter(may_be_in) {
            self.surfaces[placed.surface].prepare();
        }
        let around = |lamp: &Lamp| {
            let mut media = lamp.places.iter().map(|&place| self.around(place));
            let first = media.next().unwrap_or_default();
            // In none there, it is in none throughout or not in the same ones: the other places needn't be asked.
            let media = if first != [0; MOST] && media.all(|media| media == first) {
                first
            } else {
                [0; MOST]
            };
            std::iter::repeat_n(media, lamp.lights)
        };
        lamps.par_iter().flat_map_iter(around).collect()
    }

    /// The bodies that hold a point, the innermost first, as a path has them: 1 + material, 0 for none.
    pub(crate) fn around(&self, point: Vec3) -> [u32; MOST] {
        let mut found: Vec<(f32, u32)> = (self.placed.iter())
            .filter(|placed| placed.may_hold(point))
            .flat_map(|placed| placed.bodies_around(point, &self.surfaces[placed.surface]))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut media = [0; MOST];
        for (place, (_, material)) in media.iter_mut().zip(found) {
            *place = material + 1;
        }
        media
    }
}

/// A surface that a ray may pass as if it weren't there bounds nothing: who begins in it would never come out.
fn bounding(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Vec<[bool; 2]> {
    let bounds = |(number, material): (u32, &Material)| {
        let program = program(number);
        let is_body = materials::is_body(material, &program) && !program.decides_opacity;
        [false, true].map(|has_colors| is_body && !materials::needs_alpha(material, has_colors))
    };
    (0..).zip(&scene.materials).map(bounds).collect()
}

impl Surface {
    fn of(mesh: &Mesh, bounds: &[[bool; 2]]) -> Self {
        let has_colors = usize::from(!mesh.colors.is_empty());
        let corners = |of: &[u32; 3]| of.map(|corner| mesh.positions[corner as usize]);
        let triangles = (mesh.triangles.iter())
            .zip(&mesh.triangle_materials)
            .filter(|(_, material)| bounds[**material as usize][has_colors])
            .map(|(triangle, &material)| (corners(triangle), material))
            .collect();
        Self {
            triangles,
            hierarchy: OnceLock::new(),
        }
    }

    fn prepare(&self) {
        self.hierarchy.get_or_init(|| {
            let corners = self.triangles.par_iter().map(|(corners, _)| corners);
            let boxes: Vec<Bounds> = corners
                .map(|corners| Bounds::around(corners.map(Vec3A::from)))
                .collect();
            Crossings::over(&boxes)
        });
    }

    /// All that rays meet, in no order.
    fn met_by(&self, rays: &[Ray]) -> Vec<Hit> {
        let hit = |number: usize, ray: &Ray, (corners, material): &([Vec3; 3], u32)| {
            let (distance, _, is_front) = intersect(ray, *corners)?;
            Some((number, distance, *material, is_front))
        };
        let Some(hierarchy) = self.hierarchy.get() else {
            return (self.triangles.par_iter())
                .flat_map_iter(|triangle| {
                    let rays = rays.iter().enumerate();
                    rays.filter_map(move |(number, ray)| hit(number, ray, triangle))
                })
                .collect();
        };
        let mut hits = Vec::new();
        for (number, ray) in rays.iter().enumerate() {
            hierarchy.visit(ray.origin.into(), ray.direction.into(), |triangle| {
                hits.extend(hit(number, ray, &self.triangles[triangle as usize]));
            });
        }
        hits
    }
}

impl Placed {
    fn of(instance: &Instance, surface: usize, of: &Surface) -> Self {
        let corners = of.triangles.iter().flat_map(|(corners, _)| corners);
        let points = corners.map(|&corner| instance.transform.transform_point3(corner));
        let nowhere = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        Self {
            surface,
            object_from_world: inverse(&instance.transform),
            bounds: points.fold(nowhere, |[low, high], p| [low.min(p), high.max(p)]),
        }
    }

    fn may_hold(&self, point: Vec3) -> bool {
        let [low, high] = self.bounds;
        point.cmpge(low).all() && point.cmple(high).all()
    }

    /// How far away the backs of the bodies are that hold a point, and their materials.
    fn bodies_around(&self, point: Vec3, surface: &Surface) -> Vec<(f32, u32)> {
        // Not normalised: distances stay those of the world.
        let ray = |direction: Vec3| Ray {
            origin: self.object_from_world.transform_point3(point),
            direction: self.object_from_world.transform_vector3(direction),
        };
        let rays: Vec<Ray> = (0..DIRECTIONS).map(|i| ray(direction(i))).collect();
        let hits = surface.met_by(&rays);
        let mut materials: Vec<u32> = hits.iter().map(|hit| hit.2).collect();
        materials.sort_unstable();
        materials.dedup();
        let mut bodies = Vec::new();
        for material in materials {
            let own = || hits.iter().filter(|hit| hit.2 == material);
            let mut backs = [0_i32; DIRECTIONS as usize];
            for &(direction, _, _, is_front) in own() {
                backs[direction] += if is_front { -1 } else { 1 };
            }
            if backs.iter().filter(|&&backs| backs > 0).count() < ENOUGH {
                continue;
            }
            // As many bodies of one material as most of the directions tell of: the rest are edges that count twice.
            backs.sort_unstable();
            let count = backs[DIRECTIONS as usize / 2].max(1) as usize;
            let mut distances: Vec<f32> = own().filter(|hit| !hit.3).map(|hit| hit.1).collect();
            distances.sort_by(f32::total_cmp);
            let nearest = distances.first().copied().unwrap_or(f32::INFINITY);
            bodies.extend(std::iter::repeat_n((nearest, material), count.min(MOST)));
        }
        bodies
    }
}

/// Directions all around, along no axis and in no plane that models are built along: points of a spiral on the sphere whose steps are
/// of the golden angle.
fn direction(number: u32) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let height = 1.0 - (2.0 * number as f32 + 1.037) / DIRECTIONS as f32;
    let (sine, cosine) = (GOLDEN_ANGLE * number as f32 + 0.413).sin_cos();
    let width = (1.0 - height * height).sqrt();
    Vec3::new(width * cosine, height, width * sine)
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec4};

    use super::*;
    use crate::scene::AlphaMode;

    /// A cube of two metres around the origin, its faces outwards.
    fn cube(material: u32) -> Mesh {
        let corner = |i: u32| Vec3::from([0, 1, 2].map(|axis| 2.0 * (i >> axis & 1) as f32 - 1.0));
        let faces = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        Mesh {
            positions: (0..8).map(corner).collect(),
            triangles: faces
                .iter()
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
            triangle_materials: vec![material; 12],
            ..Mesh::default()
        }
    }

    fn placed(mesh: u32, transform: Affine3A) -> Instance {
        Instance {
            name: String::new(),
            mesh,
            transform,
            asset: None,
        }
    }

    fn glass() -> Material {
        Material {
            transmission: 1.0,
            is_solid: true,
            ..Material::default()
        }
    }

    fn around(scene: &Scene, point: Vec3) -> [u32; 4] {
        Bodies::of(scene, |_| ProgramTraits::default()).around(point)
    }

    #[test]
    fn the_innermost_body_comes_first() {
        let turn = Quat::from_rotation_y(0.3);
        let scale = |size: f32, place: Vec3| {
            Affine3A::from_scale_rotation_translation(Vec3::splat(size), turn, place)
        };
        let scene = Scene {
            materials: vec![Material::default(), glass(), glass()],
            meshes: vec![cube(1), cube(2), cube(0)],
            instances: vec![
                placed(0, scale(3.0, Vec3::ZERO)),
                placed(1, scale(0.5, Vec3::ZERO)),
                placed(2, scale(9.0, Vec3::ZERO)),
            ],
            ..Scene::default()
        };
        assert_eq!(around(&scene, Vec3::splat(0.1)), [3, 2, 0, 0]);
        assert_eq!(around(&scene, Vec3::X), [2, 0, 0, 0]);
        assert_eq!(around(&scene, Vec3::X * 5.0), [0; 4]);
    }

    #[test]
    fn mirrored_bodies_are_bodies() {
        let scene = Scene {
            materials: vec![glass()],
            meshes: vec![cube(0)],
            instances: vec![placed(0, Affine3A::from_scale(Vec3::new(-1.0, 2.0, 0.5)))],
            ..Scene::default()
        };
        assert_eq!(around(&scene, Vec3::new(0.2, 1.5, 0.1)), [1, 0, 0, 0]);
        assert_eq!(around(&scene, Vec3::new(0.2, 1.5, 0.7)), [0; 4]);
    }

    /// What isn't in the same bodies throughout is in none that one could name.
    #[test]
    fn a_lamp_is_in_the_bodies_that_all_of_it_is_in() {
        let mut scene = Scene {
            materials: vec![glass()],
            meshes: vec![cube(0)],
            ..Scene::default()
        };
        scene.instances.push(placed(0, Affine3A::IDENTITY));
        let bodies = Bodies::of(&scene, |_| ProgramTraits::default());
        let lamp = |lights, heights: &[f32]| Lamp {
            lights,
            places: heights.iter().map(|y| Vec3::Y * *y).collect(),
        };
        let lamps = [
            lamp(2, &[0.2, -0.3]),
            lamp(1, &[3.0]),
            lamp(3, &[0.5, 1.5]),
            lamp(1, &[0.0]),
        ];
        let first: Vec<u32> = (bodies.around_lamps(&lamps).iter())
            .map(|media| media[0])
            .collect();
        assert_eq!(first, [1, 1, 0, 0, 0, 0, 1]);
    }

    #[test]
    fn bodies_of_one_material_are_counted() {
        let scene = Scene {
            materials: vec![glass()],
            meshes: vec![cube(0)],
            instances: (1..=6)
                .map(|i| placed(0, Affine3A::from_scale(Vec3::splat(i as f32))))
                .collect(),
            ..Scene::default()
        };
        assert_eq!(around(&scene, Vec3::splat(0.1)), [1; 4]);
        assert_eq!(around(&scene, Vec3::splat(4.5)), [1, 1, 0, 0]);
    }

    #[test]
    fn what_may_not_be_there_is_no_body() {
        let blended = |alpha: f32| Material {
            alpha_mode: AlphaMode::Blend,
            base_color: Vec4::new(1.0, 1.0, 1.0, alpha),
            ..glass()
        };
        let scene = |material: Material| Scene {
            materials: vec![material],
            meshes: vec![cube(0)],
            instances: vec![placed(0, Affine3A::IDENTITY)],
            ..Scene::default()
        };
        let is_bound = |scene: &Scene| around(scene, Vec3::splat(0.1)) == [1, 0, 0, 0];
        assert!(is_bound(&scene(blended(1.0))));
        assert!(!is_bound(&scene(blended(0.0))));
        assert!(!is_bound(&scene(blended(0.5))));
        // An opaque one has no alpha, whatever the file says.
        let mut opaque = blended(0.0);
        opaque.alpha_mode = AlphaMode::Opaque;
        assert!(is_bound(&scene(opaque)));
        let mut colored = scene(blended(1.0));
        colored.meshes[0].colors = vec![Vec4::splat(0.5); 8];
        assert!(!is_bound(&colored), "its vertices have an alpha");
        colored.materials[0].alpha_mode = AlphaMode::Opaque;
        assert!(is_bound(&colored));
        let driven = ProgramTraits {
            decides_opacity: true,
            ..ProgramTraits::default()
        };
        let driven = Bodies::of(&scene(glass()), |_| driven);
        assert_eq!(driven.around(Vec3::splat(0.1)), [0; 4]);
    }

    #[test]
    fn a_sheet_is_no_body() {
        let mut sheet = cube(0);
        sheet.triangles.truncate(2);
        sheet.triangle_materials.truncate(2);
        sheet.positions[4].x = -1.5; // so that there is a place in its box
        let scene = Scene {
            materials: vec![glass()],
            meshes: vec![sheet],
            instances: vec![placed(0, Affine3A::IDENTITY)],
            ..Scene::default()
        };
        for x in [-1.01, -1.2] {
            assert_eq!(around(&scene, Vec3::new(x, 0.1, 0.1)), [0; 4]);
        }
    }
}
