//! A picture's numbers, and how a layer of it is found.

/// A picture with all of its layers, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// One at least.
    pub layers: Vec<Layer>,
}

/// Some channels of a picture that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// As files have it, such as `ViewLayer.Depth`; empty where it has none.
    pub name: String,
    /// Columns and rows.
    pub size: [usize; 2],
    /// Red, green and blue come first and in this order, where the layer has them; then there is none beside them but alpha, by which they
    /// are multiplied.
    pub channels: Vec<Channel>,
}

/// One number of each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Without that of its layer, such as `R`.
    pub name: String,
    /// Row by row; width times height of them.
    pub values: Vec<f32>,
}

/// Channels of colours.
const RGB: [&str; 3] = ["R", "G", "B"];
/// What colours cover of their pixel.
const ALPHA: &str = "A";
/// What is behind pictures that don't cover all: the grey in the middle of a screen's codes, linear.
const BEHIND: f32 = 0.214;
/// What Patina and Blender call the picture itself.
const COMBINED: &str = "Combined";

impl Picture {
    /// The layer of a name: its whole name, or the end of it behind a dot; upper and lower case are alike.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        let whole = |layer: &&Layer| layer.name.eq_ignore_ascii_case(name);
        let found = self.layers.iter().find(whole);
        found.or_else(|| self.layers.iter().find(|layer| layer.ends_with(name)))
    }

    /// What is meant by the picture, where no layer is named: that without a name, or `Combined`, or the first with colours, or the
    /// first.
    pub fn shown(&self) -> Option<&Layer> {
        let named = |name| self.layer(name);
        let colored = || self.layers.iter().find(|layer| layer.is_color());
        named("")
            .or_else(|| named(COMBINED))
            .or_else(colored)
            .or(self.layers.first())
    }

    /// The names of all layers, for people.
    pub fn names(&self) -> Vec<&str> {
        let names = self.layers.iter().map(|layer| layer.name.as_str());
        names.filter(|name| !name.is_empty()).collect()
    }
}

impl Layer {
    /// A layer of colours.
    ///
    /// # Panics
    /// There aren't width times height pixels.
    pub fn rgb(name: &str, size: [usize; 2], pixels: &[[f32; 3]]) -> Self {
        assert_eq!(pixels.len(), size[0] * size[1], "width times height pixels");
        let channel = |(at, name): (usize, &str)| Channel {
            name: name.to_owned(),
            values: pixels.iter().map(|rgb| rgb[at]).collect(),
        };
        Self {
            name: name.to_owned(),
            size,
            channels: RGB.into_iter().enumerate().map(channel).collect(),
        }
    }

    /// A layer of some channels, each with width times height numbers: where there are red, green and blue, nothing but alpha is kept beside
    /// them.
    pub fn new(name: String, size: [usize; 2], mut channels: Vec<Channel>) -> Self {
        let place = |wanted: &str| {
            // In small letters they are ids: Cryptomatte's.
            channels.iter().position(|channel| channel.name == wanted)
        };
        if let [Some(r), Some(g), Some(b)] = RGB.map(place) {
            let mut channel = |at: usize| Channel {
                name: std::mem::take(&mut channels[at].name),
                values: std::mem::take(&mut channels[at].values),
            };
            let colors = [channel(r), channel(g), channel(b)];
            channels.retain(|channel| channel.name == ALPHA);
            channels.truncate(1);
            channels.splice(0..0, colors);
        }
        Self {
            name,
            size,
            channels,
        }
    }

    /// Whether it is one of colours.
    pub fn is_color(&self) -> bool {
        let names = self.channels.iter().map(|channel| channel.name.as_str());
        names.take(RGB.len()).eq(RGB)
    }

    /// How much of each pixel colours cover, where the layer says it.
    pub fn alpha(&self) -> Option<&[f32]> {
        let alpha = self.channels.get(RGB.len()).filter(|_| self.is_color());
        alpha.map(|channel| channel.values.as_slice())
    }

    /// Whether colours are those of what alpha says is there: none is where nothing is covered. Pictures with everything in them may tell
    /// what surfaces cover all the same.
    pub fn is_covering(&self) -> bool {
        let is_black = |at: usize| {
            self.channels[..RGB.len()]
                .iter()
                .all(|c| c.values[at] == 0.0)
        };
        let mut pixels = self.alpha().into_iter().flatten().enumerate();
        pixels.all(|(at, &alpha)| alpha != 0.0 || is_black(at))
    }

