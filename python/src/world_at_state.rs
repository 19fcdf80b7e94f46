//! What a world is in a state: energies, contacts, stable steps, changes between states.

use crate::arrays::{Floats, array, list};
use crate::contacts::{Contact, ContactTopology};
use crate::diagnostics::Diagnostics;
use crate::errors::value_error;
use crate::plan::Plan;
use crate::rollout::Rollout;
use crate::state::State;
use crate::world::World;
use pyo3::prelude::*;

#[pymethods]
impl World {
    /// The steps from the initial state, or another one, by a plan.
    #[pyo3(signature = (plan, *, start=None))]
    fn rollout(&self, plan: &Plan, start: Option<&State>) -> PyResult<Rollout> {
        let rollout = self.inner.rollout(&plan.0);
        let rollout = match start {
            Some(state) => rollout.with_state(state.0.clone()).map_err(value_error)?,
            None => rollout,
        };
        Ok(Rollout::of(rollout, plan.0))
    }

    /// The state one time step after another one.
    fn step(&self, py: Python<'_>, state: &State, plan: &Plan) -> PyResult<State> {
        self.rollout(plan, Some(state))?.next_step(py)
    }

    /// Energies and momentum of a state. The contact energy takes longer than a step.
    fn report(&self, py: Python<'_>, state: &State) -> PyResult<Diagnostics> {
        let report = py
            .detach(|| self.inner.diagnostics(&state.0))
            .map_err(value_error)?;
        Diagnostics::of(py, &report)
    }

    /// The contacts of a state, sorted by the bodies' places. Bodies that both do not move by forces have none.
    fn contacts(&self, py: Python<'_>, state: &State) -> PyResult<Vec<Contact>> {
        let contacts = py
            .detach(|| self.inner.contacts(&state.0))
            .map_err(value_error)?;
        let names = self.names_of();
        contacts
            .iter()
            .map(|contact| Contact::of(py, contact, &names))
            .collect()
    }

    /// The bodies, by name, that have passed so far into each other in a state that contact may no longer push them apart: see
    /// Pair.has_sunk_through.
    /// Takes as long as a report.
    fn fully_submerged(&self, py: Python<'_>, state: &State) -> PyResult<Vec<(&str, &str)>> {
        let sunk = py
            .detach(|| self.inner.fully_submerged(&state.0))
            .map_err(value_error)?;
        let names = self.names_of();
        Ok(sunk.iter().map(|&[a, b]| (names[a], names[b])).collect())
    }

    /// Which tetrahedra touch in a state.
    fn topology(&self, py: Python<'_>, state: &State) -> PyResult<ContactTopology> {
        py.detach(|| self.inner.topology(&state.0))
            .map(ContactTopology)
            .map_err(value_error)
    }

    /// The longest time step (s) with which explicit steps are stable in a state; None where nothing touches. Forces other than
    /// contact are not in it.
    fn largest_stable_step(&self, py: Python<'_>, state: &State) -> PyResult<Option<f64>> {
        py.detach(|| self.inner.largest_stable_step(&state.0))
            .map_err(value_error)
    }

    /// (12 d,) float64: the change that takes one state to another, 12 numbers for each of d dynamic bodies: the motion of its
    /// pose (angular, at most half a turn, linear), and the change of its twist (angular, linear).
    #[pyo3(signature = (start, end))]
    fn displacement<'py>(
        &self,
        py: Python<'py>,
        start: &State,
        end: &State,
    ) -> PyResult<Floats<'py>> {
        let change = self
            .inner
            .difference(&start.0, &end.0)
            .map_err(value_error)?;
        array(py, change.as_slice().to_vec(), &[change.len()])
    }

    /// The state after such a change, the inverse of displacement.
    fn integrate(&self, state: &State, change: &Bound<'_, PyAny>) -> PyResult<State> {
        let change = list(change, "change")?;
        self.inner
            .integrate(&state.0, &change)
            .map(State)
            .map_err(value_error)
    }
}
