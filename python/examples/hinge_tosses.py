"""Which friction and damping of a hinge explain recorded tosses of two boxes, and how much better do they predict other tosses?

    pip install hydroelastic
    python hinge_tosses.py [--data FOLDER --fit 60 --held-out 100]

The folder contains the file elbow_tosses.csv, whose source is in docs/measured_motions.md. First, the friction and the damping of the
hinge are fitted to flights after impacts, where no contact acts. Then the parameters of the contact are fitted to the beginnings of tosses,
with and without these losses of the hinge. Without a folder, tosses are simulated with noise, and all estimates are compared with the
true values.
"""

import argparse
import pathlib

import numpy as np

import hydroelastic as he

RATE = 148.0  # frames per second
SIZES = np.array([0.1, 0.05, 0.05])  # m, of each box
MASS = 0.37  # kg, of each box
INERTIA = MASS / 12 * np.diag((SIZES**2).sum() - SIZES**2)  # of a solid box
CENTER = [0.035, 0.0, 0.0]  # m: center of the second box in its frame, whose origin is on the hinge
FRAMES = 41  # number of frames that are fitted: 0.27 s, with one or two impacts
SHORTEST_FLIGHT = 10  # frames before the first impact
SHORTEST_FLIGHT_BETWEEN = 12  # frames between two impacts
CLEARANCE = 0.012  # m: least height of the corners of the boxes in a flight between impacts
CORNERS = SIZES / 2 * np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
PLAN = he.Plan(1 / RATE, FRAMES - 1, "sdirk3", accuracy=he.Accuracy(0.05, 0.5))
MODEL_ERROR = (1e-2, 0.2)  # m, rad: standard deviations of the errors of the model after an impact
NOISE = [1e-3, 0.01, 0.03, 0.1]  # m, rad, m/s, rad/s: standard deviations of measured poses and initial velocities
GUESS = {"modulus": 3e7, "dissipation": 2.0, "friction": 0.2, "height": 1e-3, "gravity": -9.81}
HINGE_LOSSES = {"hinge damping": 1e-3, "hinge friction": 1e-3}  # N m s and N m: guess
TRUTH = {"modulus": 5e6, "dissipation": 1.5, "friction": 0.15, "height": 1e-3, "gravity": -9.75}
TRUTH |= {"hinge damping": 2e-3, "hinge friction": 5e-3}


def world_of(values):
    """A world with two boxes on a hinge above a table. If the values have no damping and no friction of the hinge, the hinge is free."""
    skin = he.Material(values["modulus"], dissipation=values["dissipation"], friction=values["friction"])
    box = he.Shape.cuboid(SIZES)
    first = he.Body.dynamic("first", box, skin, MASS, center_of_mass=[0.0] * 3, inertia=INERTIA, pose=he.pose([0.0, 0.0, 0.3]))
    loss = {"damping": values.get("hinge damping", 0.0), "friction": values.get("hinge friction", 0.0), "slip_tolerance": 0.1}
    hinge = he.Joint.revolute("hinge", [0.0, 1.0, 0.0], parent="first", origin=he.pose([-0.035, 0.06, 0.0]), **loss)
    shape = he.Shape.compound([(box, he.pose(CENTER))])
    second = he.Body.dynamic("second", shape, skin, MASS, center_of_mass=CENTER, inertia=INERTIA, joint=hinge)
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid(), pose=he.pose([0.0, 0.0, values["height"]]))
    return he.World([first, second, table], gravity=values["gravity"])


def contact_unknowns():
    """Modulus, dissipation and friction of both boxes, height of the table, and gravity."""
    boxes = "first", "second"
    unknowns = []
    for parameter in (he.Parameter.modulus, he.Parameter.dissipation, he.Parameter.friction):
        first, second = map(parameter, boxes)
        unknowns.append(he.Unknown(first, logarithmic=True, tied_to=[second]))
    unknowns.append(he.Unknown(he.Parameter.initial_position("table"), component=2, name="height"))
    return [*unknowns, gravity()]


def gravity():
    return he.Unknown(he.Parameter.gravity(), component=2, prior=(-9.81, 0.1), name="gravity")


def hinge_unknowns():
    """Damping and friction of the hinge. The prior keeps a very small friction, which no motion determines, away from zero."""
    return [he.Unknown(he.Parameter.joint("hinge", name), logarithmic=True, prior=(1e-3, 2.0)) for name in ("damping", "friction")]


