#!/usr/bin/env python3
"""Contact here beside contact in Drake: the same meshes, fields and poses, one thread each.

Serves the decision whether to use this library or Drake where contact must be fast or its
derivatives right: how many times as long Drake takes, and what its answers are worth. Run

    python3 benches/peers/compare.py            # under five minutes after the first run
    python3 benches/peers/compare.py --quick    # about a minute
    python3 benches/peers/compare.py --orders 1 2 --poses 100

The first run downloads Drake into a virtual environment in cargo's target directory. The two
programs stay up side by side and are asked by turns; what is timed says README.md. Output: Markdown.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import venv

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
REQUIREMENTS = ["drake==1.51.1", "numpy"]

MODULUS = 1e5  # Pa
DISTANCES = [1.0, 1.7]  # m, between the centres of two spheres of radius 1 m
GRID_DISTANCE = 0.9  # m, between the centres of two cubes of edge 1 m
POSES = {1: 60, 2: 30, 3: 10, 4: 3, "grid": 10}
BATCH = 10

DIFFERENCE = 1e-6  # m and rad, to either side
OFF = 1e-6  # of the largest entry: a derivative further off its differences counts as wrong
SAME = 1e-9  # of the largest entry: wrenches must agree to this, or the programs differ in fields

TIME_STEP = 2e-4  # s
BALLS = {2: 0.2, 3: 1.0}  # order of the mesh: mass (kg)
APPROXIMATIONS = ["tamsi", "sap", "similar", "lagged"]
STEPS, DERIVATIVE_STEPS, ROUNDS = 500, 50, 5


def main():
    options = parsed_options()
    target = target_directory()
    enter_virtual_environment(target / "peers_environment")
    files = written_meshes(target / "peers_meshes", options.orders)
    with Program([built_ours(), "--serve"]) as ours, Program(
        [sys.executable, HERE / "drake_side.py"]
    ) as drake:
        programs = {"drake": drake, "ours": ours}
        scenes = contact_scenes(files, options)
        print_contact_tables([compared(programs, *scene) for scene in scenes])
        print_step_table([compared_steps(programs, files, order) for order in BALLS])


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--orders", type=int, nargs="+", default=[1, 2, 3, 4], help="of icospheres")
    options.add_argument("--poses", type=int, help="per scene (default: more where they are cheap)")
    options.add_argument("--quick", action="store_true", help="orders up to 3 and few poses")
    options = options.parse_args()
    if options.quick:
        options.orders = [order for order in options.orders if order < 4]
        options.poses = options.poses or 5
    return options


# Both programs.


def target_directory():
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1"]
    metadata = subprocess.run(command, cwd=REPOSITORY, check=True, capture_output=True).stdout
    return pathlib.Path(json.loads(metadata)["target_directory"])


def enter_virtual_environment(folder):
    """Starts this script again inside the virtual environment, made if it is not there."""
    python = folder / "bin" / "python"
    if pathlib.Path(sys.prefix) == folder:
        return
    if not (folder / "installed").exists():
        venv.create(folder, with_pip=True, clear=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *REQUIREMENTS], check=True)
        (folder / "installed").touch()
    os.execv(python, [python, *sys.argv])


def built_ours():
    """The path of our side, built in release mode and without threads."""
    command = ["cargo", "bench", "--no-run", "--bench", "peers_ours", "--no-default-features"]
    command += ["--message-format", "json-render-diagnostics"]
    build = subprocess.run(command, cwd=REPOSITORY, check=True, stdout=subprocess.PIPE)
    messages = [json.loads(line) for line in build.stdout.splitlines()]
    return next(message["executable"] for message in messages if message.get("executable"))


class Program:
    """A child process that answers questions, a JSON line each."""

    def __init__(self, command):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, **pipes)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()

    def ask(self, **question):
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit(f"{self.process.args[0]} ended without an answer")
        return json.loads(answer)


def written_meshes(folder, orders):
    """Paths of the mesh files, by name."""
    import meshes

    folder.mkdir(exist_ok=True)
    wanted = {f"sphere {order}": meshes.icosphere(1.0, order) for order in orders}
    wanted |= {f"ball {order}": meshes.icosphere(0.1, order) for order in BALLS}
    wanted |= {"grid": meshes.layered_cube(1.0, 8), "box": meshes.cube(1.0)}
    paths = {name: folder / f"{name.replace(' ', '_')}.vtk" for name in wanted}
    for name, path in paths.items():
        meshes.write_vtk(path, wanted[name])
    return {name: str(path) for name, path in paths.items()}


# Poses.


def random_poses(generator, distance):
    """Two bodies turned at random, their centres a distance apart in a random direction."""
    import numpy

    center = generator.normal(size=3)
    apart = generator.normal(size=3)
    apart *= distance / numpy.linalg.norm(apart)
    turns = [rotation(generator.normal(size=3) * 2.0) for _ in range(2)]
    return [pose_numbers(turns[0], center), pose_numbers(turns[1], center + apart)]


def pose_numbers(turn, origin):
    return [*turn.ravel().tolist(), *origin.tolist()]


def rotation(vector):
    """The rotation by a rotation vector (rad)."""
    import numpy

    angle = numpy.linalg.norm(vector)
    x, y, z = vector / angle
    axis = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + numpy.sin(angle) * axis + (1 - numpy.cos(angle)) * axis @ axis


def neighbours(poses):
    """The poses with each of twelve numbers a little less, then a little more."""
    import numpy

    moved = []
    for body in range(2):
        turn, origin = numpy.reshape(poses[body][:9], (3, 3)), numpy.array(poses[body][9:])
        for column in range(6):
            for step in (-DIFFERENCE, DIFFERENCE):
                by = step * numpy.eye(3)[column % 3]
                now = (rotation(by) @ turn, origin) if column < 3 else (turn, origin + by)
                both = list(poses)
                both[body] = pose_numbers(*now)
                moved.append(both)
    return moved


# Contact.


def contact_scenes(files, options):
    """Name, meshes, centre distance (m) and number of poses of each scene."""
    for order in options.orders:
        for distance in DISTANCES:
            name = f"icosphere {order} ({20 * 4**order:,}), {distance}"
            yield name, files[f"sphere {order}"], distance, options.poses or POSES.get(order, 3)
    count = options.poses or POSES["grid"]
    yield f"layered cube (3,072), {GRID_DISTANCE}", files["grid"], GRID_DISTANCE, count


def compared(programs, name, mesh, distance, count):
    """All that is measured of a scene, by what is asked and the program asked."""
    import numpy

    print(f"{name} ...", file=sys.stderr)
    generator = numpy.random.default_rng(20 + int(10 * distance))
    poses = [random_poses(generator, distance) for _ in range(count)]
    scene = {"meshes": [mesh, mesh], "modulus": MODULUS}
    answers = {ask: by_turns(programs, ask, scene, poses) for ask in ("wrench", "jacobian")}
    found = {key: numpy.array(answers["wrench"][key]["wrenches"]) for key in programs}
    scale = abs(found["ours"]).max(axis=1, keepdims=True)
    difference = (abs(found["drake"] - found["ours"]) / scale).max()
    if difference > SAME:
        print(f"{name}: the wrenches differ by {difference:.1e}", file=sys.stderr)
    errors = {
        key: derivative_errors(program, scene, poses, answers["jacobian"][key]["jacobians"])
        for key, program in programs.items()
    }
    return {"name": name, "answers": answers, "difference": difference, "errors": errors}


def by_turns(programs, ask, scene, poses):
    """Answers of each program about all poses, asked in batches by turns."""
    together = {key: {} for key in programs}
    for first in range(0, len(poses), BATCH):
        for key, program in programs.items():
            answer = program.ask(ask=ask, scene=scene, poses=poses[first : first + BATCH])
            for what, entries in answer.items():
                together[key].setdefault(what, []).extend(entries)
    return together


def derivative_errors(program, scene, poses, jacobians):
    """For each pose the largest error against central differences of the program's own wrench, of
    the largest entry."""
    import numpy

    errors = []
    for both, jacobian in zip(poses, jacobians):
        answer = program.ask(ask="wrench", scene=scene, poses=neighbours(both))
        wrenches = numpy.array(answer["wrenches"])
        differences = (wrenches[1::2] - wrenches[0::2]).T / (2 * DIFFERENCE)
        errors.append(abs(jacobian - differences).max() / abs(differences).max())
    return errors


def print_contact_tables(results):
    print("| mesh (tetrahedra each), distance | polygons | wrench: Drake | ours | ratio |"
          " with 12 derivatives: Drake | ours | ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for result in results:
        polygons = statistics.median(result["answers"]["wrench"]["ours"]["polygons"])
        row = [result["name"], f"{polygons:,.0f}"]
        for ask in ("wrench", "jacobian"):
            row += ratio_columns(result["answers"][ask])
        print("| " + " | ".join(row) + " |")
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
    """Drake's median time, ours, and the ratio."""
    drake, ours = (statistics.median(answers[key]["seconds"]) for key in ("drake", "ours"))
    return [f"{1e3 * drake:.3g} ms", f"{1e3 * ours:.3g} ms", f"**{drake / ours:.1f}**"]


