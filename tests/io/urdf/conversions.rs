//! Shapes and joints of the dynamics from geometries and joints of robots.

use super::{jointed, robot};
use approx::assert_relative_eq;
use hydroelastic::dynamics::{self, BodyShape, JointKind, Material};
use hydroelastic::io::urdf::{
    Collision, Joint, JointOptions, MeshShape, RobotOptions, ShapeOptions, UrdfError, UrdfWarning,
};
use hydroelastic::io::{FileError, Placement, read_triangles};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::path::Path;

/// Rounding error of a volume.
const ROUND_OFF: f64 = 1e-14;

fn collision(geometry: &str) -> Collision {
    let link =
        format!("<link name='a'><collision><geometry>{geometry}</geometry></collision></link>");
    robot(&link).unwrap().links()[0].collisions[0].clone()
}

fn shape(geometry: &str, options: &ShapeOptions) -> Result<BodyShape, UrdfError> {
    collision(geometry).shape(options).map(|(shape, _)| shape)
}

fn volume(shape: &BodyShape) -> f64 {
    match shape {
        BodyShape::Compliant(shape) => shape.field().mesh().volume(),
        BodyShape::Rigid(shape) => shape.surface().volume(),
        other => panic!("{other:?}"),
    }
}

/// Mesh element of the corner of a cube, which has the volume 1/6.
fn corner(scale: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile_files");
    format!(
        "<mesh filename='{}/sound.obj' scale='{scale}'/>",
        folder.display()
    )
}

#[test]
fn primitives_become_compliant_shapes() {
    let options = ShapeOptions {
        subdivisions: 4,
        segments: 100,
        ..ShapeOptions::default()
    };
    for (geometry, expected, tolerance) in [
        ("<box size='1 2 3'/>", 6.0, ROUND_OFF),
        // Inscribed polyhedra omit about 0.3 % of the volume of the sphere, and less of the others.
        ("<sphere radius='2'/>", 4.0 / 3.0 * PI * 8.0, 4e-3),
        ("<cylinder radius='2' length='3'/>", PI * 4.0 * 3.0, 4e-3),
        (
            "<capsule radius='2' length='3'/>",
            PI * 4.0 * (3.0 + 8.0 / 3.0),
            4e-3,
        ),
    ] {
        let shape = shape(geometry, &options).unwrap();
        assert!(shape.compliant().is_some());
        assert_relative_eq!(volume(&shape), expected, max_relative = tolerance);
    }
}

#[test]
fn meshes_become_rigid_or_compliant_shapes() {
    let rigid = shape(&corner("1 1 1"), &ShapeOptions::default()).unwrap();
    assert!(rigid.is_rigid());
    assert_relative_eq!(volume(&rigid), 1.0 / 6.0, max_relative = ROUND_OFF);
    let options = ShapeOptions {
        meshes: MeshShape::StarShaped,
        ..ShapeOptions::default()
    };
    let compliant = shape(&corner("1 1 1"), &options).unwrap();
    assert!(compliant.compliant().is_some());
    assert_relative_eq!(volume(&compliant), 1.0 / 6.0, max_relative = ROUND_OFF);
}

#[test]
fn mirrored_meshes_keep_their_outer_side() {
    for scale in ["-1 2 3", "1 -2 3", "-1 -2 3", "-1 -2 -3"] {
        let shape = shape(&corner(scale), &ShapeOptions::default()).unwrap();
        assert_relative_eq!(volume(&shape), 1.0, max_relative = ROUND_OFF);
    }
    let mirrored = shape(&corner("-1 2 3"), &ShapeOptions::default()).unwrap();
    let bounds = mirrored.bounds().unwrap();
    assert_relative_eq!(bounds.lower, Vector3::new(-1.0, 0.0, 0.0));
    assert_relative_eq!(bounds.upper, Vector3::new(0.0, 2.0, 3.0));
}

#[test]
fn unknown_files_are_refused_by_name_when_they_are_loaded() {
    let error = shape("<mesh filename='hand.step'/>", &ShapeOptions::default()).unwrap_err();
    let start = "line 2: <mesh> of link \"a\": the name of hand.step ends in \"step\", but has to end in one of [";
    assert!(error.to_string().starts_with(start), "{error}");
}

