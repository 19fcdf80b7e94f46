"""Robots in contact: Pinocchio computes the mechanism, and this library computes its contacts, with exact derivatives.

``Robot`` takes a Pinocchio model and its contacts. Its joint accelerations are

    a = ABA(q, v, τ + Σ J(q)ᵀ w(poses(q), twists(q, v))).

Their derivatives with respect to q, v, τ and the materials of the contacts are computed in closed form. Pinocchio
differentiates the mechanism with forces that are fixed in the links, and the chain rule adds the derivatives of the
wrenches. Semi-implicit Euler steps and rollouts propagate the derivatives.

Joints have the conventions of Pinocchio, and contacts have the conventions of this package:

- Derivatives with respect to q are with respect to its tangent space, (nv,): q varies as
  ``pinocchio.integrate(model, q, dq)``. This includes free-flyers, spherical joints and continuous joints, for which nq
  differs from nv.
- Wrenches are (torque, force) in world axes: on A about the origin of the shape of A, then on B about the origin of the
  shape of B. Pinocchio has the linear part first.
- Pinocchio's ABA includes the armatures (rotor inertias) of the model, but not its joint friction and damping. Add
  these to τ.

Steps are explicit, so they must resolve the stiffness and damping of the contacts, friction included. A time step that
is too long raises ``TimeStepError``, which names the limit. Values may look right above the limit, but derivatives grow
in each step. The check ignores the stiffness and damping of a controller. ``python python/tests/times_pin.py`` prints
its cost.

A ``Robot`` works in its own buffers and in its ``pinocchio.Data``, so each thread needs its own robot. A robot can be
pickled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._autodiff import moduli_of
from ._core import HydroelasticError, Pair, RolloutError, SurfaceLaw

try:
    import pinocchio  # type: ignore[import-untyped, import-not-found, unused-ignore]
except ImportError as _missing:
    raise ImportError('hydroelastic.pin needs Pinocchio: pip install "hydroelastic[pin]"') from _missing

from ._pin_checks import check_count, check_time_step, checked, checked_pose, finite
from ._pin_contacts import Contact
from ._stability import Forces, Rates, TimeStepError, Watch, resistance

__all__ = [
    "Acceleration",
    "ContactPair",
    "Feedback",
    "Robot",
    "RobotJacobian",
    "RobotTrajectory",
    "Step",
    "TimeStepError",
    "Wrenches",
]

_Floats: TypeAlias = NDArray[np.float64]

# Tolerance of the norm of a quaternion.
_NORMALIZED = 1e-9


@dataclass(frozen=True)
class ContactPair:
    """Two shapes of a ``hydroelastic.Pair``, each fixed in a frame of a Pinocchio model.

    Parameters
    ----------
    pair : Pair
        Shapes, moduli and surface law.
    frame_a, frame_b : str or int
        Name or index of the frames that A and B are fixed in. The frame "universe" is the world.
    pose_a, pose_b : (4, 4) array_like, optional
        Poses of the shapes in these frames. Default: the identity.

    Raises
    ------
    HydroelasticError
        If a pose is not rigid.
    TypeError
        If a pose is not of float64 or integers.
    """

    pair: Pair
    frame_a: str | int
    frame_b: str | int = "universe"
    pose_a: _Floats | None = None
    pose_b: _Floats | None = None

    def __post_init__(self) -> None:
        for pose in (self.pose_a, self.pose_b):
            if pose is not None:
                checked_pose(pose)


class Acceleration(NamedTuple):
    """Joint accelerations and their derivatives.

    Attributes
    ----------
    a : (nv,) ndarray of float64
        Accelerations (rad/s² or m/s²).
    by_q, by_v, by_tau : (nv, nv) ndarray of float64
        Derivatives with respect to the tangent of q, to v and to tau.
    by_material : (nv, contacts, 4) ndarray of float64
        Derivatives with respect to the modulus of A (Pa), the modulus of B (Pa), the dissipation (s/m) and the friction
        coefficient of each contact.
    """

    a: _Floats
    by_q: _Floats
    by_v: _Floats
    by_tau: _Floats
    by_material: _Floats


class Wrenches(NamedTuple):
    """Wrenches of all contacts, in world axes, and their derivatives.

    Attributes
    ----------
    wrenches : (contacts, 12) ndarray of float64
        Torque (N m) and force (N) on A about the origin of its shape, then on B about the origin of its shape.
    by_q, by_v : (contacts, 12, nv) ndarray of float64
        Derivatives with respect to the tangent of q and to v.
    by_material : (contacts, 12, 4) ndarray of float64
        Derivatives with respect to the modulus of A (Pa), the modulus of B (Pa), the dissipation (s/m) and the friction
        coefficient of the same contact.
    """

    wrenches: _Floats
    by_q: _Floats
    by_v: _Floats
    by_material: _Floats


class Step(NamedTuple):
    """State after a step, and its derivatives.

    Attributes
    ----------
    q : (nq,) ndarray of float64
        Joint positions.
    v : (nv,) ndarray of float64
        Joint velocities.
    by_state : (2 nv, 2 nv) ndarray of float64
        Derivatives with respect to the state before the step, often called A. Rows and columns are the tangent of q,
        then v.
    by_tau : (2 nv, nv) ndarray of float64
        Derivatives with respect to tau, often called B.
    by_material : (2 nv, contacts, 4) ndarray of float64
        Derivatives with respect to the materials, as in ``Acceleration``.
    """

    q: _Floats
    v: _Floats
    by_state: _Floats
    by_tau: _Floats
    by_material: _Floats


class Feedback(NamedTuple):
    """Joint torques of a controller, and their derivatives. A derivative of None is zero.

    Attributes
    ----------
    tau : (nv,) ndarray of float64
        Joint torques (N m) and forces (N).
    by_q, by_v : (nv, nv) ndarray of float64 or None
        Derivatives with respect to the tangent of q and to v.
    by_parameters : (nv, p) ndarray of float64 or None
        Derivatives with respect to p parameters of the controller.
    """

    tau: _Floats
    by_q: _Floats | None = None
    by_v: _Floats | None = None
    by_parameters: _Floats | None = None


class RobotTrajectory(NamedTuple):
    """Recorded states of a rollout. The first state is the initial state.

    Attributes
    ----------
    times : (m,) ndarray of float64
        Times (s).
    q : (m, nq) ndarray of float64
        Joint positions.
    v : (m, nv) ndarray of float64
        Joint velocities.
    """

    times: _Floats
    q: _Floats
    v: _Floats


class RobotJacobian(NamedTuple):
    """Derivatives of the recorded states of a rollout. Rows are the tangent of q, then v.

    Attributes
    ----------
    by_start : (m, 2 nv, 2 nv) ndarray of float64
        Derivatives with respect to the initial state.
    by_material : (m, 2 nv, contacts, 4) ndarray of float64
        Derivatives with respect to the materials, as in ``Acceleration``.
    by_parameters : (m, 2 nv, p) ndarray of float64
        Derivatives with respect to the parameters of the controller.
    """

    by_start: _Floats
    by_material: _Floats
    by_parameters: _Floats


Controller: TypeAlias = Callable[[float, _Floats, _Floats], Feedback]


class Robot:
    """Mechanism of Pinocchio with contacts between its frames and with the world.

    Parameters
    ----------
    model : pinocchio.Model
        Model, from a URDF or MJCF file or built in code. The robot does not copy the model, which must not change.
    contacts : sequence of ContactPair
        Contact pairs. A pair that is far apart costs only its broad phase.
    check_stability : bool
        True to raise TimeStepError if a time step is too long for the contacts.

    Raises
    ------
    HydroelasticError
        If the model has mimic joints, a frame does not exist, both frames of a contact are fixed to each other, or a
        pose is not rigid. Every method raises it if an array has an unexpected shape, a number is not finite, or a
        quaternion is not normalized.
    TypeError
        Raised by every method if an argument is neither an array of float64 or integers nor a list of numbers.
    """

    def __init__(self, model: Any, contacts: Sequence[ContactPair], *, check_stability: bool = True) -> None:
        # Versions of Pinocchio without mimic joints do not have this list.
        if len(getattr(model, "mimicking_joints", ())):
            raise HydroelasticError("the model has mimic joints, which Pinocchio's derivatives do not take")
        self._model = model
        self._data = model.createData()
        self._pairs = tuple(contacts)
        width = 2 * model.nv + 4 * len(self._pairs)
        self._contacts = [Contact(model, pair, 2 * model.nv + 4 * k, width) for k, pair in enumerate(self._pairs)]
        self._width = width
        self._zero = np.zeros(model.nv)
        self._forces = pinocchio.StdVec_Force()
        for _ in range(model.njoints):
            self._forces.append(pinocchio.Force.Zero())
        self._loaded = sorted({mount.joint for contact in self._contacts for mount in contact.moving})
        self._checks_stability = check_stability
        self._watch = Watch([contact.name for contact in self._contacts])
        # Time step, q and v after the last step. They show whether the next step continues from this state.
        self._after: tuple[float, bytes, bytes] | None = None
        pairs = [contact.pair for contact in self._pairs]
        numbers = [[*moduli_of(pair), pair.law.dissipation, pair.law.friction] for pair in pairs]
        self._set_materials(np.array(numbers, dtype=np.float64).reshape(-1, 4))

    def __reduce__(self) -> tuple[Callable[..., Robot], tuple[Any, ...]]:
        return _loaded_robot, (self._model, self._pairs, self._materials, self._checks_stability)

    @property
    def model(self) -> Any:
        """Model, a ``pinocchio.Model``."""
        return self._model

    @property
    def contacts(self) -> tuple[ContactPair, ...]:
        """Contact pairs, in the order of all results."""
        return self._pairs

    @property
    def materials(self) -> _Floats:
        """Modulus of A (Pa), modulus of B (Pa), dissipation (s/m) and friction coefficient of each contact, (contacts,
        4) float64. The modulus of a rigid B is infinite, has no effect, and derivatives with respect to it are 0."""
        return self._materials.copy()

    def with_materials(self, materials: _Floats) -> Robot:
        """Copies the robot with other materials.

        Parameters
        ----------
        materials : (contacts, 4) array_like
            Numbers of each contact, as in ``materials``. The modulus of a rigid B may be any number.

        Returns
        -------
        Robot
            Robot with these materials.

        Raises
        ------
        HydroelasticError
            If a number is out of range, or the array has an unexpected shape.
        """
        robot = Robot(self._model, self._pairs, check_stability=self._checks_stability)
        numbers = checked(materials, "materials", (len(self._pairs), 4), infinite=True).copy()
        for contact, (modulus_a, modulus_b, *law) in zip(self._pairs, numbers, strict=True):
            # The constructor raises the errors of a pair. The modulus of a rigid B is infinite.
            rigid = contact.pair.moduli[1] is None
            Pair(*contact.pair.shapes, modulus_a, None if rigid else modulus_b, SurfaceLaw(*law))
        robot._set_materials(numbers)
        return robot

    def acceleration(self, q: _Floats, v: _Floats, tau: _Floats) -> _Floats:
        """Computes the joint accelerations.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.
        v : (nv,) array_like
            Joint velocities.
        tau : (nv,) array_like
            Joint torques (N m) and forces (N).

        Returns
        -------
        (nv,) ndarray of float64
            Accelerations (rad/s² or m/s²).

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or the acceleration is not finite.
        """
        return self._acceleration(q, v, tau)[0]

    def _acceleration(self, q: _Floats, v: _Floats, tau: _Floats) -> tuple[_Floats, Forces]:
        """Returns the accelerations and Jᵀ w of each contact."""
        model, data = self._model, self._data
        q, v, tau = self._check(q, v, tau)
        pinocchio.computeJointJacobians(model, data, q)
        forces = [
            contact.joint_torques(model, data, v, material)
            for contact, material in zip(self._contacts, self._by_contact, strict=True)
        ]
        for force in forces:
            if force is not None:
                tau = tau + force
        return finite(pinocchio.aba(model, data, q, v, tau)), forces

    def linearized(self, q: _Floats, v: _Floats, tau: _Floats) -> Acceleration:
        """Computes the joint accelerations and their derivatives with respect to q, v, tau and the materials.

        Parameters
        ----------
        q, v, tau
            Arguments of ``acceleration``.

        Returns
        -------
        Acceleration
            Accelerations and derivatives.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a result is not finite.
        """
        return self._linearized(q, v, tau)[0]

    def _linearized(self, q: _Floats, v: _Floats, tau: _Floats) -> tuple[Acceleration, Forces]:
        """Returns the result of ``linearized`` and Jᵀ w of each contact."""
        model, data, nv = self._model, self._data, self._model.nv
        q, v, tau = self._check(q, v, tau)
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        forces = self._forces
        for joint in self._loaded:
            forces[joint].setZero()
        slopes, torques = None, []
        for contact, material in zip(self._contacts, self._by_contact, strict=True):
            torque, of_contact = contact.joint_torque_slopes(model, data, v, material, forces)
            torques.append(torque)
            if of_contact is not None:
                slopes = of_contact if slopes is None else slopes + of_contact
        by_q, by_v, by_tau = pinocchio.computeABADerivatives(model, data, q, v, tau, forces)
        a = finite(data.ddq.copy())
        finite(by_q + by_v, "a derivative of the acceleration")
        if slopes is None:
            return Acceleration(a, by_q, by_v, by_tau, np.zeros((nv, len(self._pairs), 4))), torques
        slopes = finite(by_tau.dot(slopes), "a derivative of the acceleration")
        by_material = slopes[:, 2 * nv :].reshape(nv, -1, 4)
        return Acceleration(a, by_q + slopes[:, :nv], by_v + slopes[:, nv : 2 * nv], by_tau, by_material), torques

    def wrenches(self, q: _Floats, v: _Floats) -> _Floats:
        """Computes the wrenches of all contacts.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.
        v : (nv,) array_like
            Joint velocities.

        Returns
        -------
        (contacts, 12) ndarray of float64
            Wrenches, as in ``Wrenches``.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a wrench is not finite.
        """
        q, v = self._check(q, v)
        model, data = self._model, self._data
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        wrenches = np.zeros((len(self._pairs), 12))
        for k, (contact, material) in enumerate(zip(self._contacts, self._by_contact, strict=True)):
            contact.move(model, data, v)
            wrenches[k] = contact.wrench(material)
        return finite(wrenches, "a contact wrench")

    def linearized_wrenches(self, q: _Floats, v: _Floats) -> Wrenches:
        """Computes the wrenches of all contacts and their derivatives with respect to q, v and the materials.

        Parameters
        ----------
        q, v
            Arguments of ``wrenches``.

        Returns
        -------
        Wrenches
            Wrenches and derivatives.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a wrench is not finite.
        """
        q, v = self._check(q, v)
        model, data, nv = self._model, self._data, self._model.nv
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        count = len(self._pairs)
        result = Wrenches(*(np.zeros((count, 12, *more)) for more in ((), (nv,), (nv,), (4,))))
        for k, (contact, material) in enumerate(zip(self._contacts, self._by_contact, strict=True)):
            contact.move(model, data, v)
            result.wrenches[k], jacobian = contact.linearized(material)
            slopes = jacobian[:, :24] @ contact.motion[:24, : 2 * nv]
            result.by_q[k], result.by_v[k], result.by_material[k] = slopes[:, :nv], slopes[:, nv:], jacobian[:, 24:]
        finite(result.wrenches, "a contact wrench")
        return result

    def poses(self, q: _Floats) -> _Floats:
        """Computes the poses of the shapes of all contacts in the world.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.

        Returns
        -------
        (contacts, 2, 4, 4) ndarray of float64
            Poses of A and B for each contact.

        Raises
        ------
        HydroelasticError
            If the argument is not valid.
        """
        (q,) = self._check(q)
        pinocchio.forwardKinematics(self._model, self._data, q)
        for contact in self._contacts:
            contact.update_poses(self._data)
        return np.array([contact.poses for contact in self._contacts]).reshape(-1, 2, 4, 4)

    def contact_energy(self, q: _Floats) -> float:
        """Computes the potential energy of all contacts. It takes much longer than the wrenches.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.

        Returns
        -------
        float
            Potential energy (J).

        Raises
        ------
        HydroelasticError
            If the argument is not valid.
        """
        energy = 0.0
        for contact, (moduli, _), poses in zip(self._contacts, self._by_contact, self.poses(q), strict=True):
            energy += float(contact.pair.potential_energy(poses[0], poses[1], moduli=moduli))
        return energy

    def step(self, q: _Floats, v: _Floats, tau: _Floats, time_step: float) -> tuple[_Floats, _Floats]:
        """Takes a semi-implicit Euler step: v changes by the acceleration, and q moves by the new v.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.
        v : (nv,) array_like
            Joint velocities.
        tau : (nv,) array_like
            Joint torques (N m) and forces (N).
        time_step : float
            Time step (s), positive.

        Returns
        -------
        q : (nq,) ndarray of float64
            Joint positions after the step.
        v : (nv,) ndarray of float64
            Joint velocities after the step.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a result is not finite.
        TimeStepError
            If the time step is too long for the contacts.
        """
        check_time_step(time_step)
        q, v, tau = self._check(q, v, tau)
        a, forces = self._acceleration(q, v, tau)
        self._check_stability(q, v, forces, time_step)
        v = finite(v + time_step * a, "v")
        return self._moved(q, v, time_step), v

    def linearized_step(self, q: _Floats, v: _Floats, tau: _Floats, time_step: float) -> Step:
        """Takes a step, and differentiates it with respect to the state, tau and the materials.

        Parameters
        ----------
        q, v, tau, time_step
            Arguments of ``step``.

        Returns
        -------
        Step
            State after the step, and derivatives.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a result is not finite.
        TimeStepError
            If the time step is too long for the contacts.
        """
        check_time_step(time_step)
        q, v, tau = self._check(q, v, tau)
        nv = self._model.nv
        (a, by_q, by_v, by_tau, by_material), forces = self._linearized(q, v, tau)
        self._check_stability(q, v, forces, time_step)
        # Derivatives of the new velocity with respect to q, v, tau and the materials.
        slopes = time_step * np.hstack([by_q, by_v, by_tau, by_material.reshape(nv, -1)])
        slopes[:, nv : 2 * nv] += np.eye(nv)
        v = v + time_step * a
        moved, turned = pinocchio.dIntegrate(self._model, q, time_step * v)
        of_q = time_step * (turned @ slopes)
        of_q[:, :nv] += moved
        whole = finite(np.vstack([of_q, slopes]), "a derivative of the step")
        by_state, by_tau, by_material = whole[:, : 2 * nv], whole[:, 2 * nv : 3 * nv], whole[:, 3 * nv :]
        q = self._moved(q, v, time_step)
        return Step(q, v, by_state, by_tau, by_material.reshape(2 * nv, -1, 4))

    def rollout(
        self,
        q: _Floats,
        v: _Floats,
        tau: _Floats | Controller,
        time_step: float,
        steps: int,
        *,
        record_every: int = 1,
    ) -> RobotTrajectory:
        """Runs a rollout of semi-implicit Euler steps.

        Parameters
        ----------
        q : (nq,) array_like
            Initial joint positions.
        v : (nv,) array_like
            Initial joint velocities.
        tau : (nv,) or (steps, nv) array_like, or callable
            Joint torques (N m) and forces (N): constant, one row for each step, or a function of the time (s), q and v
            that returns a ``Feedback``. Only the ``tau`` of the feedback is used here.
        time_step : float
            Time step (s), positive.
        steps : int
            Number of steps.
        record_every : int
            Number of steps between recorded states. The last state is recorded only if its step number is a multiple.

        Returns
        -------
        RobotTrajectory
            Recorded states.

        Raises
        ------
        HydroelasticError
            If an argument is not valid.
        TimeStepError
            If the time step is too long for the contacts. Its ``trajectory`` has the recorded earlier states.
        RolloutError
            If a step fails. Its ``trajectory`` has the recorded earlier states.
        """
        records = _Records(steps, record_every, time_step)
        torques = self._torques(tau, steps)
        q, v = self._check(q, v)
        records.offer(0, (q, v))
        for k in range(steps):
            feedback = torques(k * time_step, q, v, k)
            try:
                q, v = self.step(q, v, feedback.tau, time_step)
            except HydroelasticError as error:
                raise records.failed(k, error) from error.__cause__
            records.offer(k + 1, (q, v))
        return RobotTrajectory(records.times(), *records.stacked())

    def linearized_rollout(
        self,
        q: _Floats,
        v: _Floats,
        tau: _Floats | Controller,
        time_step: float,
        steps: int,
        *,
        record_every: int = 1,
    ) -> tuple[RobotTrajectory, RobotJacobian]:
        """Runs a rollout, and differentiates the recorded states.

        The derivatives are with respect to the initial state, the materials and the parameters of a controller. For
        derivatives with respect to the torques of single steps, multiply the derivatives of ``linearized_step``.

        Parameters
        ----------
        q, v, tau, time_step, steps, record_every
            Arguments of ``rollout``. The ``Feedback`` of a controller must have its derivatives.

        Returns
        -------
        trajectory : RobotTrajectory
            Recorded states.
        jacobian : RobotJacobian
            Derivatives of the recorded states.

        Raises
        ------
        HydroelasticError
            If an argument is not valid.
        TimeStepError
            If the time step is too long for the contacts. Its ``trajectory`` has the recorded earlier states.
        RolloutError
            If a step fails. Its ``trajectory`` has the recorded earlier states.
        """
        nv, count = self._model.nv, len(self._pairs)
        records = _Records(steps, record_every, time_step)
        torques = self._torques(tau, steps)
        q, v = self._check(q, v)
        first = torques(0.0, q, v, 0) if steps else Feedback(self._zero)
        numbers = 0 if first.by_parameters is None else np.shape(first.by_parameters)[-1]
        slopes = np.zeros((2 * nv, self._width + numbers))
        slopes[:, : 2 * nv] = np.eye(2 * nv)
        records.offer(0, (q, v, slopes))
        for k in range(steps):
            feedback = torques(k * time_step, q, v, k) if k else first
            try:
                step = self.linearized_step(q, v, feedback.tau, time_step)
            except HydroelasticError as error:
                raise records.failed(k, error) from error.__cause__
            by_state = step.by_state + step.by_tau @ self._by_state(feedback)
            slopes = by_state @ slopes
            slopes[:, 2 * nv : self._width] += step.by_material.reshape(2 * nv, -1)
            if numbers:
                by_parameters = checked(feedback.by_parameters, "Feedback.by_parameters", (nv, numbers))
                slopes[:, self._width :] += step.by_tau @ by_parameters
            q, v = step.q, step.v
            records.offer(k + 1, (q, v, slopes))
        times, (all_q, all_v, all_slopes) = records.times(), records.stacked()
        by_start, by_material, by_parameters = np.split(all_slopes, [2 * nv, self._width], axis=2)
        by_material = by_material.reshape(len(times), 2 * nv, count, 4)
        return RobotTrajectory(times, all_q, all_v), RobotJacobian(by_start, by_material, by_parameters)

    def _set_materials(self, materials: _Floats) -> None:
        materials.flags.writeable = False
        self._materials = materials
        self._by_contact = [(row[:2], row[2:]) for row in materials]

    def _moved(self, q: _Floats, v: _Floats, time_step: float) -> _Floats:
        """Returns q after a step at the velocity v."""
        q = finite(pinocchio.integrate(self._model, q, time_step * v), "q")
        self._after = time_step, q.tobytes(), v.tobytes()
        return q

    def _check_stability(self, q: _Floats, v: _Floats, forces: Forces, time_step: float) -> None:
        if not self._checks_stability:
            return
        if self._after != (time_step, q.tobytes(), v.tobytes()):
            self._watch.forget()
        fault = self._watch.fault(forces, v, time_step, lambda: self._mass(q), lambda velocity: self._rates(q, velocity))
        if fault is not None:
            self._after = None
            raise fault.error(time_step)

    def _mass(self, q: _Floats) -> _Floats:
        upper = np.triu(pinocchio.crba(self._model, self._data, q))
        mass: _Floats = upper + np.triu(upper, 1).T
        return mass

    def _rates(self, q: _Floats, v: _Floats) -> Rates:
        """Returns the stiffness and damping of the contacts."""
        model, data = self._model, self._data
        stiffness, damping = np.zeros((2, len(self._contacts), model.nv, model.nv))
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        for k, (contact, (moduli, law)) in enumerate(zip(self._contacts, self._by_contact, strict=True)):
            contact.move(model, data, v)
            stiffness[k], damping[k] = resistance(
                contact.pair, contact.poses, contact.twists, contact.both_jacobians, moduli, law
            )
        return Rates(stiffness, damping, self._mass(q))

    def _check(self, *arrays: _Floats) -> tuple[_Floats, ...]:
        """Converts q, or q and v, or q, v and tau, to arrays of float64."""
        model = self._model
        sizes = (model.nq, model.nv, model.nv)
        converted = tuple(checked(array, name, (size,)) for array, name, size in zip(arrays, ("q", "v", "tau"), sizes))
        q = converted[0]
        if model.nq != model.nv and not pinocchio.isNormalized(model, q, _NORMALIZED):
            raise HydroelasticError("q has a quaternion or a continuous joint that is not normalized: see pinocchio.normalize")
        return converted

    def _torques(self, tau: _Floats | Controller, steps: int) -> Callable[[float, _Floats, _Floats, int], Feedback]:
        nv = self._model.nv
        if callable(tau):
            controller = tau

            def of_controller(time: float, q: _Floats, v: _Floats, _: int) -> Feedback:
                feedback = controller(time, q, v)
                if not isinstance(feedback, Feedback):
                    raise TypeError(f"the controller returned {type(feedback).__name__}: expected hydroelastic.pin.Feedback")
                return feedback

            return of_controller
        if np.ndim(tau) == 2:
            rows = [Feedback(row) for row in checked(tau, "tau", (steps, nv))]
            return lambda _time, _q, _v, k: rows[k]
        constant = Feedback(checked(tau, "tau", (nv,)))
        return lambda _time, _q, _v, _k: constant

    def _by_state(self, feedback: Feedback) -> _Floats:
        nv = self._model.nv
        by_state = np.zeros((nv, 2 * nv))
        for columns, value, name in ((slice(0, nv), feedback.by_q, "by_q"), (slice(nv, None), feedback.by_v, "by_v")):
            if value is not None:
                by_state[:, columns] = checked(value, f"Feedback.{name}", (nv, nv))
        return by_state


class _Records:
    """Recorded states of a rollout, each a tuple of arrays: the initial state, and the state after each ``every``
    steps."""

    def __init__(self, steps: int, every: int, time_step: float) -> None:
        check_count(steps, "steps")
        every = check_count(every, "record_every", 1)
        check_time_step(time_step)
        self._every = every
        self._time_step = time_step
        self._states: list[tuple[_Floats, ...]] = []

    def failed(self, step: int, error: HydroelasticError) -> RolloutError:
        """Returns the error with the step, its time and the earlier states."""
        time = step * self._time_step
        if isinstance(error, TimeStepError):
            error.at_step(step, time)
            failure: RolloutError = error
        else:
            failure = RolloutError(f"step {step} (t = {time:.6g} s): {error}")
        q, v, *_ = self.stacked()
        failure.trajectory = RobotTrajectory(self.times(), q, v)  # type: ignore[assignment]
        return failure

    def offer(self, step: int, state: tuple[_Floats, ...]) -> None:
        """Records the state after ``step`` steps, if the number is a multiple of ``every``."""
        if step % self._every == 0:
            self._states.append(state)

    def times(self) -> _Floats:
        """Times (s) of the recorded states."""
        times: _Floats = self._time_step * self._every * np.arange(len(self._states), dtype=np.float64)
        return times

    def stacked(self) -> list[_Floats]:
        """Stacks each of the arrays. The first axis is that of the recorded states."""
        return [np.stack(arrays) for arrays in zip(*self._states)]


def _loaded_robot(model: Any, contacts: Sequence[ContactPair], materials: _Floats, check_stability: bool) -> Robot:
    """Restores a robot from a pickle."""
    robot = Robot(model, contacts, check_stability=check_stability)
    robot._set_materials(np.array(materials))
    return robot
