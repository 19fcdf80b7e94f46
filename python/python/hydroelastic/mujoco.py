"""Contacts of this library in a MuJoCo model, as passive forces for simulation.

``PassiveContacts`` takes a model and its contacts. In its context, each evaluation of MuJoCo's passive forces adds Jᵀ w
of every contact to ``qfrc_passive``. This happens after the kinematics, so that the wrenches are those of the current
state:

    with PassiveContacts(model, [ContactPair(pair, geom("ball"), geom("block"))]):
        mujoco.mj_step(model, data)

Wrenches are (torque, force) in world axes: on A about the origin of the shape of A, then on B about the origin of the
shape of B. MuJoCo's ``xfrc_applied`` has the force first.

MuJoCo's own contact between the same bodies must be disabled. ``exclude`` adds the exclusions to a ``mujoco.MjSpec``.
``PassiveContacts`` raises an error for a model in which both contacts would act.

Limits:

- The callback of MuJoCo is global to the process. Contexts of several models may be open at the same time, in any
  order. A model without a context is not affected. A copy of a model is another model and needs its own context. A
  Python callback that was set before is called first, and is restored after the last context.
- MuJoCo's integrators ignore the derivative of a callback. ``implicit`` and ``implicitfast`` treat the contacts
  explicitly, as ``Euler`` does, so the time step must resolve the stiffness and damping of the contacts. ``RK4``
  evaluates the contacts four times in each step.
- A time step that is too long for the contacts raises ``TimeStepError`` from the second step on. The check treats
  bodies as free: MuJoCo's own constraints do not raise the limit, and its springs and actuators do not lower it.
- Sticking friction has the shortest limit. Above it, friction chatters but does not grow without bound. The check
  allows up to 2.5 times this limit. There, bodies chatter at about 2.3 slip tolerances and creep 2.5 times as fast.
  ``World.largest_stable_step`` allows none.
- If a position, a velocity or an acceleration is not finite or beyond 1e10, ``RolloutError`` names the number, the
  joint, the body, the step, the time, and the contact that last acted on the joint. This does not depend on
  ``check_stability``. MuJoCo itself only writes a warning and resets the state.
- If a step moves two bodies so deep into each other that their contact no longer acts, ``RolloutError`` names the
  contact. A body that a single step moves through another body and out of it is not detected.
- ``mjd_transitionFD`` differentiates through the callback by finite differences. ``hydroelastic.pin`` and
  ``hydroelastic.World`` have exact derivatives.
- The callback takes the GIL, so threads wait for each other in it, including the threads of ``mujoco.rollout``. Use
  processes instead. An error in a thread of ``mujoco.rollout`` is raised at the end of the context, because MuJoCo
  would end the process.
- MuJoCo does not call the callback if ``disableflags`` disables both springs and dampers. ``PassiveContacts`` raises an
  error for such a model.
- Contacts do not wake sleeping bodies.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import HydroelasticError, Pair, RolloutError, Shape, SurfaceLaw, moved_pose
from ._checks import check_count, checked_pose
from ._stability import Forces, Rates, TimeStepError, Watch, resistance

try:
    import mujoco  # type: ignore[import-untyped, import-not-found, unused-ignore]
except ImportError as _missing:
    raise ImportError('hydroelastic.mujoco needs MuJoCo: pip install "hydroelastic[mujoco]"') from _missing

__all__ = ["Attachment", "ContactPair", "PassiveContacts", "TimeStepError", "body", "exclude", "geom", "shape_from_geom", "site"]

_Floats: TypeAlias = NDArray[np.float64]

_KINDS = {"geom": mujoco.mjtObj.mjOBJ_GEOM, "body": mujoco.mjtObj.mjOBJ_BODY, "site": mujoco.mjtObj.mjOBJ_SITE}
_JOINT = mujoco.mjtObj.mjOBJ_JOINT
# Numbers of positions and velocities of joints with more than one of each.
_SIZES = {int(mujoco.mjtJoint.mjJNT_FREE): (7, 6), int(mujoco.mjtJoint.mjJNT_BALL): (4, 3)}
_IDENTITY = np.eye(4)
# Passive forces are off if springs and dampers are both disabled. Older versions have one bit for both.
_PASSIVE_BITS = ("mjDSBL_SPRING", "mjDSBL_DAMPER", "mjDSBL_PASSIVE")
_NO_PASSIVE_FORCES = sum(int(getattr(mujoco.mjtDisableBit, name, 0)) for name in _PASSIVE_BITS)

_NO_EULER_DAMPING = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
_IMPLICIT = (int(mujoco.mjtIntegrator.mjINT_IMPLICIT), int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST))
_RK4 = int(mujoco.mjtIntegrator.mjINT_RK4)
# Warnings of a state that is not finite, by the array of ``mujoco.MjData`` with the number.
_DIVERGED = {
    "qpos": mujoco.mjtWarning.mjWARN_BADQPOS,
    "qvel": mujoco.mjtWarning.mjWARN_BADQVEL,
    "qacc": mujoco.mjtWarning.mjWARN_BADQACC,
}
# Round-off of the time, relative to the time step.
_CLOCK = 1e-3
# Steps of x times the limit of sticking friction make bodies chatter at √(x² − 1) slip tolerances. The check allows x
# up to this.
_CHATTER = 2.5
# Maximum number of MjData instances whose histories are kept.
_MOST_HISTORIES = 4096


@dataclass(frozen=True)
class Attachment:
    """Frame that a shape is fixed in, created by ``geom``, ``body`` or ``site``.

    Parameters
    ----------
    kind : str
        "geom", "body" or "site".
    name : str
        Name of the geom, body or site.
    pose : (4, 4) array_like, optional
        Pose of the shape in this frame. Default: the identity.

    Raises
    ------
    HydroelasticError
        If the pose is not rigid.
    TypeError
        If the pose is not of float64 or integers.
    """

    kind: str
    name: str
    pose: _Floats | None = None

    def __post_init__(self) -> None:
        if self.pose is not None:
            checked_pose(self.pose)


def geom(name: str, pose: _Floats | None = None) -> Attachment:
    """Attaches a shape to a geom.

    MuJoCo moves the frame of a mesh geom to the center of mass and principal axes of the mesh. For a shape from the
    same file, use ``body`` instead, or the pose from ``model.mesh_pos`` and ``model.mesh_quat``.

    Parameters
    ----------
    name : str
        Name of the geom.
    pose : (4, 4) array_like, optional
        Pose of the shape in the frame of the geom. Default: the identity.

    Returns
    -------
    Attachment
        Frame of the geom.

    Raises
    ------
    HydroelasticError
        If the pose is not rigid.
    """
    return Attachment("geom", name, pose)


def body(name: str, pose: _Floats | None = None) -> Attachment:
    """Attaches a shape to a body.

    Parameters
    ----------
    name : str
        Name of the body. The body "world" is the world.
    pose : (4, 4) array_like, optional
        Pose of the shape in the frame of the body (``xpos``, not the center of mass). Default: the identity.

    Returns
    -------
    Attachment
        Frame of the body.

    Raises
    ------
    HydroelasticError
        If the pose is not rigid.
    """
    return Attachment("body", name, pose)


def site(name: str, pose: _Floats | None = None) -> Attachment:
    """Attaches a shape to a site.

    Parameters
    ----------
    name : str
        Name of the site.
    pose : (4, 4) array_like, optional
        Pose of the shape in the frame of the site. Default: the identity.

    Returns
    -------
    Attachment
        Frame of the site.

    Raises
    ------
    HydroelasticError
        If the pose is not rigid.
    """
    return Attachment("site", name, pose)


@dataclass(frozen=True)
class ContactPair:
    """Two shapes of a ``hydroelastic.Pair``, each attached to a frame of a MuJoCo model.

    Parameters
    ----------
    pair : Pair
        Shapes, moduli and surface law.
    a, b : Attachment
        Frames of A and B.
    """

    pair: Pair
    a: Attachment
    b: Attachment


def exclude(spec: Any, contacts: Sequence[ContactPair]) -> None:
    """Excludes MuJoCo's own contact between the bodies of each contact.

    The exclusions concern all geoms of both bodies, including geoms without a shape of this library.

    Parameters
    ----------
    spec : mujoco.MjSpec
        Model specification, which is changed.
    contacts : sequence of ContactPair
        Contacts.

    Raises
    ------
    HydroelasticError
        If a geom, body or site does not exist, or its body has no name.
    """
    for contact in contacts:
        names = tuple(_body_of_spec(spec, attachment) for attachment in (contact.a, contact.b))
        present = {frozenset((exclusion.bodyname1, exclusion.bodyname2)) for exclusion in spec.excludes}
        if frozenset(names) not in present and names[0] != names[1]:
            spec.add_exclude(bodyname1=names[0], bodyname2=names[1])


def shape_from_geom(model: Any, name: str, refinement: int = 3) -> Shape:
    """Creates the compliant shape of a sphere, ellipsoid, cylinder or box of a model, in the frame of its geom.

    The shape of a plane is ``hydroelastic.HalfSpace()``, also in the frame of its geom.

    Parameters
    ----------
    model : mujoco.MjModel
        Model.
    name : str
        Name of the geom.
    refinement : int
        Number of subdivisions of the icosahedron. A cylinder has 4 · 2^refinement segments.

    Returns
    -------
    Shape
        Shape in the frame of the geom.

    Raises
    ------
    HydroelasticError
        If the geom does not exist or has another type, or the refinement is out of range.
    """
    refinement = check_count(refinement, "refinement")
    index = _index(model, geom(name))
    size = [float(length) for length in model.geom_size[index]]
    kind = mujoco.mjtGeom(int(model.geom_type[index]))
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return Shape.icosphere(size[0], refinement)
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return Shape.ellipsoid(size, refinement)
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return Shape.cylinder(size[0], 2.0 * size[1], 4 * 2**refinement)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return Shape.cuboid([2.0 * length for length in size])
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        raise HydroelasticError(f"geom {name!r} is a plane, whose shape is hydroelastic.HalfSpace()")
    raise HydroelasticError(f"geom {name!r} is a {kind.name}: expected a sphere, an ellipsoid, a cylinder or a box")


class _Side:
    """Attachment of a shape, resolved in a model."""

    def __init__(self, model: Any, attachment: Attachment) -> None:
        self.index = _index(model, attachment)
        self.body = _body_index(model, attachment.kind, self.index)
        self.root = int(model.body_rootid[self.body])
        self.is_fixed = int(model.body_weldid[self.body]) == 0
        self.dofs = _dofs(model, self.body)
        self.pose_in_frame = None if attachment.pose is None else checked_pose(attachment.pose)
        # Names of the fields of mujoco.MjData with the position and the axes of the frame.
        self.fields = {"geom": ("geom_xpos", "geom_xmat"), "site": ("site_xpos", "site_xmat")}.get(
            attachment.kind, ("xpos", "xmat")
        )

    def pose(self, data: Any) -> _Floats:
        """Returns the pose of the shape in the world."""
        pose = _IDENTITY.copy()
        position, axes = self.fields
        pose[:3, 3] = getattr(data, position)[self.index]
        pose[:3, :3] = getattr(data, axes)[self.index].reshape(3, 3)
        return pose if self.pose_in_frame is None else pose @ self.pose_in_frame

    def twist(self, data: Any, position: _Floats) -> _Floats:
        """Returns the twist of the origin of the shape, which is at the position."""
        if self.is_fixed:
            return np.zeros(6)
        # The linear part of cvel is the velocity of the body at the center of mass of its whole tree.
        twist: _Floats = data.cvel[self.body].copy()
        (wx, wy, wz), (x, y, z) = twist[:3], position - data.subtree_com[self.root]
        twist[3:] += (wy * z - wz * y, wz * x - wx * z, wx * y - wy * x)
        return twist

    def joint_forces(self, data: Any, wrench: _Floats, position: _Floats) -> _Floats:
        """Returns Jᵀ w for the joints that move the body. The wrench w is about the position."""
        (x, y, z), (fx, fy, fz) = position - data.subtree_com[self.root], wrench[3:]
        about_com = wrench.copy()
        about_com[:3] += (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
        forces: _Floats = data.cdof[self.dofs].dot(about_com)
        return forces

    def jacobian(self, data: Any, position: _Floats) -> _Floats:
        """Returns the Jacobian, (6, nv), of the twist of the origin of the shape, which is at the position."""
        jacobian = np.zeros((6, len(data.qvel)))
        jacobian[:, self.dofs] = data.cdof[self.dofs].T
        jacobian[3:] += np.cross(jacobian[:3], (position - data.subtree_com[self.root])[:, None], axis=0)
        return jacobian


class PassiveContacts:
    """Contacts of a MuJoCo model. In the context of this object, they act in every step of the model.

    In the context, ``mj_step`` raises TimeStepError if the time step is too long, and RolloutError if the state or a
    wrench is not finite.

    Parameters
    ----------
    model : mujoco.MjModel
        Model.
    contacts : sequence of ContactPair
        Contacts.
    check_stability : bool
        True to raise TimeStepError if a time step is too long for the contacts.

    Raises
    ------
    HydroelasticError
        If a geom, body or site does not exist, both shapes of a contact are fixed to each other, a pose is not rigid,
        MuJoCo's own contact between the bodies is not excluded, or the model has no passive forces.
    """

    def __init__(self, model: Any, contacts: Sequence[ContactPair], *, check_stability: bool = True) -> None:
        self._model = model
        self._contacts = tuple(contacts)
        self._sides = [(_Side(model, contact.a), _Side(model, contact.b)) for contact in self._contacts]
        attachments = [(contact.a, contact.b) for contact in self._contacts]
        self._names = [f"{a.kind} {a.name!r} and {b.kind} {b.name!r}" for a, b in attachments]
        self._checks_stability = check_stability
        pairs = [contact.pair for contact in self._contacts]
        self._chattering = [_with_slip_tolerance(pair, _CHATTER * pair.law.slip_tolerance) for pair in pairs]
        # Half of the smallest extent (m) of the shape of A of each contact.
        self._sizes = [0.5 * float(np.ptp(pair.shapes[0].vertices, axis=0).min()) for pair in pairs]
        self._mass_indices = _mass_indices(model)
        self._joints = [_joint_of(model, joint) for joint in range(model.njnt)]
        self._histories: dict[int, _History] = {}
        self._failure: HydroelasticError | None = None
        for names, (a, b) in zip(self._names, self._sides, strict=True):
            if int(model.body_weldid[a.body]) == int(model.body_weldid[b.body]):
                raise HydroelasticError(f"{names} are fixed to each other: expected two bodies that move")
            if _collide(model, a.body, b.body):
                raise HydroelasticError(
                    f"MuJoCo has a contact of its own between the bodies of {names}: exclude it, by "
                    "hydroelastic.mujoco.exclude on the MjSpec or <exclude> in the XML"
                )
        if int(model.opt.disableflags) & _NO_PASSIVE_FORCES == _NO_PASSIVE_FORCES:
            raise HydroelasticError("springs and dampers of the model are both disabled: MuJoCo has no passive forces then")

    @property
    def model(self) -> Any:
        """Model, a ``mujoco.MjModel``."""
        return self._model

    @property
    def contacts(self) -> tuple[ContactPair, ...]:
        """Contact pairs, in the order of all results."""
        return self._contacts

    def poses(self, data: Any) -> _Floats:
        """Returns the poses of all shapes in the world.

        Parameters
        ----------
        data : mujoco.MjData
            Data with current kinematics.

        Returns
        -------
        (contacts, 2, 4, 4) ndarray of float64
            Poses of A and B for each contact.
        """
        return np.array([[side.pose(data) for side in sides] for sides in self._sides]).reshape(-1, 2, 4, 4)

    def wrenches(self, data: Any) -> _Floats:
        """Computes the wrenches of all contacts from the kinematics in ``data``.

        After ``mj_step``, the kinematics are those before the positions changed. Call ``mj_forward`` to update them.

        Parameters
        ----------
        data : mujoco.MjData
            Data with current kinematics.

        Returns
        -------
        (contacts, 12) ndarray of float64
            Torque (N m) and force (N) on A about the origin of its shape, then on B about the origin of its shape, in
            world axes.

        Raises
        ------
        RolloutError
            If a wrench is not finite, or cannot be computed.
        """
        return np.array([self._wrench(number, data)[0] for number in range(len(self._sides))]).reshape(-1, 12)

    def potential_energy(self, data: Any) -> float:
        """Computes the potential energy of all contacts. MuJoCo's own energy omits it.

        Parameters
        ----------
        data : mujoco.MjData
            Data with current kinematics.

        Returns
        -------
        float
            Potential energy (J).
        """
        return sum(
            float(contact.pair.potential_energy(pose_a, pose_b))
            for contact, (pose_a, pose_b) in zip(self._contacts, self.poses(data), strict=True)
        )

    def add_to(self, data: Any) -> None:
        """Adds Jᵀ w of all contacts to ``data.qfrc_passive``, as the context does. Use it in your own passive-force
        callback.

        Parameters
        ----------
        data : mujoco.MjData
            Data with current kinematics, whose ``qfrc_passive`` is changed.

        Raises
        ------
        TimeStepError
            If the time step is too long for the contacts.
        RolloutError
            If the state or a wrench is not finite.
        """
        # This method must not call MuJoCo. In versions before 4, an error after such a call in the callback ends the
        # process.
        try:
            self._check_finite(data)
            forces = [self._joint_forces(number, data) for number in range(len(self._sides))]
            self._check_depth(data, forces)
            self._check(data, forces)
        except HydroelasticError as error:
            if not isinstance(threading.current_thread(), threading._DummyThread):
                raise
            # An error in a thread that MuJoCo has started would end the process.
            self._failure = self._failure or error
            return
        passive = data.qfrc_passive
        for force in forces:
            if force is not None:
                passive += force

    def __enter__(self) -> Self:
        """Activates the contacts in every step of the model."""
        _DISPATCH.add(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the context. Raises the first error of a thread that MuJoCo started."""
        _DISPATCH.remove(self)
        self._histories.clear()
        failure, self._failure = self._failure, None
        if failure is not None and error is None:
            raise failure

    def _wrench(self, number: int, data: Any) -> tuple[_Floats, tuple[_Floats, _Floats]]:
        a, b = self._sides[number]
        pose_a, pose_b = a.pose(data), b.pose(data)
        twists = a.twist(data, pose_a[:3, 3]), b.twist(data, pose_b[:3, 3])
        try:
            wrenches = self._contacts[number].pair.wrench(pose_a, pose_b, *twists)
        except HydroelasticError as error:
            raise RolloutError(f"{self._step_of(data)}, {self._names[number]}: {error}") from error
        if not math.isfinite(wrenches.dot(wrenches)):
            raise RolloutError(
                f"{self._step_of(data)}: the wrench of the contact of {self._names[number]} is not finite, although the poses "
                "and velocities are: the motion has diverged"
            )
        return wrenches, (pose_a, pose_b)

    def _joint_forces(self, number: int, data: Any) -> _Floats | None:
        """Returns Jᵀ w of a contact, (nv,), or None if the bodies do not touch."""
        wrenches, poses = self._wrench(number, data)
        if not wrenches.dot(wrenches):
            return None
        forces = np.zeros(self._model.nv)
        for side, wrench, pose in zip(self._sides[number], (wrenches[:6], wrenches[6:]), poses, strict=True):
            if not side.is_fixed:
                forces[side.dofs] += side.joint_forces(data, wrench, pose[:3, 3])
        return forces

    def _step_of(self, data: Any) -> str:
        return f"step {round(data.time / self._model.opt.timestep)} (t = {data.time:.6g} s)"

    def _check_finite(self, data: Any) -> None:
        for name in ("qpos", "qvel"):
            is_finite = np.isfinite(getattr(data, name))
            if not is_finite.all():
                index = int(np.argmin(is_finite))
                raise RolloutError(
                    f"{self._step_of(data)}: {name}[{index}] is not finite: the motion has diverged. {self._cause(data, name, index)}"
                )

    def _cause(self, data: Any, name: str, index: int) -> str:
        """Returns the joint and the body of a number, and the contact that last acted on the joint."""
        owners = (owner for owner in self._joints if index in owner[1 if name == "qpos" else 2])
        joint, _, dofs = next(owners)
        history = self._histories.get(data._address)
        acted = {} if history is None else history.acted
        forces = [(time, float(np.abs(force[dofs]).max()), number) for number, (time, force) in acted.items()]
        time, force, number = max((item for item in forces if item[1] > 0.0), default=(0.0, 0.0, -1))
        if number < 0:
            return f"This is a number of {joint}, on which no contact has acted"
        return (
            f"This is a number of {joint}. The contact of {self._names[number]} was the last to act on it, at t = {time:.6g} s, "
            f"with a joint force of {force:.3g} N or N m"
        )

    def _check_depth(self, data: Any, forces: Forces) -> None:
        """Raises an error if two bodies have passed into each other in a step, so deep that contact no longer acts.

        Only a contact that has just ended, or a step that is longer than the shape of A, can lead there.
        """
        history = self._histories.get(data._address)
        if history is None:
            return
        touched, history.touching = history.touching, {number for number, force in enumerate(forces) if force is not None}
        model = self._model
        # Upper bound of the motion in a step (m): a joint moves a point by at most its angle times the size of the model.
        motion = model.opt.timestep * max(1.0, model.stat.extent) * float(np.abs(data.qvel).sum())
        for number, size in enumerate(self._sizes):
            if number in history.touching or (number not in touched and motion < size):
                continue
            poses = [side.pose(data) for side in self._sides[number]]
            if self._contacts[number].pair.has_sunk_through(*poses):
                raise RolloutError(
                    f"{self._step_of(data)}: the bodies of {self._names[number]} have passed so deep into each other in one step that "
                    "their contact no longer pushes them apart. Use shorter steps, lower speeds, or a higher modulus"
                )

    def _check(self, data: Any, forces: Forces) -> None:
        """Raises an error if MuJoCo has reset the state. Then compares the evaluation with the evaluation a time step
        earlier, if there is one.

        Evaluations within a step are skipped. Other evaluations, for example of a state that was set, only start a new
        history.
        """
        time, time_step = float(data.time), float(self._model.opt.timestep)
        history = self._histories.get(data._address)
        if history is None:
            if len(self._histories) >= _MOST_HISTORIES:
                self._histories.clear()
            history = self._histories[data._address] = _History(self._names, int(self._model.opt.integrator) == _RK4)
        passed, velocity = time - history.time, data.qvel.copy()
        if 0.0 < passed < (1.0 - _CLOCK) * time_step:
            return
        if not abs(passed - time_step) < _CLOCK * time_step:
            before, history.time = history.time, time
            warnings = [(name, data.warning[kind]) for name, kind in _DIVERGED.items() if data.warning[kind].number]
            if passed <= 0.0 and warnings:
                name, warning = warnings[0]
                is_first = not math.isfinite(before)
                where = "at the first step" if is_first else f"after step {round(before / time_step)} (t = {before:.6g} s)"
                raise RolloutError(
                    f"{where} the motion has diverged, and MuJoCo resets the state: {name}[{warning.lastinfo}] was not "
                    f"finite or beyond 1e10. {self._cause(data, name, warning.lastinfo)}"
                )
            history.record(forces)
            history.watch.keep(forces, velocity)
            return
        if history.is_rk4 and not history.saw_last_stage:
            history.saw_last_stage = True
            return
        history.time, history.saw_last_stage = time, False
        history.record(forces)
        if not self._checks_stability:
            return
        fault = history.watch.fault(
            forces, velocity, time_step, lambda: self._mass(data), lambda velocity: self._rates(data, velocity)
        )
        if fault is not None and (fault.begins is None or self._came_in(fault.begins, data)):
            error = fault.error(time_step)
            error.at_step(round(time / time_step), time)
            raise error

    def _came_in(self, number: int, data: Any) -> bool:
        """Returns whether a contact began by a motion, and not because the state was set."""
        poses = [side.pose(data) for side in self._sides[number]]
        twists = [side.twist(data, pose[:3, 3]) for side, pose in zip(self._sides[number], poses, strict=True)]
        moves = zip(poses, twists, strict=True)
        before = [moved_pose(pose, -self._model.opt.timestep * twist) for pose, twist in moves]
        return not self._contacts[number].pair.wrench(*before).any()

    def _mass(self, data: Any) -> _Floats:
        mass = np.zeros((len(data.qvel), len(data.qvel)))
        rows, columns = self._mass_indices
        mass[rows, columns] = mass[columns, rows] = data.qM if hasattr(data, "qM") else data.M
        return mass

    def _rates(self, data: Any, velocity: _Floats) -> Rates:
        """Returns the stiffness and damping of the contacts at a velocity, with the damping of the joints."""
        size, model = len(data.qvel), self._model
        stiffness, damping = np.zeros((2, len(self._sides), size, size))
        for number, (pair, sides) in enumerate(zip(self._chattering, self._sides, strict=True)):
            poses = [side.pose(data) for side in sides]
            jacobian = np.vstack([side.jacobian(data, pose[:3, 3]) for side, pose in zip(sides, poses, strict=True)])
            law = np.array([pair.law.dissipation, pair.law.friction])
            twists = jacobian.dot(velocity).reshape(2, 6)
            stiffness[number], damping[number] = resistance(pair, poses, twists, jacobian, law)
        integrator = int(model.opt.integrator)
        is_implicit = integrator != _RK4 and not int(model.opt.disableflags) & _NO_EULER_DAMPING
        joints = np.diag(model.dof_damping)
        if integrator in _IMPLICIT:
            # Damping of the last step, including the damping of actuators.
            is_implicit, joints = True, np.zeros((size, size))
            joints[self._damping_indices(data)] = -data.qDeriv
        return Rates(stiffness, damping, self._mass(data), joints, is_implicit)

    def _damping_indices(self, data: Any) -> tuple[_Floats, _Floats]:
        of = self._model if hasattr(self._model, "D_colind") else data
        return np.repeat(np.arange(len(of.D_rownnz)), of.D_rownnz), of.D_colind


