//! What is exchanged with the drivers in `benches/peers` as JSON. Their side: `jobs.py`, `scenes.py`, `pictures.py`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// What a driver is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Task {
    /// One render for each number of samples.
    Render,
    /// Gray, rust and scratches in turn.
    Textures,
}

/// A job for a driver.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Job {
    pub(super) task: Task,
    /// glTF.
    pub(super) scene: PathBuf,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Samples per pixel.
    pub(super) spp: Vec<u32>,
    /// Folder for pictures.
    pub(super) out: PathBuf,
    /// Most scattering vertices of a path.
    pub(super) max_depth: u32,
    pub(super) threads: u32,
    pub(super) seed: u32,
    /// Radiance of the environment, linear Rec.709.
    pub(super) environment: [f64; 3],
    /// The program to measure.
    pub(super) patina: PathBuf,
    /// Which build of it that is, in its own jobs: another one is another job.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) build: Option<String>,
    /// Rays of ambient occlusion at a hit.
    pub(super) ao_samples: Vec<u32>,
    /// Timed renders of each texture.
    pub(super) runs: u32,
}

impl Job {
    /// Whether its results are those of a job that was written before. Where a program lies makes none, [`Self::build`] tells one from
    /// another; and of pictures not what is read of textures alone.
    pub(super) fn gives_the_same_as(&self, written: &str) -> bool {
        let counting = |text: &str| {
            let mut job: Map<String, Value> = serde_json::from_str(text).ok()?;
            job.remove("patina");
            if self.task == Task::Render {
                job.remove("ao_samples");
                job.remove("runs");
            }
            Some(job)
        };
        // Both are read from text, so that their numbers are read alike.
        let own = serde_json::to_string(self).ok();
        let own = own.and_then(|own| counting(&own));
        own.is_some() && own == counting(written)
    }
}

/// What a driver did.
#[derive(Debug, Deserialize)]
pub(super) struct Outcome {
    /// Variant, device, driver.
    pub(super) details: String,
    /// Before the first timed render.
    pub(super) load_seconds: f64,
    pub(super) renders: Vec<Render>,
    pub(super) cases: Vec<TextureCase>,
}

/// A timed render.
#[derive(Debug, Deserialize)]
pub(super) struct Render {
    pub(super) spp: u32,
    /// Wall time without loading and compiling.
    pub(super) seconds: f64,
    pub(super) picture: PathBuf,
}

/// A texture and what it costs.
#[derive(Debug, Deserialize)]
pub(super) struct TextureCase {
    /// How the renderer evaluates textures.
    pub(super) form: String,
    pub(super) texture: String,
    /// Wall time of a sample of all pixels.
    pub(super) ms_per_spp: f64,
    /// More than gray takes.
    pub(super) increase_percent: Spread,
    /// From an edit to one sample of all pixels.
    pub(super) edit_ms: f64,
    /// One sample of all pixels without an edit; 0 where that isn't measured.
    pub(super) unedited_ms: f64,
}

/// Median and range of runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Spread {
    pub(super) median: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Spread {
    /// Of at least one number.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let last = values.len() - 1;
        Self {
            median: 0.5 * (values[last / 2] + values[last.div_ceil(2)]),
            low: values[0],
            high: values[last],
        }
    }
}

/// The scenes that were written.
#[derive(Debug, Deserialize)]
pub(super) struct SceneList {
    pub(super) scenes: Vec<Listed>,
    pub(super) skipped: Vec<Skipped>,
    /// What they were made of; older lists don't say it.
    #[serde(default)]
    pub(super) origin: Option<Origin>,
}

/// The folders that scenes are made of.
#[derive(Debug, PartialEq, Eq, Deserialize)]
pub(super) struct Origin {
    pub(super) scenes: PathBuf,
    pub(super) reference: PathBuf,
}

