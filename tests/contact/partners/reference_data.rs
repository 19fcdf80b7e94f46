//! Wrenches and Jacobians against the numbers of an independent program (`tests/data/reference/partners.json`).

use crate::support::reference::{PartnerCases, partner_cases};
use hydroelastic::mesh::FieldTet;
use nalgebra::{Matrix6, Vector6};

/// Tolerance. The program's numbers are exact to 2e-14 of the largest entry, and poses are printed with 17 digits.
const EXACT: f64 = 1e-11;

fn matrix(rows: &[[f64; 6]; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| rows[i][j])
}

#[test]
fn wrenches_and_jacobians_equal_those_of_an_independent_program() {
    let PartnerCases { rigid: cases, .. } = partner_cases();
    assert_eq!(cases.len(), 10);
    let mut worst = 0.0_f64;
    for case in &cases {
        let shapes = case.shapes();
        let pair = case.pair(&shapes);
        let contact = pair.linearized();
        let mut compare = |name: &str, error: f64, largest: f64| {
            worst = worst.max(error / largest);
            assert!(error <= EXACT * largest, "{} {name}: {error:e}", case.name);
        };
        let expected = Vector6::from(case.wrench_on_compliant);
        let error = (contact.wrench.on_a.to_vector() - expected).amax();
        compare("wrench", error, expected.amax());
        // The program also counts polygons without pressure.
        if !shapes
            .compliant
            .field()
            .tets()
            .iter()
            .any(FieldTet::is_inert)
        {
            compare("area", (pair.surface().area() - case.area).abs(), case.area);
        }
        for (name, column, expected) in [
            ("by own pose", 0, matrix(&case.by_own_pose)),
            ("by other pose", 6, matrix(&case.by_other_pose)),
        ] {
            let block = contact.by_poses.fixed_view::<6, 6>(0, column);
            compare(name, (block - expected).amax(), expected.amax());
        }
        let by_modulus = Vector6::from(case.by_modulus);
        let by_moduli = [0, 1].map(|body| contact.by_moduli.fixed_view::<6, 1>(0, body));
        compare(
            "modulus",
            (by_moduli[0] - by_modulus).amax(),
            by_modulus.amax(),
        );
        if let Some(expected) = case.by_pressure_per_depth.map(Vector6::from) {
            compare("slope", (by_moduli[1] - expected).amax(), expected.amax());
        }
    }
    println!("worst: {worst:.1e}");
}
