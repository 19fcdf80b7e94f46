"""Makes every mesh file in this folder from bracket.geo (see README.md)."""

import gmsh
import meshio
import numpy as np


def mesh_bracket():
    """Meshes bracket.geo with Gmsh, as .msh and legacy .vtk, ASCII and binary."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.open("bracket.geo")
    gmsh.model.mesh.generate(3)
    for binary, suffix in [(0, ""), (1, "_binary")]:
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(f"bracket{suffix}.msh")
        gmsh.write(f"bracket{suffix}.vtk")
    gmsh.finalize()


def surface_of(tets):
    """Returns the faces that belong to one tetrahedron only."""
    faces = np.sort(np.concatenate([np.delete(tets, i, axis=1) for i in range(4)]))
    unique, count = np.unique(faces, axis=0, return_counts=True)
    return unique[count == 1]


def with_inner_vertices(points, tets):
    """Splits every tetrahedron with all corners on the surface at its centroid."""
    surface = np.unique(surface_of(tets))
    flat = np.isin(tets, surface).all(axis=1)
    new = len(points) + np.arange(flat.sum())
    parts = []
    for i in range(4):
        part = tets[flat].copy()
        part[:, i] = new
        parts.append(part)
    return np.concatenate([points, points[tets[flat]].mean(axis=1)]), np.concatenate([tets[~flat], *parts])


def distance_to_segment(p, a, b):
    t = np.clip(np.dot(p - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return np.linalg.norm(p - a - t * (b - a))


def distance_to_triangle(p, a, b, c):
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    sides = [np.dot(np.cross(v - u, p - u), normal) for u, v in [(a, b), (b, c), (c, a)]]
    if min(sides) >= 0.0:
        return abs(np.dot(p - a, normal))
    return min(distance_to_segment(p, u, v) for u, v in [(a, b), (b, c), (c, a)])


def distances(points, tets):
    """Returns the distance of each point to the surface (m)."""
    triangles = surface_of(tets)
    found = np.zeros(len(points))
    for vertex in np.setdiff1d(np.arange(len(points)), triangles):
        found[vertex] = min(distance_to_triangle(points[vertex], *points[t]) for t in triangles)
    return found


def write_with_extents():
    mesh = meshio.read("bracket.msh")
    tets = np.concatenate([block.data for block in mesh.cells if block.type == "tetra"])
    points, tets = with_inner_vertices(mesh.points, tets)
    depth = distances(points, tets)
    fields = {"extent": depth / depth.max(), "position": points.astype("float32")}
    mesh = meshio.Mesh(points, [("tetra", tets)], point_data=fields)
    mesh.write("bracket_extents.vtk", file_format="vtk42", binary=False)
    mesh.write("bracket_extents_binary.vtk", binary=True)  # version 5.1
    mesh.write("bracket_extents.vtu", binary=False)
    mesh.write("bracket_extents_binary.vtu", compression=None)
    mesh.write("bracket_extents_zlib.vtu", compression="zlib")
    print(f"{len(points)} points, {len(tets)} tetrahedra, {(depth > 0).sum()} points inside, largest distance {depth.max()}")


mesh_bracket()
write_with_extents()
