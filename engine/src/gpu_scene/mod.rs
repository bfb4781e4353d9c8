//! A scene on the GPU: buffers and textures in the layout of `geometry.wgsl`, `materials.wgsl`, `lights.wgsl` and
//! `environment.wgsl`. Made once; edits of material constants are written over it (`update.rs`), those of textures do not touch it.

pub mod albedo;
mod bodies;
mod casters;
pub mod environment;
mod estimate;
mod geometry;
pub mod host_traversal;
pub mod images;
mod levels;
pub mod light_tree;
pub mod lights;
pub mod materials;
mod motion;
mod moved;
pub(crate) mod sky_parts;
mod update;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3, Vec4};

use device::{Device, DeviceError, Resources, Usage, native::accel};

use crate::{
    bvh::{BvhError, SceneBvh},
    scene::{LightSource, Mesh, Scene, name_id},
    texturing::{ProgramTraits, TextureReads},
    wave,
};

use self::{
    bodies::{Bodies, Lamps},
    environment::GpuEnvironment,
    geometry::Geometry,
    host_traversal::HostTraversal,
    images::GpuImages,
    lights::LightTable,
    materials::GpuMaterial,
    update::Uploaded,
};

pub use self::casters::MOST_TARGETS;
pub(crate) use self::estimate::bytes;
use self::geometry::TRIANGLE_ALPHA;
pub use self::geometry::{RayRules, ray_rules};
pub(crate) use self::motion::Views;
pub(crate) use self::update::Update;

/// Materials that a triangle's word can name.
const MAX_MATERIALS: usize = 1 << 24;

/// Why a scene could not be put on the GPU.
#[derive(Debug, thiserror::Error)]
pub enum GpuSceneError {
    /// No hierarchy.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// No hierarchy for rays that the program traces.
    #[error(transparent)]
    Rays(#[from] accel::BuildError),
    /// Too large, or refused by the driver.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// More materials than fit.
    #[error("the scene has {0} materials, more than the {MAX_MATERIALS} that are supported")]
    TooManyMaterials(usize),
}

/// `Instance` in `geometry.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuInstance {
    world_from_object: [[f32; 4]; 3],
    object_from_world: [[f32; 4]; 3],
    root: u32,
    handedness: f32,
    id: u32,
    source: u32,
    asset: u32,
    motion: u32,
    unused_b: u32,
    unused_c: u32,
}

impl GpuInstance {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(GpuInstance, $member))),*] };
        }
        offsets![
            world_from_object,
            object_from_world,
            root,
            handedness,
            id,
            source,
            asset,
            motion,
            unused_b,
            unused_c
        ]
    }
}

/// What a scene uses: kernels are compiled without what it doesn't.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct SceneFeatures {
    /// Some surface may be transparent.
    pub alpha: bool,
    /// Some material has an image.
    pub textures: bool,
    /// Light comes from the environment.
    pub environment: bool,
    /// Some material lets light through.
    pub transmission: bool,
    /// Some material is a clear thin wall.
    pub clear: bool,
    /// A path may pass surfaces without being scattered, so that it takes more rounds than vertices that scatter.
    pub passages: bool,
    /// Some material has a coat, sheen, a thin film or anisotropy.
    pub layers: bool,
    /// Rough surfaces give back what single scattering loses: no property of the scene, but of what is asked for.
    pub energy_compensation: bool,
    /// The film has layers beside the picture: asked for as well.
    pub film_layers: bool,
    /// Some of them are parts of the light, told apart by how it came.
    pub splits_light: bool,
    /// Some are of shadow catchers.
    pub catches_shadows: bool,
    /// Some are of nodes of the look: so many.
    pub node_layers: u32,
    /// Paths end in a cache of light: asked for, too.
    pub light_cache: bool,
    /// A cache knows the irradiance of surfaces: asked for, too, with the other cache.
    pub irradiance_cache: bool,
    /// Photons bring caustics: asked for, too, alone or with the cache of irradiance.
    pub photons: bool,
    /// Some material has a texture program.
    pub programs: bool,
    /// A texture program decides about the opacity or the light of some surface, so that shadow rays need it too.
    pub program_shadows: bool,
}

