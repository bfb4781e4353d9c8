// The prelude of Patina's texture language. Together with this text, every user texture is a complete and valid
// WGSL module: put it behind (or in front of) the texture's own text, replace the bodies below by your own, and
// the texture runs in any WGSL program. Patina itself replaces the bodies by the renderer's.

// An image, with its wrap and filter modes. Comes as a parameter of `userProc` only.
struct sam2D { patina_image: u32 }

// A colour ramp or curve. Comes as a parameter of `userProc` only.
struct ramp1D { patina_ramp: u32 }

// The value of an attribute at the hit, by one of the names below.
fn readAttr(name: u32) -> vec4f { return vec4f(0.0, 0.0, 0.0, 1.0); }

// A setting of the render, by one of the names below.
fn readGlobal(name: u32) -> vec4f { return vec4f(0.0, 0.0, 0.0, 1.0); }

// The image at uv, linear RGBA; (0, 0) is the outer corner of its first pixel, at the top left.
fn tex2D(image: sam2D, uv: vec2f) -> vec4f { return vec4f(1.0); }

// The same at a given mip level: 0 is the full image, each next one half as wide and high; fractions mix two.
fn tex2DLod(image: sam2D, uv: vec2f, lod: f32) -> vec4f { return vec4f(1.0); }

// Width and height of the full image in pixels.
fn texSize(image: sam2D) -> vec2f { return vec2f(1.0); }

// The ramp's value at t, linear RGBA.
fn rampEval(ramp: ramp1D, t: f32) -> vec4f { return vec4f(t, t, t, 1.0); }

// Attributes, for readAttr. A custom attribute of the mesh is named with a leading underscore, like `_WETNESS`,
// and needs a constant like these where the texture is compiled elsewhere.
const WorldPos = 0u;      // Position in the world, metres; w = 1.
const LocalPos = 1u;      // Position in the object's own space, before its node's transform; w = 1.
const Normal = 2u;        // Shading normal in the world, unit length, on the side of the viewer; w = 0.
const GeomNormal = 3u;    // Normal of the triangle itself in the world, unit length, on the side of the viewer; w = 0.
const LocalNormal = 4u;   // Shading normal in the object's own space, unit length; w = 0.
const Tangent = 5u;       // Tangent in the world, unit length, the mesh's or along its first texture coordinates, turned around where the back is seen; w = handedness of the bitangent, +1 or -1, of which the back has the other one.
const Bitangent = 6u;     // Bitangent in the world, unit length, turned around where the back is seen; w = 0.
const TexCoord0 = 7u;     // First texture coordinates (u, v, 0, 1); v = 0 is the top row of an image.
const TexCoord1 = 8u;     // Second texture coordinates (u, v, 0, 1); equal to the first where the mesh has one set only.
const Color0 = 9u;        // Vertex colour, linear; (1, 1, 1, 1) where the mesh has none.
const ViewDir = 10u;      // Direction from the hit towards where the ray came from, in the world, unit length; w = 0.
const AO = 11u;           // Ambient occlusion of the node's first AO slot in every component: 1 = open, 0 = fully occluded.
const AO1 = 12u;          // Ambient occlusion of the node's second AO slot, like AO.
const Curvature = 13u;    // Mean curvature in 1/metres in every component: positive on ridges, negative in creases.
const Footprint = 14u;    // Width of the pixel here: x in metres in the world, y in uv of TexCoord0, z in the object's own space.
const InstanceId = 15u;   // Number of the instance in every component, exact up to 16 million.
const ObjectRandom = 16u; // Four random numbers in [0, 1), constant over an instance and stable between renders.
const MaterialId = 17u;   // Number of the material in every component.
const FrontFacing = 18u;  // 1 in every component where the front of the triangle is seen, 0 where the back is.
const Bounce = 19u;       // Number of bounces before this hit in every component: 0 for what the camera sees.
const RayKind = 20u;      // What found this hit, in every component: 0 = camera ray, 1 = ray that a surface scattered, 2 = shadow ray (for opacity only).
const Time = 21u;         // Time of the frame in seconds in every component.

// Globals, for readGlobal; Time is there too.
const FrameIndex = 101u;  // Number of the frame in every component, from 0.
const SampleIndex = 102u; // Number of the sample of this pixel in every component, from 0.
const Resolution = 103u;  // Image size in pixels: width, height, 1/width, 1/height.
const CameraPos = 104u;   // Position of the camera in the world, metres; w = 1.
const SceneMin = 105u;    // Least corner of the scene's bounds in the world, metres; w = 1.
const SceneMax = 106u;    // Greatest corner of the scene's bounds in the world, metres; w = 1.
