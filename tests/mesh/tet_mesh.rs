//! Tetrahedral meshes: validation, surface, mass properties, inner vertices, distance fields.

use hydroelastic::mesh::{FieldTet, MeshError, PressureField, TetMesh, shapes};
use nalgebra::{Matrix3, Rotation3, Vector3, vector};
use std::collections::{BTreeMap, BTreeSet};

/// Sums over a few hundred tetrahedra, relative to the result.
const ROUND_OFF: f64 = 1e-14;

/// Moments of a shape ten times its size away from the origin: about a hundred roundings of
/// the squared coordinates.
const SHIFTED_ROUND_OFF: f64 = 1e-12;

/// The six tetrahedra of a cube about its diagonal (Kuhn), over corners numbered 4·x + 2·y + z.
const KUHN: [[usize; 4]; 6] = [
    [0, 4, 6, 7],
    [0, 4, 5, 7],
    [0, 2, 6, 7],
    [0, 2, 3, 7],
    [0, 1, 5, 7],
    [0, 1, 3, 7],
];

/// The five tetrahedra of a cube: one inside, four at corners.
const FIVE: [[usize; 4]; 5] = [
    [0, 3, 5, 6],
    [1, 0, 3, 5],
    [2, 0, 3, 6],
    [4, 0, 5, 6],
    [7, 3, 5, 6],
];

fn unit_corners() -> Vec<Vector3<f64>> {
    vec![
        vector![0.0, 0.0, 0.0],
        vector![1.0, 0.0, 0.0],
        vector![0.0, 1.0, 0.0],
        vector![0.0, 0.0, 1.0],
    ]
}

fn unit_tet() -> TetMesh {
    TetMesh::new(unit_corners(), vec![[0, 1, 2, 3]]).unwrap()
}

/// The cells of a grid (those at whose lowest corner `keeps` holds), six tetrahedra each.
fn grid(counts: [usize; 3], spacing: f64, keeps: impl Fn([usize; 3]) -> bool) -> TetMesh {
    let mut places = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut tets = Vec::new();
    let cells = (0..counts[0])
        .flat_map(|x| (0..counts[1]).flat_map(move |y| (0..counts[2]).map(move |z| [x, y, z])));
    for cell in cells.filter(|&cell| keeps(cell)) {
        let corner = |corner: usize| [2, 1, 0].map(|bit| corner >> bit & 1);
        let corners: Vec<usize> = (0..8)
            .map(|c| {
                let steps: [usize; 3] = std::array::from_fn(|axis| cell[axis] + corner(c)[axis]);
                *places.entry(steps).or_insert_with(|| {
                    vertices.push(Vector3::from(steps.map(|step| step as f64 * spacing)));
                    vertices.len() - 1
                })
            })
            .collect();
        tets.extend(KUHN.map(|tet| tet.map(|c| corners[c])));
    }
    TetMesh::new(vertices, tets).unwrap()
}

fn cube(tets: &[[usize; 4]]) -> TetMesh {
    let corner = |c: usize| Vector3::new((c >> 2 & 1) as f64, (c >> 1 & 1) as f64, (c & 1) as f64);
    TetMesh::new((0..8).map(corner).collect(), tets.to_vec()).unwrap()
}

/// A cube of edge 2 less a quarter of it: an L of height 2, its inward edge at x = y = 1.
fn l_shape(cells: usize) -> TetMesh {
    let keeps = |[x, y, _]: [usize; 3]| x < cells || y < cells;
    grid([2 * cells, 2 * cells, 2 * cells], 1.0 / cells as f64, keeps)
}

fn meshes() -> Vec<(&'static str, TetMesh)> {
    vec![
        ("one tetrahedron", unit_tet()),
        ("cube of five", cube(&FIVE)),
        ("cube of six", cube(&KUHN)),
        ("bar", grid([5, 1, 1], 0.25, |_| true)),
        ("plate", grid([3, 4, 1], 0.5, |_| true)),
        ("block", grid([3, 3, 3], 0.5, |_| true)),
        ("L", l_shape(1)),
        ("frame", grid([3, 3, 1], 1.0, |[x, y, _]| (x, y) != (1, 1))),
        ("ball", shapes::icosphere(0.3, 1).unwrap().mesh().clone()),
        (
            "disc",
            shapes::cylinder(0.5, 0.2, 9).unwrap().mesh().clone(),
        ),
    ]
}

