//! Acceleration structures for rays, and their traversal by SIMD code.
//!
//! A [`Mesh`] holds the triangles of one mesh in a hierarchy of boxes; a [`Scene`] places meshes, and holds its instances in
//! a second hierarchy. Both have eight children a node, uncompressed, which is what a processor reads fastest. A ray is
//! followed alone: one vector instruction tests it against all children of a node, or four triangles of a leaf.
//!
//! ```
//! use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene};
//! use std::{ops::ControlFlow, sync::Arc};
//!
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into);
//! let mesh = Mesh::build(&corners, &[[0, 1, 2]], |_| Flags::NONE, &|_| ControlFlow::Continue(()))?;
//! let instance = Instance::new(glam::Affine3A::from_translation(glam::Vec3::Z), 0);
//! let scene = Scene::new(vec![Arc::new(mesh)], vec![instance], Kernel::best());
//! let ray = Ray { origin: [0.2, 0.3, 0.0], direction: [0.0, 0.0, 1.0], t_min: 0.0, t_max: f32::INFINITY };
//! let hit = scene.closest(&ray, |_| true).expect("it points at the triangle");
//! assert_eq!((hit.t, hit.u, hit.v), (1.0, 0.2, 0.3));
//! # Ok::<(), device::native::accel::BuildError>(())
//! ```
//!
//! What traversal promises, whatever the finite geometry and whatever the rays:
//!
//! - Building takes n log n steps; a hierarchy has at most [`MAX_DEPTH`] levels, so that traversal's stack suffices.
//! - The same input gives the same hierarchy and the same hits for any number of threads.
//! - A ray with a component that is no number hits nothing.

mod bounds;
mod build;
mod layout;
mod mesh;
mod refit;
mod scene;
mod trace;

pub use build::{BuildError, MAX_DEPTH};
pub use mesh::{Flags, Mesh};
pub use scene::{Instance, Scene};
pub use trace::{Bundle, Candidate, Hit, Kernel, Met, Ray};
