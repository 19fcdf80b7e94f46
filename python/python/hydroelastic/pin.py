"""A Pinocchio model and a world of the same robot: conversions of their states, and joint torques of contacts.

``Adapter`` connects a ``pinocchio.Model`` and a ``hydroelastic.World`` with the same robot, for example from the same
URDF file. Programs that use Pinocchio, such as trajectory optimizers, evaluate contacts at q and v:

    robot = Adapter(world, model)
    contact = robot.linearized_contact_torques(q, v)
    acceleration = pinocchio.aba(model, data, q, v, tau + contact.tau)

The world simulates the robot: ``world.rollout(plan, start=robot.state(q, v))``. ``q_and_v`` converts its states back.

Pinocchio and the world have different generalized velocities, v and u = ``world.kinetics(state).velocities``:

- A revolute, prismatic or continuous joint has the same velocity in both.
- A ball joint (``JointModelSpherical``) has the angular velocity in the axes of the body in v, and in the axes of the
  joint frame in u.
- A free body (``JointModelFreeFlyer``) has the velocity of the origin of its frame and its angular velocity in v, in
  this order and in the axes of the body. In u, it has its angular velocity and the velocity of its center of mass, in
  world axes.

``velocity_map`` returns the matrix P with v = P u. Generalized forces and mass matrices convert as τ_world = Pᵀ τ and
M_world = Pᵀ M P.

Pinocchio ignores the actuators, stops, damping and friction of the joints of the world.
``world.kinetics(state).joint_forces`` has their torques.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import Body, HydroelasticError, Joint, Pair, State, World

try:
    import pinocchio  # type: ignore[import-untyped, import-not-found, unused-ignore]
except ImportError as _missing:
    raise ImportError('hydroelastic.pin needs Pinocchio: pip install "hydroelastic[pin]"') from _missing

from ._checks import checked

__all__ = ["Adapter", "ContactTorques"]

_Floats: TypeAlias = NDArray[np.float64]

# Tolerance of the norm of a quaternion.
_NORMALIZED = 1e-9
# Tolerance of poses (m), velocities and positions of coupled joints, relative to 1 plus their size.
_SAME = 1e-9
_WORLD_AXES = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED


class ContactTorques(NamedTuple):
    """Joint torques of all contacts, and their derivatives.

    Attributes
    ----------
    tau : (nv,) ndarray of float64
        Joint torques (N m) and forces (N).
    by_q : (nv, nv) ndarray of float64
        Derivatives with respect to the tangent of q: q varies as ``pinocchio.integrate(model, q, dq)``.
    by_v : (nv, nv) ndarray of float64
        Derivatives with respect to v.
    """

    tau: _Floats
    by_q: _Floats
    by_v: _Floats


class _Coordinates:
    """Coordinates of a joint or of a free body in the model and in the world."""

    def __init__(self, model: Any, index: int, columns: slice, body: int, com: _Floats, joint: Joint | None) -> None:
        of_model = model.joints[index]
        self.q = slice(of_model.idx_q, of_model.idx_q + of_model.nq)
        self.v = slice(of_model.idx_v, of_model.idx_v + of_model.nv)
        self.u = columns
        self.body = body
        self.com = com
        self.joint = joint
        self.kind = "free" if joint is None else joint.kind

    def velocity_map(self, q: _Floats) -> _Floats:
        """Returns the block of P with v = P u."""
        if self.kind not in ("free", "ball"):
            return np.eye(1)
        inverse = _rotation(q[self.q][-4:]).T
        if self.kind == "ball":
            return inverse
        return np.block([[pinocchio.skew(self.com) @ inverse, inverse], [inverse, np.zeros((3, 3))]])


class _Mount(NamedTuple):
    """Body of the world on a joint of the model."""

    joint: int
    placement: Any


class Adapter:
    """A Pinocchio model and a world of the same robot.

    Bodies of the world have the names of the body frames of the model, and joints have the names of its joints. A free
    flyer is the free body whose frame is the frame of the joint. All other bodies and joints of the world, such as
    objects, belong to the world only.

    An adapter works in its own ``pinocchio.Data``, so each thread needs its own adapter.

    Parameters
    ----------
    world : World
        World with the robot.
    model : pinocchio.Model
        Model of the robot. It must not change.
    prefix : str
        Text before the names of the bodies and joints of the robot in the world, as in ``Robot.mechanism``.

    Raises
    ------
    HydroelasticError
        If a joint of the model is not in the world or has another kind there, a body has another pose or velocity in
        the world than in the model, or the model has mimic joints. A model that ``buildModelFromUrdf`` reads with
        ``mimic=False`` has none.
    TypeError
        If the world is not a World, or the model is not a ``pinocchio.Model``.
    """

    def __init__(self, world: World, model: Any, prefix: str = "") -> None:
        if not isinstance(world, World):
            raise TypeError(f"world is {type(world).__name__}: expected a hydroelastic.World")
        if not isinstance(model, pinocchio.Model):
            raise TypeError(f"model is {type(model).__name__}: expected a pinocchio.Model")
        # Versions of Pinocchio without mimic joints do not have this list.
        if len(getattr(model, "mimicking_joints", ())):
            raise HydroelasticError("the model has mimic joints: build it with mimic=False, which makes them independent")
        self._world, self._model, self._prefix = world, model, prefix
        self._data = model.createData()
        weightless = model.copy()
        weightless.gravity = pinocchio.Motion.Zero()
        self._weightless = weightless, weightless.createData()
        self._bodies = world.bodies
        self._mounts: dict[str, _Mount] = {}
        for body in self._bodies:
            mount = self._mount_of(body)
            if mount is not None:
                self._mounts[body.name] = mount
        self._coordinates = self._matched()
        self._pairs: dict[tuple[str, str], Pair] = {}
        self._check_motion()

    def __reduce__(self) -> tuple[type[Adapter], tuple[World, Any, str]]:
        return Adapter, (self._world, self._model, self._prefix)

    @property
    def world(self) -> World:
        """World."""
        return self._world

    @property
    def model(self) -> Any:
        """Model, a ``pinocchio.Model``."""
        return self._model

    def state(self, q: _Floats, v: _Floats, *, start: State | None = None) -> State:
        """Converts q and v to a state of the world.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.
        v : (nv,) array_like
            Joint velocities.
        start : State, optional
            State of the bodies and joints that are not in the model, and time. Default: the initial state of the world.

        Returns
        -------
        State
            State of the world.

        Raises
        ------
        HydroelasticError
            If an array has an unexpected shape, a number is not finite, a quaternion is not normalized, a mimicking
            joint is not where its leader moves it, or ``start`` does not fit the world.
        TypeError
            If an argument is neither an array of float64 or integers nor a list of numbers.
        """
        q, v = self._checked(q, v)
        start = self._world.initial_state if start is None else start
        if not isinstance(start, State):
            raise TypeError(f"start is {type(start).__name__}: expected a hydroelastic.State")
        poses, twists = start.poses, start.twists
        if len(poses) != len(self._bodies):
            raise HydroelasticError(f"start has {len(poses)} bodies, but the world has {len(self._bodies)}")
        positions: dict[str, Any] = {}
        velocities: dict[str, Any] = {}
        for at in self._coordinates:
            mine = q[at.q]
            velocity: Any = np.linalg.solve(at.velocity_map(q), v[at.v])
            if at.joint is None:
                poses[at.body, :3, :3], poses[at.body, :3, 3] = _rotation(mine[3:]), mine[:3]
                twists[at.body] = velocity
            elif at.joint.mimic is not None:
                self._check_follower(at.joint, q, v, mine, velocity)
            elif at.kind == "ball":
                positions[at.joint.name], velocities[at.joint.name] = _rotation(mine), velocity
            else:
                positions[at.joint.name], velocities[at.joint.name] = _angle(mine), float(velocity[0])
        moved = State(start.time, poses, twists, start.joints)
        return self._world.state_with_joints(positions, velocities, state=moved)

    def q_and_v(self, state: State) -> tuple[_Floats, _Floats]:
        """Converts a state of the world to q and v.

        Parameters
        ----------
        state : State
            State of the world.

        Returns
        -------
        q : (nq,) ndarray of float64
            Joint positions.
        v : (nv,) ndarray of float64
            Joint velocities.

        Raises
        ------
        HydroelasticError
            If the state does not fit the world.
        """
        kinetics = self._world.kinetics(state)
        q, v = pinocchio.neutral(self._model), np.zeros(self._model.nv)
        for at in self._coordinates:
            if at.joint is None:
                pose = state.poses[at.body]
                q[at.q] = np.r_[pose[:3, 3], pinocchio.Quaternion(pose[:3, :3]).coeffs()]
            elif at.kind == "ball":
                rotation = state.ball_joint_rotations[self._world.joint_index(at.joint.name)]
                q[at.q] = pinocchio.Quaternion(rotation).coeffs()
            else:
                name, multiplier, offset = at.joint.mimic or (at.joint.name, 1.0, 0.0)
                angle = multiplier * state.joint_positions[self._world.joint_index(name)] + offset
                q[at.q] = angle if len(q[at.q]) == 1 else (np.cos(angle), np.sin(angle))
            v[at.v] = at.velocity_map(q) @ kinetics.velocities[at.u]
        return q, v

    def velocity_map(self, q: _Floats) -> _Floats:
        """Computes the matrix P with v = P u.

        Parameters
        ----------
        q : (nq,) array_like
            Joint positions.

        Returns
        -------
        (nv, n) ndarray of float64
            Matrix. Columns have the order of ``World.kinetics``. They are zero for bodies and joints that are not in the
            model.

        Raises
        ------
        HydroelasticError
            If the argument is not valid.
        """
        (q,) = self._checked(q)
        matrix = np.zeros((self._model.nv, len(self._world.kinetics().velocities)))
        for at in self._coordinates:
            matrix[at.v, at.u] = at.velocity_map(q)
        return matrix

    def contact_torques(self, q: _Floats, v: _Floats, *, start: State | None = None) -> _Floats:
        """Computes the joint torques of all contacts of the robot, with itself and with other bodies of the world.

        ``world.contacts(robot.state(q, v))`` returns the wrenches and surfaces of the contacts.

        Parameters
        ----------
        q, v, start
            Arguments of ``state``.

        Returns
        -------
        (nv,) ndarray of float64
            Joint torques (N m) and forces (N), to add to the torques of ``pinocchio.aba``.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a wrench is not finite.
        """
        q, v = self._checked(q, v)
        model, data, tau = self._model, self._data, np.zeros(self._model.nv)
        pinocchio.computeJointJacobians(model, data, q)
        for contact in self._world.contacts(self.state(q, v, start=start)):
            for name, wrench in zip(contact.bodies, np.split(contact.wrench, 2), strict=True):
                mount = self._mounts.get(name)
                if mount is not None and mount.joint:
                    jacobian = pinocchio.getFrameJacobian(model, data, *mount, _WORLD_AXES)
                    tau += np.roll(wrench, 3) @ jacobian
        return tau

    def linearized_contact_torques(self, q: _Floats, v: _Floats, *, start: State | None = None) -> ContactTorques:
        """Computes the joint torques of all contacts of the robot, and their derivatives with respect to q and v.

        Parameters
        ----------
        q, v, start
            Arguments of ``state``.

        Returns
        -------
        ContactTorques
            Joint torques and derivatives.

        Raises
        ------
        HydroelasticError
            If an argument is not valid, or a wrench is not finite.
        """
        q, v = self._checked(q, v)
        model, data, nv = self._model, self._data, self._model.nv
        pinocchio.computeForwardKinematicsDerivatives(model, data, q, v, np.zeros(nv))
        state = self.state(q, v, start=start)
        result = ContactTorques(np.zeros(nv), np.zeros((nv, nv)), np.zeros((nv, nv)))
        forces = pinocchio.StdVec_Force([pinocchio.Force.Zero() for _ in range(model.njoints)])
        poses, twists = state.poses, state.twists
        for contact in self._world.contacts(state):
            mounts = [self._mounts.get(name, _Mount(0, None)) for name in contact.bodies]
            if not any(mount.joint for mount in mounts):
                continue
            sides = [self._world.index_of(name) for name in contact.bodies]
            motion = [self._at_origin(side, poses[side], twists[side]) for side in sides]
            wrench, jacobian = self._pair(contact.bodies).linearized(*poses[sides], *motion)
            by_pose, twist_by_q = np.zeros((2, 12, nv))
            for side, mount in enumerate(mounts):
                if mount.joint:
                    rows = slice(6 * side, 6 * side + 6)
                    by_pose[rows], twist_by_q[rows] = self._motion_of(mount)
                    _turn_with_link(jacobian[rows, rows], wrench[rows])
                    in_body = wrench[rows].reshape(2, 3)[::-1] @ poses[sides[side]][:3, :3]
                    forces[mount.joint] += mount.placement.act(pinocchio.Force(in_body.ravel()))
            result.tau[:] += wrench @ by_pose
            result.by_q[:] += by_pose.T @ (jacobian[:, :12] @ by_pose + jacobian[:, 12:24] @ twist_by_q)
            result.by_v[:] += by_pose.T @ (jacobian[:, 12:24] @ by_pose)
        # Without gravity, the static torque is −Jᵀf of the forces f, which are constant in the axes of the links.
        result.by_q[:] -= pinocchio.computeStaticTorqueDerivatives(*self._weightless, q, forces)
        if not all(np.isfinite(array).all() for array in result):
            raise HydroelasticError("a derivative of the contact torques is not finite: q or v is too large")
        return result

    def _motion_of(self, mount: _Mount) -> tuple[_Floats, _Floats]:
        """Returns the derivatives of the pose with respect to q, and of the twist with respect to q, (6, nv). Both have
        the angular part first. The derivative of the twist with respect to v is that of the pose with respect to q."""
        model, data = self._model, self._data
        # Pinocchio returns one column as a vector.
        twist_by_q, twist_by_v = (
            array.reshape(6, model.nv) for array in pinocchio.getFrameVelocityDerivatives(model, data, *mount, _WORLD_AXES)
        )
        # The linear part of this derivative is that of the velocity at a fixed point of the world. Pinocchio's
        # derivative of the velocity of a point includes the motion of the origin.
        velocity_by_q, _ = pinocchio.getPointVelocityDerivatives(model, data, *mount, _WORLD_AXES)
        twist_by_q[:3] = velocity_by_q.reshape(3, model.nv)
        return np.roll(twist_by_v, 3, axis=0), np.roll(twist_by_q, 3, axis=0)

    def _at_origin(self, body: int, pose: _Floats, twist: _Floats) -> _Floats:
        """Converts the twist of a state, with the velocity of the center of mass, to that of the origin of the body."""
        com = self._bodies[body].center_of_mass
        if com is None:
            return twist
        at_origin: _Floats = twist.copy()
        at_origin[3:] -= np.cross(twist[:3], pose[:3, :3] @ com)
        return at_origin

    def _pair(self, names: tuple[str, str]) -> Pair:
        if names not in self._pairs:
            a, b = (self._bodies[self._world.index_of(name)] for name in names)
            law = a.material.combined_with(b.material, self._world.slip_tolerance)
            # The bodies touch, so both have shapes, and the first is compliant.
            moduli = a.material.modulus, b.material.modulus
            self._pairs[names] = Pair(a.shape, b.shape, moduli[0], moduli[1], law)  # type: ignore[arg-type]
        return self._pairs[names]

    def _mount_of(self, body: Body) -> _Mount | None:
        """Returns the place of a body of the world in the model. A body that is welded to a body of the model, such as
        a further collision geometry of a link, moves with it."""
        name, model = body.name, self._model
        if name.startswith(self._prefix) and model.existFrame(name[len(self._prefix) :], pinocchio.FrameType.BODY):
            frame = model.frames[model.getFrameId(name[len(self._prefix) :], pinocchio.FrameType.BODY)]
            return _Mount(frame.parentJoint, frame.placement)
        if body.joint is None or body.joint.kind != "fixed" or body.joint.parent not in self._mounts:
            return None
        parent = self._mounts[body.joint.parent]
        return _Mount(parent.joint, parent.placement * pinocchio.SE3(body.joint.origin))

    def _matched(self) -> list[_Coordinates]:
        """Returns the coordinates of each joint of the model."""
        model, kinetics, matched = self._model, self._world.kinetics(), []
        for index in range(1, model.njoints):
            name, kind = model.names[index], model.joints[index].shortname()
            is_free = kind == "JointModelFreeFlyer"
            bodies = [number for number, body in enumerate(self._bodies) if self._is_on(body, index, is_free)]
            if not bodies:
                wanted = "free body has the frame" if is_free else "joint has the name"
                raise HydroelasticError(
                    f"no {wanted} of joint {name!r} of the model. The joints of the world are "
                    f"{[joint.name for joint in self._world.joints]}, and the prefix is {self._prefix!r}"
                )
            body = self._bodies[bodies[0]]
            sizes = {"free": (6,), "ball": (3,), "revolute": (1,), "prismatic": (1,)}
            of_world = "free" if body.joint is None else body.joint.kind
            if model.joints[index].nv not in sizes.get(of_world, ()):
                raise HydroelasticError(f"joint {name!r} is a {kind} in the model, but {of_world} in the world")
            com = body.center_of_mass
            columns = kinetics.columns(body.name)
            matched.append(_Coordinates(model, index, columns, bodies[0], np.zeros(3) if com is None else com, body.joint))
        return matched

    def _is_on(self, body: Body, index: int, is_free: bool) -> bool:
        """Returns whether a joint of the model moves a body of the world by the coordinates of the body."""
        if body.joint is not None:
            return not is_free and body.joint.name == self._prefix + self._model.names[index]
        mount = self._mounts.get(body.name)
        is_dynamic = body.mass is not None
        return is_free and is_dynamic and mount is not None and mount.joint == index and mount.placement.isIdentity()

    def _check_motion(self) -> None:
        """Raises an error if a body has another pose or twist in the world than in the model, at a state in which all
        joints move."""
        model, data = self._model, self._data
        v = np.linspace(0.5, 1.0, model.nv)
        q = pinocchio.integrate(model, pinocchio.neutral(model), 0.3 * v)
        for at in self._coordinates:
            if at.joint is not None and at.joint.mimic is not None:
                q[at.q], v[at.v] = self._followed(at.joint, q, v)
        state = self.state(q, v)
        pinocchio.forwardKinematics(model, data, q, v)
        for number, body in enumerate(self._bodies):
            if body.name not in self._mounts:
                continue
            joint, placement = self._mounts[body.name]
            expected = (data.oMi[joint] * placement).homogeneous
            twist = self._at_origin(number, state.poses[number], state.twists[number])
            moved = pinocchio.SE3(expected[:3, :3], np.zeros(3)).act(placement.actInv(data.v[joint])).vector
            compared = (state.poses[number], expected, "pose"), (twist, np.roll(moved, 3), "velocity")
            for actual, expected, quantity in compared:
                if np.abs(actual - expected).max() > _SAME * (1.0 + np.abs(expected).max()):
                    raise HydroelasticError(
                        f"body {body.name!r} has a different {quantity} in the world than in the model: the largest difference is "
                        f"{np.abs(actual - expected).max():.3g} at q = {q}. Check the base pose, the joint origins and the axes"
                    )

    def _followed(self, joint: Joint, q: _Floats, v: _Floats) -> tuple[float, float]:
        """Returns the position and the velocity of a mimicking joint."""
        assert joint.mimic is not None
        name, multiplier, offset = joint.mimic
        leader = next((at for at in self._coordinates if at.joint is not None and at.joint.name == name), None)
        if leader is None:
            raise HydroelasticError(f"the leader {name!r} of joint {joint.name!r} is not in the model")
        return multiplier * _angle(q[leader.q]) + offset, multiplier * float(v[leader.v][0])

    def _check_follower(self, joint: Joint, q: _Floats, v: _Floats, mine: _Floats, velocity: _Floats) -> None:
        actual, expected = np.r_[_angle(mine), velocity], np.array(self._followed(joint, q, v))
        if np.abs(actual - expected).max() > _SAME * (1.0 + np.abs(expected).max()):
            raise HydroelasticError(
                f"joint {joint.name!r} mimics {joint.mimic}: expected the position and velocity {expected}, but q and v "
                f"have {actual}"
            )

    def _checked(self, *arrays: _Floats) -> tuple[_Floats, ...]:
        """Converts q, or q and v, to arrays of float64."""
        model = self._model
        named = zip(arrays, ("q", "v"), (model.nq, model.nv))
        converted = tuple(checked(array, name, (size,)) for array, name, size in named)
        if model.nq != model.nv and not pinocchio.isNormalized(model, converted[0], _NORMALIZED):
            raise HydroelasticError("q has a quaternion or a continuous joint that is not normalized: see pinocchio.normalize")
        return converted


def _rotation(quaternion: _Floats) -> _Floats:
    """Converts a quaternion (x, y, z, w) to a rotation matrix."""
    rotation: _Floats = pinocchio.Quaternion(quaternion).normalized().matrix()
    return rotation


def _angle(q: _Floats) -> float:
    """Returns the position of a revolute or prismatic joint. A continuous joint has a cosine and a sine."""
    return float(q[0]) if len(q) == 1 else float(np.arctan2(q[1], q[0]))


def _turn_with_link(by_pose: _Floats, wrench: _Floats) -> None:
    """Converts the derivatives of a wrench in world axes to derivatives in axes that turn with the link.

    In these axes, the torque and the force of a constant wrench w change by −ω × w.
    """
    by_pose[:3, :3] += pinocchio.skew(wrench[:3])
    by_pose[3:, :3] += pinocchio.skew(wrench[3:])
