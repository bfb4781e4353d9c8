/// The colour of the vertices.
fn userProc() -> vec4f {
    return readAttr(Color0);
}
