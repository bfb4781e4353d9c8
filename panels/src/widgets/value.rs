//! Numbers, vectors, colours, switches, matrices and arrays.

use egui::{DragValue, PointerButton, Response, Slider, SliderClamping, Ui};
use texgen::{Parameter, Value, Widget};

use super::number::number_field;
use super::{Edited, name, ramp};

/// Which values a number may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

impl Bounds {
    /// Whatever an `f32` can be.
    pub(crate) const ANY: Self = Self {
        min: f32::MIN as f64,
        max: f32::MAX as f64,
    };
}

/// Most digits behind the point that are shown, and those of a colour.
const DECIMALS: usize = 6;
const COLOR_DECIMALS: usize = 3;
/// Width of the button that shows a colour, in points.
const PICKER: f32 = 24.0;

/// How a value is shown.
#[derive(Debug, Clone)]
pub(crate) struct Spec<'a> {
    /// By which it is found; unique in the panel.
    pub(crate) name: String,
    /// Ends of a slider.
    pub(crate) range: Option<(f32, f32)>,
    pub(crate) bounds: Bounds,
    pub(crate) unit: &'a str,
    pub(crate) widget: Widget,
}

impl<'a> Spec<'a> {
    /// As the documentation of a texture asks for.
    pub(crate) fn of(parameter: &'a Parameter, name: String) -> Self {
        Self {
            name,
            range: parameter.soft_range.or(parameter.range),
            bounds: Bounds::ANY,
            unit: parameter.unit.as_deref().unwrap_or(""),
            widget: parameter.widget,
        }
    }

    /// What is shown is so many times what is kept, and what stands behind it.
    fn scale(&self) -> (f64, String) {
        match self.widget {
            Widget::Angle => (1f64.to_degrees(), "°".to_owned()),
            Widget::Percent => (100.0, " %".to_owned()),
            _ if self.unit == "°" || self.unit.is_empty() => (1.0, self.unit.to_owned()),
            _ => (1.0, format!(" {}", self.unit)),
        }
    }

    /// The same for a part of the value.
    fn part(&self, part: &str) -> Self {
        Self {
            name: format!("{} {part}", self.name),
            range: None,
            ..self.clone()
        }
    }
}

/// Shows a value of any type but images.
pub(crate) fn edit(ui: &mut Ui, spec: &Spec<'_>, value: &Value) -> Edited<Value> {
    match value {
        Value::F32(x) => number(ui, spec, *x).map(Value::F32),
        Value::I32(x) => {
            let bounds = (i32::MIN.into(), i32::MAX.into());
            whole(ui, spec, i64::from(*x), bounds).map(|x| Value::I32(x as i32))
        }
        Value::U32(x) => {
            whole(ui, spec, i64::from(*x), (0, u32::MAX.into())).map(|x| Value::U32(x as u32))
        }
        Value::Bool(x) => {
            let mut shown = *x;
            let response = ui.checkbox(&mut shown, "");
            name(&response, &spec.name);
            let value = response.changed().then_some(Value::Bool(shown));
            Edited { response, value }
        }
        Value::Vec2(x) => vector(ui, spec, x).map(Value::Vec2),
        Value::Vec3(x) if spec.widget == Widget::Color => color(ui, spec, *x).map(Value::Vec3),
        Value::Vec3(x) => vector(ui, spec, x).map(Value::Vec3),
        Value::Vec4(x) if spec.widget == Widget::Color => color(ui, spec, *x).map(Value::Vec4),
        Value::Vec4(x) => vector(ui, spec, x).map(Value::Vec4),
        Value::Mat3(columns) => matrix(ui, spec, columns).map(Value::Mat3),
        Value::Mat4(columns) => matrix(ui, spec, columns).map(Value::Mat4),
        Value::Ramp(stops) => ramp::edit(ui, &spec.name, stops).map(Value::Ramp),
        Value::Array(items) => array(ui, spec, items).map(Value::Array),
        // Images have widgets of their own.
        Value::Image(_) => Edited {
            response: ui.label(""),
            value: None,
        },
    }
}

/// The same of what the look has written, where that is anything. A value that changes with time is shown as it is at the beginning, and
/// stays as it is: a constant would take its keys away.
pub(crate) fn edit_steady(
    ui: &mut Ui,
    spec: &Spec<'_>,
    value: &Value,
    written: Option<&engine::scene::look::Value>,
) -> Edited<Value> {
    if !written.is_some_and(engine::scene::look::Value::has_keys) {
        return edit(ui, spec, value);
    }
    let shown = ui.add_enabled_ui(false, |ui| edit(ui, spec, value));
    let help = "it changes with time: its keys are changed in the file of the look; Reset, by a right click, takes them away";
    ui.weak("has keys").on_hover_text(help);
    Edited {
        response: shown.inner.response,
        // What isn't enabled can still be set by assistive technology.
        value: None,
    }
}