def start_errors():
    """The errors of the initial state, as nuisances with three times the standard deviations of the measurements."""
    position, turn, velocity, spin = 3 * np.array(NOISE)
    return [
        (he.Parameter.initial_position("first"), position),
        (he.Parameter.initial_orientation("first"), turn),
        (he.Parameter.initial_velocity("first"), velocity),
        (he.Parameter.initial_angular_velocity("first"), spin),
        (he.Parameter.joint("hinge", "initial_position"), turn),
        (he.Parameter.joint("hinge", "initial_velocity"), spin),
    ]


def flight_identification(values, unknowns):
    """An identification for motions without contact."""
    options = {"nuisances": start_errors(), "noise": NOISE[:2], "cauchy": 2.0, "max_iterations": 15}
    return he.Identification(world_of(values), PLAN, unknowns, **options)


def with_fitted_start(toss):
    """The toss with an initial state that fits its flight. The errors of a measured state would change the motion after an impact."""
    states = list(toss)
    beginning = he.Trajectory(states[: flight_frame_count(toss)])
    prediction = flight_identification(GUESS, []).predict([], beginning, fitted_duration=1.0)
    return he.Trajectory([prediction.trajectory[0], *states[1:]])


def read(path):
    """Recorded tosses. The columns are toss, frame, quaternion (w, x, y, z) and position of the first box, hinge angle, angular velocity
    of the first box in its axes, velocity of the first box, and rate of the hinge."""
    world = world_of(GUESS)
    tosses = {}
    for toss, frame, *numbers in np.loadtxt(path, delimiter=",", skiprows=1):
        state = state_of(world, frame / RATE, rotation(numbers[:4]), numbers[4:7], numbers[7], numbers[8:11], numbers[11:14], numbers[14])
        tosses.setdefault(toss, []).append(state)
    return [he.Trajectory(states) for states in tosses.values()]


def state_of(world, time, turn, position, angle, spin, velocity, rate):
    """A state of the world. The spin is the angular velocity of the first box in its axes."""
    state = world.initial_state
    poses, twists = state.poses, state.twists
    poses[0, :3, :3], poses[0, :3, 3] = turn, position
    twists[0] = [*(turn @ spin), *velocity]
    return world.state_with_joints({"hinge": angle}, {"hinge": rate}, state=he.State(time, poses, twists, state.joints))


def rotation(quaternion):
    """The rotation matrix of a quaternion (w, x, y, z)."""
    w, *axis = quaternion / np.linalg.norm(quaternion)
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def centers(trajectory):
    """The centers of both boxes, (states, 2, 3)."""
    poses = trajectory.poses
    return np.stack([poses[:, 0, :3, 3], poses[:, 1, :3, 3] + poses[:, 1, :3, :3] @ CENTER], axis=1)


def flight_frame_count(toss):
    """The number of frames before the common center of mass first has another acceleration than that of gravity."""
    accelerations = RATE**2 * np.diff(centers(toss).mean(axis=1)[:, 2], 2)
    contacts = np.flatnonzero(np.abs(accelerations + 9.8) > 25.0)
    return contacts[0] + 1 if contacts.size else len(toss)


def flights_between_impacts(toss):
    """The flights of a toss after its first impact."""
    poses, states = toss.poses[:, :2], list(toss)
    corners = np.einsum("sbj,cj->sbc", poses[:, :, 2, :3], CORNERS) + centers(toss)[:, :, 2, None]
    in_flight = np.concatenate([[False], corners.min(axis=(1, 2)) > CLEARANCE, [False]])
    first, end = np.flatnonzero(np.diff(in_flight.astype(int))).reshape(-1, 2).T
    is_long = (first > 0) & (end - first >= SHORTEST_FLIGHT_BETWEEN)
    return [he.Trajectory(states[i:j]) for i, j in zip(first[is_long], end[is_long])]


def simulated(values, count):
    """Random tosses of the boxes, with noise of the poses after the first."""
    world, random = world_of(values), np.random.default_rng(1)
    for _ in range(count):
        turn, angle, rate = rotation(random.normal(size=4)), random.uniform(-2, 2), random.normal(0, 3)
        start = state_of(world, 0.0, turn, [0.0, 0.0, 0.25], angle, random.normal(0, 3, 3), [0.5, 0.0, -1.0], rate)
        toss = world.rollout(PLAN, start=start).run()
        angles = random.normal(toss.joint_positions[1:, 0], NOISE[1])
        yield he.Trajectory([start, *(noisy(world, random, state, angle) for state, angle in zip(list(toss)[1:], angles))])


