//! Meshes with plateaus: tetrahedra with equal extents at all corners have constant pressure, so two bodies of equal moduli have no plane
//! of equal pressure.

use crate::support::scenes::{Random, grid, pair};
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::scalar::lift;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SVector, Vector6};
use num_dual::{DualSVec64, gradient};

/// Rounding error of some thousand polygons.
const SAME: f64 = 1e-11;

/// Error of the energy's derivative, which passes through the clips of many tetrahedra that consist only of round-off.
const SLOPE: f64 = 1e-8;

/// Returns a cube of 5³ cells, with extent 0 on the surface and 1 at every inner vertex.
fn plateau_cube() -> Shape {
    let field = grid(&[5; 3], 0.3, |_| true).unwrap();
    let mesh = TetMesh::new(
        field.mesh().vertices().to_vec(),
        field.mesh().tets().to_vec(),
    );
    let extents = field.extents().iter().map(|&e| f64::from(e > 0.0));
    Shape::new(PressureField::new(mesh.unwrap(), extents.collect()).unwrap())
}

fn for_generic_pairs(count: usize, seed: u8, check: impl Fn(&ContactPair)) {
    let (cube, mut random) = (plateau_cube(), Random::new(seed));
    for _ in 0..count {
        let position = random.direction() * random.between(0.4, 1.4);
        let turned = Pose::from_rotation_vector(&random.rotation_vector(), position);
        check(&pair((&cube, Pose::identity(), 2.0), (&cube, turned, 2.0)));
    }
}

#[test]
fn plateaus_give_one_wrench_whatever_the_search_and_the_order() {
    for_generic_pairs(12, 61, |pair| {
        let wrench = pair.wrench();
        let scale = wrench.on_a.to_vector().amax();
        let exchanged = ContactPair::new(pair.b().body().unwrap(), *pair.a()).wrench();
        let unculled = pair.with_search(Search::Culling(Culling::NONE)).wrench();
        for repeated in [exchanged.on_b, unculled.on_a] {
            let error = (wrench.on_a.to_vector() - repeated.to_vector()).amax();
            assert!(error <= SAME * scale, "{error:e} of {scale:e}");
        }
    });
}

#[test]
fn plateaus_push_along_the_slope_of_the_energy() {
    for_generic_pairs(6, 62, |pair| {
        let energy = |motion: SVector<DualSVec64<6>, 6>| {
            let twist = Twist::from_vector(&Vector6::from_fn(|i, _| motion[i]));
            let pose = Pose::lifted(pair.a().pose()).moved_by(&twist);
            let modulus = lift(pair.a().modulus());
            let body = |shape, pose| {
                hydroelastic::contact::ContactBody::new(shape, pose, modulus).unwrap()
            };
            let b = body(pair.b().shape().unwrap(), Pose::lifted(pair.b().pose()));
            ContactPair::new(body(pair.a().shape(), pose), b).potential_energy()
        };
        let (_, slope) = gradient(energy, &SVector::zeros());
        let wrench = pair.wrench().on_a.to_vector();
        let error = (wrench + slope).amax();
        assert!(
            error <= SLOPE * wrench.amax(),
            "{error:e} of {}",
            wrench.amax()
        );
    });
}

#[test]
fn a_rotation_off_by_a_hair_is_put_right() {
    let cube = Shape::new(hydroelastic::mesh::shapes::cuboid([1.0; 3]).unwrap());
    for off in [0.0, 1e-12, 1e-10, 3e-10, -3e-10] {
        let rotation = nalgebra::Matrix3::identity() * (1.0 - off);
        let moved = Pose::new(rotation, [0.5, 0.0, 0.0].into()).unwrap();
        let force = pair((&cube, moved, 1.0), (&cube, Pose::identity(), 1.0))
            .wrench()
            .on_a
            .force;
        let expected = (1.0 - 0.125) / 3.0;
        assert!((force.x - expected).abs() <= SAME, "{off:e}: {force:?}");
    }
}