class _History:
    """Last step of a ``mujoco.MjData``."""

    def __init__(self, names: Sequence[str], is_rk4: bool) -> None:
        self.watch = Watch(names, is_rk4=is_rk4)
        self.is_rk4 = is_rk4
        self.time = math.inf
        # Contacts that acted at the last evaluation.
        self.touching: set[int] = set()
        # Time (s) and Jᵀ w of each contact when it last acted, by its index.
        self.acted: dict[int, tuple[float, _Floats]] = {}
        # The last stage of RK4 has the time of the next step, but not its state.
        self.saw_last_stage = False


    def record(self, forces: Forces) -> None:
        """Records the forces of the contacts that act."""
        self.acted |= {number: (self.time, force) for number, force in enumerate(forces) if force is not None}


class _Dispatch:
    """MuJoCo's single callback, which calls the contacts of all models. Models are identified by address."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._active: dict[int, tuple[PassiveContacts, ...]] = {}
        self._before: Any = None

    def __call__(self, model: Any, data: Any) -> None:
        before = self._before
        if before is not None:
            before(model, data)
        for contacts in self._active.get(model._address, ()):
            contacts.add_to(data)

    def add(self, contacts: PassiveContacts) -> None:
        with self._lock:
            # Active contacts keep their model alive, so its address is not reused.
            address = contacts.model._address
            others = self._active.get(address, ())
            if any(other is contacts for other in others):
                raise HydroelasticError("these contacts act already: a context is entered once at a time")
            present = mujoco.get_mjcb_passive()
            if present is not self:
                if present is not None and not callable(present):
                    raise HydroelasticError("a passive-force callback that is not of Python is set, and cannot be called from here")
                self._before = present
                mujoco.set_mjcb_passive(self)
            self._active[address] = (*others, contacts)

    def remove(self, contacts: PassiveContacts) -> None:
        with self._lock:
            address = contacts.model._address
            others = tuple(other for other in self._active.get(address, ()) if other is not contacts)
            if others:
                self._active[address] = others
            else:
                self._active.pop(address, None)
            if not self._active:
                before, self._before = self._before, None
                # A callback that was set in the meantime belongs to other code, so it stays.
                if mujoco.get_mjcb_passive() is self:
                    mujoco.set_mjcb_passive(before)


_DISPATCH = _Dispatch()


def _index(model: Any, attachment: Attachment) -> int:
    index = mujoco.mj_name2id(model, _KINDS[attachment.kind], attachment.name)
    if index < 0:
        raise HydroelasticError(f"the model has no {attachment.kind} {attachment.name!r}")
    return int(index)


def _body_index(model: Any, kind: str, index: int) -> int:
    return index if kind == "body" else int({"geom": model.geom_bodyid, "site": model.site_bodyid}[kind][index])


def _with_slip_tolerance(pair: Pair, slip_tolerance: float) -> Pair:
    return Pair(*pair.shapes, *pair.moduli, SurfaceLaw(pair.law.dissipation, pair.law.friction, slip_tolerance))


def _dofs(model: Any, body: int) -> NDArray[np.intp]:
    """Returns the indices of the degrees of freedom that move a body."""
    dofs: list[int] = []
    while body:
        start = int(model.body_dofadr[body])
        dofs += range(start, start + int(model.body_dofnum[body])) if start >= 0 else ()
        body = int(model.body_parentid[body])
    return np.array(dofs, dtype=np.intp)


def _joint_of(model: Any, joint: int) -> tuple[str, range, range]:
    """Returns the name of a joint with that of its body, and the indices of its positions and velocities."""
    body = int(model.jnt_bodyid[joint])
    names = [mujoco.mj_id2name(model, kind, index) for kind, index in ((_JOINT, joint), (_KINDS["body"], body))]
    owner = f"body {names[1]!r}" if names[1] else f"body {body}"
    q_count, v_count = _SIZES.get(int(model.jnt_type[joint]), (1, 1))
    q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    return f"joint {names[0]!r} of {owner}" if names[0] else f"the joint of {owner}", range(q, q + q_count), range(v, v + v_count)


def _mass_indices(model: Any) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Returns rows and columns of the entries of ``data.qM``, or of ``data.M`` in versions without ``qM``."""
    if not hasattr(mujoco.MjData, "qM"):
        return np.repeat(np.arange(model.nv), model.M_rownnz), model.M_colind.astype(np.intp)
    indices = []
    for row in range(model.nv):
        column = row
        while column >= 0:
            indices.append((row, column))
            column = int(model.dof_parentid[column])
    rows, columns = np.array(indices, dtype=np.intp).reshape(-1, 2).T
    return rows, columns


