//! Derivatives of rollouts, and the checks of these derivatives.

mod canceling;
mod clearance;
mod converged;
mod debug_texts;
mod derivative_check;
mod difference_check;
mod dimensions;
mod force_parameters;
mod joints;
mod kinks;
mod linearized_joints;
mod loops;
mod no_derivative;
mod random_scenes;
mod reverse;
mod reverse_implicit;
mod robots;
mod shapes;
mod shapes_on_joints;
mod stacks;
mod switched_forces;
mod trajectory_gradients;
mod zero_lengths;

#[path = "../support/mod.rs"]
mod support;
