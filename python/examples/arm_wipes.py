"""How deep must a wiping arm aim below a table to press with 5 N? Newton's method uses the derivative through the
motion.

    pip install "hydroelastic[pin]"; python arm_wipes.py

An arm with five hinges lowers a soft fingertip onto a table and wipes to and fro. A joint controller holds it on its
path, which lies below the table by a depth. The mean normal force while wiping is a function of this depth and of the
materials.
"""

import numpy as np
import pinocchio

import hydroelastic as he
from hydroelastic.pin import ContactPair, Feedback, Robot

LINKS = (("RZ", 0.1), ("RY", 0.35), ("RY", 0.3), ("RY", 0.15), ("RX", 0.1))  # axis of the hinge, length (m)
START = np.array([0.2, 0.5, 1.2, 1.1, 0.1])
TIME_STEP, STEPS, EVERY, SETTLED = 5e-4, 2000, 20, 0.4  # s, steps, steps between records, s
STIFFNESS = np.array([400.0, 400.0, 300.0, 60.0, 10.0])  # N m/rad
DAMPING = np.array([30.0, 30.0, 20.0, 2.0, 0.2])  # N m s/rad
TARGET = 5.0  # N


def arm():
    """The model of the arm."""
    model, joint, placement = pinocchio.Model(), 0, pinocchio.SE3.Identity()
    for number, (axis, length) in enumerate(LINKS):
        joint = model.addJoint(joint, getattr(pinocchio, f"JointModel{axis}")(), placement, f"hinge {number}")
        placement = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, length]))
        middle = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, length / 2]))
        model.appendBodyToJoint(joint, pinocchio.Inertia.FromCylinder(5.0 * length, 0.03, length), middle)
    model.addFrame(pinocchio.Frame("fingertip", joint, placement, pinocchio.FrameType.OP_FRAME))
    return model


def scene():
    """The robot, whose fingertip starts 5 mm above the table, and the joint velocities per linear velocity of the tip.
    """
    model = arm()
    data, tip = model.createData(), model.getFrameId("fingertip")
    jacobian = pinocchio.computeFrameJacobian(model, data, START, tip, pinocchio.LOCAL_WORLD_ALIGNED)[:3]
    pinocchio.updateFramePlacements(model, data)
    x, y, z = data.oMf[tip].translation
    law = he.SurfaceLaw(dissipation=0.3, friction=0.5, slip_tolerance=1e-2)
    pair = he.Pair(he.Shape.icosphere(0.03, 2), he.Shape.cuboid([0.4, 0.6, 0.1]), 2e5, 1e7, law)
    table = he.pose([x, y, z - 0.03 - 0.005 - 0.05])
    return Robot(model, [ContactPair(pair, "fingertip", pose_b=table)]), np.linalg.pinv(jacobian)


def controller(model, per_velocity, depth):
    """A controller that holds the joints on the path: down by 5 mm and the depth within 0.2 s, then to and fro by 4 cm.
    """
    weight = pinocchio.computeGeneralizedGravity(model, model.createData(), START)
    by_q, by_v = -np.diag(STIFFNESS), -np.diag(DAMPING)

    def feedback(time, q, v):
        lowered = min(time / 0.2, 1.0)
        aim = np.array([0.0, 0.04 * np.sin(2.0 * np.pi * max(time - 0.2, 0.0) / 0.4), -lowered * (0.005 + depth)])
        tau = weight + STIFFNESS * (START + per_velocity @ aim - q) - DAMPING * v
        by_depth = STIFFNESS * (per_velocity @ [0.0, 0.0, -lowered])
        return Feedback(tau, by_q, by_v, by_depth[:, None])

    return feedback


def mean_force(robot, per_velocity, depth):
    """The mean normal force (N) while wiping, its derivatives with respect to depth (N/m) and material, and the
    friction (N)."""
    nv = robot.model.nv
    feedback = controller(robot.model, per_velocity, depth)
    motion, jacobian = robot.linearized_rollout(START, np.zeros(nv), feedback, TIME_STEP, STEPS, record_every=EVERY)
    records = np.flatnonzero(motion.times > SETTLED)
    force, by_depth, by_material, friction = 0.0, 0.0, np.zeros(4), 0.0
    for k in records:
        contact = robot.linearized_wrenches(motion.q[k], motion.v[k])
        by_state = np.r_[contact.by_q[0, 5], contact.by_v[0, 5]]  # row 5: the force on the fingertip along z
        force += contact.wrenches[0, 5] / len(records)
        by_depth += by_state @ jacobian.by_parameters[k, :, 0] / len(records)
        by_material += (contact.by_material[0, 5] + by_state @ jacobian.by_material[k, :, 0]) / len(records)
        friction += np.linalg.norm(contact.wrenches[0, 3:5]) / len(records)
    return force, by_depth, by_material, friction


if __name__ == "__main__":
    robot, per_velocity = scene()
    depth = 0.002
    for number in range(8):
        force, by_depth, by_material, friction = mean_force(robot, per_velocity, depth)
        print(f"{number}: aimed {1e3 * depth:7.4f} mm deep: {force:.6f} N, friction {friction:.3f} N, {by_depth:.3f} N/m")
        if abs(force - TARGET) < 1e-6:
            break
        depth -= (force - TARGET) / by_depth
    assert abs(force - TARGET) < 1e-6 and friction > 1.0
    step = 1e-6
    ends = [mean_force(robot, per_velocity, depth + sign * step)[0] for sign in (1, -1)]
    differences = (ends[0] - ends[1]) / (2 * step)
    print(f"central differences: {differences:.3f} N/m, a relative deviation of {abs(differences / by_depth - 1):.1e}")
    assert abs(differences / by_depth - 1) < 1e-7
    print(f"1 % more modulus of the fingertip changes the force by {0.01 * 2e5 * by_material[0]:.4f} N,")
    print(f"0.01 more friction changes it by {0.01 * by_material[3]:.4f} N")
