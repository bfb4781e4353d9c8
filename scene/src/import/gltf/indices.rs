//! The corners of a primitive in drawing order, as triangles.

use crate::import::error::Fault;
use gltf::json::mesh::Mode;

/// The vertices of a primitive in drawing order.
pub(super) enum Indices {
    List(Vec<u32>),
    /// 0, 1, 2, ...
    Sequence(u32),
}

impl Indices {
    fn len(&self) -> u64 {
        match self {
            Self::List(list) => list.len() as u64,
            Self::Sequence(count) => u64::from(*count),
        }
    }

    fn at(&self, position: u32) -> u32 {
        match self {
            Self::List(list) => list[position as usize],
            Self::Sequence(_) => position,
        }
    }

    pub(super) fn triangle_count(&self, mode: Mode) -> u64 {
        match mode {
            Mode::TriangleStrip | Mode::TriangleFan => self.len().saturating_sub(2),
            _ => self.len() / 3,
        }
    }

    /// Whether indices at the end make no triangle.
    pub(super) fn left_over(&self, mode: Mode) -> bool {
        match mode {
            Mode::TriangleStrip | Mode::TriangleFan => (1..3).contains(&self.len()),
            _ => !self.len().is_multiple_of(3),
        }
    }

    /// The triangles with glTF's winding (section 3.7.2.1). An index that is not below `vertex_count` is an error.
    pub(super) fn triangles(&self, mode: Mode, vertex_count: u32) -> Result<Vec<[u32; 3]>, Fault> {
        if let Self::List(list) = self
            && let Some(position) = list.iter().position(|&index| index >= vertex_count)
        {
            return Err(format!(
                "index {} at position {position} is out of range, there are {vertex_count} vertices",
                list[position]
            ));
        }
        let count =
            u32::try_from(self.triangle_count(mode)).map_err(|_| "has too many triangles")?;
        let positions = |i: u32| match mode {
            Mode::TriangleStrip if i % 2 == 1 => [i, i + 2, i + 1],
            Mode::TriangleStrip => [i, i + 1, i + 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [i * 3, i * 3 + 1, i * 3 + 2],
        };
        Ok((0..count)
            .map(|i| positions(i).map(|p| self.at(p)))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let indices = Indices::Sequence(5);
        let strip = indices.triangles(Mode::TriangleStrip, 5).unwrap();
        assert_eq!(strip, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let fan = indices.triangles(Mode::TriangleFan, 5).unwrap();
        assert_eq!(fan, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        let list = indices.triangles(Mode::Triangles, 5).unwrap();
        assert_eq!(list, [[0, 1, 2]]);
        assert!(indices.left_over(Mode::Triangles));
    }

    #[test]
    fn an_index_out_of_range_is_named() {
        let message = Indices::List(vec![0, 1, 2, 0, 1, 7])
            .triangles(Mode::Triangles, 3)
            .unwrap_err();
        assert!(message.contains("index 7 at position 5"), "{message}");
    }
}
