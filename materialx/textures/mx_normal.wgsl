/// The normal in the object's own space.
fn userProc() -> vec4f {
    return readAttr(LocalNormal);
}
