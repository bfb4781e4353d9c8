//! What each pass reads and writes of a wave's memory: the table of docs/performance.md, held to the kernels by tests.
//!
//! Nodes, triangles, vertices, materials and images are not in it: how much of them a ray needs is up to the scene.

use std::fmt::Write as _;
use std::mem::{offset_of, size_of};

use engine::wave::{PathBytes, RayHit};

/// Bytes of a `vec4u` field of `paths.wgsl`, and of an entry of a queue.
const FIELD: u64 = 16;
const ENTRY: u64 = 4;
/// Of a ray: what traversal needs of it, what it leaves there, and whether something was hit.
const RAY: u64 = offset_of!(RayHit, barycentrics) as u64;
const HIT: u64 = size_of::<RayHit>() as u64 - RAY + size_of::<f32>() as u64;
const TRIANGLE: u64 = size_of::<u32>() as u64;
const WHOLE: u64 = size_of::<RayHit>() as u64;

/// A pass over a wave of a scene without texture programs.
#[derive(Debug, Clone, Copy)]
pub struct Traffic {
    /// The kernel.
    pub pass: &'static str,
    /// Of what there is a thread for each.
    pub once_per: &'static str,
    /// Path fields that it reads, by their names in `paths.wgsl` without `PATH_`.
    pub fields_read: &'static [&'static str],
    /// Those that it writes.
    pub fields_written: &'static [&'static str],
    /// Of these, fields of scenes where light goes through something.
    pub transparent: &'static [&'static str],
    /// Bytes of rays and queue entries that it reads.
    pub rays_read: u64,
    /// Bytes of rays and queue entries that it writes.
    pub rays_written: u64,
}

/// The passes in the order in which a wave runs them, each with all that it may touch: a vertex that lights reach and
/// from which the path goes on.
pub const TRAFFIC: [Traffic; 5] = [
    Traffic {
        pass: "raygen",
        once_per: "camera path",
        fields_read: &[],
        fields_written: &[
            "THROUGHPUT",
            "RADIANCE",
            "LIGHT",
            "STATE",
            "LIGHT_POINT",
            "MEDIA",
        ],
        transparent: &[],
        rays_read: 0,
        rays_written: WHOLE + TRIANGLE + ENTRY,
    },
    Traffic {
        pass: "traverse_closest",
        once_per: "path ray",
        fields_read: &["STATE"],
        fields_written: &[],
        transparent: &["STATE"],
        rays_read: RAY + ENTRY,
        rays_written: HIT,
    },
    Traffic {
        pass: "brdf",
        once_per: "path ray",
        fields_read: &["THROUGHPUT", "RADIANCE", "LIGHT", "STATE", "MEDIA"],
        fields_written: &["THROUGHPUT", "RADIANCE", "LIGHT", "STATE", "MEDIA"],
        transparent: &["MEDIA"],
        rays_read: WHOLE + TRIANGLE + ENTRY,
        rays_written: 2 * (WHOLE + ENTRY),
    },
    Traffic {
        pass: "traverse_occlusion",
        once_per: "shadow ray",
        fields_read: &["LIGHT", "STATE"],
        fields_written: &["LIGHT"],
        transparent: &["LIGHT", "STATE"],
        rays_read: RAY + ENTRY,
        rays_written: TRIANGLE,
    },
    Traffic {
        pass: "accumulate",
        once_per: "camera path",
        fields_read: &["RADIANCE", "LIGHT", "STATE"],
        fields_written: &[],
        transparent: &[],
        rays_read: TRIANGLE,
        rays_written: 0,
    },
];

impl Traffic {
    /// Bytes read in scenes whose surfaces are opaque, and what transparent ones add.
    pub fn read(&self) -> (u64, u64) {
        self.bytes(self.fields_read, self.rays_read)
    }

    /// Bytes written in scenes whose surfaces are opaque, and what transparent ones add.
    pub fn written(&self) -> (u64, u64) {
        self.bytes(self.fields_written, self.rays_written)
    }

