use scene::view::{View, ViewTransform, WhiteBalance};

use super::*;

/// 1/255, the least that a file of 8 bits can be off by.
const STEP: f32 = 1.0 / 255.0;

/// A colour and its codes.
type Known = ([f32; 3], [f32; 3]);

const AGX: &[Known] = &[
    ([0.18, 0.18, 0.18], [0.4613, 0.4613, 0.4614]),
    ([0.0, 0.0, 0.0], [0.0000, 0.0000, 0.0000]),
    ([0.8, 0.2, 0.1], [0.7778, 0.4924, 0.3888]),
    ([4.0, 0.1, 0.02], [0.9927, 0.6121, 0.5505]),
    ([0.02, 0.05, 3.0], [0.4675, 0.5849, 0.9467]),
    ([-0.2, 0.5, 0.1], [0.0000, 0.6481, 0.4449]),
    ([30.0, 30.0, 29.0], [1.0000, 1.0000, 1.0000]),
    ([100.0, 2.0, 40.0], [1.0000, 0.9948, 1.0000]),
];
const FILMIC: &[Known] = &[
    ([0.18, 0.18, 0.18], [0.5002, 0.5002, 0.5002]),
    ([0.0, 0.0, 0.0], [0.0000, 0.0000, 0.0000]),
    ([0.8, 0.2, 0.1], [0.7738, 0.5207, 0.3883]),
    ([4.0, 0.1, 0.02], [0.9494, 0.3883, 0.1592]),
    ([0.02, 0.05, 3.0], [0.1592, 0.2731, 0.9288]),
    ([-0.2, 0.5, 0.1], [0.0000, 0.6950, 0.3883]),
    ([30.0, 30.0, 29.0], [1.0000, 1.0000, 1.0000]),
    ([100.0, 2.0, 40.0], [1.0000, 0.9301, 1.0000]),
];
const ACES2: &[Known] = &[
    ([0.18, 0.18, 0.18], [0.3492, 0.3492, 0.3492]),
    ([0.0, 0.0, 0.0], [0.0000, 0.0000, 0.0000]),
    ([0.8, 0.2, 0.1], [0.7047, 0.3848, 0.2813]),
    ([4.0, 0.1, 0.02], [1.0000, 0.4860, 0.3828]),
    ([0.02, 0.05, 3.0], [0.3102, 0.3661, 1.0000]),
    ([-0.2, 0.5, 0.1], [0.0003, 0.5391, 0.3560]),
    ([30.0, 30.0, 29.0], [0.9879, 0.9879, 0.9877]),
    ([100.0, 2.0, 40.0], [1.0000, 0.9819, 0.9893]),
];

fn encoder(transform: ViewTransform) -> ViewEncoder {
    ViewEncoder::new(&View {
        transform,
        ..View::default()
    })
}

/// Colours with what OpenColorIO 2.6 makes of them with Blender 5.0's configuration, for a display of sRGB; neutral after the
/// formula, as Blender's table is off at dark colours. `cargo xtask views` compares thousands.
#[test]
fn known_colors_are_within_a_step() {
    let known: [(ViewTransform, &[Known]); 5] = [
        (
            ViewTransform::Standard,
            &[
                ([0.18; 3], [0.4614; 3]),
                ([-1.0, 0.5, 7.0], [0.0, 0.7354, 1.0]),
            ],
        ),
        (ViewTransform::Agx, AGX),
        (ViewTransform::Filmic, FILMIC),
        (ViewTransform::Aces2, ACES2),
        (
            ViewTransform::KhronosNeutral,
            &[
                ([0.18; 3], [0.4100; 3]),
                ([0.0; 3], [0.0; 3]),
                ([0.8, 0.2, 0.1], [0.8860, 0.4366, 0.2717]),
                ([4.0, 0.1, 0.02], [0.9927, 0.6005, 0.5887]),
            ],
        ),
    ];
    for (transform, colors) in known {
        let encoder = encoder(transform);
        for (color, expected) in colors {
            let code = encoder.encode(*color);
            for (code, expected) in code.iter().zip(expected) {
                assert!(
                    (code - expected).abs() < STEP,
                    "{transform:?} {color:?}: {code} {expected}"
                );
            }
        }
    }
}

#[test]
fn whatever_comes_becomes_a_code() {
    let odd = [
        0.0,
        -0.0,
        -1e30,
        1e30,
        1e-40,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
    ];
    for transform in ViewTransform::ALL {
        let encoder = encoder(transform);
        for r in odd {
            for g in odd {
                let shown = encoder.encode8(&[[r, g, 0.18]]);
                assert_eq!(shown.len(), 3, "{transform:?}");
            }
        }
        assert_eq!(encoder.encode8(&[[0.0; 3]]), [0; 3], "{transform:?}");
        let white = encoder.encode8(&[[1e5; 3]]);
        assert!(
            white.iter().all(|&code| code >= 254),
            "{transform:?} {white:?}"
        );
    }
}

#[test]
fn greys_stay_grey_and_in_order() {
    for transform in ViewTransform::ALL {
        let encoder = encoder(transform);
        let mut before = -1.0;
        for i in 0..200 {
            let [r, g, b] = encoder.encode([2.0_f32.powf(-10.0 + 0.08 * i as f32); 3]);
            let spread = r.max(g).max(b) - r.min(g).min(b);
            assert!(spread < STEP, "{transform:?} {r} {g} {b}");
            assert!(g >= before - 1e-5, "{transform:?} {i}: {g} {before}");
            before = g;
        }
    }
}

#[test]
fn exposure_and_white_balance_come_before_the_transform() {
    let view = View {
        exposure: 1.0,
        white_balance: Some(WhiteBalance {
            temperature: 4000.0,
            tint: 0.0,
        }),
        transform: ViewTransform::Agx,
    };
    let shown = ViewEncoder::new(&view);
    let balance = shown.balance().expect("there is one");
    let color = glam::Vec3::new(0.4, 0.2, 0.1);
    let plain = encoder(ViewTransform::Agx).encode((balance * color * 2.0).to_array());
    for (a, b) in shown.encode(color.to_array()).iter().zip(plain) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}
