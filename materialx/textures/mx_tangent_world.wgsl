/// The tangent in the world.
fn userProc() -> vec4f {
    return readAttr(Tangent);
}
