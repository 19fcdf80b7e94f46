"""Wrenches of two posed meshes and their derivatives: time and accuracy of each program."""

import statistics
import sys

import numpy
from poses import DIFFERENCE, neighbors, random_poses

MODULUS = 1e5  # Pa
DISTANCES = [1.0, 1.7]  # m, between the centers of two spheres of radius 1 m
GRID_DISTANCE = 0.9  # m, between the centers of two cubes of edge 1 m
FAR = 10.0  # m
POSES = {1: 60, 2: 30, 3: 10, 4: 3, "grid": 10}
COLD_BATCH = 5  # poses; between batches the other program fills the caches
ROUNDS = {"wrench": 3, "jacobian": 2}

OFF = 1e-6  # of the largest entry: derivatives with a larger error count as wrong
SAME = 1e-12  # of the largest entry: wrenches that differ more come from different fields


def compare(programs, files, options):
    """Measures all scenes and prints a table of times and a table of errors."""
    batch = COLD_BATCH if options.cold else None
    results = [compared(programs, batch, *scene) for scene in contact_scenes(files, options)]
    print_times(results)
    print_without_contact(programs, batch, files["grid"])
    print_errors(results)


def contact_scenes(files, options):
    """Yields name, meshes, center distance (m) and number of poses of each scene."""
    for order in options.orders:
        for distance in DISTANCES:
            name = f"icosphere {order} ({20 * 4**order:,}), {distance}"
            yield name, files[f"sphere {order}"], distance, options.poses or POSES.get(order, 2)
    count = options.poses or POSES["grid"]
    yield f"layered cube (3,072), {GRID_DISTANCE}", files["grid"], GRID_DISTANCE, count


def compared(programs, batch, name, mesh, distance, count):
    """Returns all measurements of a scene, by question and program."""
    print(f"{name} ...", file=sys.stderr)
    generator = numpy.random.default_rng(20 + int(10 * distance))
    poses = [random_poses(generator, distance) for _ in range(count)]
    scene = {"meshes": [mesh, mesh], "modulus": MODULUS}
    answers = {ask: asked(programs, ask, scene, poses, batch) for ask in ("wrench", "jacobian")}
    found = {key: numpy.array(answers["wrench"][key]["wrenches"]) for key in programs}
    scale = abs(found["ours"]).max(axis=1, keepdims=True)
    difference = (abs(found["drake"] - found["ours"]) / scale).max()
    if not difference <= SAME:
        sys.exit(f"{name}: the wrenches differ by {difference:.1e}")
    errors = {
        key: derivative_errors(program, scene, poses, answers["jacobian"][key]["jacobians"])
        for key, program in programs.items()
    }
    return {"name": name, "answers": answers, "difference": difference, "errors": errors}


def asked(programs, ask, scene, poses, batch):
    """Returns the answers of each program for all poses, with the shortest of several times for each pose. The programs take turns every
    `batch` poses. If `batch` is `None`, each program gets all poses at once."""
    rounds = ROUNDS[ask]
    questions = poses * rounds
    batch = min(batch, len(poses)) if batch else len(questions)
    together = {key: {} for key in programs}
    for first in range(0, len(questions), batch):
        for key, program in programs.items():
            answer = program.ask(ask=ask, scene=scene, poses=questions[first : first + batch])
            for what, entries in answer.items():
                together[key].setdefault(what, []).extend(entries)
    for answers in together.values():
        seconds = numpy.reshape(answers["seconds"], (rounds, len(poses)))
        for what, entries in answers.items():
            answers[what] = entries[: len(poses)]
        answers["seconds"] = seconds.min(axis=0).tolist()
    return together


def derivative_errors(program, scene, poses, jacobians):
    """Returns, for each pose, the largest error relative to central differences of the program's own wrench, over the largest entry."""
    errors = []
    for both, jacobian in zip(poses, jacobians):
        answer = program.ask(ask="wrench", scene=scene, poses=neighbors(both))
        wrenches = numpy.array(answer["wrenches"])
        differences = (wrenches[1::2] - wrenches[0::2]).T / (2 * DIFFERENCE)
        errors.append(abs(jacobian - differences).max() / abs(differences).max())
    return errors


def print_times(results):
    print("| mesh (tetrahedra each), distance | polygons | wrench: Drake | ours | ratio |"
          " with 12 derivatives: Drake | ours | ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for result in results:
        polygons = statistics.median(result["answers"]["wrench"]["ours"]["polygons"])
        row = [result["name"], f"{polygons:,.0f}"]
        for ask in ("wrench", "jacobian"):
            row += ratio_columns(result["answers"][ask])
        print("| " + " | ".join(row) + " |")


def print_without_contact(programs, batch, mesh):
    """Prints the minimum time of a call, measured with bodies far apart."""
    generator = numpy.random.default_rng(1)
    poses = [random_poses(generator, FAR) for _ in range(50)]
    scene = {"meshes": [mesh, mesh], "modulus": MODULUS}
    for ask, words in [("wrench", "a wrench"), ("jacobian", "12 derivatives")]:
        drake, ours, _ = ratio_columns(asked(programs, ask, scene, poses, batch))
        print(f"\nOf two bodies far apart, {words}: Drake {drake}, ours {ours}.")


def print_errors(results):
    print("\n| mesh, distance | poses | wrenches differ by | derivatives off: Drake |"
          " worst | ours | worst |")
    print("|---|---|---|---|---|---|---|")
    for result in results:
        errors = result["errors"]
        row = [result["name"], str(len(errors["ours"])), f"{result['difference']:.0e}"]
        for key in ("drake", "ours"):
            off = sum(not error <= OFF for error in errors[key])
            row += [f"{off} ({off / len(errors[key]):.0%})", f"{max(errors[key]):.0e}"]
        print("| " + " | ".join(row) + " |")


def ratio_columns(answers):
    """Returns Drake's median time, ours, and the ratio."""
    drake, ours = (statistics.median(answers[key]["seconds"]) for key in ("drake", "ours"))
    return [duration(drake), duration(ours), f"**{drake / ours:.1f}**"]


def duration(seconds):
    """Formats a time in ms, or in µs if short, with three digits or all digits before the decimal point."""
    number, unit = (1e3 * seconds, "ms") if seconds >= 1e-3 else (1e6 * seconds, "µs")
    return f"{number:,.0f} {unit}" if number >= 100 else f"{number:.3g} {unit}"
