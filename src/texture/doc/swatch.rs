//! One texture on a square, without a renderer: its values at the pixels of a square metre, or of a ball.

use device::Device;
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use texgen::{OutputType, ParameterType, TextureType, Widget};

use crate::failure::Failure;

use super::shown;

/// Side of a swatch, pixels.
pub(super) const SIDE: usize = 144;
/// Points along a side of a pixel.
const FINE: usize = 2;
/// Behind a ball, linear.
const BEHIND: f32 = 0.03;

/// Whether what it gives is a colour, rather than numbers of several meanings.
pub(super) fn is_color(texture: &TextureType) -> bool {
    let gives = matches!(texture.output(), OutputType::Vec3 | OutputType::Vec4);
    let speaks_of_colour = texture.parameters().iter().any(|parameter| {
        parameter.widget == Widget::Color
            || matches!(parameter.ty, ParameterType::Ramp | ParameterType::Image)
    });
    let is_named = [
        "blackbody",
        "combine",
        "wavelength",
        "white_noise",
        "magic",
        "random_pick",
    ]
    .contains(&texture.name());
    gives && (speaks_of_colour || is_named)
}

/// The pixels of a swatch, linear, row by row. `image` is what image parameters show.
///
/// # Errors
/// The device refuses.
pub(super) fn swatch(
    device: &Device,
    sources: &TextureSources,
    texture: &TextureType,
    image: &str,
) -> Result<Vec<[f32; 3]>, Failure> {
    let look = shown::look(texture.name())?;
    let subject = match &look {
        Some(look) => Subject::Node(shown::NODE, look),
        None => Subject::Texture(texture.name()),
    };
    let mut evaluator = Evaluator::new(device, Isolated::new(subject, sources)?);
    for parameter in texture.parameters() {
        if parameter.ty == ParameterType::Image {
            evaluator.set(&parameter.name, image)?;
        }
    }
    let group = texture.group().unwrap_or_default();
    let on_ball = matches!(group, "weathering" | "surface") && !takes_uv(texture);
    let places: Vec<Option<Place>> = (0..SIDE * SIDE * FINE * FINE)
        .map(|i| {
            let (row, column) = (i / (SIDE * FINE), i % (SIDE * FINE));
            let at = |n: usize| (n as f32 + 0.5) / (SIDE * FINE) as f32;
            place(at(column), at(row), on_ball)
        })
        .collect();
    let points: Vec<Point> = places
        .iter()
        .flatten()
        .map(|place| place.point.clone())
        .collect();
    let values = evaluator.evaluate(&points)?;
    let mut shown = as_colours(texture, &values);
    if let Some(look) = look.as_ref().filter(|look| shown::has_input(look)) {
        let input = Isolated::new(Subject::Node(shown::INPUT, look), sources)?;
        let values = Evaluator::new(device, input).evaluate(&points)?;
        let sides = shown.iter_mut().zip(values).enumerate();
        for (_, (shown, value)) in sides.filter(|(i, _)| i % (SIDE * FINE) < SIDE * FINE / 2) {
            *shown = [value[0], value[1], value[2]];
        }
    }
    let mut shown = shown.into_iter();
    let fine: Vec<[f32; 3]> = (places.iter())
        .map(|place| match place {
            Some(place) => shown.next().unwrap_or_default().map(|v| v * place.light),
            None => [BEHIND; 3],
        })
        .collect();
    Ok((0..SIDE * SIDE)
        .map(|i| {
            let (row, column) = (i / SIDE * FINE, i % SIDE * FINE);
            let mut sum = [0.0; 3];
            for k in 0..FINE * FINE {
                let one = fine[(row + k / FINE) * SIDE * FINE + column + k % FINE];
                sum = std::array::from_fn(|c| sum[c] + one[c].clamp(0.0, 1.0));
            }
            sum.map(|v| v / (FINE * FINE) as f32)
        })
        .collect())
}

fn takes_uv(texture: &TextureType) -> bool {
    (texture.parameters().iter()).any(|parameter| parameter.name == "texcoord")
}

