//! Signed distances between bodies, against all pairs of features, closed forms and differences.

use super::support::scenes::{Random, mixed_shapes};
use super::support::worlds::{at, cuboid, icosphere, rigid, turned};
use hydroelastic::contact::{
    Clearance, ContactBody, ContactPair, Feature, HalfSpace, Partner, RigidShape, Shape,
};
use hydroelastic::scalar::lift;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SVector, Vector3, vector};
use num_dual::hessian;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};
use std::time::Instant;

/// Rounding error of a distance between bodies of about 1 m, from coordinates of up to 10 m.
const EXACT: f64 = 1e-12;

/// Rounding error of a distance between bodies of about 1 m at the origin.
const ROUND_OFF: f64 = 1e-15;

/// Error of central differences with a step of 1e-6 m: the rounding error of a distance of 10 m, and the curvature.
const DIFFERENCES: f64 = 1e-7;

/// Step (m, rad) of differences.
const STEP: f64 = 1e-6;

/// Difference of the slopes on both sides that counts as a kink. The curvature causes a smaller difference.
const KINK: f64 = 1e-3;

/// Allowed number of aligned pairs, out of 300, whose derivative is not between the one-sided derivatives. In these pairs, an edge of one cube
/// is parallel to a face or an edge of the other, and the depth begins with a smaller slope than the distance.
const MOST_OUTSIDE: usize = 11;

const MODULUS: f64 = 1e5;

/// Vertices (m), edges and triangles of a surface in the world.
struct Surface {
    vertices: Vec<Vector3<f64>>,
    edges: Vec<[Vector3<f64>; 2]>,
    triangles: Vec<[Vector3<f64>; 3]>,
}

impl Surface {
    fn of(shape: &Shape, pose: &Pose) -> Self {
        let mesh = shape.field().mesh();
        let point = |vertex: usize| pose.transformed_point(&mesh.vertices()[vertex]);
        let triangles = mesh.surface_triangles();
        let sides = |[a, b, c]: &[usize; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let edges: BTreeSet<[usize; 2]> = triangles
            .iter()
            .flat_map(sides)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        let vertices: BTreeSet<usize> = triangles.iter().flatten().copied().collect();
        Self {
            vertices: vertices.into_iter().map(point).collect(),
            edges: edges.into_iter().map(|ends| ends.map(point)).collect(),
            triangles: triangles.iter().map(|corners| corners.map(point)).collect(),
        }
    }

    /// Returns the smallest distance to another surface over all pairs of features.
    fn distance_to(&self, other: &Self) -> f64 {
        let mut least = f64::INFINITY;
        for (vertices, triangles) in [
            (&self.vertices, &other.triangles),
            (&other.vertices, &self.triangles),
        ] {
            for vertex in vertices {
                for triangle in triangles {
                    least = least.min(above(vertex, triangle).unwrap_or(f64::INFINITY));
                }
            }
        }
        for edge in &self.edges {
            for other_edge in &other.edges {
                least = least.min(between(edge, other_edge));
            }
        }
        least
    }
}

#[expect(clippy::many_single_char_names, reason = "the names of a textbook")]
/// Returns the distance (m) of a point to a triangle, if its projection is inside the triangle.
fn above(point: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> Option<f64> {
    let (u, v, w) = (b - a, c - a, point - a);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let determinant = uu * vv - uv * uv;
    let s = (vv * u.dot(&w) - uv * v.dot(&w)) / determinant;
    let t = (uu * v.dot(&w) - uv * u.dot(&w)) / determinant;
    let is_inside = s >= 0.0 && t >= 0.0 && s + t <= 1.0;
    is_inside.then(|| w.dot(&u.cross(&v).normalize()).abs())
}

#[expect(clippy::many_single_char_names, reason = "the names of a textbook")]
/// Returns the distance (m) of two segments: of the closest points of their lines, moved to the segments one after the other.
fn between([a, b]: &[Vector3<f64>; 2], [c, d]: &[Vector3<f64>; 2]) -> f64 {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let determinant = uu * vv - uv * uv;
    let first = if determinant > 0.0 {
        ((uv * v.dot(&w) - vv * u.dot(&w)) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let t = ((uv * first + v.dot(&w)) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - u.dot(&w)) / uu).clamp(0.0, 1.0);
    let t = ((uv * s + v.dot(&w)) / vv).clamp(0.0, 1.0);
    (w + u * s - v * t).norm()
}

fn pair<'a>(a: (&'a Shape, Pose), b: impl Into<Partner<'a>>) -> ContactPair<'a> {
    ContactPair::new(ContactBody::new(a.0, a.1, MODULUS).unwrap(), b)
}

fn body(shape: &Shape, pose: Pose) -> ContactBody<'_> {
    ContactBody::new(shape, pose, MODULUS).unwrap()
}

fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual}, not {expected}"
    );
}

