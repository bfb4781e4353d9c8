//! Where a picture lies that is to be seen: on the window's own device, or in memory, if another device has rendered it.

use std::fmt;
use std::sync::Arc;

use device::{Device, DeviceError, Image};

/// A picture that is to be seen.
#[derive(Debug, Clone)]
pub enum Picture {
    /// On the device that draws the window: shown without being copied.
    Here(wgpu::TextureView),
    /// In memory: the window brings it to its device.
    Pixels(Arc<Pixels>),
}

/// Pixels in memory.
#[derive(Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Columns and rows.
    pub size: [u32; 2],
    /// 8-bit RGBA as it is shown, row 0 on top.
    pub rgba: Vec<u8>,
    /// Another one with other pixels.
    pub number: u64,
}

impl fmt::Debug for Pixels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pixels")
            .field("size", &self.size)
            .field("number", &self.number)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Picture {
    /// What has been brought to the window's device needn't be brought there again.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Here(view), Self::Here(other)) => view == other,
            (Self::Pixels(pixels), Self::Pixels(other)) => {
                (pixels.size, pixels.number) == (other.size, other.number)
            }
            _ => false,
        }
    }
}

impl Picture {
    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Here(view) => [view.texture().width(), view.texture().height()],
            Self::Pixels(pixels) => pixels.size,
        }
    }

    /// An image as the window takes it: the former picture, if it is that. Pixels are read where the device has no textures, which the
    /// processor does without waiting for anything.
    fn of(
        image: &Image,
        device: &Device,
        former: Option<&Self>,
        number: u64,
    ) -> Result<Self, DeviceError> {
        if let Some(texture) = image.texture() {
            return Ok(match former {
                Some(Self::Here(view)) if view.texture() == texture => Self::Here(view.clone()),
                _ => Self::Here(texture.create_view(&wgpu::TextureViewDescriptor::default())),
            });
        }
        let [width, height, _] = image.size();
        let (size, rgba) = ([width, height], image.read(device)?);
        Ok(Self::Pixels(match former {
            Some(Self::Pixels(former)) if former.size == size && former.rgba == rgba => {
                Arc::clone(former)
            }
            _ => Arc::new(Pixels { size, rgba, number }),
        }))
    }
}

/// What is rendered, what that is compared with, and what lies beside the region.
pub type Pictures = [Option<Picture>; 3];

/// The pictures that are on the board, and how often these have been others.
#[derive(Debug, Default)]
pub(crate) struct Published {
    pub(crate) pictures: Pictures,
    pub(crate) number: u64,
}

impl Published {
    /// Others take their place, if they are others.
    pub(crate) fn show(
        &mut self,
        images: [Option<&Image>; 3],
        device: &Device,
    ) -> Result<(), DeviceError> {
        let number = self.number + 1;
        let mut pictures = Pictures::default();
        for (place, image) in images.into_iter().enumerate() {
            let Some(image) = image else {
                continue;
            };
            let former = self.pictures[place].as_ref();
            pictures[place] = Some(Picture::of(image, device, former, number)?);
        }
        if pictures != self.pictures {
            (self.pictures, self.number) = (pictures, number);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use device::{DeviceChoice, Format, ImageUse};

    use super::*;

    fn image(device: &Device, size: [u32; 2]) -> Image {
        let size = [size[0], size[1], 1];
        let image = device.image("a picture", ImageUse::Shown, size, Format::Rgba8Unorm);
        image.expect("memory")
    }

    fn pixels(picture: Option<&Picture>) -> &Arc<Pixels> {
        match picture {
            Some(Picture::Pixels(pixels)) => pixels,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_the_processor_renders_is_handed_over_once() {
        let device = Device::open(&DeviceChoice::Native(1)).expect("the processor");
        let (now, before) = (image(&device, [3, 2]), image(&device, [1, 1]));
        now.write(&device, [0, 0, 0], [3, 2], &[7; 24]);
        let mut published = Published::default();
        let images = [Some(&now), Some(&before), None];
        published.show(images, &device).expect("memory");
        let first = Arc::clone(pixels(published.pictures[0].as_ref()));
        assert_eq!((first.size, &*first.rgba), ([3, 2], &[7; 24][..]));
        assert_eq!(published.pictures[2], None);
        assert_eq!(published.number, 1);
        // The same again is nothing new.
        published.show(images, &device).expect("memory");
        assert!(Arc::ptr_eq(&first, pixels(published.pictures[0].as_ref())));
        assert_eq!(published.number, 1);

        now.write(&device, [2, 1, 0], [1, 1], &[9; 4]);
        let kept = published.pictures[1].clone();
        published.show(images, &device).expect("memory");
        assert_eq!(published.number, 2);
        assert_eq!(
            published.pictures[1], kept,
            "what stays isn't taken over anew"
        );
        assert_eq!(
            first.rgba, [7; 24],
            "the window has what it took until it takes another"
        );
        let second = pixels(published.pictures[0].as_ref());
        assert_eq!(second.rgba[20..], [9; 4]);

        // Fewer are others, too.
        let alone = [Some(&now), None, None];
        published.show(alone, &device).expect("memory");
        assert_eq!((published.number, &published.pictures[1]), (3, &None));
    }
}
