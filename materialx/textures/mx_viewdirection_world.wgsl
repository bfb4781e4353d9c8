/// The direction in which the surface is seen, in the world.
fn userProc() -> vec4f {
    return -readAttr(ViewDir);
}
