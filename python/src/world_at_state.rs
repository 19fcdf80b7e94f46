//! Queries of a world at a state: energies, contacts, stable steps and differences between states.

use crate::arrays::{Floats, array, check_finite, list, slice};
use crate::contacts::{Contact, ContactTopology};
use crate::diagnostics::Diagnostics;
use crate::errors::value_error;
use crate::lists::list_of;
use crate::plan::Plan;
use crate::rollout::Rollout;
use crate::state::State;
use crate::taxel_grid::TaxelGrid;
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PySlice;

#[pymethods]
impl World {
    /// Starts a rollout.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// start : State, optional
    ///     State to start from. Default: the initial state of the world.
    ///
    /// Returns
    /// -------
    /// Rollout
    ///     Iterator over the steps.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    #[pyo3(signature = (plan, *, start=None))]
    fn rollout(&self, plan: &Plan, start: Option<&State>) -> PyResult<Rollout> {
        let rollout = self.inner.rollout(&plan.0);
        let rollout = match start {
            Some(state) => rollout.with_state(state.0.clone()).map_err(value_error)?,
            None => rollout,
        };
        Ok(Rollout::of(rollout, plan.0))
    }

    /// Takes a single time step.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State before the step.
    /// plan : Plan
    ///     Plan with the time step and the integrator.
    ///
    /// Returns
    /// -------
    /// State
    ///     State after the step.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    /// RolloutError
    ///     If the step fails.
    fn step(&self, py: Python<'_>, state: &State, plan: &Plan) -> PyResult<State> {
        self.rollout(plan, Some(state))?.next_step(py)
    }

    /// Computes energies and momentum of a state. The contact energy takes longer than a step.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    ///
    /// Returns
    /// -------
    /// Diagnostics
    ///     Energies and momentum.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, or a result is not finite.
    fn diagnostics(&self, py: Python<'_>, state: &State) -> PyResult<Diagnostics> {
        let report = py
            .detach(|| self.inner.diagnostics(&state.0))
            .map_err(value_error)?;
        Diagnostics::of(py, &report)
    }

    /// Computes the contacts of a state. Two bodies have no contact if neither is dynamic.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    ///
    /// Returns
    /// -------
    /// list of Contact
    ///     Contacts, sorted by the indices of the bodies.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, or a result is not finite.
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