/// Calls `check` with pairs of bodies at random poses, nearly touching or apart. Compliant and rigid partners alternate.
fn for_random_pairs(count: u64, mut check: impl FnMut(&ContactPair, [&Shape; 2])) {
    let shapes = mixed_shapes();
    let solids: Vec<RigidShape> = shapes.iter().map(|shape| rigid(shape.field())).collect();
    for number in 0..count {
        let mut random = Random::numbered(number);
        let [a, b] = [0, 1].map(|_| random.below(shapes.len()));
        let mut pose = |reach: f64| {
            let position = random.direction() * random.between(0.0, reach);
            Pose::from_rotation_vector(&random.rotation_vector(), position)
        };
        let poses = [pose(1.0), pose(5.0)];
        let partner = if number % 2 == 0 {
            body(&shapes[b], poses[1]).into()
        } else {
            Partner::rigid(&solids[b], poses[1]).unwrap()
        };
        check(
            &pair((&shapes[a], poses[0]), partner),
            [&shapes[a], &shapes[b]],
        );
    }
}

#[test]
fn the_distance_of_bodies_apart_is_the_least_of_all_pairs_of_features() {
    let mut apart = 0;
    for_random_pairs(1_000, |pair, shapes| {
        let Clearance {
            distance, points, ..
        } = pair.clearance();
        if distance <= 0.0 {
            let overlap = pair.surface().is_empty() && !pair.has_sunk_through();
            assert!(!overlap, "{distance}");
            return;
        }
        let surface = |k: usize, pose: &Pose| Surface::of(shapes[k], pose);
        let least = surface(0, pair.a().pose()).distance_to(&surface(1, pair.b().pose()));
        assert_near(distance, least, EXACT);
        assert_near((points[1] - points[0]).norm(), distance, EXACT);
        assert!(pair.surface().is_empty());
        apart += 1;
    });
    println!("{apart} of 1000 pairs are apart");
    assert!(apart > 400);
}

#[test]
fn the_distance_from_a_half_space_is_the_height_of_the_lowest_vertex() {
    let shapes = mixed_shapes();
    for number in 0..1_000 {
        let mut random = Random::numbered(number);
        let shape = &shapes[random.below(shapes.len())];
        let floor = Pose::from_rotation_vector(&random.rotation_vector(), random.vector());
        let up = floor.rotation().column(2).into_owned();
        let position = floor.translation() + up * random.between(-0.5, 4.0) + random.vector();
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), position);
        let vertices = Surface::of(shape, &pose).vertices;
        let height = |vertex: &Vector3<f64>| up.dot(&(vertex - floor.translation()));
        let lowest = vertices.iter().map(height).fold(f64::INFINITY, f64::min);
        let pair = pair((shape, pose), Partner::rigid_half_space(floor).unwrap());
        let clearance = pair.clearance();
        if lowest > 0.0 {
            assert_near(clearance.distance, lowest, EXACT);
            assert_eq!(clearance.features[1], Feature::Plane);
        } else {
            assert!(clearance.distance <= 0.0);
        }
    }
}