#[test]
fn meshes_that_are_not_closed_become_their_hulls() {
    let mesh = |name: &str, meshes: MeshShape| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/field_files");
        let options = ShapeOptions {
            meshes,
            ..ShapeOptions::default()
        };
        shape(
            &format!("<mesh filename='file://{folder}/{name}'/>"),
            &options,
        )
    };
    for name in [
        "open_box.obj",
        "open_and_reversed.obj",
        "points.obj",
        "inwards.obj",
    ] {
        for kind in [MeshShape::Rigid, MeshShape::Hull, MeshShape::CompliantHull] {
            let shape = mesh(name, kind).unwrap();
            assert_eq!(shape.is_rigid(), kind != MeshShape::CompliantHull);
            assert_relative_eq!(volume(&shape), 1.0, max_relative = ROUND_OFF);
        }
        let refused = mesh(name, MeshShape::StarShaped).unwrap_err();
        assert!(matches!(refused, UrdfError::Surface { .. }), "{refused}");
    }
    // A closed mesh keeps its shape.
    let prism = mesh("u_prism.obj", MeshShape::Rigid).unwrap();
    assert_relative_eq!(volume(&prism), 7.0, max_relative = ROUND_OFF);
    let hull = mesh("u_prism.obj", MeshShape::Hull).unwrap();
    assert_relative_eq!(volume(&hull), 9.0, max_relative = ROUND_OFF);
}

#[test]
fn each_open_component_becomes_its_convex_hull() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/field_files");
    let boxes = [0.0, 3.0].map(|x| {
        let soup = read_triangles(format!("{folder}/open_box.obj"), &Placement::default()).unwrap();
        let corner =
            |vertex: &Vector3<f64>| format!("v {} {} {}\n", vertex.x + x, vertex.y, vertex.z);
        let count = soup.vertices.len();
        let first = if x > 0.0 { 1 + count } else { 1 };
        let face =
            |[a, b, c]: &[usize; 3]| format!("f {} {} {}\n", a + first, b + first, c + first);
        let vertices: String = soup.vertices.iter().map(corner).collect();
        vertices + &soup.triangles.iter().map(face).collect::<String>()
    });
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("open_boxes.obj");
    std::fs::write(&path, boxes.concat()).unwrap();
    let mesh = format!("<mesh filename='file://{}'/>", path.display());
    let (shape, warnings) = collision(&mesh).shape(&ShapeOptions::default()).unwrap();
    assert_relative_eq!(volume(&shape), 2.0, max_relative = ROUND_OFF);
    let [warning @ UrdfWarning::Hull { hull_count: 2, .. }] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    let text = warning.to_string();
    assert!(
        text.contains("replaced by the convex hulls of its 2 components"),
        "{text}"
    );
}

#[test]
fn changes_of_surfaces_are_reported() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/field_files");
    let warnings = |path: &str| {
        let mesh = format!("<mesh filename='file://{path}'/>");
        let shape = collision(&mesh).shape(&ShapeOptions::default());
        shape
            .map(|(shape, warnings)| (volume(&shape), warnings))
            .unwrap()
    };
    let (_, hull) = warnings(&format!("{folder}/open_box.obj"));
    assert!(matches!(hull[..], [UrdfWarning::Hull { .. }]), "{hull:?}");
    let text = hull[0].to_string();
    assert!(
        text.starts_with(
            "line 2: <mesh> of link \"a\" has a surface that is replaced by its convex hull"
        ),
        "{text}"
    );
    let (_, whole) = warnings(&format!("{folder}/inwards.obj"));
    assert!(
        matches!(
            whole[..],
            [UrdfWarning::Reversed {
                component_count: 1,
                ..
            }]
        ),
        "{whole:?}"
    );
    // Two corners of cubes. The second is turned inwards.
    let parts = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n\
        f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 6 7\nf 5 8 6\nf 5 7 8\nf 6 8 7\n";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("parts.obj");
    std::fs::write(&path, parts).unwrap();
    let (volume, parts) = warnings(path.to_str().unwrap());
    assert_relative_eq!(volume, 1.0 / 3.0, max_relative = ROUND_OFF);
    assert!(
        matches!(
            parts[..],
            [UrdfWarning::Reversed {
                component_count: 1,
                ..
            }]
        ),
        "{parts:?}"
    );
    let text = format!(
        "<link name='a'><collision><geometry><mesh filename='file://{folder}/open_box.obj' scale='20 20 20'/></geometry></collision></link>"
    );
    let mechanism = robot(&text)
        .unwrap()
        .mechanism(&RobotOptions::new(Material::rigid()))
        .unwrap();
    let [hull, size] = mechanism.warnings() else {
        panic!("{:?}", mechanism.warnings());
    };
    assert!(
        hull.contains("convex hull") && size.contains("2.000e1 m large"),
        "{hull} {size}"
    );
}

