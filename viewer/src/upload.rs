//! Pictures that another device has rendered, brought to the one that draws the window.

use crate::picture::{Picture, Pixels};

/// A texture for such a picture, which stays while pictures are of its size.
#[derive(Debug, Default)]
pub(crate) struct Upload {
    there: Option<There>,
}

#[derive(Debug)]
struct There {
    view: wgpu::TextureView,
    number: u64,
}

impl Upload {
    /// What is to be drawn for a picture. Pixels are written where they are new; that waits for nothing, and the frame that
    /// is drawn next sees them.
    pub(crate) fn view(
        &mut self,
        picture: &Picture,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> wgpu::TextureView {
        let pixels = match picture {
            Picture::Here(view) => {
                self.there = None;
                return view.clone();
            }
            Picture::Pixels(pixels) => pixels,
        };
        let former = self.there.take();
        let former = former.filter(|there| {
            let texture = there.view.texture();
            [texture.width(), texture.height()] == pixels.size
        });
        let there = match former {
            Some(there) if there.number == pixels.number => there,
            former => {
                let view = former.map_or_else(|| made(device, pixels.size), |there| there.view);
                write(queue, view.texture(), pixels);
                There {
                    view,
                    number: pixels.number,
                }
            }
        };
        self.there.insert(there).view.clone()
    }
}

fn made(device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        // Tests copy from it.
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, pixels: &Pixels) {
    let [width, height] = pixels.size;
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * width),
        rows_per_image: Some(height),
    };
    let target = texture.as_image_copy();
    queue.write_texture(target, &pixels.rgba, layout, extent(pixels.size));
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

/// What a texture holds, by the device's own way to read one.
#[cfg(test)]
pub(crate) fn held(driver: &device::gpu::Gpu, view: &wgpu::TextureView) -> Vec<u8> {
    let [width, height] = [view.texture().width(), view.texture().height()];
    let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = driver.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(stride * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = driver.device().create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(stride),
        rows_per_image: None,
    };
    let target = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    let source = view.texture().as_image_copy();
    encoder.copy_texture_to_buffer(source, target, view.texture().size());
    driver.queue().submit([encoder.finish()]);
    let slice = buffer.slice(..);
    slice.map_async(wgpu::MapMode::Read, |mapped| mapped.expect("mapped"));
    let waited = (driver.device()).poll(wgpu::PollType::wait_indefinitely());
    waited.expect("the device is there");
    let bytes = slice.get_mapped_range().expect("mapped");
    let rows = bytes.chunks(stride as usize);
    rows.flat_map(|row| &row[..4 * width as usize])
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use device::{Device, DeviceChoice};

    use super::*;

    #[test]
    fn pixels_are_written_once_to_a_texture_that_stays() {
        let device = match Device::open(&DeviceChoice::Driver) {
            Ok(device) => device,
            Err(error) => {
                let is_needed = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
                assert!(!is_needed, "{error}");
                return eprintln!("skipped: {error}");
            }
        };
        let driver = device.gpu().expect("a driver");
        let picture = |size: [u32; 2], byte: u8, number| {
            let rgba = vec![byte; 4 * (size[0] * size[1]) as usize];
            Picture::Pixels(Arc::new(Pixels { size, rgba, number }))
        };
        let mut upload = Upload::default();
        let mut shown = |picture| {
            let view = upload.view(&picture, driver.device(), driver.queue());
            let held = held(driver, &view);
            (view, held)
        };
        let (view, bytes) = shown(picture([3, 2], 7, 1));
        assert_eq!(bytes, [7; 24]);
        // What is there already isn't looked at.
        assert_eq!(shown(picture([3, 2], 9, 1)), (view.clone(), vec![7; 24]));
        assert_eq!(shown(picture([3, 2], 9, 2)), (view.clone(), vec![9; 24]));
        let (larger, bytes) = shown(picture([4, 4], 5, 3));
        assert_ne!(larger, view);
        assert_eq!(bytes, [5; 64]);
        let here = Picture::Here(view.clone());
        let here = upload.view(&here, driver.device(), driver.queue());
        assert_eq!(here, view, "what is on the device isn't copied");
        device.check().expect("nothing was refused");
    }
}
