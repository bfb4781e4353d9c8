// Hashes of words: what scrambles one thing must tell nothing of what scrambles another.

fn hash(x: u32) -> u32 {
    // "lowbias32" by C. Wellons.
    var v = x;
    v = (v ^ (v >> 16u)) * 0x7feb352du;
    v = (v ^ (v >> 15u)) * 0x846ca68bu;
    return v ^ (v >> 16u);
}

// Of two words. The first one is a hash already: of plain numbers those that differ by a few bits would swap places.
fn hash2(x: u32, y: u32) -> u32 {
    return hash(x ^ (hash(y) + 0x9e3779b9u));
}
