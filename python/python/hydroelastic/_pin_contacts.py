"""Contacts of a Pinocchio model: the motion of their shapes with the joints, and the joint torques of their wrenches.

``hydroelastic.pin`` imports this module after its own import of Pinocchio, whose error names the package to install.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pinocchio  # type: ignore[import-untyped, import-not-found, unused-ignore]

from ._core import HydroelasticError, pose
from ._pin_checks import Floats, checked_pose

if TYPE_CHECKING:
    from .pin import ContactPair

# Moduli (2,), and dissipation and friction (2,).
Material: TypeAlias = tuple[Floats, Floats]

WORLD_AXES = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
# Order of the components that converts between (linear, angular) and (angular, linear).
SWAPPED = np.array([3, 4, 5, 0, 1, 2])
# Matrix that maps a vector to its cross product matrix, by rows.
CROSS = np.zeros((9, 3))
CROSS[[1, 2, 3, 5, 6, 7], [2, 1, 2, 0, 1, 0]] = [-1.0, 1.0, 1.0, -1.0, -1.0, 1.0]
# The same map for both halves of a wrench.
CROSSES = np.kron(np.eye(2), CROSS)


class Mount:
    """Shape on a joint, with views of the rows of its motion in the buffer of its contact."""

    def __init__(self, side: int, joint: int, placement: Any, motion: Floats, nv: int) -> None:
        self.side = side
        self.joint = joint
        self.placement = placement
        self.part = slice(6 * side, 6 * side + 6)
        self.turn = slice(6 * side, 6 * side + 3)
        self.jacobian = motion[self.part, :nv]
        # Blocks of three rows: angular, then linear. Blocks of Pinocchio have the linear part first, so the views are
        # reversed.
        of_pose, of_twist = motion[:12].reshape(2, 2, 3, -1)[side], motion[12:24].reshape(2, 2, 3, -1)[side]
        self.pose_by_q = of_pose[::-1, :, :nv]
        self.twist_by_q = of_twist[::-1, :, :nv]
        self.twist_by_v = of_twist[::-1, :, nv : 2 * nv]
        self.velocity_by_q = of_twist[1, :, :nv]

    # For matrices of this size, the call costs more than the product, and a call of ``dot`` takes half the time of
    # ``@``.

    def move(self, model: Any, data: Any, v: Floats) -> tuple[Any, Floats]:
        """Returns the placement and the twist. Writes the derivatives of both to the buffer."""
        placement = data.oMi[self.joint] * self.placement
        twist_by_q, twist_by_v = pinocchio.getFrameVelocityDerivatives(
            model, data, self.joint, self.placement, WORLD_AXES
        )
        blocks = twist_by_v.reshape(self.pose_by_q.shape)
        self.pose_by_q[...] = blocks
        self.twist_by_v[...] = blocks
        self.twist_by_q[...] = twist_by_q.reshape(blocks.shape)
        # The linear part of this derivative is that of the velocity at a fixed point of the world. The origin of the
        # shape moves, so its velocity has the additional term ω × ∂p/∂q. Pinocchio's derivative of the velocity of a
        # point has both terms.
        self.velocity_by_q[...], _ = pinocchio.getPointVelocityDerivatives(
            model, data, self.joint, self.placement, WORLD_AXES
        )
        return placement, self.jacobian.dot(v)


class Contact:
    """Contact of a model, with buffers for its evaluation."""

    def __init__(self, model: Any, contact: ContactPair, column: int, width: int) -> None:
        nv = model.nv
        self.pair = contact.pair
        self.name = f"frame {contact.frame_a!r} and frame {contact.frame_b!r}"
        self.poses: list[Floats] = []
        self.twists = [np.zeros(6), np.zeros(6)]
        # Rows: the columns of Pair.linearized. Columns: those of ``Robot``, which are q, v and the materials of all
        # contacts.
        self.motion = np.zeros((28, width))
        self.motion[24:, column : column + 4] = np.eye(4)
        self.both_jacobians = self.motion[:12, :nv]
        self.moving: list[Mount] = []
        joints = []
        frames = ((contact.frame_a, contact.pose_a), (contact.frame_b, contact.pose_b))
        for side, (name, in_frame) in enumerate(frames):
            frame = model.frames[_frame_index(model, name)]
            placement = frame.placement * pinocchio.SE3(pose() if in_frame is None else checked_pose(in_frame))
            joints.append(frame.parentJoint)
            self.poses.append(np.ascontiguousarray(placement.homogeneous))
            if frame.parentJoint:
                self.moving.append(Mount(side, frame.parentJoint, placement, self.motion, nv))
        if joints[0] == joints[1]:
            raise HydroelasticError(
                f"frames {contact.frame_a!r} and {contact.frame_b!r} are fixed to each other: expected two that move"
            )

    def update_poses(self, data: Any) -> None:
        """Updates the poses from the data."""
        for mount in self.moving:
            self.poses[mount.side] = (data.oMi[mount.joint] * mount.placement).homogeneous

    def joint_torques(self, model: Any, data: Any, v: Floats, material: Material) -> Floats | None:
        """Returns Jᵀ w after ``computeJointJacobians``, or None without contact."""
        jacobians = []
        for mount in self.moving:
            self.poses[mount.side] = (data.oMi[mount.joint] * mount.placement).homogeneous
            jacobian = pinocchio.getFrameJacobian(model, data, mount.joint, mount.placement, WORLD_AXES)
            self.twists[mount.side] = jacobian.dot(v).take(SWAPPED)
            jacobians.append(jacobian)
        wrenches = self.wrench(material)
        if not wrenches.dot(wrenches):
            return None
        torques = [wrenches[m.part].take(SWAPPED).dot(j) for m, j in zip(self.moving, jacobians, strict=True)]
        total: Floats = torques[0] if len(torques) == 1 else torques[0] + torques[1]
        return total

    def move(self, model: Any, data: Any, v: Floats) -> list[Any]:
        """Updates the motion from the data after ``computeForwardKinematicsDerivatives``. Returns the placements of the
        moving shapes."""
        placements = []
        for mount in self.moving:
            placement, self.twists[mount.side] = mount.move(model, data, v)
            self.poses[mount.side] = placement.homogeneous
            placements.append(placement)
        return placements

    def wrench(self, material: Material) -> Floats:
        """Returns the wrenches, (12,), at the poses and twists."""
        try:
            wrenches = self.pair.wrench(*self.poses, *self.twists, moduli=material[0], law=material[1])
        except HydroelasticError as error:
            raise HydroelasticError(f"contact of {self.name}: {error}") from error
        return self._finite(wrenches)

    def linearized(self, material: Material) -> tuple[Floats, Floats]:
        """Returns the wrenches and their derivatives, (12, 28)."""
        try:
            wrenches, jacobian = self.pair.linearized(*self.poses, *self.twists, moduli=material[0], law=material[1])
        except HydroelasticError as error:
            raise HydroelasticError(f"contact of {self.name}: {error}") from error
        return self._finite(wrenches), jacobian

    def _finite(self, wrenches: Floats) -> Floats:
        if not math.isfinite(wrenches.dot(wrenches)):
            raise HydroelasticError(f"contact of {self.name}: the wrench is not finite, although the poses and velocities are")
        return wrenches

    def joint_torque_slopes(
        self, model: Any, data: Any, v: Floats, material: Material, forces: Any
    ) -> tuple[Floats, Floats] | tuple[None, None]:
        """Adds the wrenches to the forces on the joints, in the axes of the joints.

        Returns Jᵀ w and its derivatives with respect to q, v and the materials, without the contribution of constant
        joint forces. Returns a pair of None without contact.
        """
        self.move(model, data, v)
        wrenches, jacobian = self.linearized(material)
        if not wrenches.dot(wrenches):
            return None, None
        for mount in self.moving:
            wrench = wrenches[mount.part]
            # In axes that turn with the link, the torque and the force of a constant wrench w change by −ω × w.
            by_turn = jacobian[mount.part, mount.turn]
            np.add(by_turn, CROSSES.dot(wrench).reshape(6, 3), out=by_turn)
            in_shape = wrench.reshape(2, 3).dot(self.poses[mount.side][:3, :3])[::-1].ravel()
            forces[mount.joint] += mount.placement.act(pinocchio.Force(in_shape))
        return self.both_jacobians.T.dot(wrenches), self.both_jacobians.T.dot(jacobian.dot(self.motion))


def _frame_index(model: Any, name: str | int) -> int:
    if isinstance(name, str):
        if not model.existFrame(name):
            raise HydroelasticError(f"the model has no frame {name!r}")
        indices = [index for index, frame in enumerate(model.frames) if frame.name == name]
        first = model.frames[indices[0]]
        for frame in (model.frames[index] for index in indices[1:]):
            if frame.parentJoint != first.parentJoint or frame.placement != first.placement:
                raise HydroelasticError(f"the model has {len(indices)} frames {name!r} at different places: give an index")
        return indices[0]
    if not 0 <= name < model.nframes:
        raise HydroelasticError(f"frame {name} of a model with {model.nframes} frames")
    return name

