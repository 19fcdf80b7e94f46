use crate::contact::linearised::RelativeLinearisation;
use crate::contact::polygon::PolygonSource;
use crate::contact::response::PolygonResponse;
use crate::contact::surface_law::RelativeMotion;
use crate::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw};
use crate::mesh::{TriangleSurface, shapes};
use crate::spatial::Pose;
use nalgebra::{SMatrix, Vector3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Round-off of sums over some hundred polygons, whose terms cancel, relative to the largest entry of a block.
const ROUND_OFF: f64 = 1e-11;

/// Spins (1/s) at slips of about 1 m/s: all rungs of the ladder of rules, and the closed form.
const SPINS: [f64; 7] = [0.0, 1e-6, 1e-3, 0.1, 1.0, 5.0, 30.0];

fn largest<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> f64 {
    matrix.iter().fold(0.0, |most, entry| entry.abs().max(most))
}

/// To within a fraction of what the pressure alone does, at least: where all of it is clamped, nothing is left.
fn assert_blocks_agree([lanes, single, elastic]: [&RelativeLinearisation<f64>; 3], what: &str) {
    let agree = |difference: f64, scale: f64, of: &str| {
        assert!(
            difference <= ROUND_OFF * scale,
            "{what}, by {of}: {difference:e} of {scale:e}"
        );
    };
    // Torques and forces in bodies of 1 m are of one size.
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
        let [lanes, single, elastic] =
            [lanes, single, elastic].map(|it| it.by_moduli.column(column).into_owned());
        let scale = largest(&single).max(largest(&elastic));
        agree(largest(&(lanes - single)), scale, "modulus");
    }
    assert_eq!(lanes.kinks, single.kinks, "{what}");
}

/// Both ways of going over the polygons: in lanes, and one by one. Gives how many there are.
fn assert_ways_agree(pair: &ContactPair, law: &SurfaceLaw, spin: f64, what: &str) -> usize {
    let surface = PolygonSource::of(pair).for_values(pair.search());
    let motion = RelativeMotion {
        angular: Vector3::new(0.3, -0.5, 0.8) * spin,
        at_origin: Vector3::new(0.9, -0.4, 0.5),
    };
    let (lanes, ()) = surface.linearisation(law, &motion);
    let (single, kept) = surface.linearisation::<Vec<PolygonResponse>>(law, &motion);
    if kept.len() > 20 {
        let none = SurfaceLaw::new(0.0, 0.0, 1e-3).unwrap();
        let (elastic, ()) = surface.linearisation(&none, &motion);
        assert_blocks_agree([&lanes, &single, &elastic], what);
    }
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
                let what = format!("{number}, law {dissipation} {friction}, spin {spin}");
                compared += usize::from(assert_ways_agree(&pair, &law, spin, &what) > 20);
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}