    /// For people.
    pub fn title(&self) -> &str {
        match self.name.as_str() {
            "" => "the picture",
            name => name,
        }
    }

    /// Pixels of colours, shown on a screen: brighter by so many stops, and 0 to 1; what is no number is black. With `alpha` what they
    /// cover is taken for it, and grey is behind them. `None` where the layer is none of colours.
    pub(crate) fn displayed(&self, exposure: f32, alpha: Option<&[f32]>) -> Option<Vec<[f32; 3]>> {
        let [r, g, b, ..] = self.channels.as_slice() else {
            return None;
        };
        let gain = exposure.exp2();
        let behind = |at: usize| {
            let covered = alpha.map_or(1.0, |alpha| alpha[at]);
            BEHIND * (1.0 - covered).clamp(0.0, 1.0)
        };
        let shown = |value: f32, behind: f32| match (value.is_nan(), behind.is_nan()) {
            (false, false) => (value * gain + behind).clamp(0.0, 1.0),
            _ => 0.0,
        };
        let pixels = r.values.iter().zip(&g.values).zip(&b.values).enumerate();
        let pixels = pixels.map(|(at, ((&r, &g), &b))| [r, g, b].map(|v| shown(v, behind(at))));
        self.is_color().then(|| pixels.collect())
    }

    fn ends_with(&self, name: &str) -> bool {
        let mut rest = self.name.as_str();
        while let Some((_, end)) = rest.split_once('.') {
            if end.eq_ignore_ascii_case(name) {
                return true;
            }
            rest = end;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(name: &str, channels: &str) -> Layer {
        let channel = |(at, name): (usize, char)| Channel {
            name: name.to_string(),
            values: vec![at as f32],
        };
        let channels = channels.chars().enumerate().map(channel).collect();
        Layer::new(name.to_owned(), [1, 1], channels)
    }

    #[test]
    fn colours_come_in_their_order_and_alpha_behind_them() {
        let color = layer("a", "ABGR");
        assert!(color.is_color());
        let values: Vec<_> = color.channels.iter().map(|c| c.values[0]).collect();
        assert_eq!(values, [3.0, 2.0, 1.0, 0.0]);
        assert_eq!(color.alpha(), Some(&[0.0][..]));
        let others = layer("a", "XBGRZ");
        assert!(others.is_color() && others.channels.len() == 3 && others.alpha().is_none());
        assert!(!layer("CryptoObject00", "abgr").is_color());
        let vector = layer("a", "XYZ");
        assert!(!vector.is_color() && vector.displayed(0.0, None).is_none());
        assert_eq!(vector.channels.len(), 3);
    }

    #[test]
    fn alpha_may_be_told_of_pictures_with_everything_in_them() {
        let color = |alpha: [f32; 2], green: [f32; 2]| {
            let values = [[0.0; 2], green, [0.0; 2], alpha];
            let channels = ["R", "G", "B", "A"].into_iter().zip(values);
            let channels = channels.map(|(name, values)| Channel {
                name: name.to_owned(),
                values: values.to_vec(),
            });
            Layer::new(String::new(), [2, 1], channels.collect())
        };
        assert!(color([0.0, 0.5], [0.0, 0.5]).is_covering());
        assert!(!color([0.0, 0.5], [0.25, 0.5]).is_covering());
        assert!(layer("a", "RGB").is_covering() && layer("a", "Z").is_covering());
    }

    #[test]
    fn layers_are_found_by_the_end_of_their_names() {
        let names = [
            "ViewLayer.Depth",
            "ViewLayer.Denoising Albedo",
            "ViewLayer.Combined",
        ];
        let mut picture = Picture {
            layers: vec![
                layer(names[0], "Z"),
                layer(names[1], "BGR"),
                layer(names[2], "BGR"),
            ],
        };
        let found = |name: &str| picture.layer(name).map(|layer| layer.name.as_str());
        assert_eq!(found("depth"), Some(names[0]));
        assert_eq!(found("viewlayer.depth"), Some(names[0]));
        assert_eq!(found("Albedo"), None);
        assert_eq!(found(""), None);
        assert_eq!(picture.shown().map(|l| &*l.name), Some(names[2]));
        picture.layers.pop();
        assert_eq!(picture.shown().map(|l| &*l.name), Some(names[1]));
        picture.layers.push(layer("", "Y"));
        assert_eq!(picture.shown().map(Layer::title), Some("the picture"));
    }
}
