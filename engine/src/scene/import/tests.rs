//! Whole files in miniature: JSON in, scene out.
