//! Tetrahedra that fill surfaces and distance functions.

use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape};
use hydroelastic::geometry::Aabb;
use hydroelastic::mesh::{
    Resolution, Solid, SolidError, SurfaceError, TriangleSoup, TriangleSurface, shapes,
};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const SPACING: Resolution = Resolution::Spacing(0.011);

/// Time limit of a refusal. The last measurement had 1 s.
const TIME: Duration = Duration::from_secs(20);

/// An ellipsoid off the origin, whose triangles are not symmetric to the lattice.
fn egg() -> TriangleSoup {
    let field = shapes::ellipsoid([0.05, 0.07, 0.06], 3).unwrap();
    let mut egg = TriangleSoup::from(TriangleSurface::around(field.mesh()).unwrap());
    for vertex in &mut egg.vertices {
        let turned =
            Pose::from_rotation_vector(&vector![0.3, -0.2, 0.5], vector![0.013, -0.002, 0.0047]);
        *vertex = turned.transformed_point(vertex);
    }
    egg
}

fn moved(soup: &TriangleSoup, by: Vector3<f64>) -> TriangleSoup {
    TriangleSoup {
        vertices: soup.vertices.iter().map(|vertex| vertex + by).collect(),
        triangles: soup.triangles.clone(),
    }
}

fn joined(first: &TriangleSoup, second: &TriangleSoup) -> TriangleSoup {
    let count = first.vertices.len();
    let shifted = second
        .triangles
        .iter()
        .map(|triangle| triangle.map(|vertex| vertex + count));
    TriangleSoup {
        vertices: first
            .vertices
            .iter()
            .chain(&second.vertices)
            .copied()
            .collect(),
        triangles: first.triangles.iter().copied().chain(shifted).collect(),
    }
}

fn box_soup(lengths: [f64; 3]) -> TriangleSoup {
    let field = shapes::cuboid(lengths).unwrap();
    TriangleSoup::from(TriangleSurface::around(field.mesh()).unwrap())
}

fn volume(soup: &TriangleSoup, resolution: Resolution) -> f64 {
    soup.solid(resolution).unwrap().mesh().volume()
}

#[test]
fn volumes_converge_with_the_square_of_the_spacing() {
    let egg = egg();
    let exact = TriangleSurface::new(egg.vertices.clone(), egg.triangles.clone())
        .unwrap()
        .volume();
    let error = |spacing: f64| (volume(&egg, Resolution::Spacing(spacing)) / exact - 1.0).abs();
    let [coarse, fine] = [0.02, 0.01].map(error);
    assert!(coarse < 0.002 && fine < coarse / 4.0, "{coarse} {fine}");
}

/// Returns the force of a solid ball of 0.1 m on a plane this deep (m), over the integral of the pressure 1e5 (1 − r/0.1) over a disk.
fn force_over_exact(shape: &Shape, depth: f64) -> f64 {
    let (radius, height) = (0.1_f64, 0.1 - depth);
    let body = ContactBody::new(shape, Pose::from_translation(Vector3::z() * height), 1e5);
    let floor = Partner::rigid_half_space(Pose::identity()).unwrap();
    let force = ContactPair::new(body.unwrap(), floor).wrench().on_a.force.z;
    let disk =
        radius * (radius.powi(2) - height.powi(2)) - 2.0 / 3.0 * (radius.powi(3) - height.powi(3));
    force / (1e5 * PI * disk / radius)
}

