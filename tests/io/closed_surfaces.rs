//! Surfaces of rigid bodies from STL and OBJ files.

use hydroelastic::io::{FileError, Placement, read_triangle_surface};
use hydroelastic::mesh::{SurfaceError, TriangleSoup, TriangleSurface, shapes};
use nalgebra::Vector3;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Relative error of results from single-precision coordinates.
const SINGLE: f64 = 1e-6;

/// Rounding error of sums over some hundred triangles.
const ROUND_OFF: f64 = 1e-13;

/// A cube of edge 2 with quads, which uses all ways of OBJ to refer to a vertex, and a line along its edges.
const OBJ: &str = "# of a CAD program: \u{e9}\nmtllib none.mtl\no cube\nv 0 0 0\nv 2 0 0 1.0\nv 2 2 0 0.5 0.5 0.5\n\
    v 0 2 0\nvt 0 0\nvn 0 0 1\nf 4/1/1 3//1 2/1 1\ng top\ns off\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\nusemtl red\n\
    f -4 -3 -2 -1\nf 1 2 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8 7\n\nf 4 1 5 8\n\
    l 1 2 3 7\n";

fn read_bytes(name: &str, bytes: &[u8]) -> Result<TriangleSurface, FileError> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    read_triangle_surface(path, &Placement::default())
}

/// Returns the message of an error and of its causes.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let error = read_bytes(name, bytes).unwrap_err();
    let source = error.source().map(ToString::to_string);
    format!("{error} {}", source.unwrap_or_default())
}

fn ball() -> TriangleSurface {
    let field = shapes::icosphere(0.5, 2).unwrap();
    TriangleSurface::around(field.mesh()).unwrap()
}

/// Returns a ball of 5 mm, in millimeters, 1 km away from the origin.
fn far_ball() -> TriangleSurface {
    let far = Vector3::new(0.3, 0.5, 0.8).normalize() * 1e6;
    let moved = |corner: Vector3<f64>| corner * 10.0 + far;
    let triangles: Vec<_> = corners(&ball()).map(|t| t.map(moved)).collect();
    TriangleSoup::from_corners(&triangles).closed().unwrap()
}

fn corners(surface: &TriangleSurface) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    (0..surface.triangles().len()).map(|triangle| surface.corners(triangle))
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the format has single precision"
)]
fn binary_stl(surface: &TriangleSurface, header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(
        u32::try_from(surface.triangles().len())
            .unwrap()
            .to_le_bytes(),
    );
    for triangle in corners(surface) {
        bytes.extend([0xaa; 12]);
        let numbers = triangle.iter().flat_map(|corner| corner.iter());
        bytes.extend(numbers.flat_map(|&number| (number as f32).to_le_bytes()));
        bytes.extend([1, 2]);
    }
    bytes
}

/// Returns a mesh of MuJoCo with these numbers of normals and texture coordinates, which are NaN.
fn mujoco(surface: &TriangleSurface, normal_count: usize, texture_count: usize) -> Vec<u8> {
    let (vertices, triangles) = (surface.vertices(), surface.triangles());
    let counts = [vertices.len(), normal_count, texture_count, triangles.len()];
    let whole = |number: usize| u32::try_from(number).unwrap().to_le_bytes();
    let reals = vertices.iter().map(|vertex| vertex.cast::<f32>());
    let reals = reals.flat_map(<[f32; 3]>::from);
    let ignored = std::iter::repeat_n(f32::NAN, 3 * normal_count + 2 * texture_count);
    let words = counts.into_iter().map(whole);
    let words = words.chain(reals.chain(ignored).map(f32::to_le_bytes));
    let corners = triangles.as_flattened().iter().copied();
    words.chain(corners.map(whole)).flatten().collect()
}

