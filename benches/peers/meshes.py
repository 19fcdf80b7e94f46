"""Tetrahedral meshes for both programs, as VTK files. Each program computes the pressure field of a file itself: the distance to the
surface divided by the largest distance."""

import itertools
import math

import numpy


def icosphere(radius, order):
    """Returns a sphere of 20·4^order tetrahedra, from its center to an icosahedron subdivided `order` times."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [
        numpy.roll([0.0, first, second * golden], turn)
        for turn, first, second in itertools.product(range(3), (-1, 1), (-1, 1))
    ]
    points = [corner / numpy.linalg.norm(corner) for corner in corners]
    edge = min(numpy.linalg.norm(points[0] - point) for point in points[1:])
    triangles = [
        triple
        for triple in itertools.combinations(range(12), 3)
        if all(
            numpy.linalg.norm(points[i] - points[j]) < 1.01 * edge
            for i, j in itertools.combinations(triple, 2)
        )
    ]
    for _ in range(order):
        triangles = _subdivided(points, triangles)
    return _star(radius * numpy.array(points), triangles)


def _subdivided(points, triangles):
    """Returns four triangles for each triangle, and the points of the unit sphere with the new corners appended."""
    middles = {}

    def middle(i, j):
        key = (min(i, j), max(i, j))
        if key not in middles:
            middles[key] = len(points)
            point = points[i] + points[j]
            points.append(point / numpy.linalg.norm(point))
        return middles[key]

    return [
        part
        for a, b, c in triangles
        for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
        for part in [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    ]


def _star(points, triangles):
    """Returns tetrahedra from the triangles of a surface to the origin."""
    vertices = numpy.vstack([points, numpy.zeros(3)])
    return _oriented(vertices, [(len(points), *triangle) for triangle in triangles])


def cube(edge):
    """Returns twelve tetrahedra, from the center of the cube to two triangles per face."""
    points = numpy.array(list(itertools.product((-0.5, 0.5), repeat=3))) * edge
    triangles = []
    for axis, side in itertools.product(range(3), (0, 1)):
        low, *_, high = face = [i for i in range(8) if (i >> (2 - axis)) & 1 == side]
        triangles += [(low, other, high) for other in face if other not in (low, high)]
    return _star(points, triangles)


def cuboid(lengths, cells=1):
    """Returns a box of tetrahedra from its center to two triangles per face, or a layered box if `cells` is above one."""
    vertices, tets = cube(1.0) if cells == 1 else layered_cube(1.0, cells)
    return vertices * numpy.array(lengths), tets


def moments(mesh, mass):
    """Returns the moments of inertia (kg m²) of a uniform solid whose principal axes are those of the mesh."""
    vertices, tets = mesh
    corners = vertices[tets]
    edges = corners[:, 1:] - corners[:, :1]
    volumes = numpy.linalg.det(edges) / 6
    sums = (corners**2).sum(axis=1) + corners.sum(axis=1) ** 2
    x, y, z = mass / volumes.sum() * (volumes[:, None] * sums / 20).sum(axis=0)
    return [float(moment) for moment in (y + z, z + x, x + y)]


def layered_cube(edge, cells):
    """Returns a grid of cells³ cubes (an even number along each axis) of six tetrahedra. Each tetrahedron contains the corner of its cube
    that is nearest to the center, so no tetrahedron has all corners on the surface."""
    size, half = cells + 1, cells // 2
    grid = numpy.array(list(itertools.product(range(size), repeat=3)))
    index = lambda place: (place[0] * size + place[1]) * size + place[2]
    tets = []
    for cell in itertools.product(range(cells), repeat=3):
        outward = [1 if place >= half else -1 for place in cell]
        inner = [place if step > 0 else place + 1 for place, step in zip(cell, outward)]
        for order in itertools.permutations(range(3)):
            path = [list(inner)]
            for axis in order:
                path.append(list(path[-1]))
                path[-1][axis] += outward[axis]
            tets.append([index(place) for place in path])
    return _oriented((grid - half) * (edge / cells), tets)


def _oriented(vertices, tets):
    """Returns the mesh with all tetrahedra of positive volume."""
    tets = numpy.array(tets)
    a, b, c, d = (vertices[tets[:, corner]] for corner in range(4))
    negative = numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) < 0
    tets[negative] = tets[negative][:, [1, 0, 2, 3]]
    return vertices, tets


def write_vtk(path, mesh):
    """Writes a legacy ASCII file with all digits."""
    vertices, tets = mesh
    lines = ["# vtk DataFile Version 3.0", "mesh", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(vertices)} double")
    lines += [" ".join(repr(float(number)) for number in vertex) for vertex in vertices]
    lines.append(f"CELLS {len(tets)} {5 * len(tets)}")
    lines += ["4 " + " ".join(map(str, tet)) for tet in tets]
    lines.append(f"CELL_TYPES {len(tets)}")
    lines += ["10"] * len(tets)
    path.write_text("\n".join(lines) + "\n")
