//! What somebody who watches a session wants of it: a view of his own, another size, a part of the picture. None of
//! it is part of the look.

use std::time::Duration;

use glam::Vec2;

use crate::display::DeviceFilm;
use crate::film::{Crop, Film};
use crate::pick::{self, Pick};
use crate::renderer::{Lot, RenderError, RenderSettings, Renderer, TextureCosts};
use crate::scene::Camera;
use crate::scene::view::ViewChoice;

use super::{Session, SessionError};

impl Session {
    /// Looks through a camera of one's own, or, without it, through that of the look again. The look is not edited.
    pub fn set_view(&mut self, view: Option<Camera>) {
        self.view = view;
        let camera = self.shown_camera().clone();
        self.renderer.set_camera(&camera);
        self.generation += 1;
    }

    /// The camera of the picture.
    pub fn shown_camera(&self) -> &Camera {
        self.view.as_ref().unwrap_or(&self.camera)
    }

    /// The camera that the look asks for.
    pub fn look_camera(&self) -> &Camera {
        &self.camera
    }

    /// How the look that is shown has its picture shown. No sample depends on it, so that a change of it is no new generation.
    pub fn look_view(&self) -> ViewChoice {
        self.look_view
    }

    /// Renders a picture of another size from now on, from the first sample; nothing is done where it has that size. What is
    /// built anew has the size that its settings say.
    ///
    /// # Errors
    /// As [`crate::renderer::Renderer::resize`].
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), SessionError> {
        let now = self.renderer.settings();
        if (now.width, now.height) != (width, height) {
            self.renderer.resize(width, height)?;
            self.generation += 1;
        }
        Ok(())
    }

    /// See [`crate::renderer::Renderer::set_part`]. What is built anew has the size that its settings say.
    ///
    /// # Errors
    /// As there.
    pub fn set_part(&mut self, size: [u32; 2], crop: Option<Crop>) -> Result<(), SessionError> {
        self.renderer.set_part(size, crop)?;
        self.generation += 1;
        Ok(())
    }

    /// See [`crate::renderer::Renderer::learn_of_whole`].
    ///
    /// # Errors
    /// As there.
    pub fn learn_of_whole(&mut self, samples: u32) -> Result<bool, SessionError> {
        Ok(self.renderer.learn_of_whole(samples)?)
    }

    /// See [`crate::renderer::Renderer::set_region`].
    pub fn set_region(&mut self, region: Option<[u32; 4]>) {
        self.renderer.set_region(region);
    }

    /// See [`crate::renderer::Renderer::set_longest_wave`]; of the renderer that there is now.
    pub fn set_longest_wave(&mut self, longest: Duration) {
        self.renderer.set_longest_wave(longest);
    }

    /// See [`crate::renderer::Renderer::set_smallest_wave`]; of the renderer that there is now.
    pub fn set_smallest_wave(&mut self, paths: u32) {
        self.renderer.set_smallest_wave(paths);
    }

    /// See [`crate::renderer::Renderer::paths_done`].
    pub fn paths_done(&self) -> u64 {
        self.renderer.paths_done()
    }

    /// See [`crate::renderer::Renderer::is_preview`].
    pub fn is_preview(&self) -> bool {
        self.renderer.is_preview()
    }

    /// See [`crate::renderer::Renderer::records_awaited`].
    pub fn records_awaited(&self) -> Option<usize> {
        self.renderer.records_awaited()
    }

    /// See [`crate::renderer::Renderer::refine`].
    pub fn refine(&mut self) {
        self.renderer.refine();
    }

    /// See [`crate::renderer::Renderer::trace_apart`].
    ///
    /// # Errors
    /// The device.
    pub fn trace_apart(&mut self, seed: u32, spp: u32) -> Result<Film, SessionError> {
        Ok(self.renderer.trace_apart(seed, spp)?)
    }

    /// See [`crate::renderer::Renderer::render_lot`].
    ///
    /// # Errors
    /// The device; it isn't known then what of the lot is in the film.
    pub fn render_lot(&mut self, lot: &Lot, from: usize) -> Result<usize, SessionError> {
        Ok(self.renderer.render_lot(lot, from)?)
    }

    /// See [`crate::renderer::Renderer::paths_per_sample`].
    pub fn paths_per_sample(&self) -> u64 {
        self.renderer.paths_per_sample()
    }

    /// See [`crate::renderer::Renderer::resume`].
    ///
    /// # Errors
    /// The device.
    pub fn resume(&mut self, film: &Film, paths: u64) -> Result<(), SessionError> {
        Ok(self.renderer.resume(film, paths)?)
    }

    /// Another renderer of what is shown now, with other settings but for the camera. Edits don't reach it.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn renderer_of(&self, settings: &RenderSettings) -> Result<Renderer, SessionError> {
        let settings = RenderSettings {
            camera: self.shown_camera().clone(),
            ..settings.clone()
        };
        let (device, procedural) = (self.device(), self.renderer.procedural());
        let renderer = Renderer::new(device, &self.scene, procedural, &settings)?;
        Ok(renderer.in_system(&self.system))
    }

    /// Times each pass from now on, until something is built anew.
    ///
    /// # Errors
    /// The device.
    pub fn time_passes(&mut self) -> Result<(), SessionError> {
        Ok(self.renderer.time_passes()?)
    }

    /// Whether passes are timed.
    pub fn is_timing(&self) -> bool {
        self.renderer.is_timing()
    }

    /// Measures what one more texture costs: see [`crate::renderer::Renderer::measure_costs`].
    ///
    /// # Errors
    /// The device.
    pub fn measure_costs(&mut self) -> Result<&TextureCosts, SessionError> {
        Ok(self.renderer.measure_costs()?)
    }

    /// The film on the device, to be shown, with guides if they are asked for.
    ///
    /// # Errors
    /// The device; the next step finds out whether it is lost.
    pub fn device_film(&mut self, guides: bool) -> Result<DeviceFilm, SessionError> {
        if guides {
            self.renderer.trace_guides()?;
        }
        Ok(self.renderer.device_film()?)
    }

    /// A copy of the film on the device, as far as it is.
    ///
    /// # Errors
    /// As [`Self::device_film`].
    pub fn keep_film(&mut self, guides: bool) -> Result<DeviceFilm, SessionError> {
        let film = self.device_film(guides)?;
        Ok(film
            .copy(self.renderer.device())
            .map_err(RenderError::from)?)
    }

    /// The surface that is seen at a place of the picture, (0, 0) its upper left corner and (1, 1) its lower right one.
    pub fn pick(&self, place: Vec2) -> Option<Pick> {
        let settings = self.renderer.settings();
        let aspect = settings.width as f32 / settings.height as f32;
        pick::pick(&self.scene, self.shown_camera(), aspect, place)
    }
}