/// Returns the triangles as two solids, with the keywords of the format and arbitrary text after them.
fn ascii_stl(surface: &TriangleSurface) -> String {
    let mut text = String::from("solid\n");
    for (index, triangle) in corners(surface).enumerate() {
        if index == 7 {
            text += "endsolid\n\n  SOLID the other one\r\n";
        }
        text += "facet normal 0 0 0\n outer loop\n";
        for corner in triangle {
            writeln!(text, "\tvertex {:e} {} {}", corner.x, corner.y, corner.z).unwrap();
        }
        text += " endloop\nEndFacet\n";
    }
    text + "endsolid the other one"
}

fn obj(surface: &TriangleSurface) -> String {
    let mut text = String::new();
    for corner in surface.vertices() {
        writeln!(text, "v {} {} {}", corner.x, corner.y, corner.z).unwrap();
    }
    for triangle in surface.triangles() {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text
}

#[test]
fn a_binary_stl_file_holds_the_surface_in_single_precision() {
    let ball = ball();
    // The header may be that of an ASCII file, or not text.
    for header in ["", "solid ball", "solid \nfacet", "\u{0}\n\u{e9}"] {
        let read = read_bytes("ball.stl", &binary_stl(&ball, header.as_bytes())).unwrap();
        assert_eq!(read.vertices().len(), ball.vertices().len());
        for (actual, expected) in corners(&read).zip(corners(&ball)) {
            for (actual, expected) in actual.iter().zip(expected) {
                assert_eq!(*actual, expected.cast::<f32>().cast::<f64>());
            }
        }
        assert!((read.volume() / ball.volume() - 1.0).abs() < SINGLE);
    }
}

#[test]
fn binary_meshes_of_mujoco_have_the_surface_in_single_precision() {
    let ball = ball();
    let count = ball.vertices().len();
    for (normal_count, texture_count) in [(0, 0), (count, count), (count, 0), (1, 2)] {
        let bytes = mujoco(&ball, normal_count, texture_count);
        let read = read_bytes("ball.msh", &bytes).unwrap();
        assert_eq!(read.triangles(), ball.triangles());
        for (actual, expected) in read.vertices().iter().zip(ball.vertices()) {
            assert_eq!(*actual, expected.cast::<f32>().cast::<f64>());
        }
    }
}

#[test]
fn wrong_binary_meshes_of_mujoco_are_located_errors() {
    let whole = mujoco(&ball(), 0, 1);
    let with = |word: usize, value: i32| {
        let mut bytes = whole.clone();
        bytes[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
        refusal("wrong.msh", &bytes)
    };
    let (nan, last) = (f32::NAN.to_bits().cast_signed(), whole.len() / 4 - 1);
    for (message, expected) in [
        (with(4 + 3 * 5, nan), "vertex 5 has the coordinate NaN"),
        (
            with(last, 162),
            "triangle 319 refers to vertex 162, but the file has 162",
        ),
        (with(last - 3, -1), "triangle 318 refers to vertex -1,"),
        (
            with(3, 321),
            "162 positions, 0 normals, 1 texture coordinates and 321 triangles in 5820 bytes, but the file has 5808",
        ),
        (with(0, -1), "states 4294967295 positions"),
        (
            refusal("wrong.msh", &whole[..15]),
            "needs 16 bytes, but the file has 15",
        ),
        (
            refusal("wrong.msh", &whole[..whole.len() - 4]),
            "but the file has 5804",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn errors_name_the_reader_of_gmsh_files() {
    let error = read_bytes("gmsh.msh", b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n").unwrap_err();
    assert!(matches!(error, FileError::HoldsGrid { .. }), "{error:?}");
    assert!(error.to_string().contains("read_mesh"), "{error}");
}

#[test]
fn an_ascii_stl_file_holds_all_its_solids_in_double_precision() {
    let ball = ball();
    let text = ascii_stl(&ball);
    for text in [text.replace('\n', "\r"), text] {
        let read = read_bytes("ball_ascii.STL", text.as_bytes()).unwrap();
        assert!(corners(&read).eq(corners(&ball)));
    }
}

#[test]
fn text_files_keep_the_shape_of_a_part_far_from_the_origin() {
    let ball = far_ball();
    for (name, text) in [("far.stl", ascii_stl(&ball)), ("far.obj", obj(&ball))] {
        let read = read_bytes(name, text.as_bytes()).unwrap();
        assert!(corners(&read).eq(corners(&ball)), "{name}");
    }
    // Coordinates rounded to single precision.
    let rounded = |corner: &Vector3<f64>| corner.cast::<f32>().cast::<f64>();
    let errors = ball.vertices().iter().map(|v| (v - rounded(v)).norm());
    let worst = errors.fold(0.0, f64::max);
    println!("up to {worst:.3} mm off in single precision");
    assert!(worst > 0.01);
}

#[test]
fn an_obj_file_holds_all_groups_and_its_quads_are_cut() {
    let mut latin = OBJ.as_bytes().to_vec();
    // The comment is not UTF-8.
    let accent = latin.iter().position(|&byte| byte == 0xc3).unwrap();
    latin.remove(accent);
    for bytes in [OBJ.as_bytes(), &latin] {
        let cube = read_bytes("cube.obj", bytes).unwrap();
        assert_eq!((cube.vertices().len(), cube.triangles().len()), (8, 12));
        assert!((cube.volume() - 8.0).abs() <= ROUND_OFF);
    }
}

#[test]
fn an_obj_face_that_is_bent_inwards_is_cut_from_a_corner_that_sees_it_all() {
    // A prism over an arrowhead with a concave third corner: two levels of four corners.
    let flat = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
    let mut text = String::new();
    for z in [0, 1] {
        for [x, y] in flat {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    text += "f 5 6 7 8\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    for turn in 0..4 {
        let top: Vec<String> = (0..4).map(|k| (5 + (k + turn) % 4).to_string()).collect();
        let turned = text.replace("f 5 6 7 8", &format!("f {}", top.join(" ")));
        let head = read_bytes("arrow.obj", turned.as_bytes()).unwrap();
        assert!((head.volume() - 1.0).abs() <= ROUND_OFF, "{turn}");
        // Two triangles of the top, of area 1/2 each. A triangle that extended outside would be larger.
        let is_top = |t: &[Vector3<f64>; 3]| t.iter().all(|corner| corner.z > 0.5);
        let area: f64 = corners(&head)
            .filter(is_top)
            .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
            .sum();
        assert!((area - 1.0).abs() <= ROUND_OFF, "{turn}: {area}");
    }
}

#[test]
fn the_unit_scales_the_surface() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/tool_use/tool.stl");
    let millimeters = read_triangle_surface(&path, &Placement::default()).unwrap();
    let meters = read_triangle_surface(&path, &Placement::from_unit(0.001)).unwrap();
    assert_eq!(meters.triangles().len(), 384);
    assert_eq!(meters.component_count(), 1);
    assert!((meters.volume() * 1e9 / millimeters.volume() - 1.0).abs() < ROUND_OFF);
    let aabb = meters.aabb();
    assert!(aabb.lower.z.abs() < 1e-9 && (aabb.upper.z - 0.065).abs() < 1e-9);
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = read_triangle_surface(&path, &Placement::from_unit(unit)).unwrap_err();
        assert!(
            matches!(&refused, FileError::Option { name, .. } if name == "unit"),
            "{refused}"
        );
    }
}

#[test]
fn stl_files_that_are_wrong_are_refused_where_they_are() {
    let whole = binary_stl(&ball(), b"");
    let cut = refusal("cut.stl", &whole[..whole.len() - 1]);
    assert!(
        cut.contains("states 320 triangles, but 319 triangles and 49 bytes follow"),
        "{cut}"
    );
    let mut longer = whole.clone();
    longer.push(b'!');
    let longer = refusal("longer.stl", &longer);
    assert!(
        longer.contains("320 triangles and 1 bytes follow"),
        "{longer}"
    );
    let short = refusal("short.stl", &whole[..83]);
    assert!(
        short.contains("needs 84 bytes, but the file has 83"),
        "{short}"
    );

    let text = ascii_stl(&ball());
    for (from, to, expected) in [
        (
            "facet normal",
            "facets normal",
            "line 2, \"facets normal 0 0 0\"",
        ),
        (
            " outer loop",
            " vertex 0 0 0",
            "line 3, \"vertex 0 0 0\": expected one of [\"outer\"]",
        ),
        ("\tvertex", "\tvertex nan", "line 4, \"vertex nan"),
        (
            "endsolid the other one",
            "",
            "expected one of [\"facet\", \"endsolid\"]",
        ),
    ] {
        assert!(text.contains(from));
        let refused = refusal("wrong.stl", text.replacen(from, to, 1).as_bytes());
        assert!(refused.contains(expected), "{refused}");
    }
    let nothing = read_bytes("nothing.stl", b"solid a\nendsolid a\n").unwrap_err();
    let source = SurfaceError::TooFewTriangles { count: 0 };
    assert!(
        matches!(&nothing, FileError::Surface { source: actual, .. } if *actual == source),
        "{nothing}"
    );
}

#[test]
fn obj_files_that_are_wrong_are_refused_where_they_are() {
    for (from, to, expected) in [
        (
            "v 2 0 0 1.0",
            "v 2 0",
            "line 5, \"v 2 0\": expected three finite coordinates",
        ),
        ("v 2 0 0 1.0", "v 2 inf 0", "line 5"),
        (
            "f -4 ",
            "f -9 ",
            "line 18, \"f -9 -3 -2 -1\": \"-9\" is not the index of one of the 8",
        ),
        ("f 1 2 6 5", "f 0 2 6 5", "line 19"),
        ("f 1 2 6 5", "f 9 2 6 5", "line 19"),
        ("f 1 2 6 5", "f 1 2", "4 edges belong to one triangle only"),
        (
            "f 1 2 6 5",
            "f 1 6 2 5",
            "3 edges belong to one triangle only",
        ),
        ("f 1 2 6 5\n", "", "4 edges belong to one triangle only"),
    ] {
        assert!(OBJ.contains(from));
        let refused = refusal("wrong.obj", OBJ.replacen(from, to, 1).as_bytes());
        assert!(refused.contains(expected), "{refused}");
    }
}

#[test]
fn files_that_are_cut_or_have_wrong_bytes_never_panic() {
    let ball = TriangleSurface::around(shapes::icosphere(0.5, 0).unwrap().mesh()).unwrap();
    let ascii = ascii_stl(&ball).into_bytes();
    for (name, bytes) in [
        ("damaged.stl", binary_stl(&ball, b"solid")),
        ("damaged_ascii.stl", ascii),
        ("damaged.msh", mujoco(&ball, 1, 1)),
        ("damaged.obj", OBJ.as_bytes().to_vec()),
    ] {
        for offset in (0..bytes.len()).step_by(1 + bytes.len() / 200) {
            let _ = read_bytes(name, &bytes[..offset]).map_err(|error| error.to_string());
            for wrong in [b'0', b'-', b'\n', 0xff, bytes[offset] ^ 1] {
                let mut damaged = bytes.clone();
                damaged[offset] = wrong;
                if let Ok(surface) = read_bytes(name, &damaged) {
                    assert!(surface.volume() > 0.0);
                }
            }
        }
    }
}

#[test]
fn other_files_are_refused_by_their_names() {
    let refused = read_triangle_surface("ball.step", &Placement::default()).unwrap_err();
    assert!(
        matches!(refused, FileError::UnknownExtension { .. }),
        "{refused}"
    );
    let refused = read_triangle_surface("no such file.stl", &Placement::default()).unwrap_err();
    assert!(matches!(refused, FileError::Read { .. }), "{refused}");
}
