//! Compiled part of the Python package `hydroelastic`: classes that hold values of the library. Arguments and results are NumPy arrays.
//!
//! Doc comments of the classes and their methods are the Python docstrings. `generate_stub.py` writes the type stub from them and from the
//! types of results.

mod any_shape;
mod arrays;
mod batch;
mod body;
mod contacts;
mod control;
mod diagnostics;
mod dimension_rates;
mod errors;
mod evaluator;
mod fit;
mod force;
mod half_space;
mod identification;
mod interrupt;
mod jacobian;
mod joint;
mod kinetics;
mod kink;
mod linearized_shape;
mod lists;
mod loop_joint;
mod material;
mod mechanism;
mod mesh_arrays;
mod pair;
mod pair_inputs;
mod pair_shapes;
mod parameter;
mod path;
mod pickle;
mod plan;
mod poses;
mod rigid_shape;
mod robot;
mod rollout;
mod shape;
mod shape_files;
mod shape_gradient;
mod shape_rates;
mod shapes;
mod show;
mod solid;
mod state;
mod state_arrays;
mod state_cotangents;
mod states;
mod surface;
mod taxel_grid;
mod trajectory;
mod vjp;
mod world;
mod world_at_state;
mod world_files;
mod world_gradients;
mod world_joints;
mod world_pickle;

use pyo3::prelude::*;

/// Compiled part of hydroelastic. Import the package, not this module.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add(
        "HydroelasticError",
        py.get_type::<errors::HydroelasticError>(),
    )?;
    module.add("RolloutError", py.get_type::<errors::RolloutError>())?;
    errors::complete(py)?;
    module.add_function(wrap_pyfunction!(poses::pose, module)?)?;
    module.add_function(wrap_pyfunction!(poses::moved_pose, module)?)?;
    add_loaders(module)?;
    module.add_class::<shape::Shape>()?;
    module.add_class::<rigid_shape::RigidShape>()?;
    module.add_class::<half_space::HalfSpace>()?;
    module.add_class::<material::Material>()?;
    module.add_class::<material::SurfaceLaw>()?;
    module.add_class::<pair::Pair>()?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<taxel_grid::TaxelGrid>()?;
    module.add_class::<shape_gradient::ShapeGradient>()?;
    module.add_class::<shape_rates::ShapeRates>()?;
    module.add_class::<linearized_shape::LinearizedShape>()?;
    module.add_class::<solid::Solid>()?;
    module.add_class::<joint::Stops>()?;
    module.add_class::<joint::Joint>()?;
    module.add_class::<loop_joint::LoopJoint>()?;
    module.add_class::<body::Body>()?;
    module.add_class::<path::Path>()?;
    module.add_class::<force::Spring>()?;
    module.add_class::<force::Drag>()?;
    module.add_class::<force::Thruster>()?;
    module.add_class::<control::Control>()?;
    module.add_class::<mechanism::Mechanism>()?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<world::World>()?;
    module.add_class::<kinetics::Kinetics>()?;
    module.add_class::<plan::Accuracy>()?;
    module.add_class::<plan::Integrator>()?;
    module.add_class::<plan::Plan>()?;
    module.add_class::<state::State>()?;
    module.add_class::<states::States>()?;
    module.add_class::<trajectory::Trajectory>()?;
    module.add_class::<rollout::Rollout>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<parameter::Parameter>()?;
    module.add_class::<jacobian::TrajectoryJacobian>()?;
    module.add_class::<jacobian::DerivativeCheck>()?;
    module.add_class::<jacobian::DifferenceCheck>()?;
    module.add_class::<diagnostics::StepReport>()?;
    module.add_class::<diagnostics::Diagnostics>()?;
    module.add_class::<kink::Kink>()?;
    module.add_class::<vjp::VectorJacobianProduct>()?;
    module.add_class::<identification::Unknown>()?;
    module.add_class::<identification::Identification>()?;
    module.add_class::<fit::Checkpoint>()?;
    module.add_class::<fit::Fit>()?;
    module.add_class::<fit::Prediction>()?;
    module.add_class::<contacts::Contact>()?;
    module.add_class::<contacts::ContactTopology>()
}

/// Adds the functions that restore pickles.
fn add_loaders(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(path::_load_path, module)?)?;
    module.add_function(wrap_pyfunction!(parameter::_load_parameter, module)?)?;
    module.add_function(wrap_pyfunction!(identification::_load_unknown, module)?)?;
    module.add_function(wrap_pyfunction!(fit::_load_fit, module)?)?;
    module.add_function(wrap_pyfunction!(fit::_load_prediction, module)?)?;
    module.add_function(wrap_pyfunction!(diagnostics::_load_step_report, module)?)?;
    module.add_function(wrap_pyfunction!(world_pickle::_load_world, module)?)?;
    module.add_function(wrap_pyfunction!(world_pickle::_load_body, module)?)?;
    module.add_function(wrap_pyfunction!(joint::_load_joint, module)?)?;
    module.add_function(wrap_pyfunction!(loop_joint::_load_loop_joint, module)?)?;
    module.add_function(wrap_pyfunction!(mechanism::_load_mechanism, module)?)?;
    module.add_function(wrap_pyfunction!(solid::_load_solid, module)?)?;
    module.add_function(wrap_pyfunction!(contacts::_load_topology, module)?)?;
    module.add_function(wrap_pyfunction!(jacobian::_load_derivative_check, module)?)?;
    module.add_function(wrap_pyfunction!(jacobian::_load_difference_check, module)?)?;
    Ok(())
}
