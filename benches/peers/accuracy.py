#!/usr/bin/env python3
"""Speed against error, here and in Drake: four scenes, steps from 0.1 to 10 ms, one thread each.

Serves the decision which program, integrator and step to take for an error small enough. Run

    python3 benches/peers/accuracy.py            # ten minutes to an hour, most of it Drake's references
    python3 benches/peers/accuracy.py --quick    # half of that
    python3 benches/peers/accuracy.py --ours     # this library alone

The first run downloads Drake into a virtual environment in cargo's target directory, where Drake's
references are kept too. What is measured says README.md. Output: Markdown, and the plot
`docs/figures/accuracy.svg` (with --quick in the target directory).
"""

import argparse
import hashlib
import json
import math
import os
import statistics
import sys
from concurrent.futures import ThreadPoolExecutor

from compare import HERE, REPOSITORY, Program, built_ours, enter_virtual_environment
from compare import target_directory

sys.dont_write_bytecode = True

STEPS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2]  # s
# Explicit steps must be short beside the stiffest contact.
EXPLICIT_STEPS = [1e-5, 2e-5, 5e-5, *STEPS]
# The names of our integrators, as rollouts.rs has them, with their steps.
OURS = {"leapfrog": EXPLICIT_STEPS, "sdirk3": STEPS, "implicit_euler": STEPS}
DRAKE = {approximation: STEPS for approximation in ("tamsi", "sap", "similar", "lagged")}
# All of ours share a reference, each approximation of Drake has its own.
OUR_REFERENCE = "leapfrog"
# Shorter ones (s) take minutes where many polygons meet; the leapfrog needs them.
SHORTEST = {"stack of five cubes": 2e-4, "grasp": 2e-4}
QUICK_REFERENCE = 5  # times as long
QUICK_SHORTEST = {"ours": 5e-5, "drake": 5e-4}
DRAKE_SIDE = [sys.executable, HERE / "drake_rollouts.py"]
SHORT = 1.0  # s: shorter rollouts are timed as often as fit into this, at least twice
LONG = 6.0  # s: longer ones are timed once
MOST_ROUNDS = 8


def main():
    options = parsed_options()
    target = target_directory()
    enter_virtual_environment(target / "peers_environment")
    # These need numpy and matplotlib, which the virtual environment has.
    import accuracy_tables
    import rollout_scenes

    scenes = rollout_scenes.Builder(target / "peers_meshes").groups()
    names = options.scenes or list(scenes)
    with Program([built_ours("peers_rollouts"), "--serve"]) as ours, Program(DRAKE_SIDE) as drake:
        study = Study({"ours": ours, "drake": drake}, target / "peers_references", options)
        study.prepare([scenes[name] for name in names])
        results = {name: study.measured(name, scenes[name]) for name in names}
    accuracy_tables.print_all(results)
    in_part = options.quick or options.ours or options.scenes
    folder = target if in_part else REPOSITORY / "docs/figures"
    accuracy_tables.plot(results, folder / "accuracy.svg")


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--quick", action="store_true", help="longer steps, coarser references")
    options.add_argument("--ours", action="store_true", help="without Drake")
    options.add_argument("--scenes", nargs="+", help="names of scenes (default: all)")
    return options.parse_args()