def noisy(world, random, state, angle):
    """A state with noise of the pose of the first box, without velocities."""
    turn = state.poses[0, :3, :3] @ rotation([1.0, *random.normal(0, NOISE[1] / 2, 3)])
    position = random.normal(state.poses[0, :3, 3], NOISE[0])
    return state_of(world, state.time, turn, position, angle, np.zeros(3), np.zeros(3), 0.0)


def predict_flights(identification, values, flights):
    """Mean errors over the second halves of flights: positions of the origins (mm) and rotations (°). The starts are fitted to the first
    halves."""
    rows = []
    for toss in flights:
        middle = len(toss) // 2
        prediction = identification.predict(values, toss, fitted_duration=toss[middle].time - toss[0].time)
        errors = 1e3 * prediction.position_errors, np.degrees(prediction.rotation_errors)
        rows.append([error[middle:].mean() for error in errors])
    print_errors(["position (mm)", "rotation (°)"], rows)


def predict_tosses(identification, values, tosses):
    """Mean errors along the fitted parts and along whole tosses: positions of the centers (% of the length) and rotations (°)."""
    rows = []
    for toss in tosses:
        prediction = identification.predict(values, toss)
        distances = np.linalg.norm(centers(prediction.trajectory) - centers(toss), axis=2).mean(axis=1)
        path = np.stack([100 * distances / SIZES[0], np.degrees(prediction.rotation_errors).mean(axis=1)])
        rows.append([*path[:, :FRAMES].mean(axis=1), *path.mean(axis=1)])
    names = ["position (% of the length)", "rotation (°)"]
    print_errors([f"{name}, {part}" for part in ("fitted part", "whole toss") for name in names], rows)


def print_errors(names, rows):
    for name, column in zip(names, np.transpose(rows)):
        print(f"  {name}: mean {column.mean():.2f}, median {np.median(column):.2f}, standard error {column.std() / len(column) ** 0.5:.2f}")


def fit(title, identification, motions):
    result = identification.fit(motions)
    print(f"{title}, {len(motions)} motions: cost {result.cost:.1f}, {result.termination} after {result.iterations} iterations")
    for unknown, value, (lower, upper) in zip(result.names, result.values, result.sandwich_intervals):
        print(f"  {unknown}: {value:.4g} ({lower:.4g} to {upper:.4g})")
    return result


def fit_recordings(options):
    tosses = read(options.data / "elbow_tosses.csv")
    flights = [part for toss in tosses for part in flights_between_impacts(toss)]
    losses = {}
    for title, values, unknowns in [("free hinge", {}, []), ("hinge with losses", HINGE_LOSSES, hinge_unknowns())]:
        identification = flight_identification({**GUESS, **values}, [gravity(), *unknowns])
        result = fit(f"{title}, flights", identification, flights[::2])
        predict_flights(identification, result.values, flights[1::2])
        losses[title] = dict(zip(values, result.values[1:]))
    tosses = [toss for toss in tosses if flight_frame_count(toss) >= SHORTEST_FLIGHT]
    training, held_out = ([with_fitted_start(toss) for toss in subset] for subset in (tosses[: options.fit], tosses[-options.held_out :]))
    for title, values in losses.items():
        identification = contact_identification({**GUESS, **values}, [], MODEL_ERROR)
        result = fit(f"{title}, tosses", identification, [he.Trajectory(list(toss)[:FRAMES]) for toss in training])
        predict_tosses(identification, result.values, held_out)


def fit_simulation():
    """Fits all parameters to simulated tosses."""
    identification = contact_identification({**GUESS, **HINGE_LOSSES}, hinge_unknowns(), NOISE[:2])
    result = fit("simulated tosses", identification, list(simulated(TRUTH, 4)))
    truth = np.array(list(TRUTH.values()))
    assert ((result.intervals[:, 0] < truth) & (truth < result.intervals[:, 1])).all(), "the intervals contain the true values"


def contact_identification(values, unknowns, noise):
    """An identification of the parameters of the contact, and of further unknowns."""
    return he.Identification(world_of(values), PLAN, [*contact_unknowns(), *unknowns], noise=noise, cauchy=2.0)


options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
options.add_argument("--data", type=pathlib.Path, help="folder of elbow_tosses.csv")
options.add_argument("--fit", type=int, default=60, help="number of tosses that are fitted, from the first")
options.add_argument("--held-out", type=int, default=100, help="number of tosses that are predicted, up to the last")
options = options.parse_args()
if options.data:
    fit_recordings(options)
else:
    fit_simulation()
