//! What is known of the light of a picture that is rendered in parts, one after the other: it is found out once, as the camera sees the whole, and
//! all parts have it, so that no seams are seen between them.

use crate::frame::Frame;

use super::{RenderError, RenderSettings, Renderer, check_size};

/// What is known of the light of the picture that parts belong to.
#[derive(Debug)]
pub(super) struct Known {
    /// For so many samples of each pixel.
    samples: u32,
    /// Nothing is left to be found out.
    is_all: bool,
}

impl Renderer {
    /// Takes a step towards what is to be known of the light of the picture of which [pieces](RenderSettings::piece_of) are rendered then, by
    /// [`Self::set_part`] and [`Self::step`] or [`Self::render_lot`], each with at most so many samples of each pixel; false where it is
    /// known, and where there is no such picture. The film stays as large as it is, however large the picture. Other than in a picture at once, where
    /// it grows with the samples, the first of them know as much as the last. Whatever has the picture begin anew, but for another part of
    /// it and [`Self::trace_apart`], has that forgotten.
    ///
    /// # Errors
    /// A size that can't be rendered, a part beyond the picture, or what the driver reports.
    pub fn learn_of_whole(&mut self, samples: u32) -> Result<bool, RenderError> {
        let Some(settings) = self
            .settings_of_whole()
            .filter(|_| self.irradiance.is_some())
        else {
            return Ok(false);
        };
        check_size(&settings)?;
        if self
            .whole
            .as_ref()
            .is_none_or(|known| known.samples != samples)
        {
            self.restart();
            self.whole = Some(Known {
                samples,
                is_all: false,
            });
        }
        let mut whole = Frame::new(&settings, self.capacity, &self.scene);
        whole.set_known_sky(self.frame.knows_sky());
        let own = std::mem::replace(&mut self.frame, whole);
        let is_more = self.prepare_ahead(samples.saturating_sub(1));
        let whole = std::mem::replace(&mut self.frame, own);
        self.frame.set_known_sky(whole.knows_sky());
        let is_more = is_more?;
        if let Some(known) = &mut self.whole {
            known.is_all = !is_more;
        }
        Ok(is_more)
    }

    /// Takes a step towards what the samples until this one are made with, but for photons of their own.
    fn prepare_ahead(&mut self, sample: u32) -> Result<bool, RenderError> {
        let is_awaited = self.records_awaited().is_some();
        Ok(is_awaited && self.prepare_photons()? || self.prepare_irradiance(sample)?)
    }

    /// Whether the light is known, and doesn't grow with the samples.
    pub(super) fn knows_whole(&self) -> bool {
        self.whole.as_ref().is_some_and(|known| known.is_all)
    }

    /// The picture that this one is a piece of.
    fn settings_of_whole(&self) -> Option<RenderSettings> {
        let whole = self.settings.piece_of?;
        Some(RenderSettings {
            width: whole.size[0],
            height: whole.size[1],
            crop: whole.crop,
            piece_of: None,
            ..self.settings.clone()
        })
    }

    /// The frame of the picture, or of the one that it is a piece of.
    pub(super) fn frame_of_whole(&self) -> Frame {
        match self.settings_of_whole() {
            Some(settings) => Frame::new(&settings, self.capacity, &self.scene),
            None => self.frame,
        }
    }
}
