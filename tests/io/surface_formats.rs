//! Surfaces in PLY, OFF, glTF and COLLADA files.

use hydroelastic::io::{FileError, Placement, read_triangle_surface, read_triangles};
use hydroelastic::mesh::TriangleSurface;
use nalgebra::{Vector3, vector};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Rounding error of matrices in single precision.
const SINGLE: f64 = 1e-6;

/// Corners and triangles of the unit tetrahedron at the origin.
const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn read(name: &str, bytes: &[u8]) -> Result<TriangleSurface, FileError> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    read_triangle_surface(path, &Placement::default())
}

fn refusal(name: &str, bytes: &[u8]) -> String {
    let error = read(name, bytes).unwrap_err();
    let source = error.source().map(ToString::to_string);
    format!("{error} {}", source.unwrap_or_default())
}

/// Asserts that a surface has this volume and these bounds.
fn assert_box(surface: &TriangleSurface, volume: f64, lower: [f64; 3], upper: [f64; 3]) {
    assert!(
        (surface.volume() / volume - 1.0).abs() < SINGLE,
        "{}",
        surface.volume()
    );
    let bounds = surface.aabb();
    assert!(
        (bounds.lower - Vector3::from(lower)).amax() < SINGLE,
        "{bounds:?}"
    );
    assert!(
        (bounds.upper - Vector3::from(upper)).amax() < SINGLE,
        "{bounds:?}"
    );
}

/// Returns a PLY file with properties of several types around the coordinates and the corners.
fn ply(format: &str) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat {format} 1.0\ncomment of a scanner\nelement camera 1\nproperty list uchar short path\nelement vertex 4\n\
         property uchar red\nproperty double x\nproperty float y\nproperty float32 z\nelement face 4\nproperty int8 flag\n\
         property list uint8 int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let is_big = format.contains("big");
    if format == "ascii" {
        let mut text = String::from("2 -5 6\n");
        for [x, y, z] in CORNERS {
            writeln!(text, "255 {x} {y} {z}").unwrap();
        }
        for [a, b, c] in TRIANGLES {
            writeln!(text, "-1 3 {a} {b} {c}").unwrap();
        }
        file.extend(text.into_bytes());
        return file;
    }
    let mut push = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if is_big {
            bytes.reverse();
        }
        file.extend(bytes);
    };
    push(&[2]);
    push(&(-5_i16).to_le_bytes());
    push(&6_i16.to_le_bytes());
    for [x, y, z] in CORNERS {
        push(&[255]);
        push(&f64::from(x).to_le_bytes());
        push(&y.to_le_bytes());
        push(&z.to_le_bytes());
    }
    for triangle in TRIANGLES {
        push(&[255]);
        push(&[3]);
        for corner in triangle {
            push(&i32::from(corner).to_le_bytes());
        }
    }
    file
}

#[test]
fn ply_files_of_all_encodings_have_their_solid() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let surface = read("tetrahedron.ply", &ply(format)).unwrap();
        assert_box(&surface, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
        let file = ply(format);
        let cut = refusal("cut.ply", &file[..file.len() - 2]);
        assert!(
            cut.contains("cannot be in the last") || cut.contains("end of the file"),
            "{cut}"
        );
    }
}

