"""Writes the hostile mesh files to its own folder: python3 make_files.py"""

import base64
import json
import struct
import zlib
from pathlib import Path

HERE = Path(__file__).parent
TRILLION = 10**12
# Slightly less than the largest u32.
BILLIONS = 4 * 10**9
U64 = 2**64 - 1

MSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 4 1 4
3 1 0 4
1
2
3
4
0 0 0
1 0 0
0 1 0
0 0 1
$EndNodes
$Elements
1 1 1 1
3 1 4 1
1 1 2 3 4
$EndElements
"""

VTK = """# vtk DataFile Version 3.0
one tetrahedron
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0
1 0 0
0 1 0
0 0 1
CELLS 1 5
4 0 1 2 3
CELL_TYPES 1
10
"""

VTK_5 = """# vtk DataFile Version 5.1
one tetrahedron
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0
1 0 0
0 1 0
0 0 1
CELLS 2 4
OFFSETS vtktypeint64
0 4
CONNECTIVITY vtktypeint64
0 1 2 3
CELL_TYPES 1
10
"""

VTU = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1">
<Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray>
</Cells>
</Piece>
</UnstructuredGrid>
</VTKFile>
"""

POINTS = 'format="ascii">0 0 0 1 0 0 0 1 0 0 0 1<'


def write(name, text, *changes):
    """Writes the text with each (from, to) replaced once."""
    for old, new in changes:
        assert old in text, (name, old)
        text = text.replace(old, str(new), 1)
    data = text if isinstance(text, bytes) else text.encode()
    (HERE / name).write_bytes(data)


