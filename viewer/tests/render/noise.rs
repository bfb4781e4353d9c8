//! Pictures without noise in the window.

use super::*;

#[test]
fn the_picture_is_shown_without_noise_where_that_can_be_done() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.thread.link.send(Command::Denoise(Denoise::Always));
    stage.wait("answer", |stage| {
        stage.harness.state().status().denoiser != DenoiserState::Unknown
    });
    if let DenoiserState::Absent(why) = &stage.harness.state().status().denoiser {
        eprintln!("skipped: {why}");
        assert!(!why.is_empty());
        return stage.thread.finish();
    }
    let is_clean = |stage: &Stage| stage.harness.state().status().denoised == Some(4.0);
    stage.wait("picture without noise", is_clean);
    // Another picture is shown as it is, until there is one of it.
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    stage.wait("picture without noise", |stage| {
        let status = stage.harness.state().status();
        assert!(status.denoised.is_none() || status.spp >= 1.0);
        is_clean(stage)
    });
    assert!(stage.harness.state().status().error.is_some());
    stage.thread.link.send(Command::Denoise(Denoise::Never));
    stage.wait("picture with noise", |stage| !is_clean(stage));
    stage.thread.finish();
}

#[test]
fn noise_is_taken_out_by_itself_and_of_what_is_compared_and_saved() {
    // With some noise that can be seen.
    const LAMP: &str = "environment = { color = [0.01, 0.01, 0.01] }\n\n[light.lamp]\ntype = \"area\"\nposition = [1.0, 0.8, 0.5]\nlook_at = [0, 0, 0]\nsize = [1.5, 1.5]\n";
    let Some(mut stage) = Stage::beginning(LAMP) else {
        return;
    };
    stage.wait("a picture", |stage| {
        stage.harness.state().status().spp >= 4.0
    });
    stage.wait("answer", |stage| {
        stage.harness.state().status().denoiser != DenoiserState::Unknown
    });
    if let DenoiserState::Absent(why) = &stage.harness.state().status().denoiser {
        eprintln!("skipped: {why}");
        return stage.thread.finish();
    }
    let noisy = |stage: &Stage| {
        let [_, before, _] = stage.thread.link.board().shown.clone()?.pictures;
        before
    };
    stage.thread.link.send(Command::KeepBefore(true));
    stage.wait("picture of before", |stage| noisy(stage).is_some());
    let kept = noisy(&stage);
    // Done, with an error that can be seen.
    stage.thread.link.send(Command::Denoise(Denoise::ByItself));
    let is_clean = |stage: &Stage| stage.harness.state().status().denoised.is_some();
    let error = |stage: &Stage| stage.harness.state().status().error.unwrap_or(1.0);
    stage.wait("picture without noise", |stage| {
        error(stage) < FINE || is_clean(stage)
    });
    assert!(error(&stage) > FINE, "{}", error(&stage));
    stage.wait("picture of before without noise", |stage| {
        noisy(stage) != kept
    });
    // With more samples nobody sees it.
    stage.thread.link.send(Command::Target(1 << 20));
    stage.wait("picture with its samples", |stage| {
        error(stage) < FINE && !is_clean(stage)
    });
    // Who asks for it gets it all the same.
    stage.thread.link.send(Command::Denoise(Denoise::Always));
    stage.wait("picture without noise", is_clean);
    let size = [40, 30];
    for (name, layers) in [("clean.png", 1), ("clean.exr", 1)] {
        let order = PictureOrder {
            path: stage.path(name),
            size,
            spp: 2,
            layers: false,
            denoised: true,
            view: View::default(),
        };
        stage.thread.link.send(Command::SavePicture(order));
        stage.wait("written picture", |stage| !stage.read(name).is_empty());
        let text = stage.read(name);
        let start = format!("40 x 30, 2 spp, {layers} layers, without noise by Open Image Denoise");
        assert!(text.starts_with(&start), "{text}");
    }
    stage.thread.finish();
}
