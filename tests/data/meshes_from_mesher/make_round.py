"""Meshes a ball, a cylinder and a torus with Gmsh, with about the given number of tetrahedra each, as binary .msh files in a folder.

    python make_round.py 1000 .
    python make_round.py 20000 /tmp/meshes/20000
"""

import pathlib
import sys

import gmsh

# Constructor and volume (m³) by name.
SHAPES = {
    "sphere": (lambda occ: occ.addSphere(0, 0, 0, 0.1), 4.19e-3),
    "cylinder": (lambda occ: occ.addCylinder(0, 0, -0.1, 0, 0, 0.2, 0.08), 4.02e-3),
    "torus": (lambda occ: occ.addTorus(0, 0, 0, 0.1, 0.04), 3.16e-3),
}


def mesh(name, size, path):
    """Writes the mesh with edges of about this size (m), and returns its number of tetrahedra."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.option.setNumber("General.NumThreads", 1)
    SHAPES[name][0](gmsh.model.occ)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    count = sum(len(tets) for tets in gmsh.model.mesh.getElements(3)[1])
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(str(path))
    gmsh.finalize()
    return count


def main(wanted, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, (_, volume) in SHAPES.items():
        size = (volume / wanted / 0.095) ** (1 / 3)
        for _ in range(3):
            count = mesh(name, size, folder / f"{name}.msh")
            if abs(count / wanted - 1) < 0.05:
                break
            size *= (count / wanted) ** (1 / 3)
        print(f"{name}: {count} tetrahedra")


main(int(sys.argv[1]), pathlib.Path(sys.argv[2]))
