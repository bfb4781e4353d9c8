//! Parts of the picture that alone get samples.

use super::*;

#[test]
fn a_region_alone_follows_edits_and_the_picture_of_before_is_kept() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let whole = |stage: &Stage| {
        let status = stage.harness.state().status();
        status.spp >= 4.0 && status.is_whole
    };
    stage.wait("whole picture", whole);
    let size = stage.harness.state().status().size;
    let has = |stage: &Stage| {
        let board = stage.thread.link.board();
        let shown = board.shown.as_ref();
        shown.map_or((false, false), |shown| {
            let [_, before, beside] = &shown.pictures;
            (before.is_some(), beside.is_some())
        })
    };
    stage.thread.link.send(Command::KeepBefore(true));
    stage.wait("picture of before", |stage| has(stage) == (true, false));
    let region = Some([0.0, 0.0, 0.5, 1.0]);
    stage.thread.link.send(Command::Region(region));
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    stage.wait("region", |stage| has(stage) == (true, true));
    for _ in 0..20 {
        stage.harness.run_steps(1);
        assert_eq!(
            stage.harness.state().status().size,
            size,
            "nothing is coarse"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    stage.thread.link.send(Command::Region(None));
    stage.wait("all of it", |stage| {
        has(stage) == (true, false) && whole(stage)
    });
    stage.thread.link.send(Command::KeepBefore(false));
    stage.wait("picture alone", |stage| has(stage) == (false, false));
    stage.thread.finish();
}

#[test]
fn what_lay_beside_a_region_gets_the_samples_that_it_lacks() {
    let Some(mut stage) = Stage::on(&usual_device(), LOOK, 4096) else {
        return;
    };
    let spp = |stage: &Stage| stage.harness.state().status().spp;
    stage.wait("whole picture", |stage| spp(stage) >= 4.0);
    let region = Some([0.0, 0.0, 0.5, 1.0]);
    stage.thread.link.send(Command::Region(region));
    stage.wait("region", |stage| spp(stage) >= 2048.0);
    stage.thread.link.send(Command::Region(None));
    stage.wait("all of it anew", |stage| spp(stage) < 2048.0);
    stage.thread.finish();
}

#[test]
fn a_region_alone_follows_what_others_save() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let whole = |stage: &Stage| {
        let status = stage.harness.state().status();
        status.spp >= 4.0 && status.is_whole
    };
    stage.wait("whole picture", whole);
    let size = stage.harness.state().status().size;
    let beside = |stage: &Stage| {
        let board = stage.thread.link.board();
        let shown = board.shown.as_ref();
        let [_, _, beside] = shown.map(|shown| shown.pictures.clone())?;
        beside
    };
    let answered = |stage: &Stage| stage.harness.state().status().answered;
    let region = Some([0.0, 0.0, 0.5, 1.0]);
    stage.thread.link.send(Command::Region(region));
    let look = Changes {
        look: true,
        ..Changes::default()
    };
    let assets = Changes {
        assets: true,
        ..Changes::default()
    };
    let mut kept = None;
    for (name, text, changes) in [
        // By writes to buffers, and by another renderer.
        ("scene.look.toml", LOOK.replace("0.5 ", "0.25 "), look),
        ("scene.gltf", SCENE.replace("0.7", "0.75"), assets),
    ] {
        let before = answered(&stage);
        fs::write(stage.path(name), text).expect("written");
        stage.changes.send(changes).expect("heard");
        stage.wait("region", |stage| {
            assert_eq!(
                stage.harness.state().status().size,
                size,
                "nothing is coarse"
            );
            beside(stage).is_some() && answered(stage) > before
        });
        let now = beside(&stage);
        assert!(kept.is_none() || kept == now, "it stays");
        kept = now;
    }
    stage.thread.link.send(Command::Region(None));
    stage.wait("all of it", |stage| beside(stage).is_none() && whole(stage));
    stage.thread.finish();
}
