use crate::contact::integrate::Integrand;
use crate::contact::motion::RelativeMotion;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::relative_linearization::RelativeLinearization;
use crate::contact::response::{OfCell, PolygonResponse};
use crate::contact::traction_derivatives::{InMotion, MovingJacobian};
use crate::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw};
use crate::mesh::{TriangleSurface, shapes};
use crate::spatial::Pose;
use nalgebra::{SMatrix, Vector3, Vector6};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Round-off of sums over some hundred polygons, whose terms cancel, relative to the largest entry of a block.
const ROUND_OFF: f64 = 1e-12;

/// Round-off of one polygon, relative to the largest contribution of a polygon.
const CLOSE: f64 = 1e-12;

/// Spins (1/s) at slips of about 1 m/s. They select all levels of quadrature rules, and the closed form.
const SPINS: [f64; 7] = [0.0, 1e-6, 1e-3, 0.1, 1.0, 5.0, 30.0];

fn largest<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> f64 {
    matrix.iter().fold(0.0, |most, entry| entry.abs().max(most))
}

/// Compares to within a fraction of the larger of the result and the elastic part, because the result is zero if the whole pressure is
/// clamped.
fn assert_blocks_agree([lanes, single, elastic]: [&RelativeLinearization; 3], label: &str) {
    let agree = |difference: f64, scale: f64, of: &str| {
        assert!(
            difference <= ROUND_OFF * scale,
            "{label}, by {of}: {difference:e} of {scale:e}"
        );
    };
    // Torques and forces in bodies of 1 m have similar magnitudes.
    let wrench = largest(&single.wrench).max(largest(&elastic.wrench));
    agree(largest(&(lanes.wrench - single.wrench)), wrench, "nothing");
    let scale = largest(&single.by_motion).max(largest(&elastic.by_motion));
    agree(
        largest(&(lanes.by_motion - single.by_motion)),
        scale,
        "motion",
    );
    let scale = largest(&single.by_twist).max(wrench);
    agree(largest(&(lanes.by_twist - single.by_twist)), scale, "twist");
    let scale = largest(&single.by_law).max(wrench);
    agree(largest(&(lanes.by_law - single.by_law)), scale, "law");
    for column in 0..2 {
        let [lanes, single, elastic] = [lanes, single, elastic]
            .map(|linearization| linearization.by_moduli.column(column).into_owned());
        let scale = largest(&single).max(largest(&elastic));
        agree(largest(&(lanes - single)), scale, "modulus");
    }
    assert_eq!(lanes.kinks, single.kinks, "{label}");
}

/// Compares the contribution of each polygon to the derivatives of a number with respect to the shapes, to within a fraction of the largest
/// contribution.
fn assert_responses_agree(
    source: &PolygonSource<f64>,
    responses: [&[PolygonResponse]; 2],
    label: &str,
) {
    let covector = Vector6::new(0.3, -0.8, 0.5, 0.9, 0.2, -0.6);
    let [lanes, single] = responses.map(|responses| {
        let of_cells = |response: &PolygonResponse| {
            let cells = source.barycentric(response.tets);
            response.pulled_back(&covector, source.moduli(), &cells)
        };
        let mut pulled: Vec<_> = responses
            .iter()
            .map(|response| (response.tets, of_cells(response)))
            .collect();
        pulled.sort_by_key(|(tets, _)| *tets);
        pulled
    });
    assert_eq!(lanes.len(), single.len(), "{label}");
    for body in 0..2 {
        let corners = |(_, cells): &(_, [OfCell; 2])| cells[body].by_corners.map(|by| by.amax());
        let extents = |(_, cells): &(_, [OfCell; 2])| cells[body].by_extents.map(f64::abs);
        let most = |of: &[[f64; 4]]| of.iter().flatten().copied().fold(0.0, f64::max);
        let by_corners = most(&single.iter().map(corners).collect::<Vec<_>>());
        let by_extents = most(&single.iter().map(extents).collect::<Vec<_>>());
        for ((tets, lanes), (others, single)) in lanes.iter().zip(&single) {
            assert_eq!(tets, others, "{label}");
            let (lanes, single) = (&lanes[body], &single[body]);
            for corner in 0..4 {
                let difference = lanes.by_corners[corner] - single.by_corners[corner];
                let of_extent = lanes.by_extents[corner] - single.by_extents[corner];
                assert!(
                    difference.amax() <= CLOSE * by_corners
                        && of_extent.abs() <= CLOSE * by_extents,
                    "{label}, {tets:?}, body {body}: {:e}, {:e}",
                    difference.amax() / by_corners,
                    of_extent.abs() / by_extents
                );
            }
        }
    }
}

