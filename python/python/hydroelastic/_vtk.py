"""VTK files: reads tetrahedral meshes with meshio, and writes contact surfaces."""

from __future__ import annotations

import base64
import os
import uuid
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from ._core import HydroelasticError

if TYPE_CHECKING:
    from ._core import Surface

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

# Prefixes of meshio's names of cells that are not part of a solid.
_NOT_SOLID = ("vertex", "line", "triangle", "quad", "polygon", "pixel")
# Prefixes of meshio's names of tetrahedra of higher order.
_HIGHER_ORDER = ("tetra", "VTK_LAGRANGE_TETRAHEDRON", "VTK_HIGHER_ORDER_TETRAHEDRON", "VTK_BEZIER_TETRAHEDRON")


def read_mesh(path: str | os.PathLike[str], extents: str | None) -> tuple[Floats, Whole, Floats | None]:
    """Reads the tetrahedra of a .vtk or .vtu file.

    Returns the vertices that tetrahedra use, in the order of the file, the tetrahedra, and the point data with the name
    ``extents`` at these vertices.
    """
    file = _read(Path(path))
    tets = _tets(path, file.cells)
    points = np.asarray(file.points, dtype=np.float64)
    outside = np.argwhere((tets < 0) | (tets >= len(points)))
    if len(outside):
        tet, corner = outside[0]
        raise HydroelasticError(
            f"tetrahedron {tet} of {path} refers to vertex {tets[tet, corner]}, which the file does not have"
        )
    used, renumbered = np.unique(tets, return_inverse=True)
    chosen = None if extents is None else _numbers(path, file.point_data, extents, len(points))[used]
    return points[used], renumbered.reshape(tets.shape).astype(np.int64), chosen


def _read(path: Path) -> Any:
    try:
        # These readers raise exceptions, whereas meshio.read ends the program if a file is damaged.
        from meshio import vtk, vtu  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ImportError as error:
        raise ImportError(
            f'{path.name} is a file of VTK, which is read by meshio: pip install "hydroelastic[files]". '
            "Files of Gmsh (.msh) need nothing more"
        ) from error
    # A file that cannot be opened raises OSError here.
    with path.open("rb"):
        pass
    is_xml = path.suffix.lower() == ".vtu"
    try:
        return vtu.read(str(path)) if is_xml else vtk.read(str(path))
    except (Exception, SystemExit) as error:
        what = "VTK XML" if is_xml else "legacy VTK"
        why = f"{type(error).__name__}: {error}"
        raise HydroelasticError(f"{path} is not a {what} file that meshio can read, or is damaged: {why}") from error


def _tets(path: str | os.PathLike[str], blocks: Iterable[Any]) -> Whole:
    tets = []
    for block in blocks:
        if block.type == "tetra":
            tets.append(np.asarray(block.data, dtype=np.int64).reshape(-1, 4))
        elif block.type.startswith(_HIGHER_ORDER):
            raise HydroelasticError(
                f"{path} has tetrahedra of second or higher order ({block.type}), but only tetrahedra of first order, with "
                "4 vertices, can be read"
            )
        elif not block.type.startswith(_NOT_SOLID):
            raise HydroelasticError(
                f"{path} has solid elements of the kind {block.type}, but only tetrahedra can be read"
            )
    if not tets:
        raise HydroelasticError(f"{path} has no tetrahedra: was only its surface meshed or saved?")
    return np.concatenate(tets)


def _numbers(path: str | os.PathLike[str], data: dict[str, Any], name: str, count: int) -> Floats:
    """Returns the point data with a name and with one number for each point."""
    suitable = {key: np.asarray(values) for key, values in data.items() if np.size(values) == count}
    if name not in suitable:
        raise HydroelasticError(
            f"{path} has no point-data array {name!r} with one number per vertex, only {sorted(suitable)}"
        )
    return suitable[name].reshape(count).astype(np.float64)


def write_surface(path: str | os.PathLike[str], surface: Surface) -> None:
    """Writes a contact surface as VTK PolyData, in a .vtp file or a legacy .vtk file. The write is atomic: an existing
    file is replaced after the new file is complete.
    """
    path = Path(path)
    writers = {".vtp": _xml, ".vtk": _legacy}
    kind = path.suffix.lower()
    if kind not in writers:
        raise HydroelasticError(f'the name of {path} ends in "{kind[1:]}", but has to end in one of ["vtk", "vtp"]')
    contents = writers[kind](surface)
    draft = path.with_name(f"hydroelastic-{uuid.uuid4().hex}.part")
    try:
        with draft.open("xb") as file:
            file.write(contents)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _cell_data(surface: Surface) -> dict[str, Floats]:
    return {"pressure": surface.mean_pressures, "area": surface.areas, "normal": surface.normals}


def _xml(surface: Surface) -> bytes:
    def array(name: str, values: NDArray[Any]) -> str:
        kind, size = ("Int64", "<i8") if values.dtype.kind == "i" else ("Float64", "<f8")
        data = np.ascontiguousarray(values, dtype=size).tobytes()
        text = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
        components = values.shape[1] if values.ndim == 2 else 1
        return (
            f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{components}" format="binary">'
            f"{text}</DataArray>"
        )

    corners = np.arange(len(surface.vertices))
    cells = "".join(array(name, values) for name, values in _cell_data(surface).items())
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
        f'<PolyData><Piece NumberOfPoints="{len(surface.vertices)}" NumberOfVerts="0" NumberOfLines="0" '
        f'NumberOfStrips="0" NumberOfPolys="{len(surface)}">\n'
        f'<PointData Scalars="pressure">{array("pressure", surface.pressures)}</PointData>\n'
        f'<CellData Scalars="pressure" Normals="normal">{cells}</CellData>\n'
        f"<Points>{array('Points', surface.vertices)}</Points>\n"
        f"<Polys>{array('connectivity', corners)}{array('offsets', surface.offsets[1:])}</Polys>\n"
        "</Piece></PolyData></VTKFile>\n"
    )
    return text.encode()


def _legacy(surface: Surface) -> bytes:
    def floats(values: Floats) -> bytes:
        return values.astype(">f8").tobytes() + b"\n"

    points, polygons = len(surface.vertices), len(surface)
    parts = [f"# vtk DataFile Version 3.0\ncontact surface\nBINARY\nDATASET POLYDATA\nPOINTS {points} double\n".encode()]
    parts.append(floats(surface.vertices))
    # Readers treat an empty list of polygons as damage.
    if polygons:
        # Each polygon is written as the number of its corners, then the corners.
        ends = surface.offsets
        lists = np.insert(np.arange(points), ends[:-1], np.diff(ends))
        parts += [f"POLYGONS {polygons} {len(lists)}\n".encode(), lists.astype(">i4").tobytes() + b"\n"]
    parts += [f"POINT_DATA {points}\nSCALARS pressure double 1\nLOOKUP_TABLE default\n".encode(), floats(surface.pressures)]
    parts.append(f"CELL_DATA {polygons}\n".encode())
    for name, values in _cell_data(surface).items():
        head = f"VECTORS {name} double\n" if values.ndim == 2 else f"SCALARS {name} double 1\nLOOKUP_TABLE default\n"
        parts += [head.encode(), floats(values)]
    return b"".join(parts)
