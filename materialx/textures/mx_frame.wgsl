/// The number of the frame, from 1.
fn userProc() -> f32 {
    return readGlobal(FrameIndex).x + 1.0;
}
