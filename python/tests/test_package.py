"""The package: stub, README files and import."""

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import hydroelastic as he

PACKAGE = Path(__file__).parent.parent
READMES = [PACKAGE / "README.md", PACKAGE.parent / "README.md"]
CHAPTERS = sorted((PACKAGE.parent / "docs" / "guide").glob("*.md"))


def test_the_stub_is_generated():
    generator = runpy.run_path(str(PACKAGE / "generate_stub.py"))
    assert generator["STUB"].read_text() == generator["stub"](), "run python generate_stub.py"


def test_mypy_accepts_the_stub():
    """The stub is that of the compiled part. The Python modules have inline types."""
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy.stubtest", "hydroelastic._core"]
    completed = subprocess.run(command, capture_output=True, text=True, cwd=os.sep)
    assert completed.returncode == 0, completed.stdout + completed.stderr


DOCUMENTS = [
    pytest.param(READMES[0], id="package", marks=pytest.mark.optional),  # Imports JAX.
    pytest.param(READMES[1], id="library"),
    *(pytest.param(path, id=path.stem) for path in CHAPTERS),
]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_programs_of_a_document_run(document, tmp_path, monkeypatch):
    # The guide reads meshes of the repository.
    monkeypatch.chdir(PACKAGE.parent if document in CHAPTERS else tmp_path)
    programs = re.findall(r"```python\n(.*?)```", document.read_text(), flags=re.S)
    assert programs or document in CHAPTERS
    for program in programs:
        try:
            exec(compile(program, str(document), "exec"), {})
        except ImportError as missing:  # A package that a program or an extra needs is missing.
            assert "hydroelastic[" in str(missing) or missing.name in ("matplotlib", "pandas")


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
