//! A scene with look and textures in a folder of its own, rendered live.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::device::{Device, DeviceError};
use engine::film::Film;
use engine::renderer::RenderSettings;
use engine::session::{Inputs, Session, SessionError};
use tempfile::TempDir;

use crate::support::device;

/// Two squares, a floor and a wall behind it, with texture coordinates, each of its own material, and a camera.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1, 2] }],
  "nodes": [
    { "name": "Floor", "mesh": 0 },
    { "name": "Wall", "mesh": 1, "translation": [0, 1, -1], "rotation": [0.7071068, 0, 0, 0.7071068] },
    { "name": "View", "camera": 0, "translation": [0, 0.8, 3.2] }
  ],
  "cameras": [{ "name": "View", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
  "materials": [
    { "name": "Floor", "pbrMetallicRoughness": { "baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0, "roughnessFactor": 0.7 } },
    { "name": "Wall", "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.4, 0.3, 1], "metallicFactor": 0.1, "roughnessFactor": 0.5 } }
  ],
  "meshes": [
    { "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0 }] },
    { "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 1 }] }
  ],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1] },
    { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
    { "bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR" }
  ],
  "bufferViews": [
    { "buffer": 0, "byteLength": 48 },
    { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
    { "buffer": 0, "byteOffset": 80, "byteLength": 12 }
  ],
  "buffers": [{ "byteLength": 92, "uri": "squares.bin" }]
}"#;

/// The files, gone when it is dropped.
pub(crate) struct Stage {
    folder: TempDir,
}

impl Stage {
    /// The scene with a look and textures.
    pub(crate) fn new(look: &str, textures: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let stage = Self { folder };
        let corners: [[f32; 3]; 4] = [
            [-1.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, -1.0],
            [-1.0, 0.0, -1.0],
        ];
        let uvs: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&corners).to_vec();
        bytes.extend(bytemuck::cast_slice::<_, u8>(&uvs));
        bytes.extend(bytemuck::cast_slice::<u16, u8>(&[0, 1, 2, 0, 2, 3]));
        fs::write(stage.path("squares.bin"), bytes).expect("written");
        stage.write("scene.gltf", SCENE);
        stage.write("scene.look.toml", look);
        fs::create_dir(stage.path("textures")).expect("a folder");
        for (name, text) in textures {
            stage.write(&format!("textures/{name}.wgsl"), text);
        }
        stage
    }

    /// A file of the stage.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file in place.
    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("the folder can be written");
    }

    /// Writes a file aside and renames it, as many editors do.
    pub(crate) fn replace(&self, name: &str, text: &str) {
        let aside = self.path("aside.tmp");
        fs::write(&aside, text).expect("the folder can be written");
        fs::rename(aside, self.path(name)).expect("renamed");
    }

    /// Rendered live, with a look of that name.
    pub(crate) fn open(&self, look: &str) -> Session {
        self.open_on(look, || Device::open(&device::choice()))
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// On a device of one's own.
    pub(crate) fn open_on(
        &self,
        look: &str,
        device: impl Fn() -> Result<Device, DeviceError> + Send + Sync + 'static,
    ) -> Result<Session, SessionError> {
        let inputs = Inputs {
            scene: self.path("scene.gltf"),
            look: Some(self.path(look)),
            textures: vec![self.path("textures")],
            camera: None,
        };
        Session::open(
            inputs,
            Arc::new(device),
            Arc::new(|camera| RenderSettings {
                max_depth: 3,
                ..RenderSettings::new(24, 16, &camera)
            }),
        )
    }

    /// The film of a look by a renderer that knew no other.
    pub(crate) fn fresh(&self, look: &str) -> Film {
        self.fresh_on(look, || Device::open(&device::choice()))
    }

    /// The same on a device of one's own.
    pub(crate) fn fresh_on(
        &self,
        look: &str,
        device: impl Fn() -> Result<Device, DeviceError> + Send + Sync + 'static,
    ) -> Film {
        self.write("fresh.look.toml", look);
        let session = self.open_on("fresh.look.toml", device);
        film(&mut session.unwrap_or_else(|error| panic!("{error}")))
    }
}

/// Samples of the films that are compared.
pub(crate) const SPP: u32 = 4;

/// Waits until nothing is built any more.
pub(crate) fn settle(session: &mut Session) {
    loop {
        session.step(1).unwrap_or_else(|error| panic!("{error}"));
        if !session.is_building() {
            // What has been waiting begins with the next step.
            session.step(1).unwrap_or_else(|error| panic!("{error}"));
            if !session.is_building() {
                return;
            }
        }
        std::thread::yield_now();
    }
}

/// The film after [`SPP`] samples.
pub(crate) fn film(session: &mut Session) -> Film {
    while !(session.step(SPP))
        .unwrap_or_else(|error| panic!("{error}"))
        .is_done()
    {}
    let snapshot = session.snapshot().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        snapshot.film.sample_bounds(),
        (SPP, SPP),
        "all pixels have as many samples"
    );
    snapshot.film
}

/// Whether two films are alike to the bit.
pub(crate) fn is_same(a: &Film, b: &Film) -> bool {
    a == b
}

/// Reads a file of the stage.
pub(crate) fn read(path: &Path) -> String {
    fs::read_to_string(path).expect("the file is there")
}
