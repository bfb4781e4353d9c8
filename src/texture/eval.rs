//! `patina texture eval`: the value of a texture at points.

use device::Device;
use engine::evaluate::{EvaluateError, Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::scene::look::Look;
use texgen::Diagnostic;

use crate::console;
use crate::failure::Failure;
use crate::progress::Bar;

use super::job::{EvalJob, TargetJob};
use super::written;

/// Prints a line per point: as many numbers as the texture gives, as JSON an array of them.
///
/// # Errors
/// Mistakes in the texture, its arguments or points; no device.
pub(crate) fn run(job: &EvalJob) -> Result<(), Failure> {
    let TargetJob {
        name,
        look,
        sets,
        texture_dirs,
        device,
    } = &job.target;
    let sources = super::sources(texture_dirs, look.as_deref())?;
    let look = look.as_deref().map(Look::load).transpose()?;
    let subject = match &look {
        Some(look) => Subject::Node(name, look),
        None => Subject::Texture(name),
    };
    let mut isolated = Isolated::new(subject, &sources)?;
    let textures = isolated.procedural().graph().library().textures();
    for texture in textures {
        console::diagnostics(texture.warnings());
    }
    for (parameter, value) in sets {
        isolated.set(parameter, value).map_err(Failure::because)?;
    }
    let components = isolated.output().components();

    let bar = Bar::new("preparing the device");
    let device = Device::open(device).map_err(Failure::because)?;
    bar.follow(&device);
    let point = |values: &Vec<(String, Vec<f32>)>| {
        let point = Point::new();
        (values.iter()).fold(point, |point, (name, value)| point.with(name, value))
    };
    let points: Vec<Point> = job.points.iter().map(point).collect();
    let evaluated = Evaluator::new(&device, isolated).evaluate(&points);
    let values = evaluated.map_err(|error| of_target(error, &job.target))?;
    bar.finish();
    for value in values {
        console::print(&line(&value[..components]));
    }
    Ok(())
}

/// Where a node of a look needs too much at once, with its place.
fn of_target(error: EvaluateError, target: &TargetJob) -> Failure {
    match (&error, &target.look) {
        (EvaluateError::TooManySlots { .. }, Some(look)) => {
            let message = format!("node `{}` of {}: {error}", target.name, look.display());
            let note = "use fewer nodes that are read again far behind, or combine them earlier";
            Diagnostic::error(message).with_note(note).into()
        }
        _ => error.into(),
    }
}

fn line(value: &[f32]) -> String {
    if console::is_json() {
        // What is not finite has no number in JSON: it becomes null.
        return serde_json::to_string(value).unwrap_or_default();
    }
    let numbers: Vec<String> = value.iter().map(|&v| written::number(v)).collect();
    numbers.join(" ")
}

impl From<EvaluateError> for Failure {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Mistakes(mistakes) => mistakes.into(),
            _ => Self::because(error),
        }
    }
}