impl SceneFeatures {
    /// Words of a path, besides the results of its texture program, that not every scene needs.
    pub fn path_words(&self) -> u32 {
        let words = [
            (self.splits_light, wave::SPLIT_WORDS),
            (self.catches_shadows, wave::CATCH_WORDS),
            (self.light_cache, wave::LIGHT_RECORD_WORDS),
            (self.leaves_scattering(), wave::LEFT_WORDS),
            (
                self.splits_light && self.leaves_scattering(),
                wave::GIVEN_WORDS,
            ),
            (self.photons, wave::PHOTON_WORDS),
        ];
        let needed = words.into_iter().filter(|(is_needed, _)| *is_needed);
        needed.map(|(_, words)| words).sum()
    }

    /// Whether paths leave behind how surfaces scatter.
    fn leaves_scattering(&self) -> bool {
        self.light_cache || self.photons
    }

    /// What a scene uses, whose triangles say so of their materials, and whose environment may emit light.
    fn of(
        scene: &Scene,
        program: impl Fn(u32) -> ProgramTraits,
        flags: &[[u32; 2]],
        environment: bool,
    ) -> Self {
        let shadows = Shadows::of(scene, &program);
        let may_be_transparent = |mesh: &Mesh| {
            let has_colors = usize::from(!mesh.colors.is_empty());
            let mut materials = mesh.triangle_materials.iter();
            materials.any(|&m| flags[m as usize][has_colors] & TRIANGLE_ALPHA != 0)
        };
        Self {
            alpha: scene.meshes.iter().any(may_be_transparent),
            textures: !scene.images.is_empty(),
            environment,
            transmission: (0..)
                .zip(&scene.materials)
                .any(|(i, m)| materials::transmits(m) || program(i).transmits),
            layers: (0..)
                .zip(&scene.materials)
                .any(|(i, m)| materials::has_layers(m) || program(i).has_layers),
            energy_compensation: false,
            film_layers: false,
            splits_light: false,
            catches_shadows: false,
            node_layers: 0,
            light_cache: false,
            irradiance_cache: false,
            photons: false,
            programs: (0..scene.materials.len() as u32).any(|m| program(m).runs),
            program_shadows: shadows.by_program,
            clear: shadows.clear,
            passages: shadows.passages,
        }
    }

    /// Values of the kernels' `override` constants.
    pub fn constants(&self) -> [(&'static str, f64); 13] {
        [
            ("has_alpha", f64::from(u8::from(self.alpha))),
            ("has_textures", f64::from(u8::from(self.textures))),
            ("has_environment", f64::from(u8::from(self.environment))),
            ("has_transmission", f64::from(u8::from(self.transmission))),
            ("has_clear", f64::from(u8::from(self.clear))),
            ("has_layers", f64::from(u8::from(self.layers))),
            (
                "energy_compensation",
                f64::from(u8::from(self.energy_compensation)),
            ),
            ("has_programs", f64::from(u8::from(self.programs))),
            (
                "has_program_shadows",
                f64::from(u8::from(self.program_shadows)),
            ),
            ("splits_light", f64::from(u8::from(self.splits_light))),
            (
                "leaves_diffuse",
                f64::from(u8::from(self.leaves_scattering())),
            ),
            ("catches_shadows", f64::from(u8::from(self.catches_shadows))),
            ("node_layers", f64::from(self.node_layers)),
        ]
    }
}

/// What the frame needs to know about the scene, and its memory.
#[derive(Debug)]
pub struct GpuScene {
    /// Lights with a place.
    pub light_count: u32,
    /// Lights infinitely far away, but for the environment.
    pub directional_count: u32,
    /// What the kernels must be able to do.
    pub features: SceneFeatures,
    /// The environment's numbers.
    pub environment: GpuEnvironment,
    /// Number of the light group that it is in.
    pub environment_group: u32,
    /// Least and greatest corner of a box around the scene, metres.
    pub bounds: [Vec3; 2],
    /// Centre of a sphere around the scene, metres.
    pub center: Vec3,
    /// Its radius, metres.
    pub radius: f32,
    /// Row of the image table where the images of texture arguments begin.
    pub user_image_base: u32,
    /// Bytes of the image layers.
    pub image_bytes: u64,
    /// Middle and radius of spheres around all that may throw caustics, metres.
    pub(crate) casters: Vec<Vec4>,
    /// Which transparent bodies are where.
    pub(crate) bodies: Bodies,
    /// Where the lights with a place are.
    lamps: Lamps,
    /// What later changes of materials are compared with.
    uploaded: Uploaded,
}

impl GpuScene {
    /// Whether the sky and lamps infinitely far away are all that lights, and no texture program has a say in that.
    pub(crate) fn is_lit_from_afar(&self) -> bool {
        self.light_count == 0 && !self.features.program_shadows && !self.uploaded.glows()
    }