#[test]
fn ply_faces_may_precede_their_vertices() {
    let text = "ply\nformat ascii 1.0\nelement face 3\nproperty list uchar int vertex_indices\nelement edge 2\nproperty int vertex1\n\
        element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\n\
        end_header\n3 0 2 1\n3 0 1 3\n3 0 3 2\n7\n8\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 1 2 3\n";
    let surface = read("early.ply", text.as_bytes()).unwrap();
    assert_box(&surface, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
    let missing = refusal("early.ply", text.replace("3 0 3 2", "3 0 4 2").as_bytes());
    let expected = "line 16, \"3 0 4 2\": vertex 4 is not one of the 4 vertices";
    assert!(missing.contains(expected), "{missing}");
}

#[test]
fn ply_headers_without_a_format_are_refused() {
    let text = String::from_utf8(ply("ascii")).unwrap();
    let without = refusal(
        "format.ply",
        text.replace("format ascii 1.0\n", "").as_bytes(),
    );
    assert!(
        without.contains("the header has no line \"format\""),
        "{without}"
    );
    let unknown = refusal("unknown.ply", text.replace("ascii", "base64").as_bytes());
    assert!(
        unknown.contains("binary_little_endian or binary_big_endian"),
        "{unknown}"
    );
}

#[test]
fn ply_strips_and_polygons_are_triangles() {
    let strip = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
        9 0 2 1 3 0 2 -1 0 1\n";
    let surface = read("strip.ply", strip.as_bytes()).unwrap();
    assert_box(&surface, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
}

#[test]
fn off_files_have_comments_and_colors() {
    let off = "# of CGAL\nCOFF 8 6 0\n\n0 0 0 255 0 0 1\n1 0 0 0 0 0 1 # corner\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n\
        4 3 2 1 0 255 0 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
    let cube = read("cube.off", off.as_bytes()).unwrap();
    assert_box(&cube, 1.0, [0.0; 3], [1.0; 3]);
    let in_one_word = off.replace("COFF 8 6 0", "OFF8 6 0");
    let cube = read("word.off", in_one_word.as_bytes()).unwrap();
    assert_box(&cube, 1.0, [0.0; 3], [1.0; 3]);
    for (from, to, expected) in [
        ("COFF", "POFF", "expected the word OFF"),
        ("8 6 0", "8", "the numbers of vertices and faces"),
        ("8 6 0", "8 7 0", "expected a face"),
        ("4 4 5 6 7", "4 4 5 6", "indices below 8"),
        ("4 4 5 6 7", "4 4 5 6 8", "indices below 8"),
        ("1 0 1\n", "1 0 one\n", "line 9"),
    ] {
        let refused = refusal("wrong.off", off.replace(from, to).as_bytes());
        assert!(refused.contains(expected), "{refused}");
    }
}

/// Returns a binary glTF file with the tetrahedron in a node of these properties, below a node that doubles lengths.
fn glb(node: &str, mode: &str) -> Vec<u8> {
    let (json, data) = gltf(node, mode, "");
    binary(json, data)
}

fn binary(json: String, data: Vec<u8>) -> Vec<u8> {
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunks = [(*b"JSON", json), (*b"BIN\0", data)];
    let size: usize = 12
        + chunks
            .iter()
            .map(|(_, bytes)| 8 + bytes.len())
            .sum::<usize>();
    let number = |number: usize| u32::try_from(number).unwrap().to_le_bytes();
    let mut file = [b"glTF".as_slice(), &number(2), &number(size)].concat();
    for (kind, bytes) in chunks {
        file.extend(number(bytes.len()));
        file.extend(kind);
        file.extend(bytes);
    }
    file
}

fn gltf(node: &str, mode: &str, uri: &str) -> (String, Vec<u8>) {
    let mut data: Vec<u8> = CORNERS
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    data.extend(
        TRIANGLES
            .iter()
            .flatten()
            .flat_map(|corner| corner.to_le_bytes()),
    );
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [1]}}],
        "nodes": [{{"mesh": 0 {node}}}, {{"children": [0], "scale": [2, 2, 2]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1 {mode}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
                      {{"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 24}}],
        "buffers": [{{"byteLength": 72 {uri}}}]}}"#
    );
    (json, data)
}

#[test]
fn gltf_scenes_are_placed_by_their_nodes_with_y_upwards() {
    // The file's y axis becomes z, and its z axis becomes −y.
    let plain = read("plain.glb", &glb("", "")).unwrap();
    assert_box(&plain, 8.0 / 6.0, [0.0, -2.0, 0.0], [2.0, 0.0, 2.0]);
    let moved = glb(r#", "translation": [1, 2, 3], "scale": [-1, 1, 3]"#, "");
    let moved = read("moved.glb", &moved).unwrap();
    assert_box(&moved, 8.0 / 2.0, [0.0, -12.0, 4.0], [2.0, -6.0, 6.0]);
    let turned = glb(
        r#", "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]"#,
        "",
    );
    let turned = read("turned.glb", &turned).unwrap();
    assert_box(&turned, 8.0 / 6.0, [-2.0, -2.0, 0.0], [0.0, 0.0, 2.0]);
    let matrix = glb(
        r#", "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]"#,
        "",
    );
    let matrix = read("matrix.glb", &matrix).unwrap();
    assert_box(&matrix, 8.0 / 6.0, [0.0, -2.0, 0.0], [2.0, 0.0, 2.0]);
}

#[test]
fn gltf_files_in_text_have_embedded_buffers() {
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA";
    let uri = format!(r#", "uri": "data:application/octet-stream;base64,{base64}""#);
    let (json, _) = gltf("", "", &uri);
    let surface = read("text.gltf", json.as_bytes()).unwrap();
    assert_box(&surface, 8.0 / 6.0, [0.0, -2.0, 0.0], [2.0, 0.0, 2.0]);
    let (json, _) = gltf("", "", r#", "uri": "part.bin""#);
    let refused = refusal("outside.gltf", json.as_bytes());
    assert!(refused.contains("save as .glb"), "{refused}");
}

#[test]
fn byte_order_marks_are_ignored() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let facets: String = TRIANGLES.iter().fold(String::new(), |text, triangle| {
        let corners = triangle.map(|corner| CORNERS[usize::from(corner)]);
        let corners = corners.map(|[x, y, z]| format!("vertex {x} {y} {z}\n"));
        format!(
            "{text}facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            corners.concat()
        )
    });
    let stl = format!("solid\n{facets}endsolid\n");
    let ply = String::from_utf8(ply("ascii")).unwrap();
    let dae = dae(Z_UP, FACES, NODE);
    for (name, text) in [
        ("mark.obj", obj),
        ("mark.stl", &stl),
        ("mark.ply", &ply),
        ("mark.dae", &dae),
    ] {
        let marked = ["\u{feff}", text].concat();
        let surface = read(name, marked.as_bytes()).unwrap();
        assert_box(&surface, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
    }
    let damaged = refusal("mark.obj", "\u{feff}v 0 0 zero".as_bytes());
    assert!(damaged.contains("is not an OBJ file"), "{damaged}");
}

#[test]
fn gltf_primitives_keep_the_vertices_that_they_use() {
    let (json, data) = gltf("", "", "");
    let file = |json: &str| {
        let mut file = glb("", "");
        file.truncate(12);
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &data)] {
            file.extend(u32::try_from(bytes.len()).unwrap().to_le_bytes());
            file.extend(kind);
            file.extend(bytes);
        }
        file
    };
    // Four primitives of one triangle each.
    let primitive = json.find("{\"attributes\"").unwrap();
    let end = json.find("}]}]").unwrap();
    let four =
        [2, 3, 4, 5].map(|k| format!(r#"{{"attributes": {{"POSITION": 0}}, "indices": {k}}}"#));
    let accessors = [0, 6, 12, 18].map(|offset| {
        format!(r#", {{"bufferView": 1, "byteOffset": {offset}, "componentType": 5123, "count": 3, "type": "SCALAR"}}"#)
    });
    let split = [&json[..primitive], &four.join(","), &json[end + 1..]].concat();
    let split = split.replace(
        r#""type": "SCALAR"}]"#,
        &format!(r#""type": "SCALAR"}}{}]"#, accessors.concat()),
    );
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("split.glb");
    std::fs::write(&path, file(&split)).unwrap();
    let soup = read_triangles(&path, &Placement::default()).unwrap();
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (12, 4));
    assert_box(
        &soup.closed().unwrap(),
        8.0 / 6.0,
        [0.0, -2.0, 0.0],
        [2.0, 0.0, 2.0],
    );

    let sparse = json.replacen(
        r#""type": "VEC3""#,
        r#""type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}"#,
        1,
    );
    let refused = refusal("sparse.glb", &file(&sparse));
    assert!(
        refused.contains("sparse accessors cannot be read"),
        "{refused}"
    );
}

#[test]
fn gltf_extras_and_extensions_of_materials_are_ignored() {
    let with = |members: &str| {
        let (json, data) = gltf(
            r#", "extras": 3"#,
            r#", "material": 0, "extras": ["a"]"#,
            "",
        );
        binary(json.replacen('{', &format!("{{{members},"), 1), data)
    };
    let textures = r#""extras": "text", "textures": [{"extensions": {"EXT_texture_webp": {"source": 0}}}],
        "extensionsRequired": ["EXT_texture_webp", "KHR_texture_transform", "KHR_materials_unlit", "KHR_lights_punctual"]"#;
    let surface = read("textures.glb", &with(textures)).unwrap();
    assert!((surface.volume() - 8.0 / 6.0).abs() < 1e-6);
    let draco = r#""extensionsRequired": ["KHR_texture_transform", "KHR_draco_mesh_compression"]"#;
    let refused = refusal("draco.glb", &with(draco));
    assert!(refused.contains("KHR_draco_mesh_compression"), "{refused}");
}

#[test]
fn invalid_gltf_files_are_refused() {
    for (node, mode, expected) in [
        (r#", "children": [1]"#, "", "too deep, or contains itself"),
        (r#", "children": [7]"#, "", "a node does not exist"),
        ("", r#", "mode": 1"#, "at least 4 triangles"),
    ] {
        let refused = refusal("wrong.glb", &glb(node, mode));
        assert!(refused.contains(expected), "{refused}");
    }
    let file = glb("", "");
    let cut = refusal("cut.glb", &file[..file.len() - 1]);
    assert!(cut.contains("is missing or truncated"), "{cut}");
    for offset in (0..file.len()).step_by(3) {
        let mut damaged = file.clone();
        damaged[offset] ^= 0x11;
        let _ = read("damaged.glb", &damaged).map_err(|error| error.to_string());
    }
}

/// Returns a COLLADA file with a tetrahedron in this list of faces, and a scene of these nodes.
fn dae(asset: &str, faces: &str, nodes: &str) -> String {
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset>{asset}</asset>
        <library_geometries><geometry id="tet"><mesh>
          <source id="points"><float_array id="array" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
            <technique_common><accessor source="#array" count="4" stride="3"/></technique_common></source>
          <vertices id="corners"><input semantic="POSITION" source="#points"/></vertices>
          {faces}
        </mesh></geometry></library_geometries>
        <library_nodes><node id="part"><instance_geometry url="#tet"/></node></library_nodes>
        <library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##
    )
}

const INPUTS: &str = r##"<input semantic="VERTEX" source="#corners" offset="0"/>"##;
const FACES: &str = r##"<triangles count="4"><input semantic="NORMAL" source="#points" offset="1"/>
    <input semantic="VERTEX" source="#corners" offset="0"/><p>0 9 2 9 1 9 0 9 1 9 3 9 0 9 3 9 2 9 1 9 2 9 3 9</p></triangles>"##;
const Z_UP: &str = "<up_axis>Z_UP</up_axis>";
const NODE: &str = r##"<node><instance_geometry url="#tet"/></node>"##;

#[test]
fn collada_faces_of_all_kinds_are_triangles() {
    let polylist = format!(
        "<polylist>{INPUTS}<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 0 3 2 1 2 3</p></polylist>"
    );
    let polygons =
        format!("<polygons>{INPUTS}<p>0 2 1</p><p>0 1 3</p><p>0 3 2</p><p>1 2 3</p></polygons>");
    let strips = format!("<tristrips>{INPUTS}<p>0 2 1 3 0 2</p></tristrips>");
    let fans = format!(
        "<trifans>{INPUTS}<p>0 2 1 3 2</p></trifans><trifans>{INPUTS}<p>1 2 3</p></trifans>"
    );
    for faces in [FACES, &polylist, &polygons, &strips, &fans] {
        let surface = read("faces.dae", dae(Z_UP, faces, NODE).as_bytes()).unwrap();
        assert_box(&surface, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
    }
}

#[test]
fn scale_factors_apply_to_the_axes_of_the_file() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("factors.dae");
    std::fs::write(&path, dae("", FACES, NODE)).unwrap();
    let placement = Placement {
        scale: vector![1.0, 2.0, -3.0],
        ..Placement::default()
    };
    let surface = read_triangle_surface(path, &placement).unwrap();
    assert_box(&surface, 1.0, [0.0; 3], [1.0, 3.0, 2.0]);
}

#[test]
fn collada_scenes_have_units_an_up_axis_and_nodes() {
    let millimeters = format!(r#"<unit name="mm" meter="0.001"/>{Z_UP}"#);
    let surface = read("unit.dae", dae(&millimeters, FACES, NODE).as_bytes()).unwrap();
    assert_box(&surface, 1e-9 / 6.0, [0.0; 3], [1e-3; 3]);
    let y_up = read("y_up.dae", dae("", FACES, NODE).as_bytes()).unwrap();
    assert_box(&y_up, 1.0 / 6.0, [0.0, -1.0, 0.0], [1.0, 0.0, 1.0]);
    let x_up = dae("<up_axis>X_UP</up_axis>", FACES, NODE);
    let x_up = read("x_up.dae", x_up.as_bytes()).unwrap();
    assert_box(&x_up, 1.0 / 6.0, [-1.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
    let nodes = r##"<node><translate>1 0 0</translate><node><rotate>0 0 1 90</rotate><scale>2 1 -1</scale>
        <instance_node url="#part"/></node></node>
        <node><matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#tet"/></node>"##;
    let nodes = read("nodes.dae", dae(Z_UP, FACES, nodes).as_bytes()).unwrap();
    assert_eq!(nodes.component_count(), 2);
    assert_box(&nodes, 0.5, [0.0, 0.0, -1.0], [6.0, 2.0, 1.0]);
}

#[test]
fn collada_comments_offsets_and_shared_sources_are_read() {
    let one = |triangle: &str| {
        format!("<triangles>{INPUTS}<p>{triangle}<!-- a comment --></p></triangles>")
    };
    let lists = ["0 2 1", "0 1 3", "0 3 2", "1 2 3"].map(one).concat();
    let commented = dae(Z_UP, &lists, NODE)
        .replace("0 0 0 1 0 0 0 1 0", "0 0 0 1<!-- x --> 0 0 <!-- y -->0 1 0")
        .replace("<p>1 2", "<p>1<!-- between --> 2");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shared.dae");
    std::fs::write(&path, commented).unwrap();
    let soup = read_triangles(&path, &Placement::default()).unwrap();
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (4, 4));
    assert_box(&soup.closed().unwrap(), 1.0 / 6.0, [0.0; 3], [1.0; 3]);
    let offset = dae(Z_UP, FACES, NODE)
        .replace("0 0 0 1 0 0 0 1 0", "7 7 0 0 0 7 7 1 0 0 7 7 0 1 0 7 7")
        .replace(
            "count=\"4\" stride=\"3\"",
            "count=\"4\" stride=\"5\" offset=\"2\"",
        );
    let offset = read("offset.dae", offset.as_bytes()).unwrap();
    assert_box(&offset, 1.0 / 6.0, [0.0; 3], [1.0; 3]);
}

#[test]
fn collada_skins_and_views_are_placed() {
    let skin = dae(
        Z_UP,
        FACES,
        r##"<node><scale>3 1 1</scale><instance_controller url="#skin"/></node>"##,
    );
    let skin = skin.replace(
        "<library_nodes>",
        r##"<library_controllers><controller id="skin"><skin source="#tet"><bind_shape_matrix>
        2 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller></library_controllers><library_nodes>"##,
    );
    let skin = read("skin.dae", skin.as_bytes()).unwrap();
    assert_box(&skin, 1.0, [3.0, 0.0, 0.0], [9.0, 1.0, 1.0]);
    // The node at (5, 0, 0) looks along −x, so that its axes x, y and z are the axes y, z and x of its parent.
    let view =
        r##"<node><lookat>5 0 0 4 0 0 0 0 1</lookat><instance_geometry url="#tet"/></node>"##;
    let view = read("view.dae", dae(Z_UP, FACES, view).as_bytes()).unwrap();
    assert_box(&view, 1.0 / 6.0, [5.0, 0.0, 0.0], [6.0, 1.0, 1.0]);
    let skew = r##"<node><skew>45 1 0 0 0 1 0</skew><instance_geometry url="#tet"/></node>"##;
    let refused = refusal("skew.dae", dae(Z_UP, FACES, skew).as_bytes());
    assert!(refused.contains("<skew>"), "{refused}");
}

#[test]
fn invalid_collada_files_are_refused() {
    let bomb: String = (0..60).fold(String::new(), |text, k| {
        let next = if k == 59 {
            "part".to_owned()
        } else {
            format!("n{}", k + 1)
        };
        let instance = format!(r##"<instance_node url="#{next}"/>"##);
        text + &format!(r#"<node id="n{k}">{instance}{instance}</node>"#)
    });
    for (faces, nodes, expected) in [
        (
            FACES,
            r##"<node><instance_geometry url="#no"/></node>"##,
            "refers to \"#no\"",
        ),
        (
            FACES,
            r##"<node id="a"><instance_node url="#a"/></node>"##,
            "contains itself",
        ),
        (FACES, &bomb, "more than a million triangles"),
        (&FACES.replace("0 9 2", "0 9 4"), NODE, "refers to vertex 4"),
        (
            &FACES.replace("0 9 2", "0 9 two"),
            NODE,
            "\"two\" instead of a number",
        ),
        ("", NODE, "at least 4 triangles"),
    ] {
        let refused = refusal("wrong.dae", dae(Z_UP, faces, nodes).as_bytes());
        assert!(refused.contains(expected), "{refused}");
    }
    let other = refusal("other.dae", b"<svg/>");
    assert!(
        other.contains("the root element is not <COLLADA>"),
        "{other}"
    );
    let origin = vector![0.0, 0.0, 0.0];
    let library = dae(Z_UP, FACES, "")
        .replace("<scene>", "<extra>")
        .replace("</scene>", "</extra>");
    let library = read("library.dae", library.as_bytes()).unwrap();
    assert!(library.vertices().contains(&origin));
}
