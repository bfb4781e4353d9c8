//! What is known of the light of a picture that is rendered in parts, one after the other: it is found out once, as the camera sees the whole, and
//! all parts have it, so that no seams are seen between them.

use crate::{film::Crop, frame::Frame};

use super::{RenderError, RenderSettings, Renderer, check_size};

/// The picture that parts belong to.
#[derive(Debug)]
pub(super) struct Whole {
    /// Its size, where it is a part itself, and the samples of each pixel that it will have at the most.
    what: ([u32; 2], Option<Crop>, u32),
    /// Nothing is left to be found out.
    is_known: bool,
}

impl Renderer {
    /// Takes a step towards what is to be known of the light of a picture of which parts are rendered then, by [`Self::set_part`] and
    /// [`Self::step`] or [`Self::render_lot`], each with at most so many samples of each pixel; false where it is known. The film stays
    /// as large as it is, however large the picture. Other than in a picture at once, where it grows with the samples, the
    /// first of them know as much as the last. Whatever has the picture begin anew, but for another part of it, has that forgotten.
    ///
    /// # Errors
    /// A size that can't be rendered, a part beyond the picture, or what the driver reports.
    pub fn learn_of_whole(
        &mut self,
        [width, height]: [u32; 2],
        crop: Option<Crop>,
        samples: u32,
    ) -> Result<bool, RenderError> {
        if self.irradiance.is_none() {
            return Ok(false);
        }
        let settings = RenderSettings {
            width,
            height,
            crop,
            ..self.settings.clone()
        };
        check_size(&settings)?;
        let what = ([width, height], crop, samples);
        if self.whole.as_ref().is_none_or(|whole| whole.what != what) {
            self.restart();
            self.whole = Some(Whole {
                what,
                is_known: false,
            });
        }
        let mut whole = Frame::new(&settings, self.capacity, &self.scene);
        whole.set_known_sky(self.frame.knows_sky());
        let own = std::mem::replace(&mut self.frame, whole);
        let is_more = self.prepare_irradiance(samples.saturating_sub(1));
        let whole = std::mem::replace(&mut self.frame, own);
        self.frame.set_known_sky(whole.knows_sky());
        let is_more = is_more?;
        if let Some(whole) = &mut self.whole {
            whole.is_known = !is_more;
        }
        Ok(is_more)
    }

    /// Whether the light is known, and doesn't grow with the samples.
    pub(super) fn knows_whole(&self) -> bool {
        self.whole.as_ref().is_some_and(|whole| whole.is_known)
    }
}
