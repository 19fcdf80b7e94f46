#!/usr/bin/env python3
"""Errors of values and of slopes against processor time, for this library, Drake and MuJoCo.

Helps to choose a program, a method and its accuracy for a given error. Run

    python3 benches/peers/accuracy.py            # about half an hour
    python3 benches/peers/accuracy.py --quick    # about five minutes
    python3 benches/peers/accuracy.py --scenes "stiff ball" grasp

The first run downloads Drake and MuJoCo into a virtual environment in cargo's target directory, which also stores references. README.md
describes the measurements. The output is Markdown and the plot `docs/figures/accuracy.svg` (in the target directory if the script has
options).
"""

import argparse
import dataclasses
import hashlib
import json
import os
import pathlib
import sys

from compare import HERE, REPOSITORY, Program, built_ours, enter_virtual_environment
from compare import target_directory

sys.dont_write_bytecode = True

# Tolerances of values and slopes, and resting speeds (m/s), of `Sdirk3`; 3e-4 is the default.
TOLERANCES = {
    1e-2: (1e-2, 2e-2, None),
    1e-3: (1e-3, 2e-3, None),
    3e-4: (3e-4, 2e-3, None),
    1e-4: (1e-4, 5e-4, None),
    1e-5: (1e-5, 1e-4, 0.03),
    1e-6: (1e-6, 3e-5, 0.03),
}
LONGEST_STEP = 5e-3  # s, with error control
STEPS = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4]  # s
SHORT_STEPS = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5]  # s
CHANGE = 1e-3  # SI units, to either side, for differences whose error is measured
WIDE_CHANGE = 5e-3  # SI units, for differences of references; the second width is half of this
LARGEST_DRIFT, LARGEST_SPREAD = 1e-3, 0.2  # m, relative: references above these are not converged
SHORT, LONG = 0.5, 3.0  # s: shorter measurements are repeated, longer ones are made once
MOST_ROUNDS = 5


@dataclasses.dataclass(frozen=True)
class Method:
    """A method of a program with its settings: accuracies or steps (s)."""

    program: str
    name: str
    has_error_control: bool
    settings: tuple
    # Settings of references: for short scenes, for longer scenes, and for long scenes with many polygons.
    references: tuple = ()
    # The default accuracy of the program, if it has one.
    default: float | None = None

    def coarser(self, setting):
        factor = 10 if self.has_error_control else 5
        return float(f"{factor * setting:.3g}")

    def question(self, scene, setting):
        step = LONGEST_STEP if self.has_error_control else setting
        accuracy = setting if self.has_error_control else None
        if self.program == "ours" and accuracy:
            accuracy = TOLERANCES[setting]
        steps = round(scene["duration"] / step)
        return {"method": self.name, "time_step": step, "steps": steps, "accuracy": accuracy}


METHODS = [
    Method("ours", "sdirk3", True, (1e-2, 1e-3, 3e-4, 1e-4, 1e-5), (1e-6, 1e-6, 1e-6), 3e-4),
    Method("ours", "implicit_euler", False, tuple(STEPS)),
    Method("ours", "leapfrog", False, tuple(SHORT_STEPS), (2e-6, 2e-6, 5e-6)),
    Method("drake", "cenic", True, (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7), (1e-11, 1e-9, 1e-7), 1e-4),
    Method("drake", "sap", False, tuple(STEPS), (5e-6, 2e-5, 2e-4)),
    Method("mujoco", "euler", False, tuple(STEPS + SHORT_STEPS[3:5]), (2e-6, 2e-6, 2e-5)),
]


def main():
    options = parsed_options()
    target = target_directory()
    os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")})
    enter_virtual_environment(target / "peers_environment")
    # accuracy_tables needs numpy and matplotlib, which the virtual environment provides.
    import accuracy_tables
    import rollout_scenes

    scenes = rollout_scenes.Builder(target / "peers_meshes").scenes()
    names = options.scenes or list(scenes)
    sides = {name: [sys.executable, HERE / f"{name}_rollouts.py"] for name in ("drake", "mujoco")}
    ours = [built_ours("peers_rollouts"), "--serve"]
    with Program(ours) as ours, Program(sides["drake"]) as drake, Program(sides["mujoco"]) as mujoco:
        programs = {"ours": ours, "drake": drake, "mujoco": mujoco}
        study = Study(programs, target / "peers_references", options.quick)
        results = {name: study.measured(name, scenes[name]) for name in names}
    accuracy_tables.print_all(results, scenes)
    folder = target if options.quick or options.scenes else REPOSITORY / "docs/figures"
    accuracy_tables.plot(results, folder / "accuracy.svg")


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--quick", action="store_true", help="fewer settings, coarser references")
    options.add_argument("--scenes", nargs="+", help="names of scenes (default: all)")
    return options.parse_args()


