"""VTK files: meshes that are read, and contact surfaces that are written."""

import base64
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

MESHES = Path(__file__).parents[2] / "tests" / "data" / "meshes_from_mesher"
HOSTILE = MESHES.parent / "hostile_files"
FIELD = MESHES.parent / "field_files"

# Files that only look odd.
ACCEPTED = {"deep.vtu", "most_components.vtu"}

# Error of numbers that are written as text.
TEXT = 1e-10


def assert_same(actual, expected):
    assert np.array_equal(actual.vertices, expected.vertices) and np.array_equal(actual.tets, expected.tets)
    assert np.array_equal(actual.extents, expected.extents)


def test_meshes_are_those_of_the_reader_of_gmsh():
    for name in ("bracket", "bracket_binary"):
        assert_same(he.Shape.read(MESHES / f"{name}.vtk"), he.Shape.read(MESHES / f"{name}.msh"))


def test_extents_come_from_point_data():
    first = he.Shape.read(MESHES / "bracket_extents_binary.vtu", "extent")
    assert first.tets.shape == (1781, 4) and first.extents.shape == (609,) and first.extents.max() == 1.0
    for name in ("bracket_extents_binary.vtk", "bracket_extents_zlib.vtu"):
        assert_same(he.Shape.read(str(MESHES / name), extents="extent"), first)
    # Text has fewer digits.
    for name in ("bracket_extents.vtk", "bracket_extents.vtu"):
        actual = he.Shape.read(MESHES / name, "extent")
        assert np.array_equal(actual.tets, first.tets) and np.abs(actual.vertices - first.vertices).max() < TEXT
        assert np.abs(actual.extents - first.extents).max() < TEXT
    with pytest.raises(he.HydroelasticError, match=r'no point-data array "position" with one number.*only \["extent"\]'):
        he.Shape.read(MESHES / "bracket_extents.vtk", "position")


@pytest.mark.parametrize("path", sorted(HOSTILE.glob("*.vt[ku]")), ids=lambda path: path.name)
def test_damaged_files_are_refused(path):
    if path.name.startswith("sound") or path.name in ACCEPTED:
        assert he.Shape.read(path).volume > 0.0
        return
    with pytest.raises(he.HydroelasticError, match=path.name):
        he.Shape.read(path)


GRID = "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} float\n{}\nCELLS 1 {}\n{}\nCELL_TYPES 1\n{}\n"


@pytest.mark.parametrize(
    "points, cells, kind, reason",
    [
        (8, range(8), 12, "solid elements that are not tetrahedra .hexahedron: 1."),
        (10, range(10), 24, "tetrahedra of second or higher order"),
        (3, range(3), 5, "holds a surface, not a mesh of tetrahedra"),
    ],
)
def test_other_solids_are_refused(tmp_path, points, cells, kind, reason):
    coordinates = " ".join(str(number) for number in range(3 * points))
    corners = " ".join(str(number) for number in (len(cells), *cells))
    path = tmp_path / "mesh.vtk"
    path.write_text(GRID.format(points, coordinates, 1 + len(cells), corners, kind))
    with pytest.raises(he.HydroelasticError, match=reason):
        he.Shape.read(path)


def test_vertices_without_a_tetrahedron_are_left_out(tmp_path):
    path = tmp_path / "mesh.VTK"
    path.write_text(GRID.format(6, "9 9 9 0 0 0 1 0 0 0 1 0 8 8 8 0 0 1", 5, "4 1 2 3 5", 10))
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert_same(he.Shape.read(path, tolerance=None), he.Shape(corners, np.array([[0, 1, 2, 3]])))


def test_a_file_that_is_not_there_is_said_to_be_so(tmp_path):
    with pytest.raises(OSError, match="nothing.vtu"):
        he.Shape.read(tmp_path / "nothing.vtu")


def test_warnings_of_files_are_warnings_of_python():
    with pytest.warns(UserWarning, match=r"seam.vtk: merged 3 duplicated vertices, so that 1 pairs of coincident faces lie inside"):
        shape = he.Shape.read(FIELD / "seam.vtk")
    assert_same(shape, he.Shape.read(FIELD / "no_seam.vtk"))


def test_meshes_are_placed_and_corners_are_read_on_request():
    with pytest.raises(he.HydroelasticError, match="the option corners_only reads them"):
        he.Shape.read(FIELD / "second_order.msh")
    pose = he.pose([0.0, 0.0, 3.0])
    shape = he.Shape.read(FIELD / "second_order.msh", unit=0.5, scale=[-1.0, 2.0, 1.0], pose=pose, corners_only=True)
    assert shape.volume == pytest.approx(0.25 / 6)
    assert np.array_equal(shape.vertices[:4], [[0.0, 0.0, 3.0], [-0.5, 0.0, 3.0], [0.0, 1.0, 3.0], [0.0, 0.0, 3.5]])


