//! Draws what egui wants drawn, without a device: the same picture everywhere.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use egui::epaint::{ImageData, Mesh, Primitive, Vertex};
use egui::{Color32, ColorImage, Pos2, TextureId, TexturesDelta, pos2};
use egui_kittest::{Harness, TestRenderer};

/// Keeps the textures that the harness brings.
#[derive(Clone, Default)]
pub(crate) struct Painter(Rc<RefCell<HashMap<TextureId, ColorImage>>>);

impl TestRenderer for Painter {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut textures = self.0.borrow_mut();
        for (id, parts) in &delta.set {
            for part in parts {
                let ImageData::Color(image) = &part.image;
                match part.pos {
                    None => drop(textures.insert(*id, image.as_ref().clone())),
                    Some(corner) => {
                        if let Some(whole) = textures.get_mut(id) {
                            put(whole, image, corner);
                        }
                    }
                }
            }
        }
        delta.clear();
    }
}

/// A part of a texture is new.
fn put(whole: &mut ColorImage, part: &ColorImage, [left, top]: [usize; 2]) {
    for y in 0..part.size[1] {
        for x in 0..part.size[0] {
            whole[(left + x, top + y)] = part[(x, y)];
        }
    }
}

impl Painter {
    /// What was shown in the last frame, RGB.
    pub(crate) fn paint<S>(&self, harness: &Harness<'_, S>) -> image::RgbImage {
        let ctx = &harness.ctx;
        let size = ctx.content_rect().size();
        let (width, height) = (size.x as usize, size.y as usize);
        let mut target = ColorImage::filled([width, height], Color32::BLACK);
        let shapes = harness.output().shapes.clone();
        for primitive in ctx.tessellate(shapes, 1.0) {
            let Primitive::Mesh(mesh) = &primitive.primitive else {
                continue;
            };
            if let Some(texture) = self.0.borrow().get(&mesh.texture_id) {
                draw(&mut target, mesh, texture, primitive.clip_rect);
            }
        }
        let pixels = target.pixels.iter().flat_map(|p| [p.r(), p.g(), p.b()]);
        image::RgbImage::from_raw(width as u32, height as u32, pixels.collect())
            .expect("so many bytes")
    }
}

fn draw(target: &mut ColorImage, mesh: &Mesh, texture: &ColorImage, clip: egui::Rect) {
    for corners in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
        let area = cross(a.pos, b.pos, c.pos);
        if area == 0.0 {
            continue;
        }
        let bounds = egui::Rect::from_points(&[a.pos, b.pos, c.pos]).intersect(clip);
        let [width, height] = target.size;
        // Numbers below 0 become 0.
        let last = |end: f32, size: usize| (end.ceil() as usize).min(size);
        for y in bounds.top() as usize..last(bounds.bottom(), height) {
            for x in bounds.left() as usize..last(bounds.right(), width) {
                let at = pos2(x as f32 + 0.5, y as f32 + 0.5);
                let weights = [
                    cross(b.pos, c.pos, at) / area,
                    cross(c.pos, a.pos, at) / area,
                    cross(a.pos, b.pos, at) / area,
                ];
                // A pixel on an edge that two triangles share belongs to one of them.
                let is_in = corner_rule(
                    weights,
                    [(b.pos, c.pos), (c.pos, a.pos), (a.pos, b.pos)],
                    area,
                );
                if is_in && clip.contains(at) {
                    let color = shade([a, b, c], weights, texture);
                    let pixel = &mut target[(x, y)];
                    *pixel = pixel.blend(color);
                }
            }
        }
    }
}

fn corner_rule(weights: [f32; 3], edges: [(Pos2, Pos2); 3], area: f32) -> bool {
    weights
        .into_iter()
        .zip(edges)
        .all(|(weight, (start, end))| {
            let along = (end - start) * area.signum();
            let is_kept = along.y > 0.0 || (along.y == 0.0 && along.x < 0.0);
            weight > 0.0 || (weight == 0.0 && is_kept)
        })
}

fn cross(a: Pos2, b: Pos2, c: Pos2) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

fn shade(corners: [Vertex; 3], weights: [f32; 3], texture: &ColorImage) -> Color32 {
    let mix = |of: &dyn Fn(&Vertex) -> f32| -> f32 {
        corners.iter().zip(weights).map(|(v, w)| of(v) * w).sum()
    };
    let texel = sample(texture, mix(&|v| v.uv.x), mix(&|v| v.uv.y));
    let channel = |i: usize| {
        let tint = mix(&|v| f32::from(v.color.to_array()[i]));
        (tint * texel[i] / 255.0).round() as u8
    };
    Color32::from_rgba_premultiplied(channel(0), channel(1), channel(2), channel(3))
}

/// Between four texels, 0 to 255.
fn sample(texture: &ColorImage, u: f32, v: f32) -> [f32; 4] {
    let [width, height] = texture.size;
    let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let mut sum = [0.0; 4];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let (fx, fy) = (x - left, y - top);
        let weight = if dx == 1 { fx } else { 1.0 - fx } * if dy == 1 { fy } else { 1.0 - fy };
        let column = (left as isize + dx).clamp(0, width as isize - 1) as usize;
        let row = (top as isize + dy).clamp(0, height as isize - 1) as usize;
        let texel = texture[(column, row)].to_array();
        for (sum, texel) in sum.iter_mut().zip(texel) {
            *sum += weight * f32::from(texel);
        }
    }
    sum
}
