//! Shows colours through a view transform: linear Rec.709 comes in, sRGB codes go out, each as three 32-bit floats. `cargo xtask
//! views` compares them with OpenColorIO's.
//!
//! `cargo run --package engine --example view_colors -- agx colors.f32 codes.f32`

use std::error::Error;

use engine::scene::view::{View, ViewTransform};
use engine::view::ViewEncoder;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, colors, codes] = &arguments[..] else {
        return Err("usage: view_colors TRANSFORM COLORS CODES".into());
    };
    let transform = ViewTransform::named(name).ok_or("there is no such view transform")?;
    let view = View {
        transform,
        ..View::default()
    };
    let encoder = ViewEncoder::new(&view);
    let bytes = std::fs::read(colors)?;
    let colors = bytemuck::pod_collect_to_vec::<u8, [f32; 3]>(&bytes);
    let shown: Vec<[f32; 3]> = colors.iter().map(|&color| encoder.encode(color)).collect();
    std::fs::write(codes, bytemuck::cast_slice(&shown))?;
    Ok(())
}
