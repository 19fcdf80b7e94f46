//! Ready-made shapes: sizes, volumes, and fields that are the true distance to the surface.

mod balls;
mod boxes;
mod cylinders;
mod field_checks;
mod rates;
mod refusals;
