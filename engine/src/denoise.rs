//! Takes the noise out of a film's picture: by Open Image Denoise, a library that is opened at run time where its caller has found
//! it. Nothing links against it, and nobody needs it who doesn't ask for it.
//!
//! Beside the picture the library is shown two layers of it, [`GUIDES`], which tell edges and textures from noise. They have noise of
//! their own where edges are blurred, so each is denoised first, by itself; then the library may trust them
//! (<https://www.openimagedenoise.org/documentation.html>, "Prefiltering").
//!
//! It computes on the processor, with as many threads as everything else does. The same film always gives the same picture, on
//! one kind of processor and with one version of the library.

#[cfg(any(unix, windows))]
mod library;
#[cfg(not(any(unix, windows)))]
#[path = "denoise/no_library.rs"]
mod library;

use std::ffi::CStr;
use std::path::{Path, PathBuf};

use crate::film::write::Content;
use crate::film::{Film, Layer};
use library::Library;

pub use library::FILE;

/// The layers that help to denoise a picture; a film needs both.
pub const GUIDES: [&str; 2] = ["albedo", "normal"];

/// What the library calls them, and the picture.
const GUIDE_IMAGES: [&CStr; 2] = [c"albedo", c"normal"];
const COLOR: &CStr = c"color";
/// The picture is radiance, not 0 to 1.
const IS_HDR: &CStr = c"hdr";
/// The guides have no noise.
const GUIDES_ARE_CLEAN: &CStr = c"cleanAux";

/// Why there is no denoised picture.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// There is no such library, or another one.
    #[error("cannot open {}: {reason}", path.display())]
    Open {
        /// As it was asked for.
        path: PathBuf,
        /// What the system or the library says.
        reason: String,
    },
    /// It gave up.
    #[error("Open Image Denoise gave up: {0}")]
    Failed(String),
}

/// The library, ready to denoise.
#[derive(Debug)]
pub struct Denoiser {
    library: Library,
    version: [i32; 3],
}

/// Layers of a picture, pixel by pixel, in the picture's order.
#[derive(Debug, Clone, Copy)]
pub struct Guides<'a> {
    /// Linear base colour of what is seen, 0 to 1.
    pub albedo: &'a [[f32; 3]],
    /// Mean of its normals, each component from -1 to 1.
    pub normal: &'a [[f32; 3]],
}

impl Denoiser {
    /// Opens the library at a path, or one that the system finds by a name without folders ([`FILE`]).
    ///
    /// # Errors
    /// It isn't there, isn't Open Image Denoise 2, or can't work on this machine.
    pub fn open(path: &Path) -> Result<Self, DenoiseError> {
        let refused = |reason: String| {
            // The system may begin with the name, too.
            let start = format!("{}: ", path.display());
            let said = reason.strip_prefix(&start).unwrap_or(&reason).to_owned();
            DenoiseError::Open {
                path: path.to_owned(),
                reason: said,
            }
        };
        let library = Library::open(path, rayon::current_num_threads()).map_err(refused)?;
        let version = library.version();
        match version {
            [2, ..] => Ok(Self { library, version }),
            [major, ..] => Err(refused(format!(
                "it is version {major}, and version 2 is needed"
            ))),
        }
    }

    /// Name and version of the library.
    pub fn title(&self) -> String {
        let [major, minor, patch] = self.version;
        format!("Open Image Denoise {major}.{minor}.{patch}")
    }

    /// Whether a film has gathered the [`GUIDES`]. Without them textures and edges are blurred.
    pub fn has_guides(film: &Film) -> bool {
        GUIDES.iter().all(|name| {
            let mut layers = film.layers().iter();
            layers.any(|layer| layer.name == *name)
        })
    }

    /// What files of a film show without its noise, with the help of the [`GUIDES`] where the film has both.
    ///
    /// # Errors
    /// As [`Self::picture`].
    pub fn film(&self, content: &Content<'_>) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let mut picture = self.guided_by(content.film, &content.picture())?;
        if let Some(alpha) = content.alpha() {
            clear_uncovered(&mut picture, &alpha);
        }
        Ok(picture)
    }

    /// Radiance of a film's pixels without its noise, as of its lights mixed otherwise, with the help of the [`GUIDES`] where the film
    /// has both.
    ///
    /// # Errors
    /// As [`Self::picture`].
    ///
    /// # Panics
    /// As [`Self::picture`].
    pub fn guided_by(
        &self,
        film: &Film,
        radiance: &[[f32; 3]],
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let guides: Vec<_> = (GUIDES.iter())
            .filter_map(|name| film.values(Layer::named(name)?))
            .collect();
        let guides = match guides.as_slice() {
            [albedo, normal] => Some(Guides { albedo, normal }),
            _ => None,
        };
        self.picture([film.width, film.height], radiance, guides)
    }

