//! Built-in shapes: sizes, volumes, and fields that are the exact distance to the surface.

mod balls;
mod boxes;
mod capsules;
mod cylinders;
mod field_checks;
mod outlines;
mod rates;
mod refusals;
