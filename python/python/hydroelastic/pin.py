"""Robots with joints in contact: Pinocchio carries the mechanism, this library its contacts; derivatives are exact.

``Robot`` takes a Pinocchio model and its contacts. Its joint accelerations obey

    a = ABA(q, v, τ + Σ J(q)ᵀ w(poses(q), twists(q, v))),

and come with their derivatives by q, v, τ and the materials of the contacts, in closed form: Pinocchio's of the mechanism with
forces fixed in the links, and by the chain rule those of the wrenches. Semi-implicit Euler steps and rollouts carry them on.

Conventions are those of Pinocchio for joints, and those of this package for contacts:

- Derivatives by q are by its tangent space, (nv,): q varies as ``pinocchio.integrate(model, q, dq)``. Free-flyers, spherical and
  continuous joints, whose nq is not nv, are of no other kind.
- Wrenches are (torque, force) in world axes, on A about the origin of A's shape and then on B about that of B's. Pinocchio has
  the linear part first.
- Pinocchio's ABA takes armatures (rotor inertias) of the model, and not its joint friction and damping: put these into τ.

Steps are explicit, so they must resolve the stiffness and damping of the contacts, friction included. A time step that is too long
raises ``TimeStepError``, which names the limit. Values may look right above the limit, but derivatives grow in each step. The
check leaves out the stiffness and damping of a controller. ``python python/tests/times_pin.py`` prints its cost.

A ``Robot`` works in buffers of its own and of its ``pinocchio.Data``: use one a thread. It can be pickled.
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

# How far the norm of a quaternion may be from 1.
_NORMALIZED = 1e-9


@dataclass(frozen=True)
class ContactPair:
    """Two shapes of a ``hydroelastic.Pair``, each fixed in a frame of a Pinocchio model.

    Parameters
    ----------
    pair : the shapes, moduli and the surface law.
    frame_a, frame_b : name or index of the frame that carries A, and B. Frame "universe" is the world.
    pose_a, pose_b : (4, 4), the poses of the shapes in these frames; None for the same axes and origin.
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

    a is (nv,) (rad/s², m/s²). by_q, by_v and by_tau are (nv, nv). by_material is (nv, contacts, 4): by the modulus of A, that of
    B (Pa), the dissipation (s/m) and the friction coefficient of each contact.
    """

    a: _Floats
    by_q: _Floats
    by_v: _Floats
    by_tau: _Floats
    by_material: _Floats


class Wrenches(NamedTuple):
    """Wrenches of all contacts, in world axes, and their derivatives.

    wrenches is (contacts, 12): torque (N m) and force (N) on A, about the origin of its shape, and those on B, about its own.
    by_q and by_v are (contacts, 12, nv). by_material is (contacts, 12, 4), by the contact's own modulus of A, modulus of B,
    dissipation and friction.
    """

    wrenches: _Floats
    by_q: _Floats
    by_v: _Floats
    by_material: _Floats


class Step(NamedTuple):
    """A step and its derivatives.

    q is (nq,), v (nv,). by_state is (2 nv, 2 nv), often called A: rows and columns are the tangent of q, then v. by_tau is
    (2 nv, nv), often called B. by_material is (2 nv, contacts, 4), as in ``Acceleration``.
    """

    q: _Floats
    v: _Floats
    by_state: _Floats
    by_tau: _Floats
    by_material: _Floats


class Feedback(NamedTuple):
    """Joint torques of a controller, (nv,), and their derivatives.

    by_q and by_v are (nv, nv), by_parameters is (nv, p) for p parameters of the controller. None is for no dependence.
    """

    tau: _Floats
    by_q: _Floats | None = None
    by_v: _Floats | None = None
    by_parameters: _Floats | None = None


class RobotTrajectory(NamedTuple):
    """Recorded states: times (m,) (s), q (m, nq) and v (m, nv). The start is the first of them."""

    times: _Floats
    q: _Floats
    v: _Floats


class RobotJacobian(NamedTuple):
    """Derivatives of the recorded states; rows are the tangent of q, then v.

    by_start is (m, 2 nv, 2 nv), by the first state. by_material is (m, 2 nv, contacts, 4), as in ``Acceleration``.
    by_parameters is (m, 2 nv, p), by the parameters of the controller.
    """

    by_start: _Floats
    by_material: _Floats
    by_parameters: _Floats


Controller: TypeAlias = Callable[[float, _Floats, _Floats], Feedback]


class Robot:
    """A mechanism of Pinocchio whose frames touch each other and the world.

    Parameters
    ----------
    model : pinocchio.Model, from a URDF, an MJCF or built in code. It is used as it is, and must not change.
    contacts : the contact pairs. A pair that is far apart costs its broad phase only.
    check_stability : whether a time step that is too long for the contacts raises TimeStepError.

    Raises
    ------
    HydroelasticError if a frame is not there, both frames of a contact are fixed to each other, or a pose is not rigid; every
    method, if an array has another shape, a number is not finite, or a quaternion is not normalized. TypeError if an argument is
    neither an array of float64 or integers nor a list of numbers. Steps and rollouts raise TimeStepError if the time step is too long, and
    rollouts RolloutError if a step fails; the ``trajectory`` of both errors holds the recorded earlier states.
    """

    def __init__(self, model: Any, contacts: Sequence[ContactPair], *, check_stability: bool = True) -> None:
        # Versions before these joints have no list of them.
        if len(getattr(model, "mimicking_joints", ())):
            raise HydroelasticError("the model has mimic joints, which Pinocchio's derivatives do not take")
        self._model = model
        self._data = model.createData()
        self._pairs = tuple(contacts)
        width = 2 * model.nv + 4 * len(self._pairs)
        self._contacts = [Contact(model, it, 2 * model.nv + 4 * k, width) for k, it in enumerate(self._pairs)]
        self._width = width
        self._zero = np.zeros(model.nv)
        self._forces = pinocchio.StdVec_Force()
        for _ in range(model.njoints):
            self._forces.append(pinocchio.Force.Zero())
        self._loaded = sorted({mount.joint for it in self._contacts for mount in it.moving})
        self._checks_stability = check_stability
        self._watch = Watch([it.name for it in self._contacts])
        # Time step, q and v after the last step, to tell whether the next step continues from there.
        self._after: tuple[float, bytes, bytes] | None = None
        numbers = [[*moduli_of(it.pair), it.pair.law.dissipation, it.pair.law.friction] for it in self._pairs]
        self._set_materials(np.array(numbers, dtype=np.float64).reshape(-1, 4))

    def __reduce__(self) -> tuple[Callable[..., Robot], tuple[Any, ...]]:
        return _loaded_robot, (self._model, self._pairs, self._materials, self._checks_stability)

    @property
    def model(self) -> Any:
        """The ``pinocchio.Model``."""
        return self._model

    @property
    def contacts(self) -> tuple[ContactPair, ...]:
        """The contact pairs, in the order of all results."""
        return self._pairs

    @property
    def materials(self) -> _Floats:
        """(contacts, 4): modulus of A, modulus of B (Pa), dissipation (s/m) and friction coefficient of each contact. That of a
        rigid B is infinite, has no effect and derivatives of 0."""
        return self._materials.copy()

    def with_materials(self, materials: _Floats) -> Robot:
        """The same robot with other ``materials``, (contacts, 4)."""
        robot = Robot(self._model, self._pairs, check_stability=self._checks_stability)
        found = checked(materials, "materials", (len(self._pairs), 4), infinite=True).copy()
        for contact, (modulus_a, modulus_b, *law) in zip(self._pairs, found, strict=True):
            # Raises the errors of a pair. The modulus of a rigid B is infinite.
            rigid = contact.pair.moduli[1] is None
            Pair(*contact.pair.shapes, modulus_a, None if rigid else modulus_b, SurfaceLaw(*law))
        robot._set_materials(found)
        return robot

    def acceleration(self, q: _Floats, v: _Floats, tau: _Floats) -> _Floats:
        """Joint accelerations (nv,) at q (nq,), v (nv,) and joint torques tau (nv,)."""
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
        """Joint accelerations and their derivatives by q, v, tau and the materials."""
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
            found, added = contact.joint_torque_slopes(model, data, v, material, forces)
            torques.append(found)
            if added is not None:
                slopes = added if slopes is None else slopes + added
        by_q, by_v, by_tau = pinocchio.computeABADerivatives(model, data, q, v, tau, forces)
        a = finite(data.ddq.copy())
        finite(by_q + by_v, "a derivative of the acceleration")
        if slopes is None:
            return Acceleration(a, by_q, by_v, by_tau, np.zeros((nv, len(self._pairs), 4))), torques
        slopes = finite(by_tau.dot(slopes), "a derivative of the acceleration")
        by_material = slopes[:, 2 * nv :].reshape(nv, -1, 4)
        return Acceleration(a, by_q + slopes[:, :nv], by_v + slopes[:, nv : 2 * nv], by_tau, by_material), torques

    def wrenches(self, q: _Floats, v: _Floats) -> _Floats:
        """Wrenches of all contacts, (contacts, 12), as in ``Wrenches``."""
        q, v = self._check(q, v)
        model, data = self._model, self._data
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        found = np.zeros((len(self._pairs), 12))
        for k, (contact, material) in enumerate(zip(self._contacts, self._by_contact, strict=True)):
            contact.move(model, data, v)
            found[k] = contact.wrench(material)
        return finite(found, "a contact wrench")

    def linearized_wrenches(self, q: _Floats, v: _Floats) -> Wrenches:
        """Wrenches of all contacts and their derivatives by q, v and the materials."""
        q, v = self._check(q, v)
        model, data, nv = self._model, self._data, self._model.nv
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, self._zero)
        count = len(self._pairs)
        found = Wrenches(*(np.zeros((count, 12, *more)) for more in ((), (nv,), (nv,), (4,))))
        for k, (contact, material) in enumerate(zip(self._contacts, self._by_contact, strict=True)):
            contact.move(model, data, v)
            found.wrenches[k], jacobian = contact.linearized(material)
            slopes = jacobian[:, :24] @ contact.motion[:24, : 2 * nv]
            found.by_q[k], found.by_v[k], found.by_material[k] = slopes[:, :nv], slopes[:, nv:], jacobian[:, 24:]
        finite(found.wrenches, "a contact wrench")
        return found

    def poses(self, q: _Floats) -> _Floats:
        """Poses of the shapes of all contacts in the world, (contacts, 2, 4, 4): those of A, those of B."""
        (q,) = self._check(q)
        pinocchio.forwardKinematics(self._model, self._data, q)
        for contact in self._contacts:
            contact.place(self._data)
        return np.array([contact.poses for contact in self._contacts]).reshape(-1, 2, 4, 4)

    def contact_energy(self, q: _Floats) -> float:
        """Potential energy (J) of all contacts. Takes much longer than the wrenches."""
        energy = 0.0
        for contact, (moduli, _), poses in zip(self._contacts, self._by_contact, self.poses(q), strict=True):
            energy += float(contact.pair.potential_energy(poses[0], poses[1], moduli=moduli))
        return energy

    def step(self, q: _Floats, v: _Floats, tau: _Floats, time_step: float) -> tuple[_Floats, _Floats]:
        """q and v after a semi-implicit Euler step (s): v grows by the acceleration, and q moves by the new v."""
        check_time_step(time_step)
        q, v, tau = self._check(q, v, tau)
        a, forces = self._acceleration(q, v, tau)
        self._check_stability(q, v, forces, time_step)
        v = finite(v + time_step * a, "v")
        return self._moved(q, v, time_step), v

    def linearized_step(self, q: _Floats, v: _Floats, tau: _Floats, time_step: float) -> Step:
        """``step`` with its derivatives by the state, tau and the materials."""
        check_time_step(time_step)
        q, v, tau = self._check(q, v, tau)
        nv = self._model.nv
        (a, by_q, by_v, by_tau, by_material), forces = self._linearized(q, v, tau)
        self._check_stability(q, v, forces, time_step)
        # Of the new velocity, by q, v, tau and the materials.
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
        """States from q, v on, every so many steps.

        tau is constant, (nv,), has a row a step, (steps, nv), or is a function of the time (s), q and v that returns a
        ``Feedback``, of which only tau is used here.
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
        """``rollout`` with derivatives of the recorded states by the first, the materials and the parameters of a controller.

        The ``Feedback`` of a controller must have its derivatives. By torques of single steps, multiply those of
        ``linearized_step``.
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
        """q after a step at the velocity v."""
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
        """Stiffness and damping of the contacts."""
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
        """Returns q, or q and v, or q, v and tau, as arrays of float64."""
        model = self._model
        sizes = (model.nq, model.nv, model.nv)
        found = tuple(checked(it, name, (size,)) for it, name, size in zip(arrays, ("q", "v", "tau"), sizes))
        q = found[0]
        if model.nq != model.nv and not pinocchio.isNormalized(model, q, _NORMALIZED):
            raise HydroelasticError("q has a quaternion or a continuous joint that is not normalized: see pinocchio.normalize")
        return found

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
    """The states of a rollout that are recorded, each a tuple of arrays: the first, and every so many-th after it."""

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
        """Takes the state after so many steps, if it is one to record."""
        if step % self._every == 0:
            self._states.append(state)

    def times(self) -> _Floats:
        """Times (s) of the recorded states."""
        times: _Floats = self._time_step * self._every * np.arange(len(self._states), dtype=np.float64)
        return times

    def stacked(self) -> list[_Floats]:
        """Each of the arrays, with an axis for the recorded states in front."""
        return [np.stack(arrays) for arrays in zip(*self._states)]


def _loaded_robot(model: Any, contacts: Sequence[ContactPair], materials: _Floats, check_stability: bool) -> Robot:
    """What pickle calls."""
    robot = Robot(model, contacts, check_stability=check_stability)
    robot._set_materials(np.array(materials))
    return robot