    /// Linear radiance without its noise; row 0 is on top of all of them.
    ///
    /// # Errors
    /// The library gives up, as where memory doesn't suffice.
    ///
    /// # Panics
    /// A picture or a guide has other than width times height pixels.
    pub fn picture(
        &self,
        [width, height]: [u32; 2],
        radiance: &[[f32; 3]],
        guides: Option<Guides<'_>>,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let size = [width as usize, height as usize];
        let filtered = |images: &[library::Image<'_>], flags: &[&CStr]| {
            let filtered = self.library.filter(size, images, flags);
            filtered.map_err(DenoiseError::Failed)
        };
        let Some(Guides { albedo, normal }) = guides else {
            return filtered(&[(COLOR, radiance)], &[IS_HDR]);
        };
        let [albedo_image, normal_image] = GUIDE_IMAGES;
        let albedo = filtered(&[(albedo_image, albedo)], &[])?;
        let normal = filtered(&[(normal_image, normal)], &[])?;
        filtered(
            &[
                (COLOR, radiance),
                (albedo_image, &albedo),
                (normal_image, &normal),
            ],
            &[IS_HDR, GUIDES_ARE_CLEAN],
        )
    }
}

/// Takes away what denoising has spread over the border of what is there: colours are multiplied by alpha, which isn't denoised, and
/// would glow in front of everything.
fn clear_uncovered(picture: &mut [[f32; 3]], alpha: &[f32]) {
    for (rgb, _) in picture.iter_mut().zip(alpha).filter(|(_, a)| **a == 0.0) {
        *rgb = [0.0; 3];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layers;

    #[test]
    fn where_nothing_is_nothing_glows() {
        let mut picture = [[0.5, 0.25, 0.0]; 3];
        clear_uncovered(&mut picture, &[0.0, 0.125, 1.0]);
        assert_eq!(picture, [[0.0; 3], [0.5, 0.25, 0.0], [0.5, 0.25, 0.0]]);
    }

    #[test]
    fn what_is_no_such_library_is_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(FILE);
        let absent = Denoiser::open(&path).expect_err("it isn't there");
        assert!(absent.to_string().contains(FILE), "{absent}");
        std::fs::write(&path, b"no library").expect("written");
        let other = Denoiser::open(&path).expect_err("it is a text");
        assert!(other.to_string().contains(FILE), "{other}");
    }

    #[test]
    fn guides_are_layers_that_a_film_may_lack() {
        let with = |names: &[&str]| {
            let layers = Layers::named(names.iter().copied()).expect("known");
            Denoiser::has_guides(&Film::with_layers(2, 2, layers))
        };
        assert!(with(&GUIDES));
        assert!(with(&["depth", "normal", "albedo"]));
        assert!(!with(&["albedo", "depth"]));
        assert!(!with(&[]));
    }

    /// Noise around a step: what is left of it is far less, the step stays where it is, and it is the same each time.
    #[test]
    fn noise_goes_and_edges_stay() {
        let Some(folder) = std::env::var_os("OIDN_DIR") else {
            eprintln!("skipped: OIDN_DIR doesn't say where Open Image Denoise is");
            return;
        };
        let folder = PathBuf::from(folder);
        let library = ["lib", "lib64", "bin", ""].map(|place| folder.join(place).join(FILE));
        let library = library.iter().find(|path| path.is_file());
        let denoiser = Denoiser::open(library.expect("OIDN_DIR has it")).expect("it opens");
        let (width, height) = (96, 64);
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * (state >> 8) as f32 / (1 << 24) as f32
        };
        let truth = |at: usize| if at % 96 < 48 { 0.2_f32 } else { 0.8 };
        let pixels = width * height;
        let radiance: Vec<_> = (0..pixels).map(|at| [truth(at) * noise(); 3]).collect();
        let albedo: Vec<_> = (0..pixels).map(|at| [truth(at); 3]).collect();
        let normal = vec![[0.0, 0.0, 1.0]; pixels];
        let guides = Guides {
            albedo: &albedo,
            normal: &normal,
        };
        let size = [width as u32, height as u32];
        let clean = denoiser
            .picture(size, &radiance, Some(guides))
            .expect("denoised");
        let error = |picture: &[[f32; 3]]| {
            let squares = picture.iter().enumerate();
            let squares = squares.map(|(at, rgb)| (rgb[1] - truth(at)).powi(2));
            (squares.sum::<f32>() / pixels as f32).sqrt()
        };
        assert!(
            error(&clean) < 0.1 * error(&radiance),
            "{} of {}",
            error(&clean),
            error(&radiance)
        );
        let again = denoiser.picture(size, &radiance, Some(guides));
        assert_eq!(again.expect("denoised"), clean);
    }
}
