"""Creates mug.msh with Gmsh (`pip install gmsh`, here 4.15): `python mug.py` in this folder.

A cup of radius 40 mm and height 95 mm with walls of 4 mm, and a handle in the shape of half a ring.

Script and mesh are our own work, under the license of the repository.
"""

import gmsh

RADIUS, HEIGHT, WALL = 0.040, 0.095, 0.004
# The axis of the handle's ring is along y. These are its radii, its width, and the height of its center (m).
OUTER, INNER, WIDTH, MIDDLE = 0.031, 0.022, 0.010, 0.048
# Length of edges (m).
SIZE = 0.0095

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
occ, mesh = gmsh.model.occ, gmsh.model.mesh


def across(radius):
    return 3, occ.addCylinder(RADIUS, -WIDTH / 2, MIDDLE, 0, WIDTH, 0, radius)


cup = 3, occ.addCylinder(0, 0, 0, 0, 0, HEIGHT, RADIUS)
# The seam of a cylinder is on the side of x. This rotates the seam away from the handle.
occ.rotate([cup], 0, 0, 0, 0, 0, 1, 2)
ring, _ = occ.cut([across(OUTER)], [across(INNER)])
solid, _ = occ.fuse([cup], ring)
hollow = 3, occ.addCylinder(0, 0, WALL, 0, 0, HEIGHT, RADIUS - WALL)
occ.rotate([hollow], 0, 0, 0, 0, 0, 1, 2)
parts, _ = occ.cut(solid, [hollow])
assert len(parts) == 1
occ.synchronize()

gmsh.option.setNumber("Mesh.MeshSizeMin", SIZE)
gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
mesh.generate(3)
mesh.optimize("")
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.model.addPhysicalGroup(3, [tag for _, tag in parts], name="mug")
gmsh.write("mug.msh")
_, tags, _ = mesh.getElements(3)
quality = mesh.getElementQualities(tags[0], "gamma")
print(f"{len(tags[0])} tetrahedra, least quality {min(quality):.2f}")
gmsh.finalize()