class Study:
    """Asks both programs about scenes."""

    def __init__(self, programs, references, options):
        self.programs, self.references, self.options = programs, references, options
        self.own_references = {}
        references.mkdir(exist_ok=True)

    def methods(self, name):
        """Program, method and steps in a scene."""
        of_programs = {"ours": OURS} if self.options.ours else {"ours": OURS, "drake": DRAKE}
        quick = QUICK_SHORTEST if self.options.quick else {"ours": 0.0, "drake": 0.0}
        for key, methods in of_programs.items():
            for method, steps in methods.items():
                of_scene = 0.0 if steps is EXPLICIT_STEPS else SHORTEST.get(name, 0.0)
                shortest = max(quick[key], of_scene)
                yield key, method, [step for step in steps if step >= shortest]

    def measured(self, name, scenes):
        """Of each method: the reference, and speed and error by the step."""
        print(f"{name}, references ...", file=sys.stderr)
        found, methods_of = {}, {}
        for key, method, steps in self.methods(name):
            reference = [self.reference(key, method, scene) for scene in scenes]
            found[key, method] = {"reference": reference, "rows": {}}
            for step in steps:
                methods_of.setdefault(step, []).append((key, method))
        for step, methods in sorted(methods_of.items()):
            print(f"{name}, {1e3 * step:g} ms ...", file=sys.stderr)
            for method, (seconds, measured) in self.timed(methods, scenes, step).items():
                of_method = found[method]
                row = rated(scenes, seconds, measured, of_method["reference"])
                of_method["rows"][step] = row
        return found

    def reference(self, key, method, scene):
        """What is measured of the scene, by the program's own short steps. Drake's, which take
        long, are kept in files, named by all that they depend on."""
        if key == "ours":
            return self.own_reference(scene)
        file = self.reference_file(method, scene)
        if not file.exists():
            with Program(DRAKE_SIDE) as own:
                step = self.reference_step(key, scene)
                measured = asked(own, method, scene, step)[1]
            file.write_text(json.dumps(measured))
        return json.loads(file.read_text())

    def own_reference(self, scene):
        question = json.dumps(scene)
        if question not in self.own_references:
            step = self.reference_step("ours", scene)
            self.own_references[question] = self.rollout("ours", OUR_REFERENCE, scene, step)[1]
        return self.own_references[question]

    def reference_step(self, key, scene):
        return scene["reference_steps"][key] * (QUICK_REFERENCE if self.options.quick else 1)

    def reference_file(self, method, scene):
        program = DRAKE_SIDE[-1].read_text()
        question = json.dumps([program, method, scene, self.reference_step("drake", scene)])
        return self.references / (hashlib.sha256(question.encode()).hexdigest()[:16] + ".json")

    def prepare(self, groups):
        """Computes Drake's references, on all cores: they are not timed."""
        if self.options.ours:
            return
        wanted = [(method, scene) for scenes in groups for scene in scenes for method in DRAKE]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(lambda each: self.reference("drake", *each), wanted))

    def timed(self, methods, scenes, step):
        """Of each method: the shortest time (s) of several rounds of the scenes, and what was
        measured. The methods, and so the programs, take turns: what else the cores do meets
        all of them."""
        times, measured = {method: [] for method in methods}, {}
        waiting = methods
        while waiting:
            for method in waiting:
                answers = [self.rollout(*method, scene, step) for scene in scenes]
                times[method].append(sum(seconds for seconds, _ in answers))
                measured[method] = [positions for _, positions in answers]
            waiting = [method for method in waiting if needs_more(times[method])]
        return {method: (min(times[method]), measured[method]) for method in methods}

    def rollout(self, key, method, scene, step):
        return asked(self.programs[key], method, scene, step)


def needs_more(times):
    if len(times) < 2:
        return times[0] < LONG
    return sum(times) < SHORT and len(times) < MOST_ROUNDS


def rated(scenes, seconds, measured, references):
    """Simulated seconds per second, and the error (m): root mean square over the scenes and their
    bodies; nothing if a rollout failed."""
    if None in measured or None in references:
        return None
    squares = []
    for positions, reference in zip(measured, references):
        squares += [math.dist(*both) ** 2 for both in zip(positions, reference)]
    duration = sum(scene["duration"] for scene in scenes)
    return {"speed": duration / seconds, "error": math.sqrt(statistics.fmean(squares))}


def asked(program, method, scene, step):
    """The time (s) of a rollout, and what is measured after it; nothing if it failed."""
    import rollout_scenes

    steps = round(scene["duration"] / step)
    answer = program.ask(scene=scene["question"], method=method, time_step=step, steps=steps)
    if answer["positions"] is None:
        print(f"{method}, {1e3 * step:g} ms: {answer['failure'][:100]}", file=sys.stderr)
        return answer["seconds"], None
    measured = rollout_scenes.measured_positions(scene, answer["positions"])
    return answer["seconds"], measured.tolist()


if __name__ == "__main__":
    main()
