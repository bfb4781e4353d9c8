//! glTF 2.0 to [`super::Scene`].