    fn bytes(&self, fields: &[&str], rays: u64) -> (u64, u64) {
        let (more, always): (Vec<&str>, Vec<&str>) = fields
            .iter()
            .partition(|field| self.transparent.contains(field));
        (
            FIELD * always.len() as u64 + rays,
            FIELD * more.len() as u64,
        )
    }
}

/// Both tables as Markdown: memory of a path, and bytes that each pass moves.
pub fn tables() -> String {
    let path = PathBytes::new(0);
    let mut text = String::from("| memory of a path | bytes |\n|---|---|\n");
    for (name, bytes) in [
        ("state, field by field", path.state),
        ("its ray and its shadow ray, with what they hit", path.rays),
        ("its places in the queues", path.queues),
        (
            "together, without results of texture programs",
            path.total(),
        ),
    ] {
        let _ = writeln!(text, "| {name} | {bytes} |");
    }
    text.push_str("\n| pass | once per | bytes read | bytes written |\n|---|---|---|---|\n");
    for pass in &TRAFFIC {
        let shown = |(always, more): (u64, u64)| match more {
            0 => always.to_string(),
            more => format!("{always} + {more}"),
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            pass.pass,
            pass.once_per,
            shown(pass.read()),
            shown(pass.written())
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::passes::wgsl::FILES;
    use std::collections::BTreeSet;

    /// The text of a file of the engine's, or of all in a folder.
    fn text_of(place: &str) -> String {
        let files = FILES.iter().filter(|(name, _)| name.starts_with(place));
        files.map(|(_, text)| *text).collect()
    }

    /// Fields that a kernel's own text reads or writes, without what only texture programs need.
    fn fields(text: &str, calls: &[&str]) -> BTreeSet<String> {
        let uses = |call: &&str| {
            let call = format!("{call}(PATH_");
            let names = text.split(&call).skip(1).map(|rest| {
                let end = rest.find(|c: char| !c.is_ascii_uppercase() && c != '_');
                rest[..end.unwrap_or(rest.len())].to_owned()
            });
            names.collect::<Vec<_>>()
        };
        calls.iter().flat_map(uses).collect()
    }

    fn named(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn the_table_has_the_fields_that_the_kernels_use() {
        let both = text_of("traverse/traverse.wgsl");
        let (closest, occlusion) = both.split_once("fn find_occluder").expect("both are there");
        for (pass, text) in TRAFFIC.iter().zip([
            text_of("raygen/").as_str(),
            closest,
            text_of("brdf/").as_str(),
            occlusion,
            text_of("accumulate/").as_str(),
        ]) {
            let mut read = fields(text, &["path_read", "path_words"]);
            for (call, field) in [
                ("path_depth(", "STATE"),
                ("path_is_last(", "STATE"),
                ("alpha_coin(", "STATE"),
                ("waiting_light(", "LIGHT"),
            ] {
                if text.contains(call) {
                    read.insert(field.to_owned());
                }
            }
            let mut written = fields(text, &["path_write", "path_set_words"]);
            // Only where a cache wants to know of surfaces.
            for field in ["PLACE", "DIFFUSE", "LEFT", "UNSENT"] {
                read.remove(field);
                written.remove(field);
            }
            if pass.pass != "raygen" {
                // Only where programs decide about shadows.
                read.remove("LIGHT_POINT");
                written.remove("LIGHT_POINT");
            }
            assert_eq!(read, named(pass.fields_read), "read by {}", pass.pass);
            assert_eq!(
                written,
                named(pass.fields_written),
                "written by {}",
                pass.pass
            );
        }
    }

    #[test]
    fn a_path_has_room_for_the_fields_of_the_kernels() {
        let text = text_of("shared/paths.wgsl");
        let (_, rest) = text
            .split_once("const PATH_RESULTS = ")
            .expect("it is declared");
        let (count, _) = rest.split_once("u;").expect("a number");
        let fields: u64 = count.parse().expect("a number");
        assert_eq!(PathBytes::new(0).state, FIELD * fields);
        assert_eq!(PathBytes::new(5).results, 2 * FIELD);
    }

    #[test]
    fn the_documented_tables_are_these() {
        let text = include_str!("../../docs/performance.md");
        let tables = tables();
        assert!(
            text.contains(&tables),
            "docs/performance.md should have:\n{tables}"
        );
    }
}