def _body_of_spec(spec: Any, attachment: Attachment) -> str:
    element = {"geom": spec.geom, "body": spec.body, "site": spec.site}[attachment.kind](attachment.name)
    if element is None:
        raise HydroelasticError(f"the spec has no {attachment.kind} {attachment.name!r}")
    name: str = element.name if attachment.kind == "body" else element.parent.name
    if not name:
        raise HydroelasticError(f"the body of {attachment.kind} {attachment.name!r} has no name, which an exclusion needs")
    return name


def _collide(model: Any, first: int, second: int) -> bool:
    """Returns whether MuJoCo detects contacts between two bodies."""
    if int(model.opt.disableflags) & (int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)):
        return False
    listed = zip(model.pair_geom1, model.pair_geom2, strict=True)
    if any({int(model.geom_bodyid[g]) for g in geoms} == {first, second} for geoms in listed):
        return True
    signatures = {(first << 16) + second, (second << 16) + first}
    excluded = {int(signature) for signature in model.exclude_signature}
    return not signatures & excluded and _filters_pass(model, first, second)


def _filters_pass(model: Any, first: int, second: int) -> bool:
    """Returns whether the filters by ancestry and by contact bits allow contacts between two bodies."""
    welds = [int(model.body_weldid[body]) for body in (first, second)]
    parents = [int(model.body_weldid[model.body_parentid[weld]]) for weld in welds]
    filters_parents = not int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    if filters_parents and all(welds) and (welds[0] == parents[1] or welds[1] == parents[0]):
        return False
    bodies = (first, second)
    geoms = [range(start := int(model.body_geomadr[body]), start + int(model.body_geomnum[body])) for body in bodies]
    kinds, affinities = model.geom_contype, model.geom_conaffinity
    return any((kinds[i] & affinities[j]) or (kinds[j] & affinities[i]) for i in geoms[0] for j in geoms[1])