fn transformed(mesh: &TetMesh, map: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> TetMesh {
    TetMesh::new(
        mesh.vertices().iter().map(map).collect(),
        mesh.tets().to_vec(),
    )
    .unwrap()
}

/// Volume inside the surface by the divergence theorem: Σ a·(b × c)/6.
fn enclosed_volume(mesh: &TetMesh) -> f64 {
    let origin = mesh.vertices()[0];
    let sixth = |triangle: &[usize; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex] - origin);
        a.dot(&b.cross(&c)) / 6.0
    };
    mesh.surface_triangles().iter().map(sixth).sum()
}

fn assert_relative(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found:e} is not {expected:e}"
    );
}

// Validation.

#[test]
fn negative_tetrahedra_are_turned_round() {
    for swap in [[0, 1], [1, 3], [2, 0]] {
        let mut tet = [0, 1, 2, 3];
        tet.swap(swap[0], swap[1]);
        let mesh = TetMesh::new(unit_corners(), vec![tet]).unwrap();
        assert_relative(mesh.tetrahedron(0).signed_volume(), 1.0 / 6.0, ROUND_OFF);
        let mut corners = mesh.tets()[0];
        corners.sort_unstable();
        assert_eq!(corners, [0, 1, 2, 3]);
    }
}

#[test]
fn positive_tetrahedra_are_left_as_they_are() {
    let mesh = TetMesh::new(unit_corners(), vec![[1, 2, 0, 3]]).unwrap();
    assert_eq!(mesh.tets(), [[1, 2, 0, 3]]);
    assert_eq!((mesh.tet_count(), mesh.vertex_count()), (1, 4));
    assert_eq!(mesh.vertices(), unit_corners());
}

fn mesh_error(vertices: Vec<Vector3<f64>>, tets: &[[usize; 4]]) -> MeshError {
    TetMesh::new(vertices, tets.to_vec()).unwrap_err()
}

#[test]
fn a_mesh_without_tetrahedra_is_empty() {
    assert_eq!(mesh_error(unit_corners(), &[]), MeshError::Empty);
    assert_eq!(mesh_error(Vec::new(), &[]), MeshError::Empty);
    assert_eq!(
        MeshError::Empty.to_string(),
        "a mesh needs at least one tetrahedron"
    );
}

/// The message only: a mesh of this size would take 100 GB.
#[test]
fn the_message_of_too_large_a_mesh_names_count_and_limit() {
    let (count, limit) = (5_000_000_000, 4_294_967_295);
    assert_eq!(
        MeshError::TooLarge { count, limit }.to_string(),
        "a mesh holds at most 4294967295 vertices and tetrahedra, but 5000000000 were given"
    );
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut vertices = unit_corners();
        vertices[2].y = bad;
        let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
        assert!(
            matches!(error, MeshError::NonFiniteCoordinate { vertex: 2, value }
                if value.to_bits() == bad.to_bits()),
            "{error}"
        );
    }
    let (vertex, value) = (2, f64::NAN);
    assert_eq!(
        MeshError::NonFiniteCoordinate { vertex, value }.to_string(),
        "vertex 2 has the coordinate NaN, but coordinates must be finite"
    );
}

#[test]
fn a_vertex_that_does_not_exist_is_named() {
    let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], [0, 1, 12, 2]]);
    let expected = MeshError::VertexOutOfRange {
        tet: 1,
        vertex: 12,
        vertex_count: 4,
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "tetrahedron 1 refers to vertex 12, but the mesh has 4 vertices"
    );
    let error = mesh_error(unit_corners(), &[[0, 1, 2, usize::MAX]]);
    assert!(matches!(error, MeshError::VertexOutOfRange { tet: 0, .. }));
}