    /// For each light with a place the bodies that it is in, the innermost first: 1 + material, 0 for none. The first call after a change
    /// of lamps or bodies takes a moment.
    pub(crate) fn media_of_lamps(&self) -> &[[u32; 4]] {
        self.lamps.media(&self.bodies)
    }

    /// The order of triangles and instances on the GPU. Its nodes are not kept.
    pub fn hierarchy(&self) -> &SceneBvh {
        self.uploaded.hierarchy()
    }

    /// Uploads the scene and names its resources. `program` says what is known of a material's texture program,
    /// `reads` what of the scene its textures read.
    ///
    /// # Errors
    /// If the scene is empty or exceeds what the device can bind.
    pub fn new(
        device: &Device,
        scene: &Scene,
        reads: &TextureReads<'_>,
        program: impl Fn(u32) -> ProgramTraits,
        resources: &mut Resources,
    ) -> Result<Self, GpuSceneError> {
        if scene.materials.len() > MAX_MATERIALS {
            return Err(GpuSceneError::TooManyMaterials(scene.materials.len()));
        }
        let calls_functions = device.traits().calls_functions;
        let mut bvh = match calls_functions {
            true => SceneBvh::in_scene_order(scene)?,
            false => SceneBvh::build(scene)?,
        };
        let mut traversal = None;
        if calls_functions {
            let rules = ray_rules(scene, &program);
            let made = Arc::new(HostTraversal::new(scene, &bvh, &rules, device.activity())?);
            traversal = Some(made);
        }
        let (lo, hi) = scene.bounds().ok_or(BvhError::Empty)?;
        let (center, radius) = sphere(lo, hi);

        let mut materials: Vec<GpuMaterial> = scene
            .materials
            .iter()
            .enumerate()
            .map(|(i, m)| {
                GpuMaterial::new(
                    m,
                    scene.light_groups.of(LightSource::Material(&m.name)),
                    &program(i as u32),
                )
            })
            .collect();
        let lights = LightTable::gather(scene, &bvh, &program, &mut materials);
        let (triangles, vertices, geometry) =
            Geometry::lay_out(scene, &bvh, &program, reads.attributes);
        let images = GpuImages::new(device, scene, reads)?;
        let environment = GpuEnvironment::new(device, &scene.environment)?;

        resources.set_buffer(
            "nodes",
            device.filled_buffer(
                "the geometry's hierarchy",
                Usage::Storage,
                bytemuck::cast_slice(&bvh.nodes),
            )?,
        );
        resources.set_buffer(
            "triangles",
            device.filled_buffer(
                "triangles",
                Usage::Storage,
                bytemuck::cast_slice(&triangles),
            )?,
        );
        resources.set_buffer(
            "vertices",
            device.filled_buffer("vertices", Usage::Storage, bytemuck::cast_slice(&vertices))?,
        );
        if let Some(traversal) = &traversal {
            traversal.set(resources);
        }
        resources.set_buffer(
            "instances",
            device.filled_buffer(
                "instances",
                Usage::Storage,
                bytemuck::cast_slice(&instances(scene, &bvh)),
            )?,
        );
        resources.set_buffer(
            "materials",
            device.filled_buffer(
                "materials",
                Usage::Storage,
                bytemuck::cast_slice(&materials),
            )?,
        );
        resources.set_buffer(
            "lights",
            device.filled_buffer("lights", Usage::Storage, &lights.bytes())?,
        );
        images.name(resources);
        resources.set_image("albedo_table", albedo::upload(device)?);
        environment.name(resources);
        GpuEnvironment::name_unknown_sky(device, resources)?;
        bvh.nodes = Vec::new();
        let uploaded = Uploaded {
            geometry,
            traversal,
            ..Uploaded::new(scene, &program, materials, bvh)
        };
        Ok(Self {
            features: SceneFeatures {
                energy_compensation: true,
                ..SceneFeatures::of(scene, &program, uploaded.flags(), environment.emits)
            },
            uploaded,
            light_count: lights.placed.len() as u32,
            directional_count: lights.directional.len() as u32,
            environment,
            environment_group: scene.light_groups.of(LightSource::Environment),
            bounds: [lo, hi],
            center,
            radius,
            user_image_base: images.user_base,
            image_bytes: images.bytes,
            casters: casters::targets(scene, &program),
            bodies: Bodies::of(scene, &program),
            lamps: Lamps::new(lights.lamps),
        })
    }
}

/// Centre and radius of a sphere around a box, metres.
fn sphere(lo: Vec3, hi: Vec3) -> (Vec3, f32) {
    // The sum, the difference and its square may be out of range where the corners are not.
    let center = lo * 0.5 + hi * 0.5;
    let radius = 0.5 * (hi.as_dvec3() - lo.as_dvec3()).length();
    (center, (radius as f32).clamp(1e-6, f32::MAX))
}

/// What rays may meet besides what ends them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shadows {
    by_program: bool,
    clear: bool,
    passages: bool,
}

