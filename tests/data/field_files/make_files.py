"""Writes the files of Gmsh and VTK to the folder of this script: pip install gmsh==4.15.2 vtk==9.7.2 && python make_files.py"""

import os
import struct
from pathlib import Path

import gmsh
import vtk

HERE = Path(__file__).parent


def write_gmsh():
    """Writes a box in all versions that Gmsh writes, with and without parameters of its nodes (SaveParametric)."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 10.0)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    for version, digits in (("2.2", 22), ("4.0", 40), ("4.1", 41)):
        # Gmsh 4.15 does not write version 4.0 in binary.
        for is_binary in (0, 1) if digits != 40 else (0,):
            for is_parametric in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", digits / 10)
                gmsh.option.setNumber("Mesh.Binary", is_binary)
                gmsh.option.setNumber("Mesh.SaveParametric", is_parametric)
                encoding = "binary" if is_binary else "ascii"
                parameters = "_parametric" if is_parametric else ""
                gmsh.write(str(HERE / f"box_{version.replace('.', '_')}_{encoding}{parameters}.msh"))
    # The path is written to the file.
    os.chdir(HERE)
    gmsh.write("box.inp")
    gmsh.write("box.mesh")
    gmsh.finalize()


def write_gmsh_4_0_binary():
    """Writes the tetrahedron of gmsh_4_0.msh in binary, as the manual of Gmsh 4.0 describes it."""
    text = b"$MeshFormat\n4 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n" + struct.pack("<2Q3iQ", 1, 4, 0, 3, 0, 4)
    for tag, corner in enumerate([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], 1):
        text += struct.pack("<i3d", tag, *corner)
    text += b"\n$EndNodes\n$Elements\n" + struct.pack("<2Q3iQ5i", 1, 1, 0, 3, 4, 1, 1, 1, 2, 3, 4) + b"\n$EndElements\n"
    (HERE / "gmsh_4_0_binary.msh").write_bytes(text)


def grid():
    points, data = vtk.vtkPoints(), vtk.vtkDoubleArray()
    points.SetDataType(vtk.VTK_DOUBLE)
    data.SetName("some depth")
    for k, corner in enumerate([(9, 9, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]):
        points.InsertNextPoint(corner)
        data.InsertNextValue(k)
    made = vtk.vtkUnstructuredGrid()
    made.SetPoints(points)
    made.InsertNextCell(vtk.VTK_TETRA, 4, [1, 2, 3, 4])
    made.InsertNextCell(vtk.VTK_TRIANGLE, 3, [1, 2, 3])
    made.GetPointData().AddArray(data)
    return made


def write_vtk():
    """Writes a tetrahedron of VTK in all encodings of XML, and in the versions and encodings of legacy files."""
    for order, set_order in (("little", "SetByteOrderToLittleEndian"), ("big", "SetByteOrderToBigEndian")):
        for header, set_header in (("32", "SetHeaderTypeToUInt32"), ("64", "SetHeaderTypeToUInt64")):
            for mode in ("Ascii", "Binary", "Appended", "AppendedRaw"):
                for compressor in ("None", "ZLib"):
                    writer = vtk.vtkXMLUnstructuredGridWriter()
                    writer.SetInputData(grid())
                    getattr(writer, set_order)()
                    getattr(writer, set_header)()
                    getattr(writer, f"SetDataModeTo{mode.removesuffix('Raw')}")()
                    writer.SetEncodeAppendedData(mode == "Appended")
                    getattr(writer, f"SetCompressorTypeTo{compressor}")()
                    name = f"{order}_{header}_{mode}_{compressor}.vtu".lower()
                    writer.SetFileName(str(HERE / "vtk" / name))
                    writer.Write()
    for version in (42, 51):
        for encoding in ("ASCII", "Binary"):
            writer = vtk.vtkUnstructuredGridWriter()
            writer.SetInputData(grid())
            writer.SetFileVersion(version)
            getattr(writer, f"SetFileTypeTo{encoding}")()
            writer.SetFileName(str(HERE / "vtk" / f"legacy_{version}_{encoding}.vtk".lower()))
            writer.Write()
    sphere = vtk.vtkSphereSource()
    stripper = vtk.vtkStripper()
    stripper.SetInputConnection(sphere.GetOutputPort())
    for name, source in (("polygons", sphere), ("strips", stripper)):
        source.Update()
        for writer, extension in ((vtk.vtkXMLPolyDataWriter(), "vtp"), (vtk.vtkPolyDataWriter(), "vtk")):
            writer.SetInputData(source.GetOutput())
            writer.SetFileName(str(HERE / "vtk" / f"{name}.{extension}"))
            writer.Write()


(HERE / "vtk").mkdir(exist_ok=True)
write_gmsh()
write_gmsh_4_0_binary()
write_vtk()
