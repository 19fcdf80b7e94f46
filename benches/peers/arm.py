"""Time per step of an arm of seven joints that wipes a rigid table with a soft ball, here and in MuJoCo, in steps of 5 ms.

    pip install ./python mujoco; python3 benches/peers/arm.py

Both programs have the same links, servos, joint friction and targets. MuJoCo has one contact point and the integrator `implicitfast`. The
programs alternate, each with one thread. A time is the shortest processor time of 15 rounds of 200 steps.
"""

import os
import time

os.environ["RAYON_NUM_THREADS"] = "1"

import hydroelastic as he
import mujoco
import numpy as np

TIME_STEP, STEPS, ROUNDS = 5e-3, 200, 15  # s
LAST = 100  # steps for which forces are printed
INTERVAL = 0.05  # s, from one target to the next
# Axis, origin (m), mass (kg) and end (m) of each link, and initial angle (rad). A link is a rod from its origin to its end.
LINKS = [
    ([0, 0, 1], [0, 0, 0.33], 4.0, [0, 0, -0.12], 0.1),
    ([0, 1, 0], [0, 0, 0], 4.0, [0, 0, 0.32], -0.5),
    ([0, 0, 1], [0, 0, 0.32], 3.0, [0.08, 0, 0], 0.1),
    ([0, 1, 0], [0.08, 0, 0], 3.0, [-0.08, 0, 0.38], 2.1),
    ([0, 0, 1], [-0.08, 0, 0.38], 2.5, [0, 0, -0.2], 0.05),
    ([0, 1, 0], [0, 0, 0], 1.5, [0.09, 0, 0], -1.62),
    ([0, 0, 1], [0.09, 0, 0], 0.8, [0, 0, -0.12], 0.3),
]
NAMES = [f"joint {number}" for number in range(1, 8)]
STIFFNESS = [3000.0] * 4 + [800.0] * 3  # N m/rad
DAMPING = [100.0] * 4 + [20.0] * 3  # N m s/rad
ARMATURE, JOINT_DAMPING, JOINT_FRICTION = 0.1, 0.5, 0.5  # kg m², N m s/rad, N m
TIP, RADIUS, TIP_MASS = [0, 0, -0.15], 0.03, 0.05  # m, m, kg
FRICTION, DISSIPATION, GRAVITY = 0.5, 0.3, 9.81  # –, s/m, m/s²
DEPTH, SWEEP = 0.01, 0.1  # m, of the targets below the table and to either side


def inertia(mass, end):
    """Inertia (kg m²) of a rod about its center."""
    end = np.array(end)
    return mass * ((end @ end * np.eye(3) - np.outer(end, end)) / 12 + 1e-4 * np.eye(3))


def bodies(modulus, targets=None, torques=(0.0,) * 7):
    """Links and tip of the arm here."""
    skin, parent, links = he.Material(modulus, dissipation=DISSIPATION, friction=FRICTION), None, []
    for index, (name, (axis, origin, mass, end, angle)) in enumerate(zip(NAMES, LINKS)):
        joint = he.Joint.revolute(
            name,
            axis,
            parent=parent,
            origin=he.pose(origin),
            position=angle,
            armature=ARMATURE,
            damping=JOINT_DAMPING,
            friction=JOINT_FRICTION,
            servo_stiffness=STIFFNESS[index],
            servo_damping=DAMPING[index],
            torque=torques[index],
            targets=None if targets is None else (INTERVAL, targets[:, index]),
        )
        center = np.array(end) / 2
        link = he.Body.dynamic(name, None, mass=mass, center_of_mass=center, inertia=inertia(mass, end), joint=joint)
        links.append(link)
        parent = name
    weld = he.Joint.fixed("tip", parent=parent, origin=he.pose(TIP))
    return [*links, he.Body.dynamic("tip", he.Shape.icosphere(RADIUS, 2), skin, mass=TIP_MASS, joint=weld)]


def motion():
    """Height of the table (m), targets (rad) at multiples of the interval, and torques (N m) against gravity."""
    arm = he.World(bodies(1e6), gravity=-GRAVITY)
    height = arm.initial_state.poses[-1, 2, 3] - RADIUS
    kinetics = arm.kinetics()
    jacobian = kinetics.jacobian("tip", [0, 0, 0])[3:]
    times = INTERVAL * np.arange(round(STEPS * TIME_STEP / INTERVAL) + 1)
    shifts = np.zeros((len(times), 3))
    shifts[:, 1] = SWEEP * np.sin(np.pi * times)
    shifts[:, 2] = -DEPTH * np.minimum(times / 0.1, 1.0)
    inverse = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-4 * np.eye(3))
    angles = np.array([link[4] for link in LINKS])
    return height, angles + shifts @ inverse.T, kinetics.gravity_bias