# Steps.


def compared_steps(programs, files, order):
    """Times of steps of Drake by each approximation (with derivatives: by the fastest) and ours."""
    print(f"ball of order {order} on a box ...", file=sys.stderr)
    scene = ball_scene(files, order)
    schemes = {f"Drake, {name}": ("drake", {**scene, "approximation": name}) for name in APPROXIMATIONS}
    schemes["ours, leapfrog"] = ("ours", scene)
    plain = steps_by_turns(programs, schemes, STEPS, 0)
    seconds = {name: statistics.median(a["seconds"] for a in plain[name]) for name in plain}
    fastest = min(list(seconds)[:-1], key=seconds.get)
    chosen = {name: schemes[name] for name in (fastest, "ours, leapfrog")}
    differentiated = steps_by_turns(programs, chosen, DERIVATIVE_STEPS, 12)
    return [
        {
            "name": f"order {order}: {name}",
            "last": plain[name][-1],
            "seconds": seconds[name],
            "ratio": seconds[name] / seconds["ours, leapfrog"],
            "with derivatives": [a["seconds"] for a in differentiated.get(name, [])],
        }
        for name in schemes
    ]


def ball_scene(files, order):
    """A ball that starts a little above where it rests on a cube of edge 1 m."""
    import numpy

    turn = rotation(numpy.array([0.3, -0.5, 0.2]))
    return {
        "ball": files[f"ball {order}"],
        "box": files["box"],
        "start": pose_numbers(turn, numpy.array([0.02, 0.05, 0.596])),
        "radius": 0.1,
        "mass": BALLS[order],
        "modulus": MODULUS,
        "dissipation": 1.0,
        "friction": 0.4,
        "time_step": TIME_STEP,
        "settling_steps": 2500,
    }


def steps_by_turns(programs, schemes, steps, derivatives):
    """Answers of each scheme, asked by turns."""
    answers = {name: [] for name in schemes}
    for _ in range(ROUNDS):
        for name, (key, scene) in schemes.items():
            question = {"scene": scene, "steps": steps, "derivatives": derivatives}
            answers[name].append(programs[key].ask(ask="steps", **question))
    return answers


def print_step_table(balls):
    print("\n| ball on box | polygons | height (m) | steps per second | time of a step, of ours |"
          " with 12 derivatives, of a plain step |")
    print("|---|---|---|---|---|---|")
    for row in (row for rows in balls for row in rows):
        derivatives = row["with derivatives"]
        price = f"{statistics.median(derivatives) / row['seconds']:.1f}" if derivatives else "–"
        last = row["last"]
        print(f"| {row['name']} | {last['polygons']} | {last['height']:.6f} |"
              f" {1 / row['seconds']:,.0f} | **{row['ratio']:.1f}** | {price} |")


if __name__ == "__main__":
    main()