class Study:
    """Sends the scenes to the programs and rates their answers."""

    def __init__(self, programs, references, is_quick):
        self.programs, self.references, self.is_quick = programs, references, is_quick
        references.mkdir(exist_ok=True)

    def measured(self, name, scene):
        """Returns the reference of each method, and its errors and times by setting."""
        found = {}
        for method in METHODS:
            print(f"{name}, reference of {method.name} ...", file=sys.stderr)
            found[method] = {"reference": self.reference(method, scene), "rows": {}}
        jobs = [(method, setting) for method in METHODS for setting in self.settings(method, scene)]
        for job, answers in self.by_turns(name, scene, jobs).items():
            method, setting = job
            found[method]["rows"][setting] = rated(answers, found[method]["reference"], scene)
        return found

    def settings(self, method, scene):
        """Returns the settings that are at least twice as coarse as that of the reference."""
        settings = method.settings[:-1] if self.is_quick else method.settings
        if not method.references:
            return settings
        finest = 2 * self.reference_setting(method, scene)
        return [setting for setting in settings if setting >= finest]

    def reference_setting(self, method, scene):
        is_long, has_many = scene["duration"] > 0.5, len(scene["question"]["bodies"]) > 2
        setting = method.references[is_long + has_many]
        return method.coarser(setting) if self.is_quick else setting

    def by_turns(self, name, scene, jobs):
        """Returns values and slopes of each job with the shortest times (s). The programs take turns, so other load on the processor
        affects all of them."""
        answers, times, waiting, turn = {}, {job: [] for job in jobs}, jobs, 0
        while waiting:
            turn += 1
            print(f"{name}, round {turn}, {len(waiting)} measurements ...", file=sys.stderr)
            for job in waiting:
                values, slopes = self.asked(*job, scene), self.slopes(*job, scene)
                times[job].append((values[0], slopes[0]))
                seconds = [min(each) for each in zip(*times[job])]
                answers[job] = [(seconds[0], values[1]), (seconds[1], slopes[1])]
            waiting = [job for job in waiting if needs_more([sum(both) for both in times[job]])]
        return answers

    def slopes(self, method, setting, scene):
        """Returns the processor time (s) and the slopes (SI units, one column per parameter)."""
        if method.program == "ours":
            seconds, _, jacobian = self.asked(method, setting, scene, parameters=scene["parameters"])
            return seconds, jacobian
        return self.differences(method, setting, scene, CHANGE)

    def differences(self, method, setting, scene, change):
        """Returns the time (s) and the slopes by central differences."""
        import numpy

        total, columns = 0.0, []
        for parameter in scene["parameters"]:
            changes = [(parameter, sign * change) for sign in (-1, 1)]
            low, high = (self.asked(method, setting, scene, each) for each in changes)
            total += low[0] + high[0]
            if low[1] is None or high[1] is None:
                return total, None
            columns.append((high[1] - low[1]) / (2 * change))
        return total, numpy.array(columns).T

    def asked(self, method, setting, scene, change=None, parameters=()):
        """Returns the processor time (s), the measured positions (m) and, with parameters, their slopes. Returns `None` if the rollout
        failed."""
        import rollout_scenes

        question = scene["question"]
        if change:
            question = rollout_scenes.changed(question, *change)
        answer = self.programs[method.program].ask(
            scene=question, parameters=parameters, **method.question(scene, setting)
        )
        if answer["positions"] is None:
            return answer["seconds"], None, None
        numbers = [answer["positions"], answer.get("jacobian") or answer["positions"]]
        return answer["seconds"], *(rollout_scenes.measured_rows(scene, rows) for rows in numbers)

    def reference(self, method, scene):
        """Returns values and slopes of the program's own converged motion, cached in a file. All methods of this library share one
        reference. `drift` is the distance (m) from the values at a coarser setting. The slopes are extrapolated from differences of two
        widths, and `spread` is the relative difference between them."""
        import numpy

        if method.program == "ours":
            names = {each.name: each for each in METHODS}
            method = names[scene["our_reference"]]
        setting = self.reference_setting(method, scene)
        file = self.reference_file(method, scene, setting)
        if not file.exists():
            values = self.asked(method, setting, scene)[1]
            coarse_values = self.asked(method, method.coarser(setting), scene)[1]
            changes = (WIDE_CHANGE, WIDE_CHANGE / 2)
            widths = [self.differences(method, setting, scene, change)[1] for change in changes]
            if any(found is None for found in (values, coarse_values, *widths)):
                return None
            slopes = (4 * widths[1] - widths[0]) / 3
            numbers = {"values": values.tolist(), "slopes": slopes.tolist()}
            numbers["drift"] = distance(values, coarse_values, scene)
            numbers["spread"] = relative_error(*widths)
            file.write_text(json.dumps(numbers))
        numbers = json.loads(file.read_text())
        return {name: numpy.array(number) for name, number in numbers.items()}

    def reference_file(self, method, scene, setting):
        """Returns a path whose name is a hash of everything on which the reference depends."""
        files = [pathlib.Path(word) for word in self.programs[method.program].process.args]
        question = [scene, method.question(scene, setting), method.coarser(setting), WIDE_CHANGE]
        digest = hashlib.sha256(json.dumps(question).encode())
        # The executable of this library, or the script of the other program.
        digest.update((files[0] if method.program == "ours" else files[1]).read_bytes())
        return self.references / f"{digest.hexdigest()[:16]}.json"


def needs_more(times):
    if len(times) < 2:
        return times[0] < LONG
    return sum(times) < SHORT and len(times) < MOST_ROUNDS


def rated(answers, reference, scene):
    """Returns times (s), and errors of values (m, root mean square over bodies) and of slopes (relative). An error is `None` if the rollout
    failed or the reference is not converged."""
    times, (values, slopes) = zip(*answers)
    row = {"seconds": times, "errors": [None, None]}
    if reference is None or reference["drift"] > LARGEST_DRIFT:
        return row
    if values is not None:
        row["errors"][0] = distance(values, reference["values"], scene)
    if slopes is not None and reference["spread"] <= LARGEST_SPREAD:
        row["errors"][1] = relative_error(slopes, reference["slopes"])
    return row


def distance(values, others, scene):
    """Returns the root mean square over the bodies of the distance (m) between their positions."""
    import numpy

    return float(numpy.linalg.norm(values - others) / len(scene["measured"][0]) ** 0.5)


def relative_error(slopes, reference):
    """Returns the root mean square over the columns of the relative error of a column."""
    import numpy

    norms = numpy.linalg.norm(slopes - reference, axis=0) / numpy.linalg.norm(reference, axis=0)
    return float(numpy.sqrt(numpy.mean(norms**2)))


if __name__ == "__main__":
    main()