#[test]
fn balls_press_as_exact_distances_do() {
    // The triangles of the coarser ball lose 1.4 % at the depth of 6 mm, and 0.4 % at 2 cm.
    let cases = [
        (4, Resolution::default(), 0.006, 0.03),
        (4, Resolution::default(), 0.02, 0.01),
        (5, SPACING, 0.006, 0.005),
        (5, SPACING, 0.02, 0.005),
        (5, SPACING, 0.08, 0.005),
    ];
    for (subdivisions, resolution, depth, error) in cases {
        let ball = shapes::icosphere(0.1, subdivisions).unwrap();
        let ball = TriangleSurface::around(ball.mesh()).unwrap();
        let solid = Solid::of_surface(&ball, resolution).unwrap();
        assert!(solid.warnings().is_empty());
        assert!(solid.distance_error().is_none_or(|error| error < 0.02));
        let ratio = force_over_exact(&Shape::new(solid.field().unwrap()), depth);
        assert!((ratio - 1.0).abs() < error, "{depth} {ratio}");
    }
}

#[test]
fn faces_stay_flat_and_the_volume_is_as_asked() {
    let brick = box_soup([0.1, 0.2, 0.05]);
    let solid = brick.solid(Resolution::VolumeWithin(0.01)).unwrap();
    assert!((solid.mesh().volume() / 1e-3 - 1.0).abs() < 0.01);
    let bottom = solid.mesh().aabb().lower.z;
    assert!((bottom + 0.025).abs() < 1e-15);
}

#[test]
fn overlapping_parts_are_united() {
    let cube = box_soup([0.1; 3]);
    let both = joined(&cube, &moved(&cube, vector![0.05, 0.0, 0.0]));
    let found = volume(&both, Resolution::Spacing(0.00501));
    assert!((found / 1.5e-3 - 1.0).abs() < 0.01, "{found}");
}

/// The winding number of two nested cups is large at points above their openings.
#[test]
fn solids_end_at_the_bounds_of_their_triangles() {
    let cup = |lengths: [f64; 3]| {
        let mut cup = box_soup(lengths);
        let top = lengths[2] / 2.0;
        let is_below = |&vertex: &usize| cup.vertices[vertex].z < top;
        cup.triangles
            .retain(|triangle| triangle.iter().any(is_below));
        cup
    };
    let cups = joined(&cup([0.2, 0.2, 0.05]), &cup([0.19, 0.19, 0.05]));
    let solid = cups.solid(Resolution::Spacing(0.01)).unwrap();
    let bounds = solid.mesh().aabb();
    assert!((bounds.upper.z - 0.025).abs() < 1e-8, "{bounds:?}");
    let found = solid.mesh().volume();
    assert!((found / 2e-3 - 1.0).abs() < 0.03, "{found}");
}

/// The field of a coarse solid has the slope of the largest distance inside, not of the farthest node of the lattice.
#[test]
fn the_deepest_point_is_a_vertex() {
    let ball = TriangleSurface::around(shapes::icosphere(0.1, 4).unwrap().mesh()).unwrap();
    let moved = ball
        .vertices()
        .iter()
        .map(|vertex| vertex + vector![0.013, 0.017, 0.011]);
    let ball = TriangleSurface::new(moved.collect(), ball.triangles().to_vec()).unwrap();
    let solid = Solid::of_surface(&ball, Resolution::Spacing(0.03)).unwrap();
    let (field, distances) = solid.linearized_field().unwrap();
    let added = field.mesh().vertex_count() - solid.mesh().vertex_count();
    assert_eq!(added, 1);
    let deepest = field.mesh().vertices()[solid.mesh().vertex_count()];
    let extent = field.extents()[solid.mesh().vertex_count()];
    // The fit raises the tip of the cone of extents.
    assert!((1.0..1.05).contains(&extent), "{extent}");
    let off_center = (deepest - vector![0.013, 0.017, 0.011]).norm();
    assert!(off_center < 0.003, "{off_center}");
    let rates = distances
        .rates(&vec![Vector3::x(); solid.mesh().vertex_count()])
        .unwrap();
    assert!(rates.extents.iter().all(|rate| rate.abs() < 1e-9));
}

