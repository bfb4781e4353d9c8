//! Rays against a scene. The code is generic over the instruction set and inlined into one function for each; the
//! processor's features choose among these at run time.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod bundle;
mod lanes;
mod levels;
mod nodes;
mod pending;
mod portable;
mod stack;
mod triangles;

use std::fmt;

use bytemuck::{Pod, Zeroable};

use super::Scene;

/// A ray, in the world. Its direction needn't have unit length: distances are in units of it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
    /// Hits are farther than this, which is not negative.
    pub t_min: f32,
    /// Hits are nearer than this.
    pub t_max: f32,
}

/// Up to four rays from one place, all as long, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bundle {
    /// Where they start.
    pub origin: [f32; 3],
    /// Where each goes: x of all, y of all, z of all.
    pub directions: [[f32; Self::RAYS]; 3],
    /// Hits are nearer than this, in units of the directions.
    pub t_max: f32,
    /// Which of the rays there are, a bit for each.
    pub asked: u32,
}

impl Bundle {
    /// Most rays of a bundle.
    pub const RAYS: usize = 4;
}

/// What rays of a bundle meet, a bit for each ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Met {
    /// A triangle that is not deferred.
    pub opaque: u32,
    /// A triangle that is: known of those rays that don't meet another one.
    pub deferred: u32,
}

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance, in units of the ray's direction.
    pub t: f32,
    /// Weight of the triangle's second corner.
    pub u: f32,
    /// Weight of its third corner.
    pub v: f32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Index of the instance in the scene.
    pub instance: u32,
}

/// A hit that a filter judges. It needn't be the closest.
pub type Candidate = Hit;

/// The instruction set by which rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kernel(Set);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Set {
    /// Exists only where the processor has it: see [`Kernel::best`].
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Kernel {
    /// The fastest that this processor has.
    pub fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if avx2::is_available() {
            return Self(Set::Avx2);
        }
        Self::portable()
    }

    /// The one that needs only what the program is compiled for.
    pub fn portable() -> Self {
        Self(Set::Portable)
    }

    #[inline(always)]
    pub(super) fn trace<const ANY: bool>(
        self,
        scene: &Scene,
        ray: &Ray,
        only: Option<u32>,
        filter: &impl Fn(&Candidate) -> bool,
    ) -> Option<Hit> {
        let hit = match self.0 {
            // SAFETY: the value exists, so the processor has these features.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { avx2::trace::<ANY>(scene, ray, only, filter) },
            Set::Portable => portable::trace::<ANY>(scene, ray, only, filter),
        };
        hit.as_ref().map(Hit::read_one_by_one)
    }

    pub(super) fn trace_bundle(self, scene: &Scene, bundle: &Bundle, only: Option<u32>) -> Met {
        match self.0 {
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { avx2::trace_bundle(scene, bundle, only) },
            Set::Portable => portable::trace_bundle(scene, bundle, only),
        }
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "vectors of 8 by AVX2",
            Set::Portable => "vectors of 4",
        })
    }
}
