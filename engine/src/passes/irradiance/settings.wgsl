// What the passes of the irradiance cache are told. The Rust twin is `renderer::irradiance::Settings`.
struct IrradianceSettings {
    mode: u32,
    first_record: u32, // of those that rays are gathered for
    end_record: u32, // behind the last of them
    candidates: u32, // most that there is room for
    mask: u32, // slots of the grid less one: a power of two
    first_level: i32, // the finest cells of the grid have sides of 2^first_level metres
    levels: u32,
    falloff: f32, // 1: a record's weight has fallen to nothing at its radius; 1/2: at twice that
    share: f32, // of the places that no record covers, those that become candidates
    gather: u32, // field of a path's state where its gather ray keeps what it knows
    radius_share: f32, // of the harmonic mean of the distances to what a record sees: its radius
    most_change: f32, // that the gradient may make of the irradiance within the radius
    photons: u32, // field of a path's state that is the photons' own, 0 where there are none
    turn: u32, // that rays are gathered for the same records, from 0 on
    turns: u32, // of these
    rings: u32, // of gather rays around a record's normal, of equal weight
    sectors: u32, // of each ring
    points: u32, // stream of the points in their strata
    left: f32, // how often what is better left to paths is left to them
    solved: u32, // what has been gathered when records are made
}

@group(0) @binding(50) var<uniform> irradiance_settings: IrradianceSettings;

// Paths go on as if there were no cache.
const IRRADIANCE_IDLE = 0u;
// Paths end at the first surface that scatters diffusely, and places that no record covers become candidates.
const IRRADIANCE_FIND = 1u;
// What surfaces scatter diffusely is taken from the records.
const IRRADIANCE_USE = 2u;

// All rays.
const SOLVE_WHOLE = 0u;
// Those of the first half of turns.
const SOLVE_FIRST_HALF = 1u;
// Both halves, the first of which is known.
const SOLVE_HALVES = 2u;

// Gather rays of a record at a time.
fn gather_rays() -> u32 {
    return irradiance_settings.rings * irradiance_settings.sectors;
}