#[test]
fn open_boxes_are_filled_up_to_their_rims() {
    let mut open = box_soup([0.1; 3]);
    open.triangles.drain(4..6);
    // In front of the hole, two layers have a winding number as large as inside a solid.
    let doubled = joined(&open, &open);
    for (soup, spacing) in [&open, &doubled]
        .into_iter()
        .flat_map(|soup| [0.01, 0.005_17, 0.0025].map(|spacing| (soup, spacing)))
    {
        let solid = soup.solid(Resolution::Spacing(spacing)).unwrap();
        let found = solid.mesh().volume();
        assert!((0.7e-3..1.001e-3).contains(&found), "{spacing} {found}");
        assert!(solid.mesh().aabb().half_extents().max() < 0.050_001);
    }
}

#[test]
fn narrow_slits_are_closed() {
    let half = box_soup([0.05, 0.1, 0.1]);
    let [left, right] = [-0.025_001, 0.025_001].map(|x| moved(&half, vector![x, 0.0, 0.0]));
    let found = volume(&joined(&left, &right), Resolution::Spacing(0.01));
    assert!((found / 1e-3 - 1.0).abs() < 0.01, "{found}");
}

#[test]
fn holes_are_closed_and_surfaces_may_face_inwards() {
    let egg = egg();
    let whole = volume(&egg, SPACING);
    let mut open = egg.clone();
    open.triangles.drain(10..14);
    assert!((volume(&open, SPACING) / whole - 1.0).abs() < 0.01);
    let mut turned = egg;
    turned
        .triangles
        .iter_mut()
        .for_each(|triangle| triangle.swap(0, 1));
    assert!((volume(&turned, SPACING) - whole).abs() < 1e-15);
}

#[test]
fn cavities_stay_empty() {
    let (outer, mut inner) = (box_soup([0.1; 3]), box_soup([0.06; 3]));
    inner
        .triangles
        .iter_mut()
        .for_each(|triangle| triangle.swap(0, 1));
    let found = volume(&joined(&outer, &inner), Resolution::Spacing(0.004));
    assert!((found / (1e-3 - 2.16e-4) - 1.0).abs() < 0.01, "{found}");
}

/// A smooth field of velocities that does not keep the shape.
fn velocity(point: &Vector3<f64>) -> Vector3<f64> {
    vector![
        0.3 + point.y * 4.0,
        (20.0 * point.x).sin(),
        0.7 - 9.0 * point.z * point.x
    ]
}

/// A scalar that depends on all vertices of a mesh.
fn score(vertices: &[Vector3<f64>]) -> f64 {
    let of_vertex = |(index, vertex): (usize, &Vector3<f64>)| {
        vertex.dot(&vector![1.0, 2.0, -0.5]) * (index as f64 * 0.37).sin() + vertex.norm_squared()
    };
    vertices.iter().enumerate().map(of_vertex).sum()
}

#[test]
fn vertices_follow_the_triangles() {
    let egg = egg();
    let solid = egg.solid(SPACING).unwrap();
    let velocities: Vec<_> = egg.vertices.iter().map(velocity).collect();
    let rates = solid.rates(&velocities).unwrap();
    let vertices = solid.mesh().vertices();
    let step = 1e-7;
    let after = |step: f64| {
        let mut changed = egg.clone();
        for (vertex, velocity) in changed.vertices.iter_mut().zip(&velocities) {
            *vertex += velocity * step;
        }
        changed.solid(SPACING).unwrap().mesh().vertices().to_vec()
    };
    let [before, after] = [after(-step), after(step)];
    assert_eq!(
        (before.len(), after.len()),
        (vertices.len(), vertices.len())
    );
    assert!(solid.ambiguous().is_empty());
    for vertex in 0..vertices.len() {
        let difference = (after[vertex] - before[vertex]) / (2.0 * step);
        assert!(
            (difference - rates[vertex]).norm() < 1e-5,
            "{vertex} {difference} {}",
            rates[vertex]
        );
    }
    let by_vertices: Vec<_> = vertices
        .iter()
        .enumerate()
        .map(|(index, vertex)| vector![1.0, 2.0, -0.5] * (index as f64 * 0.37).sin() + vertex * 2.0)
        .collect();
    let gradient = solid.pullback(&by_vertices).unwrap();
    let by_pullback: f64 = gradient
        .iter()
        .zip(&velocities)
        .map(|(by, velocity)| by.dot(velocity))
        .sum();
    let by_rates: f64 = by_vertices
        .iter()
        .zip(&rates)
        .map(|(by, rate)| by.dot(rate))
        .sum();
    let by_difference = (score(&after) - score(&before)) / (2.0 * step);
    assert!((by_pullback - by_rates).abs() < 1e-12 * by_rates.abs());
    assert!(
        (by_difference - by_rates).abs() < 1e-6 * by_rates.abs(),
        "{by_difference} {by_rates}"
    );
}

