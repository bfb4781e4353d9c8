//! All layers, one declaration each.

use scene::{Instance, Material};

use crate::film::Film;

use super::declaration::{CAUGHT, Layer, Rule, SHADOW_CATCHER, VECTOR};

/// The layer of a group of lights, by its number; 0 is what belongs to none. A piece of light goes to that of its own group alone.
macro_rules! light_group {
    ($number:literal) => {
        Layer {
            name: concat!("light_group_", $number),
            pass: concat!("Combined_", $number),
            channels: "RGB",
            rule: Rule::Light {
                wgsl: "found.light",
                color: None,
            },
            help: "light of one group",
        }
    };
}

/// The layers of a node of the look, by their number from 1 on: its value's first three components, and the fourth.
macro_rules! node_layer {
    ($number:literal) => {
        Layer {
            name: concat!("node_", $number),
            pass: concat!("Node ", $number),
            channels: "RGB",
            rule: Rule::Mean(concat!("node_value(at, ", $number, "u).xyz")),
            help: "value of a node",
        }
    };
    ($number:literal, alpha) => {
        Layer {
            name: concat!("node_", $number, "_alpha"),
            pass: concat!("Node ", $number),
            channels: "A",
            rule: Rule::Mean(concat!("node_value(at, ", $number, "u).w")),
            help: "fourth component of the value of a node",
        }
    };
}

