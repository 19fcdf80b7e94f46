"""Where does an arm rest if its servos aim below a table? Newton's method finds the equilibrium with Pinocchio.

    pip install "hydroelastic[pin]"; python arm_presses.py

Three servos pull an arm toward a posture in which the soft fingertip is 2 cm below the top of a table. At equilibrium,
the torques of gravity, servos and contact cancel. Pinocchio computes gravity, this library computes contact, and both
have exact derivatives. A simulation of the same robot comes to rest at the same posture.
"""

import numpy as np
import pinocchio

import hydroelastic as he
from hydroelastic.pin import Adapter

LINK = """<link name="{name}"><inertial><origin xyz="0.15 0 0"/><mass value="1"/>
    <inertia ixx="1e-3" iyy="8e-3" izz="8e-3" ixy="0" ixz="0" iyz="0"/></inertial>{more}</link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="500" velocity="9"/></joint>"""
TIP = '<collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.03"/></geometry></collision>'
ARM = "".join(
    [
        '<robot name="arm"><link name="base"/>',
        LINK.format(name="upper", more=""),
        LINK.format(name="lower", more=""),
        LINK.format(name="hand", more=TIP),
        JOINT.format(name="shoulder", parent="base", child="upper", x=0),
        JOINT.format(name="elbow", parent="upper", child="lower", x=0.3),
        JOINT.format(name="wrist", parent="lower", child="hand", x=0.3),
        "</robot>",
    ]
)
JOINTS = ["shoulder", "elbow", "wrist"]
AIM = np.array([-0.5, 0.9, 0.6])  # rad
STIFFNESS, DAMPING = np.array([300.0, 200.0, 50.0]), np.array([30.0, 20.0, 5.0])  # N m/rad, N m s/rad


def scene():
    """The arm above a table in a world, and its Pinocchio model."""
    mechanism = he.Robot.parse(ARM).mechanism(he.Material(2e5, dissipation=0.3))
    for name, stiffness, damping, aim in zip(JOINTS, STIFFNESS, DAMPING, AIM):
        mechanism = mechanism.with_joint(name, servo_stiffness=stiffness, servo_damping=damping, target_position=aim)
    model = pinocchio.buildModelFromXML(ARM)
    tip = he.World([], mechanisms=[mechanism]).state_with_joints(dict(zip(JOINTS, AIM))).poses[-1] @ [0.3, 0.0, 0.0, 1.0]
    top = he.pose([0.0, 0.0, tip[2] - 0.03 + 0.02])
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid(), pose=top)
    return Adapter(he.World([table], mechanisms=[mechanism], gravity=-9.81), model)


def equilibrium(robot):
    """The posture at which all torques cancel, by Newton's method."""
    model, data = robot.model, robot.model.createData()
    q, still = AIM.copy(), np.zeros(model.nv)
    for number in range(20):
        contact = robot.linearized_contact_torques(q, still)
        torque = contact.tau + STIFFNESS * (AIM - q) - pinocchio.computeGeneralizedGravity(model, data, q)
        print(f"{number}: largest torque {np.abs(torque).max():.3e} N m")
        if np.abs(torque).max() < 1e-10:
            return q
        by_q = contact.by_q - np.diag(STIFFNESS) - pinocchio.computeGeneralizedGravityDerivatives(model, data, q)
        q = q - np.linalg.solve(by_q, torque)
    raise RuntimeError("Newton's method has not converged")


if __name__ == "__main__":
    robot = scene()
    q = equilibrium(robot)
    (contact,) = robot.world.contacts(robot.state(q, np.zeros(3)))
    force = contact.wrench[5] if contact.bodies[0] == "hand" else contact.wrench[11]
    print(f"at rest at {q} rad, the fingertip presses with {force:.3f} N")
    start = robot.state(AIM - [0.2, 0.0, 0.0], np.zeros(3))
    trajectory = robot.world.rollout(he.Plan(1e-2, 200, he.Integrator.SDIRK3), start=start).run()
    end, velocity = robot.q_and_v(trajectory[-1])
    print(f"the simulation ends {np.abs(end - q).max():.1e} rad away, at {np.abs(velocity).max():.1e} rad/s")
    assert force > 1.0 and np.abs(end - q).max() < 1e-5
