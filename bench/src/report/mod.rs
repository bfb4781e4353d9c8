//! What was measured, for people and for programs: tables of text, JSON, a page with charts. Nothing is written to files here.

pub mod charts;
pub mod conditions;
pub mod figures;
pub mod methods;
pub mod page;
pub mod paper;
pub mod renders;
pub mod scaling;

#[cfg(test)]
mod tests;
