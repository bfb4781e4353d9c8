//! The picture as the window's renderer knows it: by textures on the device that draws.

use eframe::egui_wgpu::RenderState;
use egui::TextureId;

use crate::blit::Blit;
use crate::link::Shown;
use crate::picture::Picture;
use crate::upload::Upload;
use crate::viewer::{PictureIds, Viewer};

/// What is shown, and what it is shown by.
#[derive(Debug)]
pub(crate) struct Screen {
    blit: Option<Blit>,
    /// Of the picture, of what it is compared with, and of what lies beside the region.
    places: [Place; 3],
    /// Of what is shown.
    number: u64,
}

#[derive(Debug, Default)]
struct Place {
    /// Kept where there is nothing for now.
    known: Option<(TextureId, wgpu::TextureView)>,
    upload: Upload,
}

impl Screen {
    /// For a window that is drawn by wgpu.
    pub(crate) fn new(state: Option<&RenderState>) -> Self {
        Self {
            blit: state.and_then(|state| Blit::new(&state.device, state.target_format)),
            places: Default::default(),
            number: 0,
        }
    }

    /// Whether it is another picture than the one that is shown, or lies in another texture.
    pub(crate) fn is_new(&self, shown: &Shown) -> bool {
        shown.number != self.number
    }

    /// Brings it to the window's device, unless it lies there, and makes it known to the window's renderer.
    pub(crate) fn show(&mut self, shown: &Shown, state: &RenderState, viewer: &mut Viewer) {
        self.number = shown.number;
        let [now, before, beside] = &shown.pictures;
        let [first, second, third] = &mut self.places;
        let (id, is_other) = first.show(now.as_ref(), state);
        if let (true, Some(blit), Some((_, view))) = (is_other, &self.blit, &first.known) {
            viewer.drawn = Some(blit.bind(&state.device, view));
        }
        let (before, _) = second.show(before.as_ref(), state);
        let (beside, _) = third.show(beside.as_ref(), state);
        viewer.picture = id.map(|now| PictureIds {
            now,
            before,
            beside,
            size: shown.size,
        });
    }
}

impl Place {
    /// What the renderer knows the picture by, and whether that lies in another texture than before.
    fn show(
        &mut self,
        picture: Option<&Picture>,
        state: &RenderState,
    ) -> (Option<TextureId>, bool) {
        let Some(picture) = picture else {
            self.upload = Upload::default();
            return (None, false);
        };
        let view = self.upload.view(picture, &state.device, &state.queue);
        let (mut renderer, filter) = (state.renderer.write(), wgpu::FilterMode::Linear);
        let (id, is_other) = match &self.known {
            Some((id, known)) if *known == view => (*id, false),
            Some((id, _)) => {
                renderer.update_egui_texture_from_wgpu_texture(&state.device, &view, filter, *id);
                (*id, true)
            }
            None => {
                let id = renderer.register_native_texture(&state.device, &view, filter);
                (id, true)
            }
        };
        self.known = Some((id, view));
        (Some(id), is_other)
    }
}