class Ours:
    """A world of this library with an integrator."""

    def __init__(self, modulus, integrator, accuracy=None):
        height, targets, torques = motion()
        table = he.Body.fixed(
            "table", he.HalfSpace(), he.Material.rigid(friction=FRICTION), pose=he.pose([0, 0, height])
        )
        self.world = he.World([*bodies(modulus, targets, torques), table], gravity=-GRAVITY)
        self.plan = he.Plan(TIME_STEP, STEPS, integrator, accuracy=accuracy)
        self.seconds = np.inf

    def measure(self):
        rollout = self.world.rollout(self.plan)
        start = time.process_time()
        trajectory = rollout.run()
        self.seconds = min(self.seconds, time.process_time() - start)
        self.states, self.report = list(trajectory)[-LAST:], rollout.total_step_report

    def work(self):
        report = self.report
        return f"{report.evaluations / report.solves:.2f} | {report.failures} | {report.substeps / STEPS:.2f}"

    def forces(self):
        contacts = [self.world.contacts(state) for state in self.states]
        return [abs(found[0].wrench[5]) if found else 0.0 for found in contacts]


class Theirs:
    """The same arm in MuJoCo."""

    def __init__(self):
        height, targets, torques = motion()
        self.model = mujoco.MjModel.from_xml_string(mjcf(height))
        self.data = mujoco.MjData(self.model)
        times = TIME_STEP * (np.arange(STEPS) + 0.5)
        knots = INTERVAL * np.arange(len(targets))
        rates = np.diff(targets, axis=0) / INTERVAL
        aims = np.array([np.interp(times, knots, column) for column in targets.T]).T
        speeds = rates[(times / INTERVAL).astype(int)]
        self.controls = torques + aims * STIFFNESS + speeds * DAMPING
        self.seconds = np.inf

    def measure(self):
        start = time.process_time()
        for _ in self.steps():
            pass
        self.seconds = min(self.seconds, time.process_time() - start)

    def steps(self):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = [link[4] for link in LINKS]
        for control in self.controls:
            self.data.ctrl[:] = control
            mujoco.mj_step(self.model, self.data)
            yield

    def work(self):
        return " | | "

    def forces(self):
        forces, force = [], np.zeros(6)
        for _ in self.steps():
            force[:] = 0.0
            if self.data.ncon:
                mujoco.mj_contactForce(self.model, self.data, 0, force)
            forces.append(force[0])
        return forces[-LAST:]


def mjcf(height):
    """Model of MuJoCo."""
    text, tail, actuators = "", "", ""
    for name, (axis, origin, mass, end, _), stiffness, damping in zip(NAMES, LINKS, STIFFNESS, DAMPING):
        tensor = inertia(mass, end)
        numbers = [*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        text += f"""<body name="{name}" pos="{row(origin)}">
            <joint name="{name}" axis="{row(axis)}" armature="{ARMATURE}" damping="{JOINT_DAMPING}" frictionloss="{JOINT_FRICTION}"/>
            <inertial pos="{row(np.array(end) / 2)}" mass="{mass}" fullinertia="{row(numbers)}"/>"""
        tail += "</body>"
        actuators += f'<general joint="{name}" biastype="affine" biasprm="0 {-stiffness} {-damping}"/>'
    text += f'<body pos="{row(TIP)}"><geom type="sphere" size="{RADIUS}" mass="{TIP_MASS}"/></body>'
    return f"""<mujoco>
        <option timestep="{TIME_STEP}" integrator="implicitfast" cone="elliptic" gravity="0 0 {-GRAVITY}"/>
        <default><geom friction="{FRICTION} 0.005 0.0001"/></default>
        <worldbody><geom type="plane" size="5 5 1" pos="0 0 {height}"/>{text}{tail}</worldbody>
        <actuator>{actuators}</actuator></mujoco>"""


def row(numbers):
    return " ".join(str(float(number)) for number in numbers)


def main():
    without_control = he.Accuracy(1e9, 1e9)
    methods = {}
    for modulus in (1e7, 1e9):
        methods[f"{modulus:.0e} Pa, `Sdirk3`"] = Ours(modulus, "sdirk3")
        methods[f"{modulus:.0e} Pa, `Sdirk3` without error control"] = Ours(modulus, "sdirk3", without_control)
        methods[f"{modulus:.0e} Pa, `ImplicitEuler`"] = Ours(modulus, "implicit_euler")
    methods[f"MuJoCo {mujoco.__version__}, `implicitfast`"] = Theirs()
    for _ in range(ROUNDS):
        for method in methods.values():
            method.measure()
    print("| method | µs per step | evaluations per solve | failed solves | substeps per step | force in the last 0.5 s (N) |")
    print("|---|---|---|---|---|---|")
    for name, method in methods.items():
        microseconds, forces = 1e6 * method.seconds / STEPS, method.forces()
        print(f"| {name} | {microseconds:.1f} | {method.work()} | {min(forces):.0f}–{max(forces):.0f} |")


if __name__ == "__main__":
    main()
