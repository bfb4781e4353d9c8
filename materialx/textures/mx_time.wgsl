/// Seconds.
fn userProc() -> f32 {
    return readGlobal(Time).x;
}