/// A function from points to velocities.
type Motion = fn(&Vector3<f64>) -> Vector3<f64>;

/// Surfaces with faces, edges and corners at nodes of lattices with spacings of 1/64 m.
fn symmetric_soups() -> [TriangleSoup; 4] {
    let cube = box_soup([0.125; 3]);
    let ball = TriangleSurface::around(shapes::icosphere(0.0625, 3).unwrap().mesh()).unwrap();
    let turn = Pose::from_rotation_vector(&vector![0.0, 0.0, PI / 4.0], Vector3::zeros());
    let mut turned = cube.clone();
    for vertex in &mut turned.vertices {
        *vertex = turn.transformed_point(vertex);
    }
    let off = moved(&cube, Vector3::repeat(1.0 / 512.0));
    [cube, turned, off, ball.into()]
}

#[test]
fn fitted_extents_follow_the_triangles() {
    let (egg, step) = (egg(), 1e-7);
    let velocities: Vec<_> = egg.vertices.iter().map(velocity).collect();
    let solid = egg.solid(SPACING).unwrap();
    let (field, distances) = solid.linearized_field().unwrap();
    assert!(distances.ambiguous().is_empty());
    let of_mesh = solid.rates(&velocities).unwrap();
    let rates = distances.rates(&of_mesh).unwrap();
    let [before, after] = [-step, step].map(|step| {
        let mut moved = egg.clone();
        for (vertex, velocity) in moved.vertices.iter_mut().zip(&velocities) {
            *vertex += velocity * step;
        }
        let field = moved.solid(SPACING).unwrap().field().unwrap();
        field.extents().to_vec()
    });
    let largest = rates
        .extents
        .iter()
        .fold(0.0_f64, |most, rate| most.max(rate.abs()));
    for (vertex, rate) in rates.extents.iter().enumerate() {
        let difference = (after[vertex] - before[vertex]) / (2.0 * step);
        assert!(
            (difference - rate).abs() < 1e-5 * largest,
            "{vertex} {difference} {rate}"
        );
    }
    let by_vertices: Vec<_> = field.mesh().vertices().iter().map(velocity).collect();
    let by_extents: Vec<_> = field.extents().iter().map(|extent| extent.sin()).collect();
    let by_mesh = distances.pullback(&by_vertices, &by_extents).unwrap();
    let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
    };
    let of_extents: f64 = by_extents
        .iter()
        .zip(&rates.extents)
        .map(|(by, rate)| by * rate)
        .sum();
    let by_rates = dot(&by_vertices, &rates.vertices) + of_extents;
    let by_pullback = dot(&by_mesh.by_vertices, &of_mesh);
    assert!(
        (by_pullback / by_rates - 1.0).abs() < 1e-11,
        "{by_pullback} {by_rates}"
    );
}

