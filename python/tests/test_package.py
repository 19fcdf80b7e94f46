"""The package: its stubs, its README, its import."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import hydroelastic as he

README = Path(__file__).parent.parent / "README.md"


# Modules that need an extra cannot be imported without it.
EXTRAS = ("ray",)


def test_stubs_fit_the_module(tmp_path):
    pytest.importorskip("mypy")
    absent = tmp_path / "absent"
    absent.write_text("".join(f"hydroelastic.{name}\n" for name in EXTRAS if importlib.util.find_spec(name) is None))
    command = [sys.executable, "-m", "mypy.stubtest", "hydroelastic", "--allowlist", str(absent)]
    found = subprocess.run(command, capture_output=True, text=True, cwd=os.sep)
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_programs_of_the_readme_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    programs = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.S)
    assert programs
    for program in programs:
        exec(compile(program, str(README), "exec"), {})


def test_everything_public_has_a_docstring():
    for name in he.__all__:
        value = getattr(he, name)
        assert value.__doc__, name
        if isinstance(value, type) and not issubclass(value, Exception):
            for member, what in vars(value).items():
                is_shown = not member.startswith("_") and member not in vars(he.Integrator)
                assert not is_shown or getattr(what, "__doc__", None), f"{name}.{member}"


def test_import_takes_numpy_alone():
    code = "import sys, numpy; before = set(sys.modules); import hydroelastic; print(*(set(sys.modules) - before))"
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert all(name.startswith("hydroelastic") for name in output.split() if not name.startswith("numpy")), output
