//! A device that is lost: another one takes its place, with the look as it was.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ::device::{Device, DeviceChoice, DeviceError};
use engine::session::{Edit, SessionError};

use super::look::{LOOK, SQUARES, TEXTURES};
use super::stage::{Stage, film, is_same, settle};
use crate::support::device;

fn edit() -> Edit {
    Edit::argument("rings", "count", &texgen::Value::F32(8.0))
}

#[test]
fn a_lost_device_is_replaced() {
    if device::open_driver().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let driver = || Device::open(&DeviceChoice::Driver);
    let opened = stage.open_on("scene.look.toml", driver);
    let mut session = opened.unwrap_or_else(|error| panic!("{error}"));
    session
        .edit(&edit())
        .unwrap_or_else(|error| panic!("{error}"));
    let before = film(&mut session);
    let text = session.look_text();
    let generation = session.generation();
    session.device().gpu().expect("a driver").device().destroy();
    // Files are not needed for it.
    let aside = stage.path("gone");
    std::fs::rename(stage.path("scene.gltf"), &aside).expect("it is there");
    session.restart();
    assert!(
        is_same(&before, &film(&mut session)),
        "the same picture on another device"
    );
    assert_eq!(session.look_text(), text);
    assert!(session.generation() > generation);
    std::fs::rename(&aside, stage.path("scene.gltf")).expect("back");

    // While a kernel is built, and with an edit that meets the dead device.
    stage.write("textures/rings.wgsl", SQUARES);
    session.sources_changed();
    session.device().gpu().expect("a driver").device().destroy();
    let dead = session.edit(&Edit::argument(
        "paint",
        "color",
        &texgen::Value::Vec3([0.2, 0.9, 0.4]),
    ));
    assert!(dead.is_ok(), "{dead:?}");
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(
        &film(&mut session),
        &stage.fresh_on(&session.look_text(), driver)
    ));

    session.device().gpu().expect("a driver").device().destroy();
    session.assets_changed();
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(
        &film(&mut session),
        &stage.fresh_on(&session.look_text(), driver)
    ));
}

#[test]
fn where_no_device_is_left_the_look_is_kept() {
    if device::open_driver().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let has_device = Arc::new(AtomicBool::new(true));
    let switch = Arc::clone(&has_device);
    let mut session = stage
        .open_on("scene.look.toml", move || {
            match switch.load(Ordering::Relaxed) {
                true => Device::open(&DeviceChoice::Driver),
                false => Err(DeviceError::NoAdapter),
            }
        })
        .unwrap_or_else(|error| panic!("{error}"));
    session
        .edit(&edit())
        .unwrap_or_else(|error| panic!("{error}"));
    let before = film(&mut session);
    session.restart();
    has_device.store(false, Ordering::Relaxed);
    session.device().gpu().expect("a driver").device().destroy();
    let error = session.step(1).expect_err("there is no device");
    assert!(matches!(error, SessionError::Lost(_)), "{error}");
    assert!(error.to_string().contains("the look is kept"), "{error}");
    session.save(None).unwrap_or_else(|error| panic!("{error}"));
    let saved = super::stage::read(&stage.path("scene.look.toml"));
    assert!(saved.contains("count = 8.0"), "{saved}");
    has_device.store(true, Ordering::Relaxed);
    assert!(
        is_same(&before, &film(&mut session)),
        "once there is one again"
    );
}
