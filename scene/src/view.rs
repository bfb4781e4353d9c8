//! How radiance is brought to a screen, as plain data: exposure, white balance and view transform. What they do to a colour
//! is the engine's business; `docs/view-transforms.md` describes them for users.

/// Strongest exposure in stops, either way.
pub const MAX_EXPOSURE: f32 = 32.0;

/// How scene-linear colours become what a display shows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum ViewTransform {
    /// sRGB as it is; what is brighter than white is clipped.
    #[default]
    Standard,
    /// AgX as Blender has it: bright colours go to white on the way that film takes.
    Agx,
    /// Khronos PBR Neutral: base colours keep their look, highlights are compressed.
    KhronosNeutral,
    /// ACES 2.0's output transform for sRGB displays of 100 nits.
    Aces2,
    /// Filmic as Blender has it, with its medium contrast.
    Filmic,
}

impl ViewTransform {
    /// All of them, in the order of `view.wgsl`.
    pub const ALL: [Self; 5] = [
        Self::Standard,
        Self::Agx,
        Self::KhronosNeutral,
        Self::Aces2,
        Self::Filmic,
    ];

    /// The word that names it in looks and on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Agx => "agx",
            Self::KhronosNeutral => "khronos-neutral",
            Self::Aces2 => "aces2",
            Self::Filmic => "filmic",
        }
    }

    /// Its name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Standard => "Standard",
            Self::Agx => "AgX",
            Self::KhronosNeutral => "Khronos PBR Neutral",
            Self::Aces2 => "ACES 2.0",
            Self::Filmic => "Filmic",
        }
    }

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|view| view.name() == name)
    }
}

/// The colour of light that is to look white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteBalance {
    /// Correlated colour temperature of that light, kelvins.
    pub temperature: f32,
    /// How far it lies above Planck's locus, towards green, in 1/3000 of the CIE 1960 diagram's unit.
    pub tint: f32,
}

impl WhiteBalance {
    /// Temperatures that there are.
    pub const TEMPERATURES: std::ops::RangeInclusive<f32> = 1800.0..=25_000.0;
    /// Tints that there are, and a nought between.
    pub const TINTS: std::ops::RangeInclusive<f32> = -100.0..=100.0;
    /// Daylight lies that far above Planck's locus, so that 6500 K leave a picture as it is.
    pub const TINT: f32 = 10.0;

    /// Of a temperature and a tint, that of daylight where there is none; `None` outside of the ranges.
    pub fn new(temperature: f32, tint: Option<f32>) -> Option<Self> {
        let tint = tint.unwrap_or(Self::TINT);
        let is_inside = Self::TEMPERATURES.contains(&temperature) && Self::TINTS.contains(&tint);
        is_inside.then_some(Self { temperature, tint })
    }
}

impl Default for WhiteBalance {
    /// Daylight, all but for rounding the white of sRGB.
    fn default() -> Self {
        Self {
            temperature: 6500.0,
            tint: Self::TINT,
        }
    }
}

/// How a picture is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct View {
    /// Stops: +1 is twice as bright.
    pub exposure: f32,
    /// The light that is to look white; as it is where there is none.
    pub white_balance: Option<WhiteBalance>,
    /// From scene-linear to the display.
    pub transform: ViewTransform,
}

impl View {
    /// As PNG files are written where nothing is said, but for the exposure.
    pub fn exposed(exposure: f32) -> Self {
        Self {
            exposure,
            ..Self::default()
        }
    }
}

/// What somebody has said of how a picture is shown: a look, or a command line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ViewChoice {
    /// Stops.
    pub exposure: Option<f32>,
    /// The light that is to look white.
    pub white_balance: Option<WhiteBalance>,
    /// From scene-linear to the display.
    pub transform: Option<ViewTransform>,
}

impl ViewChoice {
    /// This, and what `other` says where this says nothing.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            exposure: self.exposure.or(other.exposure),
            white_balance: self.white_balance.or(other.white_balance),
            transform: self.transform.or(other.transform),
        }
    }

    /// The view, as `view` where nothing is said.
    pub fn over(self, view: View) -> View {
        View {
            exposure: self.exposure.unwrap_or(view.exposure),
            white_balance: self.white_balance.or(view.white_balance),
            transform: self.transform.unwrap_or(view.transform),
        }
    }

    /// The view, with the defaults where nothing is said.
    pub fn view(self) -> View {
        self.over(View::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for view in ViewTransform::ALL {
            assert_eq!(ViewTransform::named(view.name()), Some(view));
        }
        assert_eq!(ViewTransform::named("AgX"), None);
    }

    #[test]
    fn the_first_to_say_something_counts() {
        let line = ViewChoice {
            exposure: Some(1.0),
            ..ViewChoice::default()
        };
        let look = ViewChoice {
            exposure: Some(2.0),
            transform: Some(ViewTransform::Agx),
            white_balance: None,
        };
        let view = line.or(look).view();
        assert_eq!((view.exposure, view.transform), (1.0, ViewTransform::Agx));
        assert_eq!(view.white_balance, None);
        assert_eq!(ViewChoice::default().view(), View::default());
    }

    #[test]
    fn white_is_daylight_or_what_is_said_within_its_range() {
        assert_eq!(
            WhiteBalance::new(6500.0, None),
            Some(WhiteBalance::default())
        );
        for (temperature, tint) in [(100.0, 0.0), (f32::NAN, 0.0), (5000.0, 101.0)] {
            assert_eq!(WhiteBalance::new(temperature, Some(tint)), None);
        }
    }
}