/// All layers. The picture itself is the first and always there.
pub static LAYERS: [Layer; 67] = [
    Layer {
        name: "combined",
        pass: "Combined",
        channels: "RGB",
        rule: Rule::Derived(Film::pixel_mean),
        help: "the picture: linear Rec.709 radiance",
    },
    Layer {
        name: "depth",
        pass: "Depth",
        channels: "Z",
        rule: Rule::First {
            wgsl: "dot(frame.camera_position - at.surface.position, frame.camera_back)",
            empty: 1e10,
        },
        help: "distance from the plane of the camera, metres; 1e10 where nothing is",
    },
    Layer {
        name: "position",
        pass: "Position",
        channels: "XYZ",
        rule: Rule::First {
            wgsl: "at.surface.position",
            empty: 0.0,
        },
        help: "place in the world, metres",
    },
    Layer {
        name: "normal",
        pass: "Normal",
        channels: "XYZ",
        rule: Rule::Mean("normal"),
        help: "shading normal in the world, towards the viewer, normal maps and textures included",
    },
    Layer {
        name: "uv",
        pass: "UV",
        channels: "UVA",
        rule: Rule::First {
            wgsl: "vec3f(first_uv(at), 1.0)",
            empty: 0.0,
        },
        help: "first texture coordinates, v upwards, and 1 where something is",
    },
    Layer {
        name: "albedo",
        pass: "Denoising Albedo",
        channels: "RGB",
        rule: Rule::Mean("base"),
        help: "base colour, textures included",
    },
    Layer {
        name: "denoising_normal",
        pass: "Denoising Normal",
        channels: "XYZ",
        rule: Rule::Mean("in_camera_axes(normal)"),
        help: "as `normal`, along the axes of the camera: right, up, towards the viewer",
    },
    Layer {
        name: "denoising_depth",
        pass: "Denoising Depth",
        channels: "Z",
        rule: Rule::Mean("dot(frame.camera_position - at.surface.position, frame.camera_back)"),
        help: "as `depth`, but the mean of all samples; 0 where nothing is",
    },
    Layer {
        name: "diffuse_direct",
        pass: "Diffuse Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(diffuse(found), found)",
            color: Some("diffuse_color"),
        },
        help: "light that the first surface scatters diffusely, straight from a lamp; divided by `diffuse_color`",
    },
    Layer {
        name: "diffuse_indirect",
        pass: "Diffuse Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(diffuse(found), found)",
            color: Some("diffuse_color"),
        },
        help: "the same from other surfaces; divided by `diffuse_color`",
    },
    Layer {
        name: "diffuse_color",
        pass: "Diffuse Color",
        channels: "RGB",
        rule: Rule::Mean("colors.diffuse"),
        help: "the colour of diffuse scattering at the first surface",
    },
    Layer {
        name: "glossy_direct",
        pass: "Glossy Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(glossy(found), found)",
            color: Some("glossy_color"),
        },
        help: "light that it reflects, straight from a lamp; divided by `glossy_color`",
    },
    Layer {
        name: "glossy_indirect",
        pass: "Glossy Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(glossy(found), found)",
            color: Some("glossy_color"),
        },
        help: "the same from other surfaces; divided by `glossy_color`",
    },
    Layer {
        name: "glossy_color",
        pass: "Glossy Color",
        channels: "RGB",
        rule: Rule::Mean("colors.glossy"),
        help: "the colour of its reflection, seen straight on",
    },
    Layer {
        name: "transmission_direct",
        pass: "Transmission Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(transmission(found), found)",
            color: Some("transmission_color"),
        },
        help: "light that it lets through, straight from a lamp; divided by `transmission_color`",
    },
    Layer {
        name: "transmission_indirect",
        pass: "Transmission Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(transmission(found), found)",
            color: Some("transmission_color"),
        },
        help: "the same from other surfaces; divided by `transmission_color`",
    },
    Layer {
        name: "transmission_color",
        pass: "Transmission Color",
        channels: "RGB",
        rule: Rule::Mean("colors.transmission"),
        help: "the colour of what it lets through",
    },
    Layer {
        name: "emission",
        pass: "Emission",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "emitted(found)",
            color: None,
        },
        help: "radiance that the first surface emits towards the viewer",
    },
    Layer {
        name: "environment",
        pass: "Environment",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "from_far(found)",
            color: None,
        },
        help: "radiance of the environment where nothing is in front of it",
    },
    Layer {
        name: "alpha",
        pass: "Combined",
        channels: "A",
        rule: Rule::Mean("1.0"),
        help: "share of the samples that meet a surface",
    },
    Layer {
        name: "crypto_object",
        pass: "CryptoObject",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "instances[at.instance].id",
            names: |scene| (scene.instances.iter()).map(|i| i.name.as_str()).collect(),
        },
        help: "Cryptomatte: hashes of the names of objects, and how much of the pixel each covers",
    },
    Layer {
        name: "crypto_material",
        pass: "CryptoMaterial",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "materials[at.material].id",
            names: |scene| (scene.materials.iter()).map(Material::matte_name).collect(),
        },
        help: "Cryptomatte: the same of materials",
    },
    Layer {
        name: "crypto_asset",
        pass: "CryptoAsset",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "instances[at.instance].asset",
            names: |scene| scene.instances.iter().map(Instance::asset).collect(),
        },
        help: "Cryptomatte: the same of the topmost nodes that objects hang below",
    },
    Layer {
        name: "object_index",
        pass: "Object Index",
        channels: "X",
        rule: Rule::First {
            wgsl: "f32(instances[at.instance].source + 1u)",
            empty: 0.0,
        },
        help: "number of the object in the scene, from 1 on; 0 where nothing is",
    },
    Layer {
        name: "material_index",
        pass: "Material Index",
        channels: "X",
        rule: Rule::First {
            wgsl: "f32(at.material + 1u)",
            empty: 0.0,
        },
        help: "number of the material in the scene, from 1 on; 0 where nothing is",
    },
    Layer {
        name: SHADOW_CATCHER,
        pass: "Shadow Catcher",
        channels: "RGB",
        rule: Rule::Derived(Film::shadow_factor),
        help: "what a shadow leaves of the light on a shadow catcher; 1 where there is none",
    },
    Layer {
        name: "shadow_catcher_alpha",
        pass: "Shadow Catcher",
        channels: "A",
        rule: Rule::Derived(|film, pixel| [film.shadow(pixel), 0.0, 0.0]),
        help: "what it keeps from it",
    },
    Layer {
        name: CAUGHT,
        pass: "Caught",
        channels: "A",
        rule: Rule::Mean("first_caught(at)"),
        help: "share of the samples that meet a shadow catcher",
    },
    Layer {
        name: "caught_light",
        pass: "Caught Light",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "select(vec3f(0.0), found.light, is_caught(slot))",
            color: None,
        },
        help: "what is seen of shadow catchers",
    },
    Layer {
        name: "caught_shadowless",
        pass: "Caught Shadowless",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "found.shadowless",
            color: None,
        },
        help: "light of lamps on shadow catchers, as if nothing were in its way",
    },
    Layer {
        name: "caught_arrived",
        pass: "Caught Arrived",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "found.arrived",
            color: None,
        },
        help: "what arrives of it",
    },
    Layer {
        name: VECTOR,
        pass: "Vector",
        channels: "XY",
        rule: Rule::First {
            wgsl: "first_motion(at).xy",
            empty: 0.0,
        },
        help: "where the surface was a frame ago, seen from where it is: pixels to the right and up",
    },
    Layer {
        name: "vector_next",
        pass: "Vector",
        channels: "ZW",
        rule: Rule::First {
            wgsl: "first_motion(at).zw",
            empty: 0.0,
        },
        help: "where it is, seen from where it will be in a frame",
    },
    light_group!(0),
    light_group!(1),
    light_group!(2),
    light_group!(3),
    light_group!(4),
    light_group!(5),
    light_group!(6),
    light_group!(7),
    light_group!(8),
    light_group!(9),
    light_group!(10),
    light_group!(11),
    light_group!(12),
    light_group!(13),
    light_group!(14),
    light_group!(15),
    node_layer!(1),
    node_layer!(1, alpha),
    node_layer!(2),
    node_layer!(2, alpha),
    node_layer!(3),
    node_layer!(3, alpha),
    node_layer!(4),
    node_layer!(4, alpha),
    node_layer!(5),
    node_layer!(5, alpha),
    node_layer!(6),
    node_layer!(6, alpha),
    node_layer!(7),
    node_layer!(7, alpha),
    node_layer!(8),
    node_layer!(8, alpha),
    Layer {
        name: "samples",
        pass: "Debug Sample Count",
        channels: "X",
        rule: Rule::Derived(|film, pixel| [film.samples(pixel) as f32, 0.0, 0.0]),
        help: "number of samples",
    },
    Layer {
        name: "variance",
        pass: "Variance",
        channels: "RGB",
        rule: Rule::Derived(|film, pixel| film.pixel_error(pixel).map(|error| error * error)),
        help: "variance of the pixel's mean radiance; infinite below two samples",
    },
];
