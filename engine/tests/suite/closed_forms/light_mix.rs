//! Lights mixed afterwards: by a device and by the processor to the same bit, and as their layers say.

use engine::display::Mixer;
use engine::film::{Film, GroupFactors, Layer, Layers, LightMix};
use engine::renderer::Renderer;
use engine::scene::Scene;
use engine::settings::RenderSettings;
use glam::Vec3;

use super::light_layers::{SHOT, everything};
use crate::support::device;
use crate::support::scenes::{no_textures, settings};

struct Stage {
    device: ::device::Device,
    scene: Scene,
    renderer: Renderer,
    film: Film,
}

impl Stage {
    fn new() -> Option<Self> {
        let device = device::open()?;
        let (mut scene, camera) = everything();
        let procedural = no_textures(&mut scene);
        let settings = RenderSettings {
            layers: Layers::named(["light_groups"])
                .expect("known")
                .of_scene(&scene),
            ..settings(&camera, SHOT)
        };
        let mut renderer =
            Renderer::new(&device, &scene, &procedural, &settings).expect("a renderer");
        renderer.render(SHOT.spp).expect("rendered");
        let film = renderer.film().expect("read");
        Some(Self {
            device,
            scene,
            renderer,
            film,
        })
    }

    /// `None`, where the mix changes nothing.
    fn factors(&self, mix: &[(&str, Vec3)]) -> Option<GroupFactors> {
        let mut factors = LightMix::default();
        for (name, factor) in mix {
            factors.set(name, factor.to_array());
        }
        factors.of(&self.scene.light_groups)
    }

    /// By the device, which is told to mix it again and again.
    fn mixed(&mut self, mixer: &mut Mixer, factors: &GroupFactors) -> Vec<Vec3> {
        let film = self.renderer.device_film().expect("there");
        assert!(film.has_groups());
        let mixed = mixer.mix(&film, factors).expect("mixed");
        assert!(!mixed.has_groups());
        let on_device = mixed.radiance(&self.device).expect("read");
        assert_eq!(on_device, self.film.mixed(factors).mean());
        on_device.into_iter().map(Vec3::from).collect()
    }

    fn group(&self, number: usize) -> Vec<Vec3> {
        let layer = Layer::named(&format!("light_group_{number}")).expect("there is such a layer");
        let values = self.film.values(layer).expect("it was asked for");
        values.into_iter().map(Vec3::from).collect()
    }
}

#[test]
fn a_mix_is_the_sum_of_its_groups() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let mut mixer = Mixer::new(&stage.device).expect("compiled");
    assert_eq!(stage.factors(&[("day", Vec3::ONE)]), None);
    let names = ["rest", "day", "bulbs", "lamp"];
    let groups: Vec<_> = (0..names.len()).map(|number| stage.group(number)).collect();
    let dark = Vec3::ZERO;
    let kernels = stage.device.counts().pipelines;
    for factors in [
        // One off, as the picture would be without it; one alone; tinted; far brighter, beside one that is as it is.
        [Vec3::ONE, dark, Vec3::ONE, Vec3::ONE],
        [dark, dark, Vec3::ONE, dark],
        [Vec3::ONE, Vec3::new(0.2, 0.5, 1.0), Vec3::ONE, Vec3::ONE],
        [Vec3::splat(0.3), Vec3::ONE, Vec3::splat(8.0), dark],
    ] {
        let mix: Vec<_> = names.into_iter().zip(factors).collect();
        let wanted = stage.factors(&mix).expect("not all are 1");
        let mixed = stage.mixed(&mut mixer, &wanted);
        for (pixel, mixed) in mixed.into_iter().enumerate() {
            let parts = groups.iter().zip(factors);
            let sum: Vec3 = parts.map(|(group, factor)| group[pixel] * factor).sum();
            let whole: Vec3 = groups.iter().map(|group| group[pixel]).sum();
            // Each sample's parts are rounded one by one, so that what is taken away leaves as much behind.
            let off = (mixed - sum).abs().max_element();
            assert!(
                off <= 1e-5 * whole.max_element().max(1e-3),
                "pixel {pixel}: {mixed} {sum}"
            );
        }
    }
    assert_eq!(stage.device.counts().pipelines, kernels);
}

#[test]
fn films_are_left_as_they_are() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let mut mixer = Mixer::new(&stage.device).expect("compiled");
    let factors = stage.factors(&[("day", Vec3::ZERO), ("rest", Vec3::splat(2.0))]);
    let factors = factors.expect("not all are 1");
    stage.mixed(&mut mixer, &factors);
    let after = stage.renderer.film().expect("read");
    assert!(after == stage.film, "samples go on where they were");
    // A copy of it mixes alike, also in another size, by another mixer with the same kernel.
    let kernels = stage.device.counts().pipelines;
    let film = stage.renderer.device_film().expect("there");
    let copy = film.copy(&stage.device).expect("copied");
    stage.renderer.resize(8, 5).expect("a size");
    stage.renderer.render(2).expect("rendered");
    let mut another = mixer.another();
    let mixed = another.mix(&copy, &factors).expect("mixed");
    let mixed = mixed.radiance(&stage.device).expect("read");
    assert_eq!(mixed, stage.film.mixed(&factors).mean());
    stage.film = stage.renderer.film().expect("read");
    stage.mixed(&mut another, &factors);
    // Without groups there is nothing to be mixed.
    let picture = stage.renderer.device_film().expect("there").picture();
    let same = mixer.mix(&picture, &factors).expect("mixed");
    let same = same.radiance(&stage.device).expect("read");
    assert_eq!(same, stage.film.mean());
    assert_eq!(stage.device.counts().pipelines, kernels);
}