    /// Computes the forces on the taxels of a grid that is fixed to a body, in a state. See Pair.tactile_image. Two bodies have no contact
    /// if neither is dynamic.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    /// body : str
    ///     Name of the body of the grid.
    /// grid : TaxelGrid
    ///     Grid of H rows and W columns.
    /// partner : str, optional
    ///     Name of the only other body whose contact is included. Default: all other bodies.
    /// mean : bool, optional
    ///     If True, returns mean tractions (Pa) instead of forces. Default: False.
    ///
    /// Returns
    /// -------
    /// (H, W, 3) ndarray of float64
    ///     Forces (N) or mean tractions (Pa), along the axes of each taxel.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, the world has no such body, both bodies are the same, or a result is not finite.
    #[pyo3(signature = (state, body, grid, *, partner=None, mean=false))]
    fn tactile_image<'py>(
        &self,
        py: Python<'py>,
        state: &State,
        body: &str,
        grid: &TaxelGrid,
        partner: Option<&str>,
        mean: bool,
    ) -> PyResult<Floats<'py>> {
        let index = |name: &str| self.inner.index_of(name).map_err(value_error);
        let bodies = (index(body)?, partner.map(index).transpose()?);
        let image = py.detach(|| self.inner.tactile_image(&state.0, bodies, &grid.inner));
        let shape = grid.shape();
        let mut numbers = vec![0.0; shape.iter().product()];
        grid.write(&image.map_err(value_error)?, mean, &mut numbers);
        check_finite(&numbers, "the forces on taxels")?;
        array(py, numbers, &shape)
    }

    /// Returns pairs of bodies that overlap so deeply that contact may no longer push them apart. See Pair.has_sunk_through.
    ///
    /// The cost is that of the energies of a state.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    ///
    /// Returns
    /// -------
    /// list of (str, str)
    ///     Names of the bodies of each pair.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    fn fully_submerged(&self, py: Python<'_>, state: &State) -> PyResult<Vec<(&str, &str)>> {
        let sunk = py
            .detach(|| self.inner.fully_submerged(&state.0))
            .map_err(value_error)?;
        let names = self.names_of();
        Ok(sunk.iter().map(|&[a, b]| (names[a], names[b])).collect())
    }

    /// Returns the outlines of the half-spaces in a picture of states.
    ///
    /// An outline is a rectangle around the moving bodies in all states, or around all bodies if none moves, with a margin of a quarter of
    /// the diagonal of their bounding box. Its parts inside other half-spaces are cut off, so that a floor and four walls make a tray. A
    /// plane that moves relative to a half-space does not cut it.
    ///
    /// Parameters
    /// ----------
    /// states : list of State
    ///     States of this world.
    ///
    /// Returns
    /// -------
    /// list of (k, 3) ndarray of float64
    ///     For each body, the corners (m) of a convex polygon in the plane z = 0 of its frame, counter-clockwise seen from outside. There
    ///     are none if the body is not a half-space, or if other half-spaces hide it.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a state does not fit the world.
    fn half_space_outlines<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] states: Vec<Bound<'py, State>>,
    ) -> PyResult<Vec<Floats<'py>>> {
        let states: Vec<_> = states.iter().map(|state| &state.get().0).collect();
        let outlines = self.inner.half_space_outlines(&states);
        let outlines = outlines.map_err(value_error)?;
        let points = |corners: Vec<_>| {
            let shape = [corners.len(), 3];
            array(py, corners.iter().flatten().copied().collect(), &shape)
        };
        outlines.into_iter().map(points).collect()
    }

    /// Computes the set of the pairs of tetrahedra that touch in a state.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    ///
    /// Returns
    /// -------
    /// ContactTopology
    ///     Pairs of tetrahedra.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    fn topology(&self, py: Python<'_>, state: &State) -> PyResult<ContactTopology> {
        py.detach(|| self.inner.topology(&state.0))
            .map(ContactTopology)
            .map_err(value_error)
    }

    /// Computes the longest stable time step of explicit integrators in a state. It ignores forces other than contact.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    ///
    /// Returns
    /// -------
    /// float or None
    ///     Time step (s). None if no bodies touch.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    fn largest_stable_step(&self, py: Python<'_>, state: &State) -> PyResult<Option<f64>> {
        py.detach(|| self.inner.largest_stable_step(&state.0))
            .map_err(value_error)
    }

    /// Computes the change that moves one state to another, in tangent-space coordinates. The inverse is integrate.
    ///
    /// The coordinates are in the order of the bodies. Each body has the coordinates of its joint:
    ///
    /// - free body: rotation vector (rad, at most half a turn) and translation (m) of its pose, then the changes of its angular velocity
    ///   (rad/s) and of its velocity (m/s).
    /// - revolute or prismatic joint: changes of its position (rad or m) and of its velocity (rad/s or m/s). The change of an angle
    ///   includes full turns.
    /// - ball joint: rotation vector (rad) and change of the angular velocity (rad/s), in the axes of the joint frame.
    /// - fixed or mimicking joint, fixed body, body on a path: none.
    ///
    /// Parameters
    /// ----------
    /// start, end : State
    ///     States of this world.
    ///
    /// Returns
    /// -------
    /// (n,) ndarray of float64
    ///     Change, with n = tangent_dimension.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a state does not fit the world, or a result is not finite.
    #[pyo3(signature = (start, end))]
    fn difference<'py>(
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

    /// Moves a state by a change in tangent-space coordinates. Bodies on joints follow the joints.
    ///
    /// Parameters
    /// ----------
    /// state : State
    ///     State of this world.
    /// change : (n,) array_like
    ///     Change, with the coordinates of difference.
    ///
    /// Returns
    /// -------
    /// State
    ///     Changed state.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, a number is not finite, or the array has an unexpected shape.
    fn integrate(&self, state: &State, change: &Bound<'_, PyAny>) -> PyResult<State> {
        let change = list(change, "change")?;
        self.inner
            .integrate(&state.0, &change)
            .map(State)
            .map_err(value_error)
    }

    /// Number of tangent-space coordinates of a state, int: 2 for each generalized velocity that is not of a mimicking joint.
    #[getter]
    fn tangent_dimension(&self) -> usize {
        self.inner.tangent_dimension()
    }

    /// Returns the indices of the tangent-space coordinates of a body, as rows and columns of linearize.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// slice
    ///     Indices. The first half are positions, the second half are velocities. The slice is empty for a body that is welded, mimicking,
    ///     fixed or on a path.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body.
    fn tangent_columns<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PySlice>> {
        let body = self.inner.index_of(body).map_err(value_error)?;
        let columns = self.inner.tangent_columns(body).map_err(value_error)?;
        slice(py, &columns)
    }
}