impl Shadows {
    fn of(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Self {
        let clear = (0..)
            .zip(&scene.materials)
            .any(|(i, m)| materials::is_clear(m, &program(i)));
        let by_program = (0..scene.materials.len() as u32).any(|m| {
            let program = program(m);
            program.decides_opacity || program.decides_light && program.brightness > 0.0
        });
        Self {
            by_program,
            clear,
            passages: by_program || clear || has_bodies(scene),
        }
    }
}

/// Whether there are bodies, which may overlap: shells of one mesh may do so among themselves, too.
fn has_bodies(scene: &Scene) -> bool {
    let is_solid: Vec<bool> = scene.materials.iter().map(|m| m.is_solid).collect();
    let has_solid = |mesh: &Mesh| {
        let mut materials = mesh.triangle_materials.iter();
        materials.any(|&material| is_solid[material as usize])
    };
    let of_meshes: Vec<bool> = scene.meshes.iter().map(has_solid).collect();
    (scene.instances.iter()).any(|instance| of_meshes[instance.mesh as usize])
}

fn instances(scene: &Scene, bvh: &SceneBvh) -> Vec<GpuInstance> {
    bvh.instance_order
        .iter()
        .map(|&source| {
            let instance = &scene.instances[source as usize];
            GpuInstance {
                world_from_object: rows(&instance.transform),
                object_from_world: rows(&inverse(&instance.transform)),
                // Instances of empty meshes are not in the order.
                root: bvh.mesh_roots[instance.mesh as usize].unwrap_or(0),
                handedness: lights::handedness(&glam::Mat3::from(instance.transform.matrix3)),
                id: name_id(&instance.name),
                source,
                asset: name_id(instance.asset()),
                motion: 0,
                unused_b: 0,
                unused_c: 0,
            }
        })
        .collect()
}

/// In double precision: strongly scaled instances would lose digits.
pub(crate) fn inverse(transform: &Affine3A) -> Affine3A {
    let wide = glam::DAffine3::from_mat3_translation(
        glam::Mat3::from(transform.matrix3).as_dmat3(),
        Vec3::from(transform.translation).as_dvec3(),
    )
    .inverse();
    Affine3A::from_mat3_translation(wide.matrix3.as_mat3(), wide.translation.as_vec3())
}

/// The rows of a transform, as `Instance` of `geometry.wgsl` has them.
pub fn rows(a: &Affine3A) -> [[f32; 4]; 3] {
    let m = a.matrix3;
    let t = a.translation;
    std::array::from_fn(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]])
}
