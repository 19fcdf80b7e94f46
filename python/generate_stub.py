"""Writes the type stub of the compiled module: ``python generate_stub.py``.

The installed module has the classes, their members, and the arguments with their defaults. Docstrings have the types of
arguments. The Rust sources have the types of results, and of arguments that no docstring describes. If the Rust type of
a result is ``PyAny``, the docstring has its type too.
"""

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hydroelastic import _core

PACKAGE = Path(__file__).parent
STUB = PACKAGE / "python" / "hydroelastic" / "_core.pyi"
HEADER = """\
# Written by generate_stub.py.
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar, final, NoReturn, Self, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .view import Picture

_Floats: TypeAlias = NDArray[np.float64]
_Whole: TypeAlias = NDArray[np.integer]
_Numbers: TypeAlias = _Floats | _Whole | Sequence[float]
_Rows: TypeAlias = _Floats | _Whole | Sequence[object]
_Indices: TypeAlias = _Whole | Sequence[Sequence[int]]
_File: TypeAlias = str | os.PathLike[str]
_Progress: TypeAlias = Callable[[int, int], object]

__version__: str

class HydroelasticError(ValueError): ...

class RolloutError(HydroelasticError):
    trajectory: Trajectory | None
"""
WIDTH = 120
CLASSES = {name: member for name, member in vars(_core).items() if inspect.isclass(member) and not issubclass(member, Exception)}
ERRORS = {"HydroelasticError", "RolloutError"}
# Python types, by their names in docstrings and in Rust.
TYPES = {name: name for name in ["None", "bool", "bytes", "float", "int", "str", "object", *ERRORS, *CLASSES]} | {
    "callable": "_Progress",
    "function of iterations": "Callable[[int, float, _Floats, Checkpoint], object]",
    "function of points": "Callable[[_Floats], _Numbers]",
    "hydroelastic.view.Picture": "Picture",
    "path-like": "_File",
    "()": "None",
    "[u8]": "bytes",
    "Again": "tuple[Callable[..., Self], tuple[object, ...]]",
    "AnyShape": "Shape | RigidShape | HalfSpace",
    "slice": "slice",
    "Floats": "_Floats",
    "ForceObject": "Spring | Drag | Thruster",
    "Indices": "NDArray[np.int64]",
    "JointNumber": "float | _Floats",
    "Made": "tuple[Callable[..., Self], tuple[str, tuple[object, ...], dict[str, object]]]",
    "Number": "float | str",
    "PyArrayDyn<f64>": "_Floats",
    "PyArrayDyn<i64>": "NDArray[np.int64]",
    "PyDict": "dict[str, object]",
    "PyErr": "HydroelasticError",
    "PyIterator": "Iterator[State]",
    "PySlice": "slice",
    "PyTuple": "tuple[_Floats, ...]",
    "Reduced": "tuple[Callable[..., Self], tuple[bytes]]",
    "Saved": "tuple[Callable[..., Self], tuple[list[Body], list[tuple[str, str]]]]",
    "String": "str",
    "Whole": "int",
    "f64": "float",
    "usize": "int",
}
# Methods without a signature in Rust, or with a signature that differs from that in Python.
PROTOCOLS = {
    "__eq__": "(self, value: object, /) -> bool",
    "__ne__": "(self, value: object, /) -> bool",
    "__hash__": "(self) -> int",
    "__add__": "(self, other: Self, /) -> Self",
    "__radd__": "(self, other: Self, /) -> Self",
    "__getitem__": "(self, key: SupportsIndex, /) -> State",
    "__next__": "(self) -> State",
    "__call__": """(
        self,
        /,
        by_poses: _Rows,
        by_twists: _Rows,
        *,
        by_joint_positions: _Rows | None = None,
        by_joint_velocities: _Rows | None = None,
        by_ball_joint_rotations: _Rows | None = None,
        by_ball_joint_velocities: _Rows | None = None,
    ) -> _Floats""",
    "_repr_html_": "(self) -> str",
}
# Members that the stub omits, because every class inherits them, or because pickling an instance adds them.
INHERITED = {"__slotnames__", "__repr__", "__str__", "__lt__", "__le__", "__gt__", "__ge__", "__doc__", "__module__"}