def binary_msh(vertex=0.0, nodes=4, elements=1):
    """Returns a binary file. One coordinate, and the counts of two headers, can be changed."""
    head = b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n"
    points = [vertex, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    node_block = struct.pack("<3iQ4Q12d", 3, 1, 0, nodes, 1, 2, 3, 4, *points)
    tet_block = struct.pack("<3iQ5Q", 3, 1, 4, elements, 1, 1, 2, 3, 4)
    node_section = struct.pack("<4Q", 1, nodes, 1, nodes) + node_block
    tet_section = struct.pack("<4Q", 1, elements, 1, elements) + tet_block
    nodes_text = b"$Nodes\n" + node_section + b"\n$EndNodes\n"
    return head + nodes_text + b"$Elements\n" + tet_section + b"\n$EndElements\n"


def binary_vtk(points=4, version="3.0"):
    head = f"# vtk DataFile Version {version}\none\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS {points} double\n"
    coordinates = struct.pack(">12d", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
    cells = b"\nCELLS 1 5\n" + struct.pack(">5i", 4, 0, 1, 2, 3)
    return head.encode() + coordinates + cells + b"\nCELL_TYPES 1\n" + struct.pack(">i", 10) + b"\n"


def base64_of(layout, *numbers):
    return base64.b64encode(struct.pack(layout, *numbers)).decode()


def write_sound():
    """Writes the valid files, from which the other files are derived."""
    write("sound.msh", MSH)
    write("sound_binary.msh", binary_msh())
    write("sound.vtk", VTK)
    write("sound_5_1.vtk", VTK_5)
    write("sound_binary.vtk", binary_vtk())
    write("sound.vtu", VTU)
    coordinates = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    data = f'format="binary">{base64_of("<Q12d", 96, *coordinates)}<'
    write("sound_binary.vtu", VTU, (POINTS, data))


def write_msh():
    one_tet, header = "3 1 4 1\n1 1 2 3 4", "1 1 1 1\n3 1 4 1"
    write("trillion_tets.msh", MSH, (header, f"1 {TRILLION} 1 {TRILLION}\n3 1 4 {TRILLION}"))
    write("trillion_nodes.msh", MSH, ("1 4 1 4\n3 1 0 4", f"1 {TRILLION} 1 4\n3 1 0 {TRILLION}"))
    write("most_blocks.msh", MSH, ("1 1 1 1", f"{U64} 1 1 1"))
    write("trillion_points.msh", MSH, ("$Nodes", f"$Entities\n{TRILLION} 0 0 0\n1 0 0 0 0\n$EndEntities\n$Nodes"))
    write("number_beyond_all.msh", MSH, ("1 1 2 3 4", "1 1 2 3 99999999999999999999999"))
    write("negative_count.msh", MSH, ("3 1 4 1\n", "3 1 4 -1\n"))
    write("unknown_element_type.msh", MSH, ("3 1 4 1\n", "3 1 9999 1\n"))
    write("missing_node.msh", MSH, ("1 1 2 3 4", "1 1 2 3 5"))
    write("corner_twice.msh", MSH, ("1 1 2 3 4", "1 1 2 3 3"))
    write("tet_twice.msh", MSH, ("1 1 1 1\n" + one_tet, "1 2 1 2\n3 1 4 2\n1 1 2 3 4\n2 1 2 3 4"))
    write("word_for_a_number.msh", MSH, ("0 1 0", "0 one 0"))
    write("cut_in_elements.msh", MSH[: MSH.index("3 4\n$EndElements")])
    write("nan_vertex_binary.msh", binary_msh(vertex=float("nan")))
    write("infinite_vertex_binary.msh", binary_msh(vertex=float("inf")))
    write("most_nodes_binary.msh", binary_msh(nodes=U64))
    write("most_tets_binary.msh", binary_msh(elements=2**63))


def write_vtk():
    write("trillion_points.vtk", VTK, ("POINTS 4", f"POINTS {TRILLION}"))
    write("most_points.vtk", VTK, ("POINTS 4", f"POINTS {U64}"))
    write("most_points_binary.vtk", binary_vtk(points=2**62))
    write("billions_of_points.vtk", VTK, ("POINTS 4", f"POINTS {BILLIONS}"))
    write("billions_of_points_binary.vtk", binary_vtk(points=BILLIONS))
    write("billions_of_cells.vtk", VTK, ("CELLS 1 5", f"CELLS {BILLIONS} {BILLIONS}"))
    write("billions_of_cell_types.vtk", VTK, ("CELL_TYPES 1", f"CELL_TYPES {BILLIONS}"))
    write("trillion_cells.vtk", VTK, ("CELLS 1 5", f"CELLS {TRILLION} {5 * TRILLION}"))
    write("trillion_cell_types.vtk", VTK, ("CELL_TYPES 1", f"CELL_TYPES {TRILLION}"))
    write("most_corners.vtk", VTK, ("4 0 1 2 3", f"{2**32 - 1} 0 1 2 3"))
    write("missing_point.vtk", VTK, ("4 0 1 2 3", f"4 0 1 2 {2**32 - 1}"))
    write("nan_vertex.vtk", VTK, ("0 1 0", "0 nan 0"))
    write("huge_coordinates.vtk", VTK, ("0 0 1", "0 0 1e308"), ("0 1 0", "0 1e308 0"))
    write("word_for_a_number.vtk", VTK, ("4 0 1 2 3", "4 0 1 two 3"))
    write("unknown_cell_type.vtk", VTK, ("\n10\n", "\n250\n"))
    fields = "POINTS", f"FIELD FieldData {TRILLION}\nTimeValue 1 1 double\n0.5\nPOINTS"
    write("trillion_data_set_fields.vtk", VTK, fields)
    fields = "POINTS", f"FIELD FieldData 1\nTimeValue 1 {TRILLION} double\n0.5\nPOINTS"
    write("trillion_data_set_times.vtk", VTK, fields)
    data = "POINT_DATA 4\n"
    write("most_field_numbers.vtk", VTK + data + f"FIELD f 1\na {2**62} 8 double\n0 1 2 3\n")
    write("trillion_field_arrays.vtk", VTK + data + f"FIELD f {TRILLION}\na 1 4 double\n0 1 2 3\n")
    write("billions_of_field_numbers.vtk", VTK + data + f"FIELD f 1\na {BILLIONS} {BILLIONS} double\n0 1 2 3\n")
    write("billions_of_field_arrays.vtk", VTK + data + f"FIELD f {BILLIONS}\na 1 4 double\n0 1 2 3\n")
    write("billions_of_lookup_entries.vtk", VTK + data + f"LOOKUP_TABLE t {BILLIONS}\n0 0 0 0\n")
    write("billions_of_tensors.vtk", VTK + f"POINT_DATA {BILLIONS}\nTENSORS t double\n0 0 0 0\n")
    write("most_lookup_entries.vtk", VTK + data + f"LOOKUP_TABLE t {2**62}\n0 0 0 0\n")
    write("most_color_numbers.vtk", VTK + data + f"COLOR_SCALARS c {2**62}\n0 0 0 0\n")
    write("most_tensor_numbers.vtk", VTK + f"POINT_DATA {2**62}\nTENSORS t double\n0 0 0 0\n")
    most = f"{2**32 - 1} {2**32 - 1} {2**32 - 1}"
    grid = f"DATASET STRUCTURED_POINTS\nDIMENSIONS {most}\nORIGIN 0 0 0\nSPACING 1 1 1\n"
    write("most_grid_points.vtk", VTK[: VTK.index("DATASET")] + grid)
    write("end_beyond_all.vtk", VTK_5, ("\n0 4\n", f"\n0 {2**63 - 1}\n"))
    write("trillion_ends.vtk", VTK_5, ("CELLS 2 4", f"CELLS {TRILLION} {4 * TRILLION}"))
    write("no_ends.vtk", VTK_5, ("CELLS 2 4", "CELLS 0 4"), ("\n0 4\n", "\n"))
    write("cut_in_points_binary.vtk", binary_vtk()[:150])


def write_vtu():
    write("trillion_points.vtu", VTU, ('NumberOfPoints="4"', f'NumberOfPoints="{TRILLION}"'))
    write("billions_of_points.vtu", VTU, ('NumberOfPoints="4"', f'NumberOfPoints="{BILLIONS}"'))
    write("billions_of_cells.vtu", VTU, ('NumberOfCells="1"', f'NumberOfCells="{BILLIONS}"'))
    write("trillion_cells.vtu", VTU, ('NumberOfCells="1"', f'NumberOfCells="{TRILLION}"'))
    write("end_beyond_all.vtu", VTU, (">4<", f">{2**63 - 1}<"))
    write("negative_end.vtu", VTU, (">4<", ">-4<"))
    write("negative_corner.vtu", VTU, (">0 1 2 3<", ">0 1 2 -1<"))
    write("unknown_cell_type.vtu", VTU, (">10<", ">250<"))
    write("cell_type_beyond_all.vtu", VTU, (">10<", ">4000<"))
    write("no_cell_types.vtu", VTU, ('<DataArray type="UInt8" Name="types" format="ascii">10</DataArray>\n', ""))
    write("infinite_vertex.vtu", VTU, ("1 0 0 0 1<", "1 0 0 0 inf<"))
    write("most_components.vtu", VTU, ('NumberOfComponents="3"', f'NumberOfComponents="{U64}"'))
    binary = 'format="binary">'
    write("too_few_bytes.vtu", VTU, (POINTS, f"{binary}{base64_of('<Q2d', 96, 0, 0)}<"))
    write("no_base64.vtu", VTU, (POINTS, f"{binary}****$$$$<"))
    compressed = ('version="1.0" ', 'version="1.0" compressor="vtkZLibDataCompressor" ')
    blocks = base64_of("<4Q", U64, U64, U64, U64)
    write("most_blocks_zlib.vtu", VTU, compressed, (POINTS, f"{binary}{blocks}<"))
    no_zlib = base64_of("<4Q", 1, 96, 96, 12) + base64_of("<12B", *range(12))
    write("no_zlib_stream.vtu", VTU, compressed, (POINTS, f"{binary}{no_zlib}<"))
    zeros = zlib.compress(bytes(1 << 23), 9)
    bomb = base64_of("<4Q", 1, 1 << 23, 0, len(zeros)) + base64.b64encode(zeros).decode()
    write("zlib_bomb.vtu", VTU, compressed, (POINTS, f"{binary}{bomb}<"))
    appended = (POINTS, f'format="appended" offset="{U64}"><')
    data = '</UnstructuredGrid>\n<AppendedData encoding="base64">_AAAA</AppendedData>'
    write("appended_offset_beyond_all.vtu", VTU, appended, ("</UnstructuredGrid>", data))
    write("appended_to_nothing.vtu", VTU, appended)
    depth = 5000
    write("deep.vtu", VTU, ("<Points>", "<a>" * depth + "</a>" * depth + "<Points>"))
    write("entities.vtu", VTU, ('?>', '?><!DOCTYPE a [<!ENTITY b "1 1 1 1 1 1 1 1"><!ENTITY c "&b;&b;&b;&b;">]>'), ("0 0 0 1 0", "0 0 &c; 1 0"))
    write("element_for_attribute.vtu", VTU, (POINTS, f'{POINTS[:-1]}<DataArray ""></DataArray><@RangeMax ""><VTKFile></VTKFile></@RangeMax><'))
    write("not_closed.vtu", VTU, ("</VTKFile>", ""))
    write("cut_in_cells.vtu", VTU[: VTU.index('Name="offsets"')])
    write("empty.vtu", "")
    write("empty.msh", "")
    write("empty.vtk", "")


def write_others():
    """Writes files of Medit, Abaqus and TetGen."""
    medit = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n"
    write("sound.mesh", medit)
    write("trillion_vertices.mesh", medit, ("\n4\n", f"\n{TRILLION}\n"))
    write("cut_in_tets.mesh", medit[: medit.index(" 4 0\nEnd")])
    write("vertex_zero.mesh", medit, ("1 2 3 4 0", "0 1 2 3 0"))
    write("empty.mesh", "")
    abaqus = "*Heading\n** one\n*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*Element, type=C3D4\n1, 1, 2,\n3, 4\n"
    write("sound.inp", abaqus)
    write("cut_in_element.inp", abaqus[: abaqus.index("3, 4\n")])
    write("word_for_a_number.inp", abaqus, ("0, 1, 0", "0, one, 0"))
    nodes, tets = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n", "1 4 0\n0 0 1 2 3\n"
    write("sound.node", nodes)
    write("sound.ele", tets)
    write("most_attributes.node", nodes, ("4 3 0 0", f"4 3 {U64} {U64}"))
    write("most_attributes.ele", tets)
    write("trillion_nodes.node", nodes, ("4 3", f"{TRILLION} 3"))
    write("trillion_nodes.ele", tets)


def stl(count, *numbers):
    """Returns a binary STL file with a triangle count in its header and nine coordinates per triangle."""
    records = [numbers[k : k + 9] for k in range(0, len(numbers), 9)]
    bodies = [struct.pack("<12fH", 0, 0, 0, *record, 0) for record in records]
    return bytes(80) + struct.pack("<I", count) + b"".join(bodies)


def write_surfaces():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    triangles = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    numbers = [number for triangle in triangles for corner in triangle for number in corners[corner]]
    write("sound.stl", stl(4, *numbers))
    write("most_triangles.stl", stl(2**32 - 1, *numbers))
    write("fewer_triangles.stl", stl(3, *numbers))
    write("nan_vertex.stl", stl(4, *numbers[:-1], float("nan")))
    write("cut_in_triangles.stl", stl(4, *numbers)[:-20])
    write("empty.stl", "")
    facet = "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n"
    facets = [
        facet.format("".join("vertex {} {} {}\n".format(*corners[corner]) for corner in triangle))
        for triangle in triangles
    ]
    text = f"solid one\n{''.join(facets)}endsolid one\n"
    write("sound_ascii.stl", text)
    write("infinite_vertex_ascii.stl", text, ("vertex 0 1 0", "vertex 0 1e999 0"))
    write("four_corners_ascii.stl", text, ("endloop", "vertex 1 1 1\nendloop"))
    write("cut_in_facet_ascii.stl", text[: text.rindex("endloop")])
    obj = "".join("v {} {} {}\n".format(*corner) for corner in corners)
    obj += "".join("f {} {} {}\n".format(*(c + 1 for c in triangle)) for triangle in triangles)
    write("sound.obj", obj)
    write("vertex_beyond_all.obj", obj, ("f 1 3 2", f"f 1 {2**63 - 1} 2"))
    write("vertex_before_all.obj", obj, ("f 1 3 2", f"f 1 -{2**63} 2"))
    write("texture_before_all.obj", "vt 0 0\n" + obj, ("f 1 3 2", "f 1/-9223372036854775808 3/-2 2"))
    write("nan_vertex.obj", obj, ("v 0 1 0", "v 0 nan 0"))
    write("three_faces.obj", obj, ("f 2 3 4\n", ""))
    loops = " ".join(["1", "2"] * 2000)
    write("endless_face.obj", obj + f"f {loops}\n")
    write("empty.obj", "")
    write_formats_of_polygons(corners, triangles)


def write_formats_of_polygons(corners, triangles):
    points = "".join("{} {} {}\n".format(*corner) for corner in corners)
    faces = "".join("3 {} {} {}\n".format(*triangle) for triangle in triangles)
    off = f"OFF\n4 4 0\n{points}{faces}"
    write("sound.off", off)
    write("trillion_points.off", off, ("4 4 0", f"{TRILLION} 4 0"))
    write("trillion_corners.off", off, ("3 0 2 1", f"{TRILLION} 0 2 1"))
    write("missing_point.off", off, ("3 0 2 1", "3 0 2 4"))
    write("nan_vertex.off", off, ("0 1 0", "0 nan 0"))
    write("empty.off", "")
    header = (
        "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    )
    ply = header.format("ascii") + points + faces
    write("sound.ply", ply)
    write("trillion_points.ply", ply, ("vertex 4", f"vertex {TRILLION}"))
    write("trillion_empty_elements.ply", ply, ("element face", f"element nothing {TRILLION}\nelement face"))
    write("trillion_corners.ply", ply.replace("uchar int", "double int"), ("3 0 2 1", f"{TRILLION} 0 2 1"))
    write("missing_point.ply", ply, ("3 0 2 1", "3 0 2 -4"))
    write("no_format.ply", ply, ("format ascii 1.0\n", ""))
    write("endless_header.ply", ply, ("end_header\n", ""))
    write("empty.ply", "")
    body = b"".join(struct.pack("<3f", *corner) for corner in corners)
    body += b"".join(struct.pack("<B3i", 3, *triangle) for triangle in triangles)
    binary = header.format("binary_little_endian").encode() + body
    write("sound_binary.ply", binary)
    write("cut_in_faces_binary.ply", binary[:-1])
    write("most_corners_binary.ply", header.format("binary_little_endian").replace("uchar", "uint").encode() + body)
    write_mujoco(corners, triangles)
    write_glb(corners, triangles)
    write_dae(points, triangles)


def write_mujoco(corners, triangles):
    def mesh(normals=0, count=4, last=3, vertex=1.0):
        numbers = [x for corner in corners for x in corner][:-1] + [vertex]
        body = struct.pack("<12f", *numbers) + bytes(12 * normals)
        return struct.pack("<4i", 4, normals, 0, count) + body + struct.pack("<12i", *sum(triangles, ())[:-1], last)

    write("mujoco.msh", mesh(normals=4))
    write("mujoco_most_triangles.msh", mesh(count=2**31 - 1))
    write("mujoco_negative_count.msh", mesh(count=-1))
    write("mujoco_missing_vertex.msh", mesh(last=2**31 - 1))
    write("mujoco_infinite_vertex.msh", mesh(vertex=float("inf")))
    write("mujoco_cut.msh", mesh()[:-1])


def glb(document, data):
    text = (document if isinstance(document, str) else json.dumps(document)).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def write_glb(corners, triangles):
    data = b"".join(struct.pack("<3f", *corner) for corner in corners)
    data += b"".join(struct.pack("<3H", *triangle) for triangle in triangles)

    def document(count=4, nodes=({"mesh": 0},), length=24, stride=None, view=1):
        views = [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": length}]
        if stride:
            views[0]["byteStride"] = stride
        return {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": list(nodes),
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"},
                {"bufferView": view, "componentType": 5123, "count": 12, "type": "SCALAR"},
            ],
            "bufferViews": views,
            "buffers": [{"byteLength": len(data)}],
        }

    write("sound.glb", glb(document(), data))
    write("trillion_points.glb", glb(document(count=TRILLION), data))
    write("most_points.glb", glb(document(count=U64, stride=252), data))
    write("view_beyond_all.glb", glb(document(length=U64), data))
    write("missing_view.glb", glb(document(view=7), data))
    write("node_in_itself.glb", glb(document(nodes=[{"mesh": 0, "children": [0]}]), data))
    write("cut_in_data.glb", glb(document(), data)[:-1])
    write("deep.glb", glb('{"other":' + "[" * 4000, data))
    write("empty.glb", "")


def write_dae(points, triangles):
    numbers = " ".join(points.split())
    indices = " ".join(str(corner) for triangle in triangles for corner in triangle)
    dae = f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"><library_geometries><geometry id="g"><mesh>
<source id="s"><float_array count="12">{numbers}</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="w">
<node id="n0"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>
"""
    write("sound.dae", dae)
    write("offset_beyond_all.dae", dae, ('offset="0"', f'offset="{U64}"'))
    write("missing_point.dae", dae, (f"<p>{indices}", "<p>9 2 1"))
    write("node_in_itself.dae", dae, ('<instance_geometry url="#g"/>', '<instance_node url="#n0"/>'))
    write("not_closed.dae", dae, ("</COLLADA>", ""))
    write("empty.dae", "")


write_sound()
write_msh()
write_vtk()
write_vtu()
write_others()
write_surfaces()
