//! Derivatives against differences, elastic and with friction and dissipation.

use super::{for_pairs, motion, reshaped, rigid_reshaped, vertices};
use crate::support::moving::numbers;
use crate::support::scenes::Random;
use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape, ShapeGradient, SurfaceLaw};
use hydroelastic::mesh::ShapeRates;
use hydroelastic::spatial::Twist;
use nalgebra::{SVector, Vector3};

/// Error of differences with the best of three steps. If one step straddles a change of a polygon's topology or suffers from rounding,
/// another step does not.
pub const DIFFERENCES: f64 = 1e-6;
pub const STEPS: [f64; 3] = [1e-5, 1e-6, 1e-7];

/// Velocities of the vertices of both bodies, and rates of their extents.
pub struct Change {
    velocities: [Vec<Vector3<f64>>; 2],
    rates: [Vec<f64>; 2],
}

impl Change {
    pub fn random(pair: &ContactPair, random: &mut Random) -> Self {
        let velocities = vertices(pair).map(|of| of.iter().map(|_| random.vector()).collect());
        let mut rates_of = |shape: &Shape| -> Vec<f64> {
            let extents = shape.field().extents().iter();
            // On the surface, the extent remains 0.
            extents
                .map(|&extent| extent * random.between(-1.0, 1.0))
                .collect()
        };
        let rates_a = rates_of(pair.a().shape());
        let rates_b = pair.b().shape().map(rates_of).unwrap_or_default();
        Self {
            velocities,
            rates: [rates_a, rates_b],
        }
    }

    /// Calls a function with the pair after the change has continued for some time.
    pub fn after<O>(
        &self,
        pair: &ContactPair,
        time: f64,
        call: impl FnOnce(&ContactPair) -> O,
    ) -> O {
        let moves = self.velocities.each_ref().map(|velocities| {
            let moves = velocities.iter().map(|velocity| velocity * time);
            moves.collect::<Vec<_>>()
        });
        let changes = self.rates.each_ref().map(|rates| {
            let changes = rates.iter().map(|rate| rate * time);
            changes.collect::<Vec<_>>()
        });
        let (a, b) = (pair.a(), pair.b());
        let shape_a = reshaped(a.shape(), &moves[0], &changes[0]);
        let body = ContactBody::new(&shape_a, *a.pose(), a.modulus()).unwrap();
        let call = |partner: Partner| call(&ContactPair::new(body, partner));
        if let Some(shape) = b.shape() {
            let shape = reshaped(shape, &moves[1], &changes[1]);
            call(
                ContactBody::new(&shape, *b.pose(), b.modulus().unwrap())
                    .unwrap()
                    .into(),
            )
        } else if let Some(shape) = b.rigid_shape() {
            call(Partner::rigid(&rigid_reshaped(shape, &moves[1]), *b.pose()).unwrap())
        } else {
            call(*b)
        }
    }

    /// Returns the wrenches after the change has continued for some time.
    fn wrenches(
        &self,
        pair: &ContactPair,
        (law, twists): (&SurfaceLaw, [Twist; 2]),
        time: f64,
    ) -> SVector<f64, 12> {
        self.after(pair, time, |pair| {
            numbers(&pair.moving(*law, twists).wrench())
        })
    }

    /// Returns the derivative of a number with these gradients.
    pub fn along(&self, gradients: &[ShapeGradient; 2]) -> f64 {
        let by_body = [0, 1].map(|body| {
            let rates = ShapeRates {
                vertices: self.velocities[body].clone(),
                extents: self.rates[body].clone(),
                ..ShapeRates::default()
            };
            gradients[body].along(&rates).unwrap()
        });
        by_body[0] + by_body[1]
    }

    /// Returns the derivative in closed form.
    fn rate(
        &self,
        pair: &ContactPair,
        (law, twists): (&SurfaceLaw, [Twist; 2]),
    ) -> SVector<f64, 12> {
        SVector::from_fn(|row, _| {
            let rows = super::row(row);
            self.along(&pair.moving(*law, twists).shape_gradients(&rows))
        })
    }
}

#[test]
fn shape_gradients_are_what_differences_say() {
    let mut worst = 0.0_f64;
    for_pairs(120, 76, |pair, random| {
        let (law, twists) = motion(random);
        let elastic = SurfaceLaw::new(0.0, 0.0, 1.0).unwrap();
        let change = Change::random(pair, random);
        for law in [law, elastic] {
            let moving = (&law, twists);
            let expected = change.rate(pair, moving);
            let error = |step: f64| {
                let [ahead, behind] = [step, -step].map(|time| change.wrenches(pair, moving, time));
                ((ahead - behind) / (2.0 * step) - expected).amax() / expected.amax()
            };
            let least = STEPS.map(error).into_iter().fold(f64::INFINITY, f64::min);
            worst = worst.max(least);
            assert!(least <= DIFFERENCES, "{least:e}");
        }
    });
    println!("worst: {worst:.1e}");
}
