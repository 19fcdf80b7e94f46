"""A ball at rest on a floor: steps per second, and the cost of derivatives of a rollout."""

import sys

import numpy
from poses import pose_numbers, rotation

TIME_STEP = 2e-4  # s
SETTLING_STEPS = 5000
BALLS = {2: 0.2, 3: 1.0}  # order of the mesh: mass (kg)
FLOORS = ["soft box", "rigid box", "half-space"]
MODULUS = 1e5  # Pa
DISSIPATION = 1.0  # s/m
FRICTION = 0.4
APPROXIMATIONS = ["sap", "similar", "lagged"]
OURS = "ours, leapfrog"
STEPS, DERIVATIVE_STEPS, ROUNDS = 500, 20, 5


def compare(programs, files):
    """Measures Drake's contact approximations and our leapfrog by turns, and prints a table."""
    print("\n| ball on floor | polygons | height (m) | steps per second | time of a step, of ours |"
          " with 12 derivatives: of a plain step | of ours |")
    print("|---|---|---|---|---|---|---|")
    for order in BALLS:
        for floor in FLOORS:
            print(f"ball of order {order} on a {floor} ...", file=sys.stderr)
            schemes = stepping_schemes(ball_scene(files, order, floor))
            plain = steps_by_turns(programs, schemes, STEPS, derivatives=0)
            differentiated = steps_by_turns(programs, schemes, DERIVATIVE_STEPS, derivatives=12)
            for name in schemes:
                print_row(f"order {order}, {floor}", name, plain, differentiated)


def stepping_schemes(scene):
    """Returns the program and the scene of each stepping scheme, by name."""
    schemes = {
        f"Drake, {name}": ("drake", {**scene, "approximation": name}) for name in APPROXIMATIONS
    }
    return {**schemes, OURS: ("ours", scene)}


def ball_scene(files, order, floor):
    """Returns a ball slightly above its rest position on a cube of edge 1 m, or on a half-space at the height of its upper side."""
    turn = rotation(numpy.array([0.3, -0.5, 0.2]))
    return {
        "ball": files[f"ball {order}"],
        "box": files["box"],
        "floor": floor,
        "start": pose_numbers(turn, numpy.array([0.02, 0.05, 0.596])),
        "radius": 0.1,
        "mass": BALLS[order],
        "modulus": MODULUS,
        "dissipation": DISSIPATION,
        "friction": FRICTION,
        "time_step": TIME_STEP,
        "settling_steps": SETTLING_STEPS,
    }


def steps_by_turns(programs, schemes, steps, derivatives):
    """Returns the answers of each scheme. The schemes take turns."""
    answers = {name: [] for name in schemes}
    for _ in range(ROUNDS):
        for name, (key, scene) in schemes.items():
            question = {"scene": scene, "steps": steps, "derivatives": derivatives}
            answers[name].append(programs[key].ask(ask="steps", **question))
    return answers


def print_row(scene, name, plain, differentiated):
    seconds, last = shortest_seconds(plain[name]), plain[name][-1]
    with_derivatives = shortest_seconds(differentiated[name])
    row = [
        f"{scene}: {name}",
        str(last["polygons"]),
        f"{last['height']:.6f}",
        f"{1 / seconds:,.0f}",
        f"**{seconds / shortest_seconds(plain[OURS]):.1f}**",
        f"{with_derivatives / seconds:.1f}",
        f"**{with_derivatives / shortest_seconds(differentiated[OURS]):.1f}**",
    ]
    print("| " + " | ".join(row) + " |")


def shortest_seconds(answers):
    return min(answer["seconds"] for answer in answers)