impl<T> Edited<T> {
    fn map<U>(self, convert: impl FnOnce(T) -> U) -> Edited<U> {
        Edited {
            response: self.response,
            value: self.value.map(convert),
        }
    }
}

fn number(ui: &mut Ui, spec: &Spec<'_>, value: f32) -> Edited<f32> {
    number_in(ui, spec, value, DECIMALS)
}

/// With so many digits behind the point at most.
fn number_in(ui: &mut Ui, spec: &Spec<'_>, value: f32, decimals: usize) -> Edited<f32> {
    let (scale, suffix) = spec.scale();
    let mut shown = f64::from(value) * scale;
    let mut changed = false;
    let mut response = None;
    if let Some((low, high)) = spec.range {
        let range = f64::from(low) * scale..=f64::from(high) * scale;
        let slider = Slider::new(&mut shown, range)
            .show_value(false)
            .logarithmic(spec.widget == Widget::Log)
            .clamping(SliderClamping::Never);
        let slider = ui.add(slider);
        name(&slider, &spec.name);
        match is_slid(ui, &slider) {
            true => changed = true,
            false => shown = f64::from(value) * scale,
        }
        response = Some(slider);
    }
    let field_name = match response {
        Some(_) => format!("{} (number)", spec.name),
        None => spec.name.clone(),
    };
    let field = drag_value(&mut shown, spec, scale)
        .suffix(suffix)
        .max_decimals(decimals);
    let field = number_field(ui, field);
    name(&field, &field_name);
    changed |= field.changed();
    let response = match response {
        Some(slider) => slider | field,
        None => field,
    };
    let value = (shown / scale) as f32;
    Edited {
        value: (changed && value.is_finite()).then_some(value),
        response,
    }
}

/// Whether a slider was moved. A right click moves it as well, but opens a menu.
fn is_slid(ui: &Ui, slider: &Response) -> bool {
    let by_menu = ui.input(|input| {
        let pointer = &input.pointer;
        pointer.secondary_down() || pointer.button_released(PointerButton::Secondary)
    });
    slider.changed() && !by_menu
}

fn drag_value<'v>(shown: &'v mut f64, spec: &Spec<'_>, scale: f64) -> DragValue<'v> {
    let extent = match spec.range {
        Some((low, high)) if spec.widget != Widget::Log => f64::from(high - low) * scale,
        // Where nothing is said about its size: by its own. Nothing is as good as 1.
        _ if *shown == 0.0 => scale,
        _ => shown.abs().max(0.01 * scale),
    };
    let Bounds { min, max } = spec.bounds;
    DragValue::new(shown)
        .speed(extent / 300.0)
        .range(min * scale..=max * scale)
        .clamp_existing_to_range(false)
}

fn whole(ui: &mut Ui, spec: &Spec<'_>, value: i64, bounds: (i64, i64)) -> Edited<i64> {
    let bounds = (
        bounds.0.max(spec.bounds.min as i64),
        bounds.1.min(spec.bounds.max as i64),
    );
    let mut shown = value;
    let mut response = None;
    if let (Some((low, high)), true) = (spec.range, spec.widget != Widget::Seed) {
        let slider = Slider::new(&mut shown, low.ceil() as i64..=high.floor() as i64)
            .show_value(false)
            .logarithmic(spec.widget == Widget::Log)
            .clamping(SliderClamping::Never);
        let slider = ui.add(slider);
        name(&slider, &spec.name);
        if !is_slid(ui, &slider) {
            shown = value;
        }
        response = Some(slider);
    }
    let field_name = match response {
        Some(_) => format!("{} (number)", spec.name),
        None => spec.name.clone(),
    };
    let suffix = spec.scale().1;
    let field = DragValue::new(&mut shown)
        .range(bounds.0..=bounds.1)
        .clamp_existing_to_range(false)
        .speed(0.1)
        .suffix(suffix);
    let field = number_field(ui, field);
    name(&field, &field_name);
    let mut response = match response {
        Some(slider) => slider | field,
        None => field,
    };
    if spec.widget == Widget::Seed {
        let button = ui.button("New").on_hover_text("draws another number");
        name(&button, &format!("New {}", spec.name));
        if button.clicked() {
            // Any number does, so long as the next one looks unlike it.
            shown = i64::from((value as u32 ^ 0x9e37_79b9).wrapping_mul(0x85eb_ca6b) >> 12);
        }
        response |= button;
    }
    Edited {
        response,
        value: (shown != value).then(|| shown.clamp(bounds.0, bounds.1)),
    }
}