def split(text: str, separators: str) -> list[str]:
    """Splits a text at separators (a regular expression) outside of brackets."""
    parts, depth, start = [], 0, 0
    for match in re.finditer(rf"[(<\[]|[)>\]]|{separators}", text):
        if match[0] in "(<[":
            depth += 1
        elif match[0] in ")>]":
            depth -= 1
        elif depth == 0:
            parts.append(text[start : match.start()])
            start = match.end()
    return [part.strip() for part in [*parts, text[start:]] if part.strip()]


def array_type(match: re.Match[str]) -> str:
    """Returns the type of an array in a docstring, such as "(3,) array_like"."""
    shapes, kind = match[1], match[2]
    if kind == "ndarray of float64":
        return "_Floats"
    has_rows = re.search(r", \w", shapes)
    if kind == "array_like of int":
        return "_Indices" if has_rows else "_Whole | Sequence[int]"
    return "_Rows" if has_rows else "_Numbers"


def documented_type(text: str, is_result: bool) -> str:
    """Converts a type of a docstring."""
    if match := re.fullmatch(r"(?:list|sequence|pair) of (.*)", text):
        return f"{'list' if is_result else 'Sequence'}[{documented_type(match[1], is_result)}]"
    if match := re.fullmatch(r"dict of str to (.*)", text):
        return f"{'dict' if is_result else 'Mapping'}[str, {documented_type(match[1], is_result)}]"
    text = re.sub(r"((?:\([^()]*\)(?:, | or | ))+)(array_like(?: of int)?|ndarray of float64)", array_type, text)
    types = []
    for part in split(text, ", | or | and "):
        if part.startswith("("):
            part = f"tuple[{', '.join(documented_type(item, is_result) for item in split(part[1:-1], ', '))}]"
        types.append(part if part.startswith(("_", "tuple")) else TYPES[part])
    return " | ".join(types)


def rust_type(text: str, is_result: bool) -> str:
    """Converts a type of Rust."""
    if match := re.fullmatch(r"(PyResult|Bound|Py|PyRef|Option|Vec)<(.*)>", text):
        inner = rust_type(match[2], is_result)
        return {"Option": f"{inner} | None", "Vec": f"{'list' if is_result else 'Sequence'}[{inner}]"}.get(match[1], inner)
    if match := re.fullmatch(r"BTreeMap<(\w+), (.*)>", text):
        return f"dict[{rust_type(match[1], is_result)}, {rust_type(match[2], is_result)}]"
    if text.startswith("(") and text != "()":
        return f"tuple[{', '.join(rust_type(item, is_result) for item in split(text[1:-1], ','))}]"
    if text == "PyAny" and is_result:
        return "object"
    return TYPES[text]


class Source:
    """Types of the fields and functions in the Rust sources, by class ("" for functions of the module) and name."""

    def __init__(self) -> None:
        self.results: dict[tuple[str, str], str] = {}
        self.arguments: dict[tuple[str, str], dict[str, str]] = {}
        for path in sorted((PACKAGE / "src").glob("*.rs")):
            # Without comments, other attributes, lifetimes and references.
            text = re.sub(r"^ *//.*\n|#\[(?!pymethods).*?\]|'\w+(, )?|&", "", path.read_text(), flags=re.M).replace("<>", "")
            for name, fields in re.findall(r"^pub struct (\w+) \{\n(.*?)^\}", text, flags=re.S | re.M):
                for field, kind in re.findall(r"^    (?:pub )?(\w+): (.*),$", fields, flags=re.M):
                    self.results[name, field] = kind
            for name, methods in re.findall(r"^#\[pymethods\]\nimpl (\w+) \{\n(.*?)^\}", text, flags=re.S | re.M):
                self._add_functions(name, re.sub(r"\bSelf\b", name, methods))
            self._add_functions("", re.sub(r"^impl.*?^\}", "", text, flags=re.S | re.M))

    def _add_functions(self, owner: str, text: str) -> None:
        for match in re.finditer(r"\bfn (\w+)(?:<.*?>)?\((.*?)\)(?: -> (.*?))? \{$", text, flags=re.S | re.M):
            key = owner, "__new__" if match[1] == "new" else match[1]
            arguments = (part.split(": ", 1) for part in split(" ".join(match[2].split()), ","))
            self.arguments[key] = {part[0]: part[1] for part in arguments if len(part) == 2}
            self.results[key] = " ".join((match[3] or "()").split()).replace("( ", "(")


