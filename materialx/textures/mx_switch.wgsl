/// One of ten.
/// @param in1   for 0 = (0, 0, 0, 0)
/// @param in2   for 1 = (0, 0, 0, 0)
/// @param in3   for 2 = (0, 0, 0, 0)
/// @param in4   for 3 = (0, 0, 0, 0)
/// @param in5   for 4 = (0, 0, 0, 0)
/// @param in6   for 5 = (0, 0, 0, 0)
/// @param in7   for 6 = (0, 0, 0, 0)
/// @param in8   for 7 = (0, 0, 0, 0)
/// @param in9   for 8 = (0, 0, 0, 0)
/// @param in10  for 9 = (0, 0, 0, 0)
/// @param which which one = 0
fn userProc(
    in1: vec4f,
    in2: vec4f,
    in3: vec4f,
    in4: vec4f,
    in5: vec4f,
    in6: vec4f,
    in7: vec4f,
    in8: vec4f,
    in9: vec4f,
    in10: vec4f,
    which: f32,
) -> vec4f {
    if which < 1.0 {
        return in1;
    }
    if which < 2.0 {
        return in2;
    }
    if which < 3.0 {
        return in3;
    }
    if which < 4.0 {
        return in4;
    }
    if which < 5.0 {
        return in5;
    }
    if which < 6.0 {
        return in6;
    }
    if which < 7.0 {
        return in7;
    }
    if which < 8.0 {
        return in8;
    }
    if which < 9.0 {
        return in9;
    }
    if which < 10.0 {
        return in10;
    }
    return vec4f();
}
