/// The time of the frame, as a number that grows, or that goes up and down. Constant in a still picture.
/// @group random
/// @param speed per second [-100 .. 100] = 1
/// @param start value at time 0 = 0
/// @param kind  0 grows, 1 saw from 0 to 1, 2 sine from 0 to 1, 3 on and off, 4 flicker [0 .. 4] = 0
/// @param time  seconds [attr Time]
fn userProc(speed: f32, start: f32, kind: u32, time: f32) -> f32 {
    let t = start + speed * time;
    switch kind {
        case 1u: { return fract(t); }
        case 2u: { return 0.5 - 0.5 * cos(6.2831853 * t); }
        case 3u: { return select(0.0, 1.0, fract(t) < 0.5); }
        case 4u: { return saturate(0.75 + 0.5 * fbm2D(vec2f(t, 0.5), 3.0, 2.0, 0.6, 0.0)); }
        default: { return t; }
    }
}