#[test]
fn a_vertex_used_twice_by_a_tetrahedron_is_named() {
    for (tet, vertex) in [([0, 1, 2, 1], 1), ([3, 3, 0, 2], 3), ([0, 1, 2, 0], 0)] {
        let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], tet]);
        assert_eq!(error, MeshError::RepeatedVertex { tet: 1, vertex });
    }
}

#[test]
fn flat_tetrahedra_are_named() {
    let mut vertices = unit_corners();
    vertices.push(vector![1.0, 1.0, 0.0]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [0, 1, 2, 4]]);
    let expected = MeshError::ZeroVolume {
        tet: 1,
        volume: 0.0,
        longest_edge: 2.0_f64.sqrt(),
    };
    assert_eq!(error, expected);
    let message = error.to_string();
    assert!(
        message.starts_with("tetrahedron 1 has the volume 0e0 m³ over a longest edge of 1.414")
    );
    // Two different vertices at one place.
    let mut vertices = unit_corners();
    vertices[3] = vertices[0];
    let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
    assert!(matches!(error, MeshError::ZeroVolume { tet: 0, .. }));
}

/// The unit tetrahedron with its top lowered to `height`.
fn flattened(height: f64) -> Vec<Vector3<f64>> {
    let mut vertices = unit_corners();
    vertices[3].z = height;
    vertices
}

#[test]
fn flatness_is_judged_at_every_scale_alike() {
    // Powers of two scale exactly, the others to round-off.
    let scales = [
        1.0,
        1e-6,
        1e6,
        1e-100,
        1e100,
        2.0_f64.powi(-300),
        2.0_f64.powi(300),
    ];
    for scale in scales {
        let is_solid = |height| {
            let vertices = flattened(height).iter().map(|v| v * scale).collect();
            match TetMesh::new(vertices, vec![[0, 1, 2, 3]]) {
                Ok(_) => true,
                Err(MeshError::ZeroVolume { tet: 0, .. }) => false,
                Err(other) => panic!("{other}"),
            }
        };
        // The longest edge is √2, so the limit is 2.8e-12.
        assert!(
            is_solid(1.0) && is_solid(3e-12) && is_solid(-3e-12),
            "{scale:e}"
        );
        assert!(
            !is_solid(2.7e-12) && !is_solid(-2.7e-12) && !is_solid(0.0),
            "{scale:e}"
        );
    }
}

#[test]
fn sizes_beyond_the_range_of_numbers_are_flat_and_no_panic() {
    for scale in [f64::MIN_POSITIVE, 1e-300, 1e-150, 1e150, 1e300, f64::MAX] {
        let vertices = unit_corners().iter().map(|v| v * scale).collect();
        let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
        assert!(
            matches!(error, MeshError::ZeroVolume { tet: 0, .. }),
            "{scale:e}"
        );
    }
}

#[test]
fn fields_work_at_extreme_scales() {
    for scale in [1e-100, 1e-6, 1e6, 1e100] {
        let mesh = transformed(&l_shape(1), |vertex| vertex * scale);
        let field = PressureField::from_distance(&mesh).unwrap();
        let expected = PressureField::from_distance(&l_shape(1)).unwrap();
        assert_eq!(field.mesh().tets(), expected.mesh().tets());
        for (found, expected) in field.extents().iter().zip(expected.extents()) {
            assert!(
                (found - expected).abs() <= ROUND_OFF,
                "{found} is not {expected} at {scale:e}"
            );
        }
        assert_relative(field.steepest() * scale, expected.steepest(), ROUND_OFF);
        assert_relative(field.reach() / scale, expected.reach(), ROUND_OFF);
        assert_relative(field.mesh().volume(), 6.0 * scale.powi(3), ROUND_OFF);
    }
}

#[test]
fn an_unused_vertex_is_named() {
    let mut vertices = unit_corners();
    vertices.insert(1, vector![5.0, 5.0, 5.0]);
    let error = mesh_error(vertices, &[[0, 2, 3, 4]]);
    assert_eq!(error, MeshError::UnusedVertex { vertex: 1 });
    assert_eq!(error.to_string(), "vertex 1 belongs to no tetrahedron");
}