/// Values as colours: colours as they are, directions around grey, places as a chequered space, numbers as greys by the first of them.
fn as_colours(texture: &TextureType, values: &[[f32; 4]]) -> Vec<[f32; 3]> {
    let group = texture.group().unwrap_or_default();
    if group == "coordinates" {
        return values
            .iter()
            .map(|&[x, y, z, _]| chequered([x, y, z]))
            .collect();
    }
    let is_direction = ["normal_map", "flakes", "height_to_normal"].contains(&texture.name());
    if is_direction {
        return (values.iter())
            .map(|&[x, y, z, _]| [x, y, z].map(|v| (0.5 + 0.5 * v).powf(2.2)))
            .collect();
    }
    if is_color(texture) {
        return values.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
    }
    // Small heights, and what is greater than 1, are stretched.
    let bounds = values.iter().fold((f32::MAX, f32::MIN), |(low, high), v| {
        (low.min(v[0]), high.max(v[0]))
    });
    let (low, high) = match bounds {
        (low, high) if low < -0.01 || high > 1.5 || (high < 0.1 && high > low) => (low, high),
        _ => (0.0, 1.0),
    };
    // Cells, tiles and planks also give a random number, which tells them apart.
    let tint = match texture.output() {
        OutputType::Vec3 | OutputType::Vec4 => 0.5,
        OutputType::F32 | OutputType::Vec2 => 0.0,
    };
    let grey = |v: &[f32; 4]| {
        let plain = ((v[0] - low) / (high - low)).clamp(0.0, 1.0).powf(2.2);
        plain * (1.0 - tint + tint * v[2].clamp(0.0, 1.0))
    };
    values.iter().map(|v| [grey(v); 3]).collect()
}

fn chequered(p: [f32; 3]) -> [f32; 3] {
    let cells = p.map(|v| (4.0 * v).floor());
    let dark = (cells.iter().sum::<f32>()).rem_euclid(2.0) < 0.5;
    let fine = p.map(|v| 0.35 + 0.4 * (v - v.floor()));
    fine.map(|v| if dark { 0.35 * v } else { v })
}

/// Where a pixel lies, and how bright it is.
struct Place {
    point: Point,
    light: f32,
}

/// The place at (`x`, `y`) of a square with (0, 0) at its upper left; none beside the ball.
fn place(x: f32, y: f32, on_ball: bool) -> Option<Place> {
    let pixel = 1.0 / (SIDE * FINE) as f32;
    let tile = ((x * 4.0) as u32 + 4 * (y * 4.0) as u32) as f32;
    let random: [f32; 4] = std::array::from_fn(|k| (tile * 0.618_034 + 0.37 * k as f32).fract());
    let base = Point::new()
        .with("TexCoord0", &[x, y])
        .with("Footprint", &[pixel, pixel, pixel, 0.0])
        .with("ObjectRandom", &random)
        .with("InstanceId", &[tile; 4])
        .with("ViewDir", &[0.0, 0.0, 1.0])
        .with("Time", &[0.4; 4]);
    let (px, py) = (x - 0.5, 0.5 - y);
    if !on_ball {
        let point = (base.with("WorldPos", &[px, py, 0.0]))
            .with("Normal", &[0.0, 0.0, 1.0])
            .with("Tangent", &[1.0, 0.0, 0.0, -1.0]);
        return Some(Place { point, light: 1.0 });
    }
    // A ball with a groove around it, where it is occluded, and rims beside that.
    let [nx, ny] = [px / 0.48, py / 0.48];
    let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
    if nz <= 0.0 {
        return None;
    }
    let bell = |at: f32, width: f32| (-(at / width) * (at / width)).exp();
    let open = 1.0 - 0.75 * bell(ny + 0.25, 0.07);
    let rim = 24.0 * bell((ny + 0.25).abs() - 0.2, 0.05);
    let point = (base.with("WorldPos", &[0.48 * nx, 0.48 * ny, 0.48 * nz]))
        .with("Normal", &[nx, ny, nz])
        .with("Tangent", &[nz, 0.0, -nx, -1.0])
        .with("AO", &[open; 4])
        .with("Curvature", &[2.0 + rim; 4]);
    let light = 0.35 + 0.65 * (-0.4 * nx + 0.5 * ny + 0.77 * nz).max(0.0);
    Some(Place { point, light })
}
