//! The look file: what glTF cannot say.