def section(function: Any, title: str) -> list[tuple[str, str]]:
    """Returns the names and types in a section of a docstring. The name of a single result may be empty."""
    match = re.search(rf"^{title}\n-+\n(.*?)(?=\n\n\w+\n--|\Z)", inspect.getdoc(function) or "", flags=re.S | re.M)
    lines = [line for line in (match[1] if match else "").splitlines() if line and not line.startswith(" ")]
    entries = [(*([""] if " : " not in line else []), *line.split(" : ", 1)) for line in lines]
    return [(name, kind) for names, kind in entries for name in names.split(", ")]


def wrapped(start: str, items: list[str], end: str, indent: str = "") -> str:
    """Returns items between two texts, on one line if they fit."""
    line = f"{indent}{start}{', '.join(items)}{end}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{indent}{start}", *(f"{indent}    {item}," for item in items), f"{indent}{end}"])


def result_type(owner: str, name: str, function: Any, source: Source) -> str:
    """Returns the type of the result of a function, or of a property."""
    if name == "__new__":
        return "Self"
    text = source.results[owner, name]
    if name == "__reduce__" and text == "PyResult<()>":
        return "NoReturn"
    types = [documented_type(kind, True) for _, kind in section(function, "Returns")] if "PyAny" in text else []
    return ("tuple[" + ", ".join(types) + "]" if len(types) > 1 else types[0]) if types else rust_type(text, True)


def definition(owner: str, name: str, function: Any, first: list[str], source: Source) -> str:
    """Returns the definition of a function. ``first`` has the argument that the signature of Rust omits."""
    types = dict(section(function, "Parameters"))
    arguments = list(first)
    for argument in inspect.signature(function).parameters.values():
        if argument.name == "self":
            continue
        if argument.kind is argument.KEYWORD_ONLY and "*" not in arguments:
            arguments.append("*")
        if argument.name in types:
            kind = documented_type(types[argument.name].removesuffix(", optional"), False)
        else:
            kind = rust_type(source.arguments[owner, name][argument.name], False)
        if argument.default is None and not kind.endswith("None"):
            kind += " | None"
        default = "..." if argument.default is ... else repr(argument.default)
        arguments.append(f"{argument.name}: {kind}" + ("" if argument.default is argument.empty else f" = {default}"))
    result = result_type(owner, name, function, source)
    return wrapped(f"def {name}(", arguments, f") -> {result}: ...", "    " if owner else "")


def members(name: str, source: Source) -> Iterator[str]:
    """Yields the definitions of the members of a class, in the order of the Rust sources."""
    place = {key: index for index, key in enumerate(source.results)}
    own = {member: value for member, value in vars(CLASSES[name]).items() if member not in INHERITED and value is not None}
    for member in sorted(own, key=lambda member: (place.get((name, member), len(place)), member)):
        value = own[member]
        if member in PROTOCOLS:
            yield f"    def {member}{PROTOCOLS[member]}: ..."
        elif member == "__new__":
            yield definition(name, member, CLASSES[name], ["cls"], source)
        elif isinstance(value, CLASSES[name]):
            yield f"    {member}: ClassVar[{name}]"
        elif isinstance(value, staticmethod):
            yield "    @staticmethod\n" + definition(name, member, value.__func__, [], source)
        elif inspect.isroutine(value):
            yield definition(name, member, value, ["self"], source)
        else:
            yield f"    @property\n    def {member}(self) -> {result_type(name, member, value, source)}: ..."


def stub() -> str:
    """Returns the text of the stub."""
    source = Source()
    parts = [HEADER, wrapped("__all__ = [", [f'"{name}"' for name in sorted(_core.__all__)], "]") + "\n"]
    functions = ((name, member) for name, member in vars(_core).items() if inspect.isbuiltin(member))
    parts.append("\n".join(definition("", name, function, [], source) for name, function in functions) + "\n")
    parts += [f"@final\nclass {name}:\n" + "\n".join(members(name, source)) + "\n" for name in CLASSES]
    return "\n".join(parts)


if __name__ == "__main__":
    STUB.write_text(stub())