/// Extents are ratios of lengths, so that a mesh that moves and grows as a whole keeps them.
#[test]
fn fitted_extents_stay_as_meshes_move_turn_and_grow() {
    let solid = egg().solid(SPACING).unwrap();
    let (_, distances) = solid.linearized_field().unwrap();
    let motions: [Motion; 3] = [
        |_| vector![0.3, 0.7, -0.4],
        |point| vector![0.3, 0.7, -0.4].cross(point),
        |point| *point,
    ];
    for motion in motions {
        let velocities: Vec<_> = solid.mesh().vertices().iter().map(motion).collect();
        let rates = distances.rates(&velocities).unwrap();
        assert!(rates.extents.iter().all(|rate| rate.abs() < 1e-10));
    }
}

#[test]
fn vertices_without_derivatives_are_listed() {
    let spacing = Resolution::Spacing(1.0 / 64.0);
    let motions: [Motion; 3] = [|point| *point, |_| vector![0.3, 0.7, -0.4], velocity];
    let step = 1e-8;
    for (soup, motion) in symmetric_soups()
        .iter()
        .flat_map(|soup| motions.map(|motion| (soup, motion)))
    {
        let solid = soup.solid(spacing).unwrap();
        let velocities: Vec<_> = soup.vertices.iter().map(motion).collect();
        let rates = solid.rates(&velocities).unwrap();
        let after = |step: f64| {
            let mut changed = soup.clone();
            for (vertex, velocity) in changed.vertices.iter_mut().zip(&velocities) {
                *vertex += velocity * step;
            }
            changed.solid(spacing).unwrap().mesh().clone()
        };
        let meshes = [after(-step), after(step)];
        if meshes.iter().any(|mesh| mesh.tets() != solid.mesh().tets()) {
            assert!(!solid.ambiguous().is_empty());
            continue;
        }
        let [before, after] = meshes;
        assert!(solid.ambiguous().len() < solid.boundary_vertices().count());
        for (vertex, rate) in rates.iter().enumerate() {
            let difference = (after.vertices()[vertex] - before.vertices()[vertex]) / (2.0 * step);
            let is_exact = (difference - rate).norm() < 1e-5;
            let is_listed = solid.ambiguous().binary_search(&vertex).is_ok();
            assert!(is_exact || is_listed, "{vertex} {difference} {rate}");
        }
    }
}

#[test]
fn regions_of_distance_functions_follow_their_parameters() {
    // A torus of main radius `r` and a tube of radius `tube`.
    let distance =
        |point: &Vector3<f64>, r: f64, tube: f64| (point.xy().norm() - r).hypot(point.z) - tube;
    let bounds = Aabb {
        lower: vector![-0.15, -0.15, -0.06],
        upper: vector![0.15, 0.15, 0.06],
    };
    let solid = |r: f64, tube: f64| {
        let distances = |points: &[Vector3<f64>]| {
            points
                .iter()
                .map(|point| distance(point, r, tube))
                .collect()
        };
        Solid::of_distance(distances, bounds, Resolution::Spacing(0.0131)).unwrap()
    };
    let (r, tube, step) = (0.1, 0.041, 1e-7);
    let torus = solid(r, tube);
    let exact = 2.0 * std::f64::consts::PI.powi(2) * r * tube * tube;
    assert!((torus.mesh().volume() / exact - 1.0).abs() < 0.03);
    let places: Vec<_> = torus
        .boundary_vertices()
        .map(|vertex| torus.mesh().vertices()[vertex])
        .collect();
    let gradients: Vec<_> = places
        .iter()
        .map(|point| {
            let radial = vector![point.x, point.y, 0.0].normalize();
            (radial * (point.xy().norm() - r) + vector![0.0, 0.0, point.z]) / tube
        })
        .collect();
    let by_tube = vec![-1.0; places.len()];
    let rates = torus.rates_of_distance(&gradients, &by_tube).unwrap();
    let [before, after] = [solid(r, tube - step), solid(r, tube + step)];
    let pairs = after.mesh().vertices().iter().zip(before.mesh().vertices());
    for ((after, before), rate) in pairs.zip(&rates) {
        let difference = (after - before) / (2.0 * step);
        assert!(
            (difference - rate).norm() < 1e-5 * (1.0 + rate.norm()),
            "{difference} {rate}"
        );
    }
}