/// Returns the pair after a motion of A and of B.
fn moved<'a>(pair: &ContactPair<'a>, motion: &SVector<f64, 12>) -> ContactPair<'a> {
    let twist = |row| Twist::from_vector(&motion.fixed_rows::<6>(row).into_owned());
    let pose_b = pair.b().pose().moved_by(&twist(6));
    let modulus = pair.b().modulus().unwrap_or(1.0);
    ContactPair::new(
        body(pair.a().shape(), pair.a().pose().moved_by(&twist(0))),
        pair.b().at(pose_b, modulus).unwrap(),
    )
}

#[test]
fn derivatives_of_the_distance_are_differences_except_at_kinks() {
    let (mut smooth, mut kinks, mut overlapping) = (0, 0, 0);
    for_random_pairs(300, |pair, _| {
        let contact = pair.linearized_clearance();
        for column in 0..12 {
            let mut motion = SVector::zeros();
            motion[column] = STEP;
            let sides = [motion, -motion].map(|motion| moved(pair, &motion).clearance());
            let features = sides.map(|side| side.features);
            let [ahead, behind] = sides.map(|side| side.distance - contact.clearance.distance);
            // Polygons that share their deepest corner are selected by round-off.
            let is_apart = contact.clearance.distance > 0.0;
            let is_changed = is_apart && features != [contact.clearance.features; 2];
            if is_changed || (ahead + behind).abs() > KINK * STEP {
                kinks += 1;
                continue;
            }
            let difference = (sides[0].distance - sides[1].distance) / (2.0 * STEP);
            let error = (contact.by_poses[column] - difference).abs();
            assert!(
                error <= DIFFERENCES * difference.abs().max(1.0),
                "{error:e} {contact:?}"
            );
            smooth += 1;
            overlapping += usize::from(contact.clearance.distance < 0.0);
        }
    });
    println!("{smooth} smooth derivatives, {overlapping} of them overlapping, {kinks} kinks");
    assert!(kinks * 20 < smooth && overlapping > 500);
}

/// Returns two cubes whose distance is within one floating-point step of contact. Their rotations are random, or some of their faces, edges or corners are aligned.
fn touching_cubes([a, b]: [&Shape; 2], number: u64, are_aligned: bool) -> ContactPair<'_> {
    let mut random = Random::numbered(number);
    let rotations = [0, 1].map(|_| {
        let mut turn = Vector3::zeros();
        turn[random.below(3)] = [0.0, FRAC_PI_4, FRAC_PI_2, 0.3][random.below(4)];
        if are_aligned {
            turn
        } else {
            random.rotation_vector()
        }
    });
    let mut direction = Vector3::from_fn(|_, _| [0.0, 0.0, 1.0, 0.9, 0.2, -0.3][random.below(6)]);
    direction[random.below(3)] += 0.5;
    let at = |distance: f64| {
        let [pose_a, pose_b] = [Vector3::zeros(), direction * distance];
        let pose_b = Pose::from_rotation_vector(&rotations[1], pose_b);
        let pose_a = Pose::from_rotation_vector(&rotations[0], pose_a);
        pair((a, pose_a), body(b, pose_b))
    };
    let ends = bisected([0.0, 8.0], |distance| {
        at(distance).clearance().distance > 0.0
    });
    at(ends[usize::from(number.is_multiple_of(2))])
}

