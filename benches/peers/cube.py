#!/usr/bin/env python3
"""Fits this library, MuJoCo or Drake to measured tosses of a cube, and predicts other tosses.

Compares contact laws on the measurements of the example `cube_tosses`. Run

    python3 benches/peers/cube.py FOLDER --engine mujoco --fit 100 --held-out 100

FOLDER contains the file `cube_tosses.csv`. The first run downloads Drake, MuJoCo and CMA-ES into a virtual environment in cargo's target
directory. The first run of the engine `hydroelastic` also builds the Python package of this library. README.md describes the measurements
and the file. The output is Markdown.
"""

import argparse
import json
import pathlib
import sys

from compare import REPOSITORY, enter_virtual_environment, target_directory

sys.dont_write_bytecode = True

REQUIREMENTS = ["drake==1.58.0", "mujoco==4.0.0", "numpy", "cma==4.5.0"]
ENGINES = ["hydroelastic", "mujoco", "drake-hydroelastic", "drake-point"]
VARIANTS = ["sdirk3", "implicit_euler", "elliptic", "pyramidal", "sap", "lagged", "similar"]


def main():
    options = parsed_options()
    recordings = options.folder / "cube_tosses.csv"
    if not recordings.is_file():
        sys.exit(f"{recordings} does not exist: README.md says where the recordings are from")
    if options.engine == "hydroelastic":
        enter_virtual_environment(target_directory() / "cube_environment_hydroelastic", [*REQUIREMENTS, str(REPOSITORY / "python")])
    else:
        enter_virtual_environment(target_directory() / "cube_environment", REQUIREMENTS)
    # These modules need numpy and cma, which the virtual environment provides.
    import cube_fit

    engine = engine_of(options)
    tosses = cube_fit.read(recordings)
    if options.starts == "flight":
        from cube_flight import improved_start

        for toss in tosses:
            toss[0] = improved_start(toss)
    if options.fit + options.held_out > len(tosses):
        sys.exit(f"the file has {len(tosses)} tosses: reduce --fit or --held-out, whose sum is {options.fit + options.held_out}")
    fit = cube_fit.Fit(engine, cube_fit.COSTS[options.loss])
    values = fit.best(tosses[: options.fit], options.searches, options.evaluations)
    errors = cube_fit.errors(engine, values, tosses[len(tosses) - options.held_out :])
    name = f"{options.engine}, {engine.variant}, {options.fit} tosses, loss {options.loss}, {options.starts} starts"
    print("| engine | position: mean | median | rotation: median | mean | final position: median |")
    print("|---|---|---|---|---|---|")
    print(f"| {name} | {cube_fit.summary(errors)} |\n")
    print(", ".join(f"{name} {value:.4g}" for name, value in values.items()))
    if options.output:
        result = {"parameters": values, "cost": fit.cost, "evaluations": fit.evaluations, **errors}
        options.output.write_text(json.dumps(result, ensure_ascii=False))


def engine_of(options):
    """Returns the engine. The default variant has the lowest cost."""
    import cube_engines

    if options.engine == "hydroelastic":
        from cube_hydroelastic import Hydroelastic as Engine
    else:
        Engine = cube_engines.ENGINES[options.engine]
    engine = Engine(options.variant or Engine.variant, options.substeps or Engine.substeps)
    if options.inertia:
        engine.parameters = [*engine.parameters, cube_engines.Parameter(cube_engines.INERTIA, cube_engines.MOMENT, 0.1)]
    return engine


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("folder", type=pathlib.Path, help="folder of cube_tosses.csv")
    options.add_argument("--engine", choices=ENGINES, required=True)
    options.add_argument("--variant", choices=VARIANTS, help="integrator of this library, cone of MuJoCo, or contact approximation of Drake")
    options.add_argument("--substeps", type=int, help="time steps per frame (default: 1 for this library, 4 for MuJoCo, 2 for Drake)")
    options.add_argument("--loss", choices=["windows", "tosses"], default="tosses", help="cost (default: tosses)")
    options.add_argument("--starts", choices=["measured", "flight"], default="flight", help="initial states (default: flight)")
    options.add_argument("--inertia", action="store_true", help="fit the moment of inertia too")
    options.add_argument("--fit", type=int, default=100, help="number of training tosses, from the first (default: 100)")
    options.add_argument("--held-out", type=int, default=100, help="number of predicted tosses, up to the last (default: 100)")
    options.add_argument("--searches", type=int, default=2, help="number of initial searches, on at most 20 tosses (default: 2)")
    options.add_argument("--evaluations", type=int, default=250, help="number of evaluations of the cost per search (default: 250)")
    options.add_argument("--output", type=pathlib.Path, help="JSON file for parameters and errors")
    return options.parse_args()


if __name__ == "__main__":
    main()
