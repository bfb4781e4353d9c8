/// The normal in the world.
fn userProc() -> vec4f {
    return readAttr(Normal);
}