#[test]
fn meshes_that_cannot_be_read_are_errors() {
    let missing = shape("<mesh filename='no_such.stl'/>", &ShapeOptions::default()).unwrap_err();
    let UrdfError::MeshFile { source, .. } = missing else {
        panic!("{missing}");
    };
    assert!(matches!(*source, FileError::Read { .. }));
    let package = shape(
        "<mesh filename='package://arm/a.stl'/>",
        &ShapeOptions::default(),
    );
    assert!(matches!(package, Err(UrdfError::UnknownPackage { .. })));
    let flat = shape(&corner("1 1 1e-14"), &ShapeOptions::default()).unwrap_err();
    assert!(matches!(flat, UrdfError::Surface { .. }), "{flat}");
    let needle = shape("<box size='1 1e-9 1e-9'/>", &ShapeOptions::default()).unwrap_err();
    assert!(matches!(needle, UrdfError::Field { .. }), "{needle}");
}

fn joint(kind: &str, elements: &str) -> Joint {
    robot(&jointed(kind, elements)).unwrap().joints()[0].clone()
}

fn converted(kind: &str, elements: &str) -> dynamics::Joint {
    joint(kind, elements)
        .dynamics_joint(&JointOptions::default())
        .unwrap()
}

const LIMIT: &str = r#"<limit lower="-1" upper="2" effort="30" velocity="4"/>"#;

#[test]
fn a_joint_keeps_its_frame_its_law_and_its_limits() {
    let elements =
        r#"<origin xyz="1 2 3"/><axis xyz="0 0 2"/><dynamics damping="0.1" friction="0.2"/>"#;
    let elbow = converted("revolute", &format!("{elements}{LIMIT}"));
    assert_eq!((elbow.name(), elbow.parent()), ("elbow", Some("base")));
    assert_eq!(*elbow.kind(), JointKind::Revolute(Vector3::z_axis()));
    assert_eq!(*elbow.origin().translation(), Vector3::new(1.0, 2.0, 3.0));
    let law = elbow.law();
    assert_eq!(
        (law.damping, law.friction, law.actuator.limit),
        (0.1, 0.2, Some(30.0))
    );
    let stops = law.stops.unwrap();
    assert_eq!(
        (stops.range, stops.stiffness, stops.dissipation),
        ([-1.0, 2.0], 1e3, 1.0)
    );
}

#[test]
fn only_revolute_and_prismatic_joints_with_a_range_have_stops() {
    let slide = converted("prismatic", LIMIT);
    assert_eq!(*slide.kind(), JointKind::Prismatic(Vector3::x_axis()));
    assert_relative_eq!(slide.law().stops.unwrap().stiffness, 1e5);
    assert!(converted("continuous", LIMIT).law().stops.is_none());
    assert!(converted("fixed", LIMIT).law().stops.is_none());
    for limit in [
        "",
        "<limit effort='1'/>",
        "<limit lower='-inf' upper='inf'/>",
    ] {
        assert!(
            converted("revolute", limit).law().stops.is_none(),
            "{limit}"
        );
    }
    let options = JointOptions {
        revolute_stops: None,
        ..JointOptions::default()
    };
    let without = joint("revolute", LIMIT).dynamics_joint(&options).unwrap();
    assert!(without.law().stops.is_none());
}

#[test]
fn an_effort_of_zero_does_not_limit_the_actuator() {
    for limit in ["", "<limit effort='0'/>"] {
        let joint = converted("continuous", limit);
        assert!(joint.law().actuator.limit.is_none());
    }
}

#[test]
fn floating_and_planar_joints_are_refused() {
    for kind in ["floating", "planar"] {
        let error = joint(kind, "")
            .dynamics_joint(&JointOptions::default())
            .unwrap_err();
        let expected = format!(
            "line 3: joint \"elbow\" is a {kind} joint, but only revolute, continuous, prismatic and fixed joints can be converted"
        );
        assert_eq!(error.to_string(), expected);
    }
}