#[test]
fn tetrahedra_on_one_side_of_a_face_overlap() {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, 0.5]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [2, 1, 0, 4]]);
    let expected = MeshError::OverlappingTets {
        first: 0,
        second: 1,
        face: [0, 1, 2],
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "tetrahedra 0 and 1 overlap: they share the face of vertices [0, 1, 2], but lie on the same side of it or share it with a third"
    );
}

#[test]
fn a_tetrahedron_given_twice_overlaps_itself() {
    let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], [1, 0, 2, 3]]);
    assert!(matches!(
        error,
        MeshError::OverlappingTets {
            first: 0,
            second: 1,
            ..
        }
    ));
}

#[test]
fn three_tetrahedra_at_one_face_overlap() {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, -0.5]);
    vertices.push(vector![0.3, 0.3, -1.0]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]);
    assert!(
        matches!(
            error,
            MeshError::OverlappingTets {
                face: [0, 1, 2],
                ..
            }
        ),
        "{error}"
    );
}

fn field_error(mesh: TetMesh, extents: &[f64]) -> MeshError {
    PressureField::new(mesh, extents.to_vec()).unwrap_err()
}

/// Five vertices, the last one inside.
fn tet_around_a_vertex() -> TetMesh {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, 0.2]);
    let tets = vec![[0, 1, 2, 4], [0, 1, 3, 4], [0, 2, 3, 4], [1, 2, 3, 4]];
    TetMesh::new(vertices, tets).unwrap()
}

#[test]
fn a_field_needs_one_extent_per_vertex() {
    for extents in [&[0.0; 4][..], &[0.0; 6][..], &[]] {
        let error = field_error(tet_around_a_vertex(), extents);
        let expected = MeshError::ExtentCount {
            vertex_count: 5,
            extent_count: extents.len(),
        };
        assert_eq!(error, expected);
    }
    let error = field_error(tet_around_a_vertex(), &[]);
    assert_eq!(
        error.to_string(),
        "a pressure field needs one extent per vertex: 5, but has 0"
    );
}

#[test]
fn extents_must_be_finite_and_not_negative() {
    for bad in [-1e-300, -1.0, f64::NAN, f64::INFINITY] {
        let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, 0.0, 0.0, bad]);
        assert!(
            matches!(error, MeshError::InvalidExtent { vertex: 4, value }
                if value.to_bits() == bad.to_bits()),
            "{error}"
        );
    }
    let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, -2.5, 0.0, 1.0]);
    assert_eq!(
        error.to_string(),
        "vertex 2 has the extent -2.5, but extents must be finite and not negative"
    );
}

#[test]
fn the_extent_on_the_surface_must_be_zero() {
    let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, 0.0, 1e-9, 1.0]);
    let expected = MeshError::SurfaceExtent {
        vertex: 3,
        value: 1e-9,
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "vertex 3 lies on the surface, where the extent must be 0, but has 0.000000001"
    );
}

#[test]
fn tetrahedra_without_pressure_are_named_or_inert() {
    let mesh = cube(&FIVE);
    assert_eq!(
        field_error(mesh.clone(), &[0.0; 8]),
        MeshError::ZeroField { tet: 0 }
    );
    let message = MeshError::ZeroField { tet: 0 }.to_string();
    assert!(
        message.contains("TetMesh::with_inner_vertices"),
        "{message}"
    );
    let field = PressureField::with_inert_tets(mesh, vec![0.0; 8]).unwrap();
    assert!(field.tets().iter().all(FieldTet::is_inert));
}

