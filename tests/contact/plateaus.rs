//! Meshes with plateaus: tetrahedra with equal extents at all corners have constant pressure, so two bodies of equal moduli have no plane
//! of equal pressure.

use super::skins::with_skin;
use crate::support::scenes::{Random, grid, pair};
use crate::support::worlds::cuboid;
use hydroelastic::contact::{ContactBody, ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::scalar::lift;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::SVector;
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

/// Visits rough cubes with plateaus, one of them rotated: with layers of one cell, and with skins, from first contact to far beyond the skins.
fn for_generic_pairs(mut check: impl FnMut(&ContactPair)) {
    let skin = with_skin(&grid(&[5; 3], 0.2, |_| true).unwrap(), 0.07);
    for (cube, apart, moduli, seed) in [
        (&plateau_cube(), [0.4, 1.4], [2.0, 2.0], 61),
        (&skin, [0.5, 1.2], [2.0, 2.0], 83),
        (&skin, [0.5, 1.2], [2.0, 3.0], 83),
    ] {
        let mut random = Random::new(seed);
        for _ in 0..12 {
            let position = random.direction() * random.between(apart[0], apart[1]);
            let turned = Pose::from_rotation_vector(&random.rotation_vector(), position);
            check(&pair(
                (cube, Pose::identity(), moduli[0]),
                (cube, turned, moduli[1]),
            ));
        }
    }
}

#[test]
fn plateaus_give_one_wrench_whatever_the_search_and_the_order() {
    for_generic_pairs(|pair| {
        let found = pair.wrench().on_a.to_vector();
        let exchanged = ContactPair::new(pair.b().body().unwrap(), *pair.a()).wrench();
        let culled = [Culling::NONE, Culling::default()]
            .map(|culling| pair.with_search(Search::Culling(culling)).wrench().on_a);
        for other in culled.into_iter().chain([exchanged.on_b]) {
            let error = (found - other.to_vector()).amax();
            assert!(error <= SAME * found.amax(), "{error:e} of {found:?}");
        }
    });
}

#[test]
fn plateaus_push_along_the_slope_of_the_energy() {
    for_generic_pairs(|pair| {
        let energy = |motion: SVector<DualSVec64<6>, 6>| {
            let pose = Pose::lifted(pair.a().pose()).moved_by(&Twist::from_vector(&motion));
            let a = ContactBody::new(pair.a().shape(), pose, lift(pair.a().modulus())).unwrap();
            let modulus = lift(pair.b().modulus().unwrap());
            let b = pair.b().at(Pose::lifted(pair.b().pose()), modulus).unwrap();
            ContactPair::new(a, b).potential_energy()
        };
        let (_, slope) = gradient(energy, &SVector::zeros());
        let wrench = pair.wrench().on_a.to_vector();
        let error = (wrench + slope).amax();
        assert!(error <= SLOPE * wrench.amax(), "{error:e} of {wrench:?}");
    });
}

#[test]
fn a_rotation_off_by_a_hair_is_put_right() {
    let cube = cuboid([1.0; 3]);
    for off in [0.0, 1e-12, 1e-10, 3e-10, -3e-10] {
        let rotation = nalgebra::Matrix3::identity() * (1.0 - off);
        let moved = Pose::new(rotation, [0.5, 0.0, 0.0].into()).unwrap();
        let pair = pair((&cube, moved, 1.0), (&cube, Pose::identity(), 1.0));
        let force = pair.wrench().on_a.force;
        let expected = (1.0 - 0.125) / 3.0;
        assert!((force.x - expected).abs() <= SAME, "{off:e}: {force:?}");
    }
}