/// Compares both ways of integrating the polygons: in lanes, and one by one. Returns the number of polygons.
fn assert_integrations_agree(
    pair: &ContactPair,
    law: &SurfaceLaw,
    spin: f64,
    label: &str,
) -> usize {
    let surface = pair.source().for_values(pair.search());
    let motion = RelativeMotion {
        angular: Vector3::new(0.3, -0.5, 0.8) * spin,
        at_origin: Vector3::new(0.9, -0.4, 0.5),
    };
    let source = &surface.source;
    let integrand = MovingJacobian::<Vec<PolygonResponse>>::new(law, &motion);
    let moduli = source.moduli();
    let (lanes, kept) = surface.integral(&integrand).linearization(moduli);
    let single: InMotion<_> = surface.sum_of_cuts(|sum, cut| integrand.add(source, cut, sum));
    let (single, kept_singly) = single.linearization(moduli);
    let values = |law: &SurfaceLaw| {
        let integrand = MovingJacobian::<()>::new(law, &motion);
        surface.integral(&integrand).linearization(moduli).0
    };
    if kept.len() > 20 {
        let frictionless = SurfaceLaw::new(0.0, 0.0, 1e-3).unwrap();
        let elastic = values(&frictionless);
        assert_blocks_agree([&lanes, &single, &elastic], label);
        assert_responses_agree(source, [&kept, &kept_singly], label);
    }
    assert_eq!(values(law).by_motion, lanes.by_motion, "{label}");
    kept.len()
}

#[test]
fn polygons_side_by_side_add_what_they_add_one_by_one() {
    let ball = Shape::new(shapes::icosphere(1.0, 2).unwrap());
    let block = Shape::new(shapes::cuboid([1.0, 1.2, 0.8]).unwrap());
    let round = TriangleSurface::around(shapes::icosphere(0.9, 2).unwrap().mesh());
    let round = RigidShape::new(round.unwrap());
    let layer = HalfSpace::layer(0.1).unwrap();
    let mut random = StdRng::seed_from_u64(83);
    let mut compared = 0;
    for number in 0..60 {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| random.random_range(-size..size));
        let pose = Pose::from_rotation_vector(&vector(1.5), vector(0.6));
        let modulus = 10_f64.powf(random.random_range(2.0..8.0));
        let a = ContactBody::new(&ball, pose, 1e5).unwrap();
        let at_origin = |shape| ContactBody::new(shape, Pose::identity(), modulus).unwrap();
        let partner = match number % 5 {
            0 => Partner::from(at_origin(&ball)),
            1 => Partner::from(at_origin(&block)),
            2 => Partner::rigid(&round, Pose::identity()).unwrap(),
            3 => Partner::rigid_half_space(Pose::identity()).unwrap(),
            _ => Partner::half_space(&layer, Pose::identity(), modulus).unwrap(),
        };
        let pair = ContactPair::new(a, partner);
        for [dissipation, friction] in [[0.0, 0.0], [0.0, 0.7], [0.4, 0.0], [0.4, 0.7], [3.0, 0.3]]
        {
            let law = SurfaceLaw::new(dissipation, friction, 1e-3).unwrap();
            for spin in SPINS {
                let label = format!("{number}, law {dissipation} {friction}, spin {spin}");
                compared += usize::from(assert_integrations_agree(&pair, &law, spin, &label) > 20);
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}