#[test]
fn errors_that_stay_larger_than_asked_are_told() {
    // A wall of 10 µm across 10 cm.
    let wall = box_soup([0.1, 0.1, 1e-5]).solid(Resolution::DistanceWithin(0.1));
    assert!(matches!(wall, Err(SolidError::Empty { .. })), "{wall:?}");
    let wall = box_soup([0.1, 0.1, 0.002])
        .solid(Resolution::DistanceWithin(1e-3))
        .unwrap();
    let [warning] = wall.warnings() else {
        panic!("{:?}", wall.warnings())
    };
    assert!(
        warning.reached > 1e-9 && warning.tet_count > 150_000,
        "{warning}"
    );
    assert_eq!(Some(warning.reached), wall.distance_error());
}

#[test]
fn small_regions_in_large_boxes_warn_about_the_cell_limit() {
    let bounds = Aabb {
        lower: Vector3::repeat(-0.5),
        upper: Vector3::repeat(0.5),
    };
    let distances = |points: &[Vector3<f64>]| points.iter().map(|p| p.norm() - 0.008).collect();
    let ball = Solid::of_distance(distances, bounds, Resolution::DistanceWithin(1e-3)).unwrap();
    assert_eq!(ball.warnings().len(), 1);
    assert!((ball.mesh().volume() / (4.0 / 3.0 * PI * 0.008_f64.powi(3)) - 1.0).abs() < 0.1);
}

#[test]
fn tiny_regions_in_huge_boxes_are_refused_at_once() {
    let bounds = Aabb {
        lower: Vector3::repeat(-1000.0),
        upper: Vector3::repeat(1000.0),
    };
    let center = vector![3.3, 2.2, 1.1];
    let distances = |points: &[Vector3<f64>]| {
        let distances = points.iter().map(|point| (point - center).norm() - 1.0);
        distances.collect()
    };
    let start = Instant::now();
    let error = Solid::of_distance(distances, bounds, Resolution::default()).unwrap_err();
    assert!(matches!(error, SolidError::Empty { .. }), "{error}");
    assert!(error.to_string().contains("tighter bounds"));
    assert!(start.elapsed() < TIME, "{:?}", start.elapsed());
}

/// The winding number at a point on a triangle without an area is a rounding error.
#[test]
fn triangles_without_an_area_change_no_solid() {
    let cube = box_soup([0.125; 3]);
    let whole = cube.solid(Resolution::Spacing(1.0 / 64.0)).unwrap();
    let diagonal = vector![0.0625, 0.0625, 0.0625];
    for ends in [
        [-diagonal, diagonal],
        [-2.0 * diagonal, vector![0.1, 0.03, -0.05]],
    ] {
        for share in [0.0, 0.5, 0.3] {
            let mut with_line = cube.clone();
            let count = cube.vertices.len();
            let middle = ends[0].lerp(&ends[1], share);
            with_line.vertices.extend([ends[0], ends[1], middle]);
            with_line.triangles.push([count, count + 1, count + 2]);
            let solid = with_line.solid(Resolution::Spacing(1.0 / 64.0)).unwrap();
            assert_eq!(solid.mesh().vertices(), whole.mesh().vertices());
            assert_eq!(solid.mesh().tets(), whole.mesh().tets());
        }
    }
}