/// Number fields in a row.
fn fields(
    ui: &mut Ui,
    spec: &Spec<'_>,
    parts: &[&str],
    values: &mut [f32],
    decimals: usize,
) -> Edited<()> {
    let mut changed = false;
    let mut all = None;
    for (value, part) in values.iter_mut().zip(parts) {
        let edited = number_in(ui, &spec.part(part), *value, decimals);
        if let Some(new) = edited.value {
            *value = new;
            changed = true;
        }
        all = Some(match all {
            Some(all) => all | edited.response,
            None => edited.response,
        });
    }
    Edited {
        response: all.unwrap_or_else(|| ui.label("")),
        value: changed.then_some(()),
    }
}

fn vector<const N: usize>(ui: &mut Ui, spec: &Spec<'_>, value: &[f32; N]) -> Edited<[f32; N]> {
    let mut shown = *value;
    let edited = fields(ui, spec, &["x", "y", "z", "w"], &mut shown, DECIMALS);
    edited.map(|()| shown)
}

fn color<const N: usize>(ui: &mut Ui, spec: &Spec<'_>, value: [f32; N]) -> Edited<[f32; N]> {
    let mut shown = value;
    let mut rgb = [shown[0], shown[1], shown[2]];
    // Picker and four numbers fit into a panel of usual width.
    let spacing = ui.spacing().clone();
    ui.spacing_mut().interact_size.x = PICKER;
    ui.spacing_mut().item_spacing.x = 3.0;
    let picker = ui.color_edit_button_rgb(&mut rgb);
    name(&picker, &spec.name);
    // The picker works in another colour space: untouched colours would not come back to the bit.
    let is_picked = picker.changed() && rgb.iter().all(|x| x.is_finite());
    if is_picked {
        shown[..3].copy_from_slice(&rgb);
    }
    let parts = Spec {
        widget: Widget::Plain,
        ..spec.clone()
    };
    ui.spacing_mut().interact_size.x = 0.0;
    ui.spacing_mut().button_padding.x = 2.0;
    let names = ["red", "green", "blue", "alpha"];
    let edited = fields(ui, &parts, &names, &mut shown, COLOR_DECIMALS);
    *ui.spacing_mut() = spacing;
    Edited {
        value: (is_picked || edited.value.is_some()).then_some(shown),
        response: picker | edited.response,
    }
}

/// Columns of a matrix, each a column of the table.
fn matrix<const N: usize>(
    ui: &mut Ui,
    spec: &Spec<'_>,
    columns: &[[f32; N]; N],
) -> Edited<[[f32; N]; N]> {
    let mut shown = *columns;
    let mut changed = false;
    let grid = egui::Grid::new(&spec.name).show(ui, |ui| {
        for row in 0..N {
            for (column, values) in shown.iter_mut().enumerate() {
                let edited = number(ui, &spec.part(&format!("{column},{row}")), values[row]);
                if let Some(new) = edited.value {
                    values[row] = new;
                    changed = true;
                }
            }
            ui.end_row();
        }
    });
    Edited {
        response: grid.response,
        value: changed.then_some(shown),
    }
}

/// So many values of an array are always there, to be walked through by the keyboard; of more, those that are seen.
const MOST_ROWS: usize = 64;

fn array(ui: &mut Ui, spec: &Spec<'_>, items: &[Value]) -> Edited<Vec<Value>> {
    let mut changed = None;
    let mut row = |ui: &mut Ui, i: usize| {
        let content = |ui: &mut Ui| {
            ui.weak(i.to_string());
            let part = Spec {
                range: spec.range,
                ..spec.part(&i.to_string())
            };
            if let Some(value) = edit(ui, &part, &items[i]).value {
                changed = Some((i, value));
            }
        };
        // Under its number: what is typed into stays the same field when rows before it aren't drawn any more.
        ui.push_id(i, |ui| ui.horizontal(content));
    };
    let shown = ui.vertical(|ui| {
        let count = items.len();
        let top = ui.cursor().top();
        let drawn = count.min(MOST_ROWS);
        (0..drawn).for_each(|i| row(ui, i));
        if drawn < count {
            // All rows are as high: of so many, only those that are seen are drawn.
            let height = (ui.cursor().top() - top) / drawn as f32;
            let at = |y: f32| ((y - top) / height.max(1.0)).clamp(drawn as f32, count as f32);
            let clip = ui.clip_rect();
            let first = at(clip.top()).floor() as usize;
            let end = at(clip.bottom()).ceil() as usize;
            ui.add_space((first - drawn) as f32 * height);
            (first..end).for_each(|i| row(ui, i));
            ui.add_space((count - end) as f32 * height);
        }
    });
    let value = changed.map(|(i, value)| {
        let mut items = items.to_vec();
        items[i] = value;
        items
    });
    Edited {
        response: shown.response,
        value,
    }
}
