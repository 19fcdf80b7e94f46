#!/usr/bin/env python3
"""Gradient of a long rollout with contact with respect to 1,000 controls, in this library and in MuJoCo MJX.

Helps to choose a program for optimizing controls through contact and friction. Measures the cost of a gradient, in time and in rollouts,
and its error. Run

    python3 benches/peers/gradients.py            # three minutes to a quarter of an hour, most of it compilation in JAX
    python3 benches/peers/gradients.py --quick    # a tenth of the steps and controls

The first run downloads MJX into a virtual environment in cargo's target directory. README.md describes the measurements. The output is
Markdown.
"""

import argparse
import math
import os
import sys

from compare import Program, built_ours, enter_virtual_environment, target_directory

sys.dont_write_bytecode = True

REQUIREMENTS = ["mujoco-mjx==3.17.0", "mujoco==4.0.0", "jax==0.10.2", "numpy"]
STEPS, STEPS_AN_INTERVAL, SETTLING_STEPS = 1000, 2, 500
QUICK_STEPS = 100
SCENE = {
    "size": [0.2, 0.2, 0.1],  # m
    "mass": 1.0,  # kg
    "modulus": 1e6,  # Pa
    "dissipation": 1.0,  # s/m
    "friction": 0.3,
    "slip_tolerance": 1e-2,  # m/s
    "gravity": 9.81,  # m/s²
    "time_step": 1e-3,  # s
    "settling_steps": SETTLING_STEPS,
    "goal": [0.5, 0.1],  # m
}
PUSH = [5.0, 1.0]  # N, in the first half; friction brings the block to rest in the second half
ROUNDS = 5
COLUMNS = 24  # number of controls whose derivatives are compared with differences
DIFFERENCE = 1e-3  # N, step of the differences with which gradients are compared
PLAIN_DIFFERENCES = [1e-1, 1e-2, 1e-3, 1e-4]  # N; the table has the best of these


def main():
    options = parsed_options()
    enter_virtual_environment(target_directory() / "peers_mjx_environment", REQUIREMENTS)
    # Both programs use one core, and at most one thread.
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    # The virtual environment provides numpy, and JAX for mjx_side.
    import mjx_side
    import numpy

    steps = QUICK_STEPS if options.quick else STEPS
    scene = {**SCENE, "steps": steps, "intervals": steps // STEPS_AN_INTERVAL}
    pushes = numpy.zeros((scene["intervals"], 2))
    pushes[: scene["intervals"] // 2] = PUSH
    with Program([built_ours("peers_gradients"), "--serve"]) as program:
        ways = [Ours(program, scene), *mjx_side.ways(scene)]
        mjx_side.print_default(scene, pushes)
        print_all(ways, by_turns(ways, pushes), pushes)


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--quick", action="store_true", help="a tenth of the steps and controls")
    return options.parse_args()


class Ours:
    """This library, in reverse mode."""

    name = "ours, swept back"
    compilation = 0.0

    def __init__(self, program, scene):
        self.program = program
        self.height = program.ask(**scene)["height"]

    def value(self, pushes):
        return self.asked(pushes, False)

    def gradient(self, pushes):
        return self.asked(pushes, True)

    def asked(self, pushes, derivatives):
        return self.program.ask(pushes=pushes.tolist(), derivatives=derivatives)


def by_turns(ways, pushes):
    """Returns, for each variant, the shortest times of a value and of a gradient, with their results."""
    answers = [{"value": [], "gradient": []} for _ in ways]
    for _ in range(ROUNDS):
        for way, found in zip(ways, answers):
            found["value"].append(way.value(pushes))
            found["gradient"].append(way.gradient(pushes))
    return [{what: shortest(replies) for what, replies in found.items()} for found in answers]


def shortest(replies):
    return min(replies, key=lambda reply: reply["seconds"])


def print_all(ways, answers, pushes):
    print(f"\n{pushes.size:,} controls; errors are the largest of {COLUMNS}, of the largest derivative:\n")
    print("| | end (m) | a rollout | gradient | in rollouts | its error | by differences | their"
          " error | compilation |")
    print("|---|---|---|---|---|---|---|---|---|")
    for way, answer in zip(ways, answers):
        value, gradient = answer["value"]["seconds"], answer["gradient"]["seconds"]
        x, y, _ = answer["value"]["end"]
        error, best_step, their_error = errors(way, answer["gradient"]["gradient"], pushes)
        row = [
            way.name,
            f"{x:.4f}, {y:.4f}",
            time(value),
            time(gradient),
            f"**{gradient / value:.1f}**",
            "not finite" if math.isnan(error) else f"{error:.0e}",
            time(2 * pushes.size * value),
            "" if math.isnan(error) else f"{their_error:.0e} ({best_step:g} N)",
            time(way.compilation) if way.compilation else "–",
        ]
        print("| " + " | ".join(row) + " |", flush=True)


def errors(way, gradient, pushes):
    """Returns the error of the gradient relative to fourth-order differences, the best step (N) of central differences, and their error
    relative to the gradient."""
    import numpy

    columns = numpy.linspace(0, pushes.size - 1, COLUMNS).astype(int)
    scale, slope = numpy.abs(gradient).max(), numpy.ravel(gradient)[columns]
    steps = [*PLAIN_DIFFERENCES, 2 * DIFFERENCE]
    found = {step: differences(way, pushes, columns, step) for step in steps}
    reference = (4 * found[DIFFERENCE] - found[2 * DIFFERENCE]) / 3
    theirs = {step: numpy.abs(found[step] - slope).max() / scale for step in PLAIN_DIFFERENCES}
    best = min(theirs, key=theirs.get)
    return numpy.abs(slope - reference).max() / scale, best, theirs[best]


def differences(way, pushes, columns, step):
    """Returns central differences of the loss with respect to some controls."""
    import numpy

    found = []
    for column in columns:
        beside = []
        for sign in (1, -1):
            changed = pushes.copy()
            changed.flat[column] += sign * step
            beside.append(way.value(changed)["loss"])
        found.append((beside[0] - beside[1]) / (2 * step))
    return numpy.array(found)


def time(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.1e} s"


if __name__ == "__main__":
    main()