#[test]
fn sizes_with_moments_beyond_double_precision_are_refused_at_once() {
    let start = Instant::now();
    for size in [1e-300, 1e-110, 1e-70, 1e70, 1e110, 1e200] {
        let mut soup = egg();
        soup.vertices.iter_mut().for_each(|vertex| *vertex *= size);
        let error = soup.solid(Resolution::default()).unwrap_err();
        let is_size = matches!(error, SolidError::NoSize { .. } | SolidError::NoTriangles);
        assert!(is_size, "{size:e}: {error}");
        let bounds = Aabb {
            lower: Vector3::repeat(-size),
            upper: Vector3::repeat(size),
        };
        let distances = |points: &[Vector3<f64>]| {
            let distances = points.iter().map(|point| point.norm() - size / 2.0);
            distances.collect()
        };
        let error = Solid::of_distance(distances, bounds, Resolution::default()).unwrap_err();
        assert!(matches!(error, SolidError::NoSize { .. }), "{error}");
    }
    assert!(start.elapsed() < TIME, "{:?}", start.elapsed());
}

#[test]
fn nan_distances_stop_the_refinement() {
    let calls = AtomicUsize::new(0);
    let distances = |points: &[Vector3<f64>]| {
        calls.fetch_add(points.len(), Ordering::Relaxed);
        vec![f64::NAN; points.len()]
    };
    let bounds = Aabb {
        lower: Vector3::zeros(),
        upper: Vector3::repeat(1.0),
    };
    let error = Solid::of_distance(distances, bounds, Resolution::default()).unwrap_err();
    assert!(matches!(error, SolidError::NonFiniteDistance { .. }));
    assert!(calls.into_inner() < 1000);
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let egg = egg();
    let cases = [
        (TriangleSoup::default(), SPACING),
        (
            TriangleSoup {
                vertices: vec![],
                triangles: vec![[0, 1, 2]],
            },
            SPACING,
        ),
        (
            TriangleSoup {
                vertices: vec![vector![f64::NAN, 0.0, 0.0]; 3],
                triangles: vec![[0, 1, 2]],
            },
            SPACING,
        ),
        (
            TriangleSoup {
                vertices: vec![Vector3::zeros(); 3],
                triangles: vec![[0, 1, 2]],
            },
            SPACING,
        ),
        (
            TriangleSoup {
                vertices: vec![Vector3::zeros(), Vector3::x(), Vector3::y()],
                triangles: vec![[0, 1, 2]],
            },
            SPACING,
        ),
        (egg.clone(), Resolution::Spacing(-1.0)),
        (egg.clone(), Resolution::VolumeWithin(f64::NAN)),
        (egg.clone(), Resolution::Spacing(1e-9)),
        (egg, Resolution::Spacing(10.0)),
    ];
    let errors = cases.map(|(soup, resolution)| soup.solid(resolution).unwrap_err());
    assert!(
        matches!(
            errors,
            [
                SolidError::NoTriangles,
                SolidError::Surface(SurfaceError::VertexOutOfRange { .. }),
                SolidError::Surface(SurfaceError::NonFiniteCoordinate { .. }),
                SolidError::NoTriangles,
                SolidError::NoSize { .. },
                SolidError::InvalidResolution { .. },
                SolidError::InvalidResolution { .. },
                SolidError::TooFine { .. },
                SolidError::Empty { .. },
            ]
        ),
        "{errors:?}"
    );
}

#[test]
fn distance_functions_that_return_anything_else_are_refused() {
    let bounds = Aabb {
        lower: Vector3::zeros(),
        upper: Vector3::repeat(1.0),
    };
    let of = |value: f64, extra: usize| {
        let distances = |points: &[Vector3<f64>]| vec![value; points.len() + extra];
        Solid::of_distance(distances, bounds, Resolution::Spacing(0.1)).unwrap_err()
    };
    let errors = [of(f64::NAN, 0), of(1.0, 1), of(-1.0, 0), of(1.0, 0)];
    assert!(
        matches!(
            errors,
            [
                SolidError::NonFiniteDistance { .. },
                SolidError::DistanceCount { .. },
                SolidError::BeyondBounds { .. },
                SolidError::Empty { .. },
            ]
        ),
        "{errors:?}"
    );
}
