/// The bitangent in the world.
fn userProc() -> vec4f {
    return readAttr(Bitangent);
}
