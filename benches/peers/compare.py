#!/usr/bin/env python3
"""Contact in this library and in Drake: the same meshes, fields and poses, with one thread each.

Helps to choose between this library and Drake if contact must be fast or its derivatives correct. Measures the ratio of times and the
errors of the derivatives. Run

    python3 benches/peers/compare.py            # under five minutes after the first run
    python3 benches/peers/compare.py --quick    # about a minute
    python3 benches/peers/compare.py --floors   # the ball on its floors alone
    python3 benches/peers/compare.py --cold     # five poses at a time by turns: caches are cold
    python3 benches/peers/compare.py --orders 1 2 --poses 100

The first run downloads Drake into a virtual environment in cargo's target directory. Both programs keep running, and the script sends
questions to one at a time. README.md describes what is timed. The output is Markdown.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
REQUIREMENTS = ["drake==1.58.0", "mujoco==4.0.0", "numpy", "matplotlib"]
OLDEST_PYTHON = (3, 12)  # supported by Drake


def main():
    options = parsed_options()
    target = target_directory()
    enter_virtual_environment(target / "peers_environment")
    # These modules need numpy, which the virtual environment provides.
    import contacts
    import steps

    files = written_meshes(target / "peers_meshes", options.orders, steps.BALLS)
    drake_side = [sys.executable, HERE / "drake_side.py"]
    with Program([built_ours(), "--serve"]) as ours, Program(drake_side) as drake:
        programs = {"drake": drake, "ours": ours}
        if not options.floors:
            contacts.compare(programs, files, options)
        steps.compare(programs, files)


def parsed_options():
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--orders", type=int, nargs="+", default=[1, 2, 3, 4], help="of icospheres")
    options.add_argument("--poses", type=int, help="per scene (default: more where they are cheap)")
    options.add_argument("--quick", action="store_true", help="orders up to 3 and few poses")
    options.add_argument("--floors", action="store_true", help="the ball on its floors alone")
    options.add_argument("--cold", action="store_true", help="the programs take turns every five poses")
    options = options.parse_args()
    if options.quick:
        options.orders = [order for order in options.orders if order < 4]
        options.poses = options.poses or 5
    return options


def target_directory():
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1"]
    metadata = subprocess.run(command, cwd=REPOSITORY, check=True, capture_output=True).stdout
    return pathlib.Path(json.loads(metadata)["target_directory"])


def enter_virtual_environment(folder, requirements=REQUIREMENTS):
    """Restarts this script inside the virtual environment, which is created if it does not exist."""
    python = folder / "bin" / "python"
    if folder.exists() and os.path.samefile(sys.prefix, folder):
        return
    installed = folder / "installed"
    if not (installed.exists() and installed.read_text() == str(requirements)):
        subprocess.run([interpreter(), "-m", "venv", "--clear", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *requirements], check=True)
        installed.write_text(str(requirements))
    os.execv(python, [python, *sys.argv])


def interpreter():
    """Returns the path of a Python that is new enough for Drake."""
    if sys.version_info >= OLDEST_PYTHON:
        return sys.executable
    versions = pathlib.Path.home() / ".pyenv/versions"
    for name in ("python3.13", "python3.12"):
        for python in [shutil.which(name), *sorted(versions.glob(f"*/bin/{name}"))]:
            # pyenv puts shims on the path even for versions that are not active, so run the interpreter.
            if python and subprocess.run([python, "-c", ""], capture_output=True).returncode == 0:
                return python
    sys.exit("Drake needs Python 3.12 or later: none on the path or under ~/.pyenv/versions")


def built_ours(bench="peers_ours"):
    """Returns the path of this library's program, built in release mode and without threads."""
    command = ["cargo", "bench", "--no-run", "--bench", bench]
    command += ["--no-default-features", "--features", "avx512,vtk"]
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


def written_meshes(folder, orders, balls):
    """Writes the mesh files and returns their paths by name."""
    import meshes

    folder.mkdir(exist_ok=True)
    wanted = {f"sphere {order}": meshes.icosphere(1.0, order) for order in orders}
    wanted |= {f"ball {order}": meshes.icosphere(0.1, order) for order in balls}
    wanted |= {"grid": meshes.layered_cube(1.0, 8), "box": meshes.cube(1.0)}
    paths = {name: folder / f"{name.replace(' ', '_')}.vtk" for name in wanted}
    for name, path in paths.items():
        meshes.write_vtk(path, wanted[name])
    return {name: str(path) for name, path in paths.items()}


if __name__ == "__main__":
    main()
