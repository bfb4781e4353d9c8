//! A thousand random edits, with failing sources in between.

use engine::scene::look::{AoDirection, AoSettings, Value};
use engine::session::{Edit, Session, SessionError};
use texgen::{Interpolation, Ramp};

use super::look::{LOOK, RINGS, SQUARES, TEXTURES};
use super::stage::{Stage, film, is_same, settle};
use crate::support::device;

/// Marsaglia's xorshift, 32 bits.
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    fn below(&mut self, n: u32) -> u32 {
        self.next() % n
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u32) as usize]
    }

    fn color(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.unit())
    }
}

/// Any edit at all; some are refused.
fn any(random: &mut Random) -> Vec<Edit> {
    let unit = Value::number(random.unit());
    let scalars = ["rings", "other", "paint.x", "worn.y", "extra"];
    let one = |edit| vec![edit];
    match random.below(20) {
        0 | 1 => {
            let node = random.pick(&["rings", "other", "extra"]);
            one(Edit::argument(
                node,
                "count",
                &texgen::Value::F32(9.0 * random.unit()),
            ))
        }
        2 => one(Edit::argument(
            "paint",
            "color",
            &texgen::Value::Vec3(random.color()),
        )),
        3 => one(Edit::argument(
            "worn",
            "scale",
            &texgen::Value::F32(1.0 + random.unit()),
        )),
        4 => {
            let stops = (0..1 + random.below(4)).map(|_| {
                let [r, g, b] = random.color();
                (random.unit(), [r, g, b, 1.0])
            });
            let ramp = Ramp {
                stops: stops.collect(),
                interpolation: random.pick(&[Interpolation::Linear, Interpolation::Smooth]),
            };
            one(Edit::argument("worn", "ramp", &texgen::Value::Ramp(ramp)))
        }
        5 => one(Edit::link("paint", "amount", random.pick(&scalars))),
        6 => one(Edit::link(
            random.pick(&["rings", "other"]),
            "count",
            random.pick(&scalars),
        )),
        7 => one(Edit::reset(
            random.pick(&["rings", "paint"]),
            random.pick(&["count", "amount"]),
        )),
        8 => {
            let settings = AoSettings {
                distance: 0.1 + random.unit(),
                direction: random.pick(&[AoDirection::Outside, AoDirection::Both]),
                samples: 1 + random.below(6),
                same_object: random.below(2) == 1,
            };
            Edit::ao("crevices", &settings).to_vec()
        }
        9 => one(Edit::material(
            "Floor",
            "base_color",
            Value::numbers(&random.color()),
        )),
        10 => {
            let node = random.pick(&["paint", "worn", "rings"]);
            one(Edit::material(
                "Floor",
                "base_color",
                Value::Text(node.to_owned()),
            ))
        }
        11 => {
            let key = random.pick(&["roughness", "metallic", "specular"]);
            let node = Value::Text(random.pick(&scalars).to_owned());
            one(Edit::material(
                random.pick(&["Floor", "Wall", "Worn"]),
                key,
                node,
            ))
        }
        12 => {
            let key = random.pick(&["roughness", "metallic", "coat_roughness", "anisotropy"]);
            one(Edit::material(
                random.pick(&["Floor", "Wall", "Worn"]),
                key,
                unit,
            ))
        }
        13 => one(Edit::reset_material(
            random.pick(&["Floor", "Wall"]),
            random.pick(&["roughness", "metallic", "base_color"]),
        )),
        14 => one(Edit::material("Wall", "blend.mask", unit)),
        15 => {
            let node = Value::Text(random.pick(&["rings", "other"]).to_owned());
            one(Edit::material("Wall", "blend.mask", node))
        }
        16 => one(Edit::environment("intensity", unit)),
        17 => one(Edit::environment("color", Value::numbers(&random.color()))),
        18 => {
            let [x, y, z] = random.color();
            one(Edit::camera(
                "position",
                Value::numbers(&[x, 0.5 + y, 2.0 + z]),
            ))
        }
        _ => match random.below(2) {
            0 => one(Edit::add_node("extra", "rings")),
            _ => one(Edit::remove_node("extra")),
        },
    }
}

/// The look with tangents on all meshes: they are made when something lies along them for the first time, and what is wrong with edits
/// meanwhile is told later.
fn brushed() -> String {
    let mut look = LOOK.to_owned();
    for name in ["Floor", "Wall", "Worn"] {
        let head = format!("[material.{name}]\n");
        assert!(look.contains(&head), "{name}");
        look = look.replace(&head, &format!("{head}anisotropy = 0.1\n"));
    }
    look
}

fn is_refused(session: &mut Session, edits: &[Edit]) -> bool {
    match session.edit_all(edits) {
        Ok(()) => false,
        Err(SessionError::Refused(_)) => true,
        Err(error) => panic!("{edits:?}: {error}"),
    }
}

#[test]
fn a_thousand_random_edits_give_the_picture_of_the_final_look() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(&brushed(), &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let mut random = Random(0x2545_f491);
    let mut refused = 0;
    for step in 0..1000 {
        let edits = any(&mut random);
        refused += u32::from(is_refused(&mut session, &edits));
        if step % 7 == 0 {
            session
                .step(2)
                .unwrap_or_else(|error| panic!("step {step}: {error}"));
        }
        // A source that is wrong for a while, in the middle of the edits.
        match step % 250 {
            50 => stage.write(
                "textures/rings.wgsl",
                "fn userProc(count: f32) -> f32 { return cuont; }",
            ),
            100 => stage.write("textures/rings.wgsl", "fn userProc(cou"),
            150 => stage.write(
                "textures/rings.wgsl",
                if step < 500 { SQUARES } else { RINGS },
            ),
            _ => continue,
        }
        session.sources_changed();
        settle(&mut session);
        assert_eq!(
            !session.problems().is_empty(),
            step % 250 < 150,
            "{}",
            session.problems()
        );
        if step % 500 == 400 {
            let fresh = stage.fresh(&session.look_text());
            assert!(
                is_same(&film(&mut session), &fresh),
                "after step {step}\n{}",
                session.look_text()
            );
        }
    }
    assert!((1..500).contains(&refused), "{refused} edits were refused");
    settle(&mut session);
    assert!(
        session.is_up_to_date() && session.problems().is_empty(),
        "{}",
        session.problems()
    );
    let fresh = stage.fresh(&session.look_text());
    assert!(
        is_same(&film(&mut session), &fresh),
        "{}",
        session.look_text()
    );
}

#[test]
fn what_is_saved_after_random_edits_is_what_is_shown() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(&brushed(), &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let mut random = Random(0x9e37_79b9);
    for _ in 0..100 {
        let edits = any(&mut random);
        is_refused(&mut session, &edits);
    }
    settle(&mut session);
    session
        .save(Some(&stage.path("saved.look.toml")))
        .unwrap_or_else(|error| panic!("{error}"));
    let mut again = stage.open("saved.look.toml");
    assert_eq!(again.look_text(), session.look_text());
    assert!(is_same(&film(&mut session), &film(&mut again)));
    // What no edit names is as it was, and where it was.
    let text = session.look_text();
    for line in [
        "# A look to be edited.",
        "# Rings around the origin.",
        "# Not in the scene.",
        "look_at = [0, 0.4, 0]",
    ] {
        assert!(
            text.lines().any(|l| l == line),
            "{line} is missing:\n{text}"
        );
    }
}
