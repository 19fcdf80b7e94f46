//! Contact of two bodies: surfaces, wrenches and derivatives, at generic poses and at special poses.

mod clearance;
mod closed_forms;
mod coincidence;
mod contact_surface;
mod degenerate;
mod exact_twin;
mod flush;
mod flush_motion;
mod hostile;
mod jacobian;
mod layers;
mod linearized;
mod partners;
mod plateaus;
mod polygon;
mod reference_data;
mod second_order;
mod shape_gradients;
mod skins;
mod spinning;
mod stiff;
mod structure;
mod surface_law;
mod tactile;
mod tiling;
mod units;

#[path = "../support/mod.rs"]
mod support;
