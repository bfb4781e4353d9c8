//! Colours of the window that can be read: text has at least 4.5 times the luminance of what it lies on, or the other way round (WCAG
//! 2.2, success criterion 1.4.3).

use egui::{Color32, Context, Theme, Visuals};

/// Dark and light, whichever the system asks for.
pub fn apply(ctx: &Context) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.set_visuals_of(theme, visuals(theme));
    }
}

fn visuals(theme: Theme) -> Visuals {
    let mut visuals = theme.default_visuals();
    let gray = Color32::from_gray;
    let (text, weak, warning, error, link) = match theme {
        Theme::Dark => (
            gray(205),
            gray(155),
            Color32::from_rgb(255, 160, 40),
            Color32::from_rgb(255, 125, 115),
            Color32::from_rgb(110, 180, 255),
        ),
        Theme::Light => (
            gray(50),
            gray(95),
            Color32::from_rgb(140, 65, 0),
            Color32::from_rgb(175, 0, 0),
            Color32::from_rgb(0, 85, 165),
        ),
    };
    visuals.widgets.noninteractive.fg_stroke.color = text;
    visuals.weak_text_color = Some(weak);
    visuals.warn_fg_color = warning;
    visuals.error_fg_color = error;
    visuals.hyperlink_color = link;
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance: WCAG 2.2, "relative luminance".
    fn luminance(color: Color32) -> f32 {
        let linear = egui::Rgba::from(color);
        0.2126 * linear.r() + 0.7152 * linear.g() + 0.0722 * linear.b()
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn text_can_be_read() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-3);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = visuals(theme);
            let texts = [
                ("text", visuals.text_color()),
                ("weak", visuals.weak_text_color()),
                ("strong", visuals.strong_text_color()),
                ("warning", visuals.warn_fg_color),
                ("error", visuals.error_fg_color),
                ("link", visuals.hyperlink_color),
            ];
            let grounds = [
                visuals.panel_fill,
                visuals.window_fill,
                visuals.extreme_bg_color,
            ];
            for (name, text) in texts {
                for ground in grounds {
                    let contrast = contrast(text, ground);
                    assert!(contrast >= 4.5, "{theme:?} {name}: {contrast}");
                }
            }
            for widget in [
                visuals.widgets.inactive,
                visuals.widgets.hovered,
                visuals.widgets.active,
                visuals.widgets.open,
            ] {
                let contrast = contrast(widget.fg_stroke.color, widget.weak_bg_fill);
                assert!(contrast >= 4.5, "{theme:?}: {contrast}");
            }
        }
    }
}
