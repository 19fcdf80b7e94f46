//! Time series of a trajectory.

use super::{Curve, Panel};
use hydroelastic::dynamics::{Diagnostics, Force, State, Trajectory, World};
use nalgebra::Vector3;

/// Returns kinetic, gravitational, contact and total energy.
pub fn energies<F: Force>(world: &World<f64, F>, trajectory: &Trajectory) -> Panel {
    let reports: Vec<(f64, Diagnostics)> = (trajectory.states().iter())
        .map(|state| {
            (
                state.time,
                world.diagnostics(state).expect("a state of this world"),
            )
        })
        .collect();
    let curve = |name, energy: fn(&Diagnostics) -> f64| {
        let points = reports.iter().map(|(time, report)| (*time, energy(report)));
        Curve::new(name, points)
    };
    Panel {
        x_label: "time (s)",
        y_label: "energy (J)",
        is_log: false,
        curves: vec![
            curve("kinetic", |report| report.kinetic_energy),
            curve("gravitational", |report| report.gravitational_energy),
            curve("contact", |report| report.contact_energy),
            curve("total", Diagnostics::total_energy),
        ],
    }
}

/// Returns the magnitude of the net contact force on a body, given by its index in the world.
pub fn contact_force<F: Force>(
    world: &World<f64, F>,
    trajectory: &Trajectory,
    body: usize,
) -> Panel {
    let force = |state: &State| {
        let mut force = Vector3::zeros();
        for contact in world.contacts(state).expect("a state of this world") {
            let wrenches = [contact.wrench.on_a, contact.wrench.on_b];
            let both = contact.bodies.iter().zip(wrenches);
            let on_body = both.filter(|(place, _)| **place == body);
            force += on_body
                .map(|(_, wrench)| wrench.force)
                .sum::<Vector3<f64>>();
        }
        (state.time, force.norm())
    };
    Panel {
        x_label: "time (s)",
        y_label: "contact force (N)",
        is_log: false,
        curves: vec![Curve::new(
            world.bodies()[body].name(),
            trajectory.states().iter().map(force),
        )],
    }
}

/// Yields the positions (m) of a body, given by its index in the world.
pub fn path(trajectory: &Trajectory, body: usize) -> impl Iterator<Item = Vector3<f64>> {
    let states = trajectory.states().iter();
    states.map(move |state| *state.bodies[body].position())
}