def test_distances_are_within_a_tolerance():
    box = FIELD / "box.mesh"
    plain, fine = (he.Shape.read(box, tolerance=tolerance) for tolerance in (None, 0.005))
    assert len(fine.tets) > len(plain.tets) and fine.volume == pytest.approx(plain.volume)
    assert_same(he.Shape.read(box), fine)
    assert_same(he.Shape(plain.vertices, plain.tets, tolerance=0.005), fine)


@pytest.mark.parametrize("name", ["gmsh_1.msh", "medit.mesh", "tetgen.node", "tetgen.ele", "appended_raw_zlib.vtu"])
def test_other_formats_are_read(name):
    assert he.Shape.read(FIELD / name).volume == pytest.approx(1 / 6)


def arrays_of(path):
    """Returns the arrays of a .vtp file, by their group and name."""
    actual = {}
    for group in ElementTree.parse(path).getroot().find("PolyData/Piece"):
        for array in group.findall("DataArray"):
            data = base64.b64decode(array.text)
            assert int.from_bytes(data[:8], "little") == len(data) - 8
            values = np.frombuffer(data[8:], {"Float64": "<f8", "Int64": "<i8"}[array.get("type")])
            columns = int(array.get("NumberOfComponents"))
            actual[group.tag, array.get("Name")] = values.reshape(-1, columns) if columns > 1 else values
    return actual


def test_surfaces_of_xml_hold_polygons_and_pressures(ball_on_block, tmp_path):
    pair, pose_a, pose_b = ball_on_block
    surface = pair.surface(pose_a, pose_b)
    pair.write_surface(tmp_path / "surface.vtp", pose_a, pose_b)
    actual = arrays_of(tmp_path / "surface.vtp")
    expected = {
        ("PointData", "pressure"): surface.pressures,
        ("CellData", "pressure"): surface.mean_pressures,
        ("CellData", "area"): surface.areas,
        ("CellData", "normal"): surface.normals,
        ("Points", "Points"): surface.vertices,
        ("Polys", "connectivity"): np.arange(len(surface.vertices)),
        ("Polys", "offsets"): surface.offsets[1:],
    }
    assert actual.keys() == expected.keys()
    for key, values in expected.items():
        assert np.array_equal(actual[key], values), key
    assert [path.name for path in tmp_path.iterdir()] == ["surface.vtp"]


def test_legacy_surfaces_hold_polygons_and_pressures(ball_on_block, tmp_path):
    pair, pose_a, pose_b = ball_on_block
    surface = pair.surface(pose_a, pose_b)
    pair.write_surface(tmp_path / "surface.vtk", pose_a, pose_b)
    rest = (tmp_path / "surface.vtk").read_bytes()
    points, polygons = len(surface.vertices), len(surface)

    def line(expected):
        nonlocal rest
        head, rest = rest.split(b"\n", 1)
        assert head.decode() == expected

    def numbers(count, kind):
        nonlocal rest
        values = np.frombuffer(rest, kind, count)
        assert rest[values.nbytes : values.nbytes + 1] == b"\n"
        rest = rest[values.nbytes + 1 :]
        return values

    for expected in ("# vtk DataFile Version 3.0", "contact surface", "BINARY", "DATASET POLYDATA"):
        line(expected)
    line(f"POINTS {points} double")
    assert np.array_equal(numbers(3 * points, ">f8"), surface.vertices.ravel())
    line(f"POLYGONS {polygons} {points + polygons}")
    lists = numbers(points + polygons, ">i4").tolist()
    for first, end in zip(surface.offsets, surface.offsets[1:]):
        count, *lists = lists
        corners, lists = lists[:count], lists[count:]
        assert corners == list(range(first, end))
    line(f"POINT_DATA {points}")
    line("SCALARS pressure double 1")
    line("LOOKUP_TABLE default")
    assert np.array_equal(numbers(points, ">f8"), surface.pressures)
    line(f"CELL_DATA {polygons}")
    assert rest.startswith(b"SCALARS pressure double 1") and b"VECTORS normal double" in rest


@pytest.mark.parametrize("name", ["surface.vtp", "surface.vtk"])
def test_no_contact_is_a_file_without_polygons(ball_on_block, tmp_path, name):
    pair, _, pose_b = ball_on_block
    pair.write_surface(tmp_path / name, he.pose([5.0, 0.0, 0.0]), pose_b)
    text = (tmp_path / name).read_bytes()
    assert b'NumberOfPolys="0"' in text or (b"POINTS 0 double" in text and b"POLYGONS" not in text)


def test_other_names_of_surfaces_are_refused(ball_on_block, tmp_path):
    pair, pose_a, pose_b = ball_on_block
    with pytest.raises(he.HydroelasticError, match="has to end in one of"):
        pair.write_surface(tmp_path / "surface.obj", pose_a, pose_b)
    with pytest.raises(OSError):
        pair.write_surface(tmp_path / "nowhere" / "surface.vtp", pose_a, pose_b)
