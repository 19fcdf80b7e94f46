"""How must an arm move to push a box to a goal? Gauss–Newton finds the joint targets from derivatives through the contacts.

    python push_box.py

The arm is read from a URDF text. The box is free and slides on the floor with friction.
"""

import numpy as np

import hydroelastic as he

LINK = """<link name="{name}"><inertial><origin xyz="0.15 0 0"/><mass value="1"/>
    <inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>{tip}</link>"""
TIP = '<collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.04"/></geometry></collision>'
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="50" velocity="5"/><dynamics damping="0.5"/></joint>"""
URDF = f"""<robot name="arm"><link name="base"/>
{LINK.format(name="upper", tip="")}{LINK.format(name="lower", tip=TIP)}
{JOINT.format(name="shoulder", parent="base", child="upper", x=0.0)}
{JOINT.format(name="elbow", parent="upper", child="lower", x=0.3)}</robot>"""
START = {"shoulder": -0.9, "elbow": 1.4}  # rad
INTERVAL, COUNT = 0.25, 4  # s between targets, and number of targets after the first
GOAL = np.array([0.52, 0.16])  # m
PLAN = he.Plan(1e-2, 120, he.Integrator.SDIRK3)
TARGETS = [he.Parameter.joint(name, "scheduled_target", index) for index in range(1, COUNT + 1) for name in START]


def scene():
    """The arm at its start. Its targets first turn the shoulder, which pushes the box."""
    rubber = he.Material(1e6, dissipation=0.5, friction=0.3)
    arm = he.Robot.parse(URDF).mechanism(rubber, pose=he.pose([0.0, 0.0, 0.05]))
    for (name, start), turn in zip(START.items(), (0.35, 0.0)):
        targets = start + turn * np.linspace(0.0, 1.0, COUNT + 1)
        arm = arm.with_joint(name, position=start, servo_stiffness=200.0, servo_damping=20.0, targets=(INTERVAL, targets))
    box = he.Body.dynamic("box", he.Shape.cuboid([0.1, 0.1, 0.1]), rubber, 0.5, pose=he.pose([0.47, 0.09, 0.0499]))
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid(friction=0.3))
    return he.World([floor, box], mechanisms=[arm], gravity=-9.81, slip_tolerance=1e-2)


def train(world, iterations=12, bound=1e-3):
    """Changes the targets until the box is at the goal. Returns the world and the misses (m)."""
    box, misses = world.index_of("box"), []
    for iteration in range(iterations):
        trajectory, jacobian = world.jacobian(PLAN, TARGETS)
        miss = GOAL - trajectory.poses[-1, box, :2, 3]
        misses.append(np.linalg.norm(miss))
        print(f"iteration {iteration}: the box misses the goal by {1e3 * misses[-1]:.1f} mm")
        if misses[-1] < bound:
            break
        # Smallest change of the targets that corrects the miss, to first order.
        slopes = jacobian.poses[-1, box, :2, 3]
        change = slopes.T @ np.linalg.solve(slopes @ slopes.T + 1e-4 * np.eye(2), miss)
        change *= min(1.0, 0.3 / np.linalg.norm(change))
        world = world.perturbed(TARGETS, change)
    return world, misses


if __name__ == "__main__":
    world, misses = train(scene())
    for name, start in START.items():
        joint = next(joint for joint in world.joints if joint.name == name)
        print(f"targets of the {name}: {joint.targets[1].round(2)} rad")
    assert misses[0] > 0.02 and misses[-1] < 1e-3