/// Returns neighboring distances, of which the bodies are apart at the second only.
fn bisected([mut low, mut high]: [f64; 2], is_apart: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_apart(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    [low, high]
}

/// Returns whether a derivative of the clearance is not between the one-sided derivatives.
fn is_outside_of_one_sided_derivatives(pair: &ContactPair) -> bool {
    let contact = pair.linearized_clearance();
    (0..12).any(|column| {
        let mut motion = SVector::zeros();
        motion[column] = STEP;
        let change =
            |motion| moved(pair, &motion).clearance().distance - contact.clearance.distance;
        let slopes = [change(motion) / STEP, -change(-motion) / STEP];
        let [least, most] = [slopes[0].min(slopes[1]), slopes[0].max(slopes[1])];
        !(least - KINK..=most + KINK).contains(&contact.by_poses[column])
    })
}

#[test]
fn derivatives_at_exact_touch_are_between_the_one_sided_derivatives() {
    let [a, b] = [cuboid([1.0; 3]), cuboid([0.8; 3])];
    for (are_aligned, most) in [(false, 0), (true, MOST_OUTSIDE)] {
        let pairs = (0..300).map(|number| touching_cubes([&a, &b], number, are_aligned));
        let outside = pairs.filter(is_outside_of_one_sided_derivatives).count();
        println!("aligned: {are_aligned}, {outside} of 300 pairs have a derivative outside");
        assert!(outside <= most);
    }
}

#[test]
fn the_derivative_of_an_edge_on_a_plane_is_the_derivative_at_the_middle_of_the_edge() {
    let cube = cuboid([1.0; 3]);
    for sunk in [0.0, 1e-13, 5e-11, -1e-13] {
        let pose = turned([FRAC_PI_4, 0.0, 0.0], [0.3, 0.2, SQRT_2 / 2.0 - sunk]);
        let on_edge = pair(
            (&cube, pose),
            Partner::rigid_half_space(Pose::identity()).unwrap(),
        );
        let contact = on_edge.linearized_clearance();
        assert_near(contact.clearance.distance, -sunk, ROUND_OFF);
        let slopes = contact.by_poses.fixed_rows::<6>(0).into_owned();
        assert_near(
            (slopes - vector![0.0, 0.0, 0.0, 0.0, 0.0, 1.0]).amax(),
            0.0,
            EXACT,
        );
    }
}

/// The corner of a soft cube is 0.05 m below the top of a plate. The pressure of the cube is 0 there.
#[test]
fn the_depth_of_a_corner_does_not_depend_on_the_moduli() {
    let (plate, cube) = (cuboid([2.0, 2.0, 1.0]), cuboid([0.2; 3]));
    let down = Vector3::new(1.0, -1.0, 0.0).normalize() * (-1.0 / 3.0_f64.sqrt()).acos();
    let pose = turned(down.into(), [0.0, 0.0, 0.5 + 0.1 * 3.0_f64.sqrt() - 0.05]);
    for modulus in [1e3, 1e5, 1e7] {
        let cube = ContactBody::new(&cube, pose, modulus).unwrap();
        let pair = pair((&plate, Pose::identity()), cube);
        assert_near(pair.clearance().distance, -0.05, ROUND_OFF);
    }
}

#[test]
fn second_derivatives_are_differences_of_first_derivatives() {
    let [a, b] = [cuboid([1.0; 3]), cuboid([1.0; 3])];
    // The edges at (0.5, 0.5, z) and (0.5, y, 0.5) of the cubes are closest after turns by an eighth.
    let b_pose = turned([0.6, 0.3, 0.2], [0.3, -1.5, 1.4]);
    let distance = |position: SVector<num_dual::Dual2SVec64<3>, 3>| {
        let pose = Pose::from_rotation_vector(
            &Vector3::repeat(lift(0.1)),
            Vector3::from_fn(|row, _| position[row]),
        );
        let body = ContactBody::new(&a, pose, lift(MODULUS)).unwrap();
        let partner = ContactBody::new(&b, Pose::lifted(&b_pose), lift(MODULUS)).unwrap();
        ContactPair::new(body, partner).clearance().distance
    };
    let (_, slope, curvature) = hessian(distance, &Vector3::zeros());
    for column in 0..3 {
        let slopes = [STEP, -STEP].map(|step| {
            let mut at = Vector3::zeros();
            at[column] = step;
            hessian(distance, &at).1
        });
        let difference = (slopes[0] - slopes[1]) / (2.0 * STEP);
        assert!((curvature.column(column) - difference).amax() <= 1e-7);
    }
    assert_near(slope.norm(), 1.0, EXACT);
}

#[test]
fn flush_and_parallel_faces_have_the_distance_of_their_planes() {
    let [a, b] = [cuboid([1.0, 0.8, 0.6]), cuboid([0.5, 2.0, 0.6])];
    for gap in [1e-9, 1e-3, 0.7] {
        for offset in [0.0, 0.2, 0.25, 0.75] {
            let below = body(&b, at(offset, 0.1, -0.6 - gap));
            assert_near(
                pair((&a, Pose::identity()), below).clearance().distance,
                gap,
                EXACT,
            );
        }
    }
    // The faces overlap, or share only an edge or a corner.
    for [x, y] in [[0.0, 0.0], [0.75, 0.0], [0.75, 1.4]] {
        let below = body(&b, at(x, y, -0.6));
        let touching = pair((&a, Pose::identity()), below).linearized_clearance();
        assert_near(touching.clearance.distance, 0.0, EXACT);
        assert!(touching.by_poses.iter().all(|slope| slope.is_finite()));
        assert_near(touching.by_poses.fixed_rows::<3>(3).norm(), 1.0, EXACT);
    }
}

#[test]
fn edges_that_cross_at_a_tiny_gap_have_their_distance() {
    let [a, b] = [cuboid([1.0; 3]), cuboid([0.8; 3])];
    for gap in [1e-12, 3e-11, 1e-10, 1e-9] {
        // The upper edge of A is along x, and the lower edge of B is along y.
        let below = turned([FRAC_PI_4, 0.0, 0.0], [0.0; 3]);
        let height = 1.8 * SQRT_2 / 2.0 + gap;
        for offset in [0.0, 0.07] {
            let above = body(&b, turned([0.0, FRAC_PI_4, 0.0], [offset, 0.1, height]));
            let contact = pair((&a, below), above).linearized_clearance();
            assert_near(contact.clearance.distance, gap, ROUND_OFF);
            assert_near(contact.by_poses[11], 1.0, EXACT);
        }
    }
}

#[test]
fn distances_of_far_and_of_tiny_and_huge_bodies_keep_their_digits() {
    let ball = icosphere(0.1, 3);
    let far = pair((&ball, at(1e3, 0.0, 0.0)), body(&ball, at(0.0, 0.0, 0.0)));
    assert_near(far.clearance().distance / (1e3 - 0.2), 1.0, 1e-5);
    for scale in [1e-6, 1e6] {
        let [a, b] = [cuboid([scale; 3]), cuboid([2.0 * scale; 3])];
        let gap = 0.3 * scale;
        let apart = pair(
            (&a, at(1.5 * scale + gap, 0.0, 0.1 * scale)),
            body(&b, Pose::identity()),
        );
        assert_near(apart.clearance().distance / gap, 1.0, EXACT);
        let depth = 0.1 * scale;
        let deep = pair(
            (&a, at(1.5 * scale - depth, 0.0, 0.1 * scale)),
            body(&b, Pose::identity()),
        );
        assert_near(deep.clearance().distance / -depth, 1.0, EXACT);
    }
}

#[test]
fn the_clearance_of_overlapping_boxes_and_of_a_ball_on_a_plane_is_the_geometric_depth() {
    let [block, ball] = [cuboid([1.0; 3]), icosphere(0.5, 3)];
    for depth in [1e-9, 1e-3, 0.1, 0.3] {
        let below = body(&block, at(0.1, 0.05, -1.0 + depth));
        let boxes = pair((&block, Pose::identity()), below).clearance().distance;
        assert_near(boxes, -depth, 1e-11);
        let layer = HalfSpace::layer(0.7).unwrap();
        for floor in [HalfSpace::rigid(), layer] {
            let floor = Partner::half_space(&floor, Pose::identity(), 3.0 * MODULUS).unwrap();
            let on_floor =
                |shape, z: f64| pair((shape, at(0.0, 0.0, z)), floor).clearance().distance;
            assert_near(on_floor(&block, 0.5 - depth), -depth, 1e-11);
            // The faces deviate from the sphere.
            assert_near(on_floor(&ball, 0.5 - depth), -depth, 0.02 * depth);
        }
    }
}

#[test]
fn the_clearance_of_a_body_that_sinks_in_is_continuous_and_does_not_rise() {
    let [ball, big] = [icosphere(0.5, 2), icosphere(1.0, 2)];
    let solid = rigid(big.field());
    let floor = HalfSpace::rigid();
    let (step, mut before) = (1e-2, [f64::INFINITY; 3]);
    for number in 0..250_u32 {
        let z = 1.7 - f64::from(number) * step;
        let partners = [
            Partner::from(ContactBody::new(&big, Pose::identity(), 2.0 * MODULUS).unwrap()),
            Partner::rigid(&solid, Pose::identity()).unwrap(),
            Partner::half_space(&floor, at(0.0, 0.0, 0.9), 1.0).unwrap(),
        ];
        for (partner, last) in partners.into_iter().zip(&mut before) {
            let distance = pair((&ball, at(0.0, 0.0, z)), partner).clearance().distance;
            if z > 0.0 && last.is_finite() {
                let change = *last - distance;
                assert!(
                    (-1e-12..=1.1 * step).contains(&change),
                    "{z}: {last} to {distance}"
                );
            }
            *last = distance;
        }
    }
}

#[test]
fn a_body_inside_another_body_overlaps() {
    let [small, large] = [icosphere(0.1, 2), icosphere(1.0, 2)];
    let (solid, pearl) = (rigid(large.field()), rigid(small.field()));
    let at_center = Pose::identity();
    let in_soft = pair((&small, at(0.0, 0.0, 0.3)), body(&large, at_center));
    let in_rigid = pair(
        (&small, at(0.0, 0.0, 0.3)),
        Partner::rigid(&solid, at_center).unwrap(),
    );
    let around_rigid = pair(
        (&large, at_center),
        Partner::rigid(&pearl, at(0.3, 0.0, 0.0)).unwrap(),
    );
    for (name, pair) in [
        ("soft", in_soft),
        ("rigid", in_rigid),
        ("around", around_rigid),
    ] {
        let distance = pair.clearance().distance;
        println!("{name}: {distance}");
        assert!(distance < -0.75 && distance > -0.85, "{name}: {distance}");
    }
}

/// Prints the time of a clearance and of a wrench.
#[test]
#[ignore = "measures times"]
fn the_clearance_of_balls_apart_takes_microseconds() {
    let ball = icosphere(0.1, 3);
    let time = |pair: &ContactPair, run: &dyn Fn(&ContactPair) -> f64| {
        let start = Instant::now();
        let sum: f64 = (0..2_000).map(|_| run(pair)).sum();
        assert!(sum.is_finite());
        start.elapsed().as_secs_f64() / 2_000.0 * 1e6
    };
    let clearance = |pair: &ContactPair| pair.clearance().distance;
    let slopes = |pair: &ContactPair| pair.linearized_clearance().by_poses[5];
    let wrench = |pair: &ContactPair| pair.wrench().on_a.force.z;
    for z in [-0.01, 0.001, 0.01, 0.1, 1.0] {
        let direction = vector![0.48, 0.6, 0.64];
        let pose = turned([0.3, 0.2, 0.1], (direction * (0.2 + z)).into());
        let pair = pair((&ball, pose), body(&ball, Pose::identity()));
        println!(
            "gap {z} m: clearance {:.1} µs, with derivatives {:.1} µs, wrench {:.1} µs",
            time(&pair, &clearance),
            time(&pair, &slopes),
            time(&pair, &wrench)
        );
    }
}
