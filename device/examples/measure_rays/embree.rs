//! Embree 4, loaded at run time, to compare with.

use std::{
    ffi::{CString, c_char, c_int, c_void},
    mem::transmute,
    ptr::null,
};

use device::native::accel::Ray;

use crate::{
    rays::{Trace, processor_seconds},
    scenes::Geometry,
};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Quality {
    Medium = 1,
    High = 2,
}

type Handle = *mut c_void;

/// `RTCRayHit`.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    uv: [f32; 2],
    primitive: u32,
    geometry: u32,
    instance: [u32; 2],
    spare: [u32; 11],
}

impl RayHit {
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            t_near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            t_far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            primitive: u32::MAX,
            geometry: u32::MAX,
            instance: [u32::MAX; 2],
            spare: [0; 11],
        }
    }
}

unsafe extern "C" {
    fn dlopen(file: *const c_char, flags: c_int) -> Handle;
    fn dlsym(library: Handle, name: *const c_char) -> Handle;
}

type Query = unsafe extern "C" fn(Handle, *mut RayHit, *const c_void);

pub(crate) struct Scene {
    scene: Handle,
    intersect: Query,
    occluded: Query,
}

impl Scene {
    /// On one thread, as one geometry; by single rays it is traced as it is by default.
    pub(crate) fn build(library: &str, geometry: &Geometry, quality: Quality) -> Self {
        let path = CString::new(library).expect("a path");
        // SAFETY: a path that ends in 0; 2 is RTLD_NOW.
        let library = unsafe { dlopen(path.as_ptr(), 2) };
        assert!(!library.is_null(), "the library can't be loaded");
        let symbol = |name: &str| {
            let name = CString::new(name).expect("a name");
            // SAFETY: an open library, and a name that ends in 0.
            let symbol = unsafe { dlsym(library, name.as_ptr()) };
            assert!(!symbol.is_null(), "the library has no {name:?}");
            symbol
        };
        // SAFETY: the types of Embree 4's `rtcore_*.h`; buffers are as large as is asked for.
        unsafe {
            type OfHandle = unsafe extern "C" fn(Handle) -> Handle;
            let new_device: unsafe extern "C" fn(*const c_char) -> Handle =
                transmute(symbol("rtcNewDevice"));
            let new_scene: OfHandle = transmute(symbol("rtcNewScene"));
            let set_quality: unsafe extern "C" fn(Handle, c_int) =
                transmute(symbol("rtcSetSceneBuildQuality"));
            let new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle =
                transmute(symbol("rtcNewGeometry"));
            let new_buffer: unsafe extern "C" fn(
                Handle,
                c_int,
                u32,
                c_int,
                usize,
                usize,
            ) -> Handle = transmute(symbol("rtcSetNewGeometryBuffer"));
            let commit_geometry: OfHandle = transmute(symbol("rtcCommitGeometry"));
            let attach: unsafe extern "C" fn(Handle, Handle) -> u32 =
                transmute(symbol("rtcAttachGeometry"));
            let commit_scene: OfHandle = transmute(symbol("rtcCommitScene"));

            let device = new_device(null());
            let scene = new_scene(device);
            set_quality(scene, quality as c_int);
            let mesh = new_geometry(device, 0);
            let (positions, triangles) = (&geometry.positions, &geometry.triangles);
            let to = new_buffer(mesh, 1, 0, 0x9003, 12, positions.len());
            to.cast::<glam::Vec3>()
                .copy_from_nonoverlapping(positions.as_ptr(), positions.len());
            let to = new_buffer(mesh, 0, 0, 0x5003, 12, triangles.len());
            to.cast::<[u32; 3]>()
                .copy_from_nonoverlapping(triangles.as_ptr(), triangles.len());
            commit_geometry(mesh);
            attach(scene, mesh);
            let start = std::time::Instant::now();
            commit_scene(scene);
            println!(
                "Embree, {quality:?}: built in {:.0} ms",
                start.elapsed().as_secs_f64() * 1e3
            );
            Self {
                scene,
                intersect: transmute::<Handle, Query>(symbol("rtcIntersect1")),
                occluded: transmute::<Handle, Query>(symbol("rtcOccluded1")),
            }
        }
    }

    /// Distance of the closest hit, or infinity.
    pub(crate) fn closest(&self, ray: &Ray) -> f32 {
        let mut ray = RayHit::new(ray);
        // SAFETY: a committed scene and a whole ray.
        unsafe { (self.intersect)(self.scene, &mut ray, null()) };
        if ray.geometry == u32::MAX {
            f32::INFINITY
        } else {
            ray.t_far
        }
    }

    pub(crate) fn tracer(self) -> Trace<'static> {
        Box::new(move |rays, is_any| {
            let query = if is_any {
                self.occluded
            } else {
                self.intersect
            };
            processor_seconds(|| {
                let hits = rays.iter().filter(|ray| {
                    let mut ray = RayHit::new(ray);
                    // SAFETY: as above.
                    unsafe { query(self.scene, &mut ray, null()) };
                    ray.geometry != u32::MAX || ray.t_far < 0.0
                });
                std::hint::black_box(hits.count());
            })
        })
    }
}