/// A scene that was written.
#[derive(Debug, Deserialize)]
pub(super) struct Listed {
    pub(super) name: String,
    pub(super) task: Task,
    pub(super) file: PathBuf,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) triangles: u64,
    /// Radiance of the environment, linear Rec.709.
    pub(super) environment: [f64; 3],
    /// A converged picture.
    pub(super) reference: Option<PathBuf>,
}

/// A scene whose files aren't there.
#[derive(Debug, Deserialize)]
pub(super) struct Skipped {
    pub(super) name: String,
    pub(super) reason: String,
}

/// A picture that is compared.
#[derive(Debug, Serialize)]
pub(super) struct Pictures {
    pub(super) file: PathBuf,
    pub(super) spp: u32,
}

/// How far pictures are from their reference.
#[derive(Debug, Deserialize)]
pub(super) struct Comparison {
    pub(super) errors: Vec<PictureError>,
}

/// How far a picture is from its reference.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct PictureError {
    pub(super) spp: u32,
    pub(super) relative_rmse: f64,
    /// Mean of the picture over that of the reference.
    pub(super) level: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(task: Task) -> Job {
        Job {
            task,
            scene: "a.gltf".into(),
            width: 4,
            height: 3,
            spp: vec![1],
            out: "out".into(),
            max_depth: 9,
            threads: 2,
            seed: 0,
            environment: [0.0; 3],
            patina: "patina".into(),
            build: Some("1 byte".to_owned()),
            ao_samples: vec![4],
            runs: 3,
        }
    }

    #[test]
    fn pictures_are_kept_where_nothing_has_changed_that_they_show() {
        let text = |job: &Job| serde_json::to_string_pretty(job).unwrap();
        let others = |task: Task| {
            let elsewhere = Job {
                patina: "elsewhere/patina".into(),
                ..job(task)
            };
            let more_runs = Job {
                runs: 5,
                ..job(task)
            };
            let more_rays = Job {
                ao_samples: vec![4, 16],
                ..job(task)
            };
            let rebuilt = Job {
                build: Some("2 bytes".to_owned()),
                ..job(task)
            };
            let finer = Job {
                spp: vec![2],
                ..job(task)
            };
            [elsewhere, more_runs, more_rays, rebuilt, finer]
                .map(|other| job(task).gives_the_same_as(&text(&other)))
        };
        assert_eq!(others(Task::Render), [true, true, true, false, false]);
        assert_eq!(others(Task::Textures), [true, false, false, false, false]);
        assert!(!job(Task::Render).gives_the_same_as("half of a jo"));
        assert!(!job(Task::Render).gives_the_same_as(&text(&job(Task::Textures))));
    }

    #[test]
    fn a_job_is_what_the_drivers_read() {
        let job = job(Task::Textures);
        let written: serde_json::Value = serde_json::to_value(&job).unwrap();
        assert_eq!(written["task"], "textures");
        // Each field that is written is one of the class `Job` in jobs.py, which refuses others.
        let python = include_str!("../../../benches/peers/jobs.py");
        let class = python.split("class Job:").nth(1).unwrap();
        let class = class.split("@staticmethod").next().unwrap();
        for field in written.as_object().unwrap().keys() {
            assert!(class.contains(&format!("    {field}: ")), "{field}");
        }
    }

    #[test]
    fn a_result_may_say_more_than_is_read() {
        let text = r#"{"details": "CPU", "load_seconds": 1.5, "version": "5.0.1", "peak_mib": 300.0, "cases": [],
            "renders": [{"spp": 4, "seconds": 0.5, "picture": "a.npy"}]}"#;
        let outcome: Outcome = serde_json::from_str(text).unwrap();
        assert_eq!(outcome.renders[0].spp, 4);
    }

    #[test]
    fn a_spread_of_an_even_count_has_its_median_between_two() {
        let spread = Spread::of([4.0, 1.0, 2.0, 3.0]);
        assert_eq!((spread.low, spread.median, spread.high), (1.0, 2.5, 4.0));
    }
}