#[test]
fn the_first_tetrahedron_without_pressure_is_the_one_named() {
    // A tetrahedron outside, on a face of one that has a vertex inside.
    let mesh = tet_around_a_vertex();
    let vertices = [mesh.vertices(), &[vector![1.0, 1.0, 1.0]]].concat();
    let tets = [mesh.tets(), &[[1, 2, 3, 5]]].concat();
    let mesh = TetMesh::new(vertices, tets).unwrap();
    let error = field_error(mesh, &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(error, MeshError::ZeroField { tet: 4 });
}

#[test]
fn fields_interpolate_the_extents_of_the_vertices() {
    let field = PressureField::from_distance(&l_shape(2)).unwrap();
    for (tet, corners) in field.tets().iter().zip(field.mesh().tets()) {
        for (place, &vertex) in corners.iter().enumerate() {
            let position = &field.mesh().vertices()[vertex];
            let expected = field.extents()[vertex];
            assert!((tet.extent.at(position) - expected).abs() <= ROUND_OFF);
            for (other, barycentric) in tet.barycentric.iter().enumerate() {
                let expected = f64::from(u8::from(other == place));
                assert!((barycentric.at(position) - expected).abs() <= ROUND_OFF);
            }
        }
        assert!(tet.steepness <= field.steepest());
    }
}

// Surface.

#[test]
fn surfaces_are_closed() {
    for (name, mesh) in meshes() {
        let mut uses: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for &[a, b, c] in mesh.surface_triangles() {
            for edge in [[a, b], [b, c], [c, a]] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        for (&[from, to], &count) in &uses {
            assert_eq!(count, 1, "{name}: {from} → {to}");
            assert!(uses.contains_key(&[to, from]), "{name}: {to} → {from}");
        }
    }
}

#[test]
fn surfaces_turn_outwards_and_enclose_the_volume() {
    for (name, mesh) in meshes() {
        let (enclosed, volume) = (enclosed_volume(&mesh), mesh.volume());
        assert!(enclosed > 0.0, "{name}");
        assert_relative(enclosed, volume, ROUND_OFF);
    }
}

#[test]
fn vertices_are_on_the_surface_where_a_surface_triangle_has_them() {
    for (name, mesh) in meshes() {
        let used: BTreeSet<usize> = mesh.surface_triangles().iter().flatten().copied().collect();
        for vertex in 0..mesh.vertex_count() {
            assert_eq!(mesh.is_on_surface(vertex), used.contains(&vertex), "{name}");
        }
    }
    let block = grid([3, 3, 3], 1.0, |_| true);
    let inner = |v: &Vector3<f64>| v.iter().all(|x| *x > 0.5 && *x < 2.5);
    for (vertex, position) in block.vertices().iter().enumerate() {
        assert_eq!(block.is_on_surface(vertex), !inner(position));
    }
}

// Mass properties.

/// Relative to the largest moment.
fn assert_inertia(found: &Matrix3<f64>, expected: &Matrix3<f64>, tolerance: f64) {
    let error = (found - expected).amax();
    assert!(
        error <= tolerance * expected.amax(),
        "{found} is not {expected}"
    );
}

/// Inertia (kg m²) of a box about its centre.
fn box_inertia(mass: f64, lengths: &Vector3<f64>) -> Matrix3<f64> {
    let squares = lengths.component_mul(lengths);
    Matrix3::from_diagonal(&Vector3::from_fn(|axis, _| {
        mass / 12.0 * (squares.sum() - squares[axis])
    }))
}

#[test]
fn boxes_have_their_mass_properties_wherever_they_are() {
    let (lengths, density) = (vector![0.5, 1.0, 2.0], 800.0);
    for (shift, tolerance) in [
        (vector![0.0, 0.0, 0.0], ROUND_OFF),
        (vector![20.0, -10.0, 5.0], SHIFTED_ROUND_OFF),
    ] {
        let mesh = transformed(&cube(&KUHN), |v| v.component_mul(&lengths) + shift);
        assert_relative(mesh.volume(), 1.0, tolerance);
        let properties = mesh.mass_properties(density);
        assert_relative(properties.mass, density, tolerance);
        let center = lengths * 0.5 + shift;
        assert!((properties.center_of_mass - center).amax() <= tolerance);
        assert_inertia(
            &properties.inertia,
            &box_inertia(density, &lengths),
            tolerance,
        );
    }
}

#[test]
fn a_turned_box_has_the_turned_inertia() {
    let (lengths, density) = (vector![0.5, 1.0, 2.0], 3.0);
    let rotation = Rotation3::new(vector![0.4, -1.1, 0.3]);
    let mesh = transformed(&cube(&FIVE), |v| rotation * v.component_mul(&lengths));
    let expected = rotation * box_inertia(density, &lengths) * rotation.transpose();
    let inertia = mesh.mass_properties(density).inertia;
    assert_inertia(&inertia, &expected, ROUND_OFF);
    // Exactly symmetric, so that its use as such loses nothing.
    assert_eq!(inertia, inertia.transpose());
}

#[test]
fn a_tetrahedron_has_its_mass_properties() {
    let properties = unit_tet().mass_properties(6.0);
    assert_relative(properties.mass, 1.0, ROUND_OFF);
    assert!((properties.center_of_mass - Vector3::repeat(0.25)).amax() <= ROUND_OFF);
    // Over the unit tetrahedron ∫ x² dV = 1/60 and ∫ x y dV = 1/120. With mass 1 about the
    // centroid: ⟨x²⟩ = 1/10 − 1/16 and ⟨x y⟩ = 1/20 − 1/16.
    let expected = Matrix3::from_fn(|i, j| if i == j { 2.0 * 0.0375 } else { 0.0125 });
    assert_inertia(&properties.inertia, &expected, ROUND_OFF);
}

#[test]
fn mass_properties_do_not_depend_on_the_order_of_vertices_and_tetrahedra() {
    for (name, mesh) in meshes() {
        let count = mesh.vertex_count();
        // Seven has no factor in common with the counts here, so this permutes.
        let place = |vertex: usize| (7 * vertex + 3) % count;
        assert!(count % 7 != 0, "{name}");
        let mut vertices = vec![Vector3::zeros(); count];
        for (vertex, position) in mesh.vertices().iter().enumerate() {
            vertices[place(vertex)] = *position;
        }
        let tets = mesh
            .tets()
            .iter()
            .rev()
            .map(|[a, b, c, d]| [*c, *a, *d, *b].map(place));
        let shuffled = TetMesh::new(vertices, tets.collect()).unwrap();
        let (found, expected) = (shuffled.mass_properties(2.0), mesh.mass_properties(2.0));
        assert_relative(found.mass, expected.mass, ROUND_OFF);
        assert!((found.center_of_mass - expected.center_of_mass).amax() <= ROUND_OFF);
        assert_inertia(&found.inertia, &expected.inertia, ROUND_OFF);
    }
}

// Inner vertices.

/// The edges, faces and tetrahedra with all corners on the surface that are no part of it.
fn flat_simplices(mesh: &TetMesh) -> Vec<BTreeSet<usize>> {
    let surface: Vec<BTreeSet<usize>> = mesh
        .surface_triangles()
        .iter()
        .map(|triangle| BTreeSet::from(*triangle))
        .collect();
    let choices = [
        &[0, 1][..],
        &[0, 2],
        &[0, 3],
        &[1, 2],
        &[1, 3],
        &[2, 3],
        &[0, 1, 2],
        &[0, 1, 3],
        &[0, 2, 3],
        &[1, 2, 3],
        &[0, 1, 2, 3],
    ];
    let simplices = mesh.tets().iter().flat_map(|tet| {
        choices.map(|choice| {
            choice
                .iter()
                .map(|&place| tet[place])
                .collect::<BTreeSet<usize>>()
        })
    });
    simplices
        .filter(|simplex| simplex.iter().all(|&vertex| mesh.is_on_surface(vertex)))
        .filter(|simplex| !surface.iter().any(|triangle| simplex.is_subset(triangle)))
        .collect()
}

fn sorted_surface(mesh: &TetMesh) -> Vec<[usize; 3]> {
    let smallest_first =
        |&[a, b, c]: &[usize; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let mut triangles: Vec<[usize; 3]> = mesh
        .surface_triangles()
        .iter()
        .map(smallest_first)
        .collect();
    triangles.sort_unstable();
    triangles
}

#[test]
fn inner_vertices_leave_nothing_flat_inside() {
    for (name, mesh) in meshes() {
        let split = mesh.with_inner_vertices().unwrap();
        assert!(flat_simplices(&split).is_empty(), "{name}");
        assert!(
            (0..split.vertex_count()).any(|vertex| !split.is_on_surface(vertex)),
            "{name}"
        );
    }
}

#[test]
fn inner_vertices_leave_volume_and_surface_as_they_were() {
    for (name, mesh) in meshes() {
        let split = mesh.with_inner_vertices().unwrap();
        assert_relative(split.volume(), mesh.volume(), ROUND_OFF);
        assert_eq!(sorted_surface(&split), sorted_surface(&mesh), "{name}");
        assert_eq!(
            &split.vertices()[..mesh.vertex_count()],
            mesh.vertices(),
            "{name}"
        );
        let (found, expected) = (split.mass_properties(1.0), mesh.mass_properties(1.0));
        assert_inertia(&found.inertia, &expected.inertia, ROUND_OFF);
    }
}

#[test]
fn meshes_with_inner_vertices_are_conforming_in_any_order_of_vertices() {
    for (name, mesh) in meshes() {
        let count = mesh.vertex_count();
        for shift in 1..count.min(12) {
            let place = |vertex: usize| (vertex + shift) % count;
            let mut vertices = mesh.vertices().to_vec();
            vertices.rotate_right(shift);
            let tets = mesh.tets().iter().map(|tet| tet.map(place)).collect();
            let turned = TetMesh::new(vertices, tets).unwrap();
            // TetMesh::new within refuses faces that do not meet.
            let split = turned.with_inner_vertices().unwrap();
            assert_relative(split.volume(), mesh.volume(), ROUND_OFF);
            assert_relative(enclosed_volume(&split), mesh.volume(), ROUND_OFF);
            assert!(flat_simplices(&split).is_empty(), "{name}");
        }
    }
}

#[test]
fn a_mesh_that_needs_no_inner_vertices_stays_as_it_is() {
    let mesh = tet_around_a_vertex();
    let split = mesh.with_inner_vertices().unwrap();
    assert_eq!(
        (split.tets(), split.vertices()),
        (mesh.tets(), mesh.vertices())
    );
    let twice = cube(&FIVE).with_inner_vertices().unwrap();
    assert_eq!(twice.with_inner_vertices().unwrap().tets(), twice.tets());
}

#[test]
fn counts_of_inner_vertices_are_known() {
    let counts = |mesh: &TetMesh| {
        let split = mesh.with_inner_vertices().unwrap();
        (split.vertex_count(), split.tet_count())
    };
    // One vertex at the centre.
    assert_eq!(counts(&unit_tet()), (5, 4));
    // The diagonal that all six share is halved.
    assert_eq!(counts(&cube(&KUHN)), (9, 12));
    // No edge runs inside, but four faces do. Each corner tetrahedron falls into three, the inner
    // one into three at its first face, and each of these into three at one of the others.
    assert_eq!(counts(&cube(&FIVE)), (12, 4 * 3 + 9));
}

// Distance fields.

#[test]
fn grids_have_the_distance_to_the_box_as_extent() {
    let (counts, spacing) = ([4, 6, 8], 0.25);
    let field = PressureField::from_distance(&grid(counts, spacing, |_| true)).unwrap();
    let upper = Vector3::from(counts.map(|count| count as f64 * spacing));
    for (position, extent) in field.mesh().vertices().iter().zip(field.extents()) {
        // The largest distance is half the shortest edge, 1/2.
        let distance = position.min().min((upper - position).min());
        assert!((extent - 2.0 * distance).abs() <= ROUND_OFF, "{position}");
    }
}

#[test]
fn stretched_grids_have_the_distance_to_the_box_as_extent() {
    // Long thin triangles: the nearest one need not have the nearest centre.
    for stretch in [
        vector![1.0, 9.0, 1.0],
        vector![1.0, 0.2, 13.0],
        vector![7.0, 5.0, 1.0],
    ] {
        let upper = stretch * 5.0;
        let straight = transformed(&grid([5, 5, 5], 1.0, |_| true), |v| {
            v.component_mul(&stretch)
        });
        // Bent inside, so that the vertices lie anywhere above the triangles.
        let mesh = transformed(&straight, |v| {
            let bubble = v
                .component_mul(&(upper - v))
                .component_div(&upper.component_mul(&upper));
            v + bubble.product() * 20.0 * vector![v.y, v.x, -v.z].sup(&-stretch).inf(&stretch)
        });
        let field = PressureField::from_distance(&mesh).unwrap();
        let vertices = field.mesh().vertices();
        let distances = vertices.iter().map(|v| v.min().min((upper - v).min()));
        let distances: Vec<f64> = distances.collect();
        let largest = distances.iter().copied().fold(0.0, f64::max);
        for (extent, distance) in field.extents().iter().zip(distances) {
            assert!(
                (extent - distance / largest).abs() <= ROUND_OFF,
                "{stretch:?}"
            );
        }
    }
}

#[test]
fn notched_cube_has_the_distance_to_its_inward_corner_as_extent() {
    // A cube of edge 2 less one octant: the nearest point may lie on a wall, an edge or a corner.
    let keeps = |cell: [usize; 3]| cell.iter().any(|&step| step < 3);
    let field = PressureField::from_distance(&grid([6, 6, 6], 1.0 / 3.0, keeps)).unwrap();
    let distance = |p: &Vector3<f64>| {
        let notch = p.map(|x| (1.0 - x).max(0.0)).norm();
        notch.min(p.min()).min(p.map(|x| 2.0 - x).min())
    };
    let distances: Vec<f64> = field.mesh().vertices().iter().map(distance).collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    for (extent, distance) in field.extents().iter().zip(distances) {
        assert!((extent * largest - distance).abs() <= ROUND_OFF);
    }
}

/// Distance (m) from a point in the L-shape to its surface.
fn distance_in_l_shape(p: &Vector3<f64>) -> f64 {
    let far = [p.x, p.y, 2.0 - p.x, 2.0 - p.y, p.z, 2.0 - p.z];
    // The edge that points inwards, at x = y = 1, and the two walls that end there.
    let (x, y) = ((1.0 - p.x).max(0.0), (1.0 - p.y).max(0.0));
    far.iter().copied().fold(x.hypot(y), f64::min)
}

#[test]
fn l_shape_has_the_distance_to_its_inward_edge_as_extent() {
    let field = PressureField::from_distance(&l_shape(4)).unwrap();
    let vertices = field.mesh().vertices();
    let distances: Vec<f64> = vertices.iter().map(distance_in_l_shape).collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    for ((position, extent), distance) in vertices.iter().zip(field.extents()).zip(&distances) {
        assert!(
            (extent * largest - distance).abs() <= ROUND_OFF,
            "{position}"
        );
    }
    // (1/2, 1/2): both walls and the inward edge matter around here.
    let extent_at = |p: Vector3<f64>| {
        let vertex = vertices
            .iter()
            .position(|v| (v - p).norm() < ROUND_OFF)
            .unwrap();
        field.extents()[vertex] * largest
    };
    assert_relative(
        extent_at(vector![0.75, 0.75, 1.0]),
        0.125_f64.sqrt(),
        ROUND_OFF,
    );
    assert_relative(extent_at(vector![0.5, 0.5, 1.0]), 0.5, ROUND_OFF);
    assert_relative(extent_at(vector![1.5, 0.75, 1.0]), 0.25, ROUND_OFF);
}

#[test]
fn distance_fields_reach_one_and_leave_no_tetrahedron_inert() {
    for (name, mesh) in meshes() {
        let field = PressureField::from_distance(&mesh).unwrap();
        let largest = field.extents().iter().copied().fold(0.0, f64::max);
        assert_relative(largest, 1.0, f64::EPSILON);
        assert!(!field.tets().iter().any(FieldTet::is_inert), "{name}");
    }
}

#[test]
fn a_single_tetrahedron_has_extent_one_at_its_centroid() {
    let field = PressureField::from_distance(&unit_tet()).unwrap();
    assert_eq!(field.extents(), [0.0, 0.0, 0.0, 0.0, 1.0]);
    // The oblique face is (1 − 3/4)/√3 away, the others 1/4.
    assert_relative(field.steepest(), 48.0_f64.sqrt(), ROUND_OFF);
}
