//! Contribution of dissipation and friction on contact polygons of constant shape. Only velocities and pressures change.

use super::MATRIX;
use super::pieces::{Piece, Pieces, PolygonToDivide, area_integrals};
use super::wrenches::{add_columns, plus, times};
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_fields::{Columns, PolygonFields};
use crate::lanes::{self, InLanes, Lanes, ROW, Row};
#[cfg(test)]
use crate::scalar::{Scalar, lift};
use crate::spatial::Wrench;
use nalgebra::{Matrix6, Vector3, Vector6};

/// Number of sums: the derivatives with respect to motions and twists, and the wrench.
const NUMBERS: usize = 2 * MATRIX + 6;

/// Contribution of dissipation and friction to the wrench on A, in A's axes about A's origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AddedByLaw {
    pub wrench: Vector6<f64>,
    /// Derivative with respect to a motion of B (angular, and linear at A's origin). Only the change of the pressure is included.
    pub by_motion: Matrix6<f64>,
    /// Derivative with respect to the velocity of A relative to B (angular, linear at A's origin).
    pub by_twist: Matrix6<f64>,
}

/// A contact polygon of constant shape, on which the pressure changes.
#[derive(Clone)]
pub(in crate::contact) struct FrozenPolygon {
    polygon: PlanePolygon<f64>,
    /// Derivatives of the pressure's coefficients with respect to a motion of B.
    pressure_by_motion: [Vector6<f64>; 3],
}

impl AddedByLaw {
    pub fn nothing() -> Self {
        Self {
            wrench: Vector6::zeros(),
            by_motion: Matrix6::zeros(),
            by_twist: Matrix6::zeros(),
        }
    }
}

impl FrozenPolygon {
    /// Freezes a polygon. If B moves by (θ, u), p_B at a fixed point x decreases by δ = ∇p_B·(u + θ × x). The pressure on the plane of
    /// equal pressure changes by −(∇p_A·n) δ/|g|, with g = ∇p_A − ∇p_B.
    pub fn of(polygon: PlanePolygon<f64>) -> Self {
        let plane = &polygon.plane;
        let [_, slope_b] = plane.slopes.map(Vector3::from);
        let share = -plane.slope_along_normal();
        let by_motion = |arm: [f64; 3], force: Vector3<f64>| {
            let torque = Vector3::from(arm).cross(&slope_b) * share;
            Wrench { torque, force }.to_vector()
        };
        let [e1, e2, _] = plane.axes;
        Self {
            pressure_by_motion: [
                by_motion(plane.origin, slope_b * share),
                by_motion(e1, Vector3::zeros()),
                by_motion(e2, Vector3::zeros()),
            ],
            polygon,
        }
    }

    /// Computes the contribution of dissipation and friction over frozen polygons, after a motion of B and for a velocity of A relative to
    /// B.
    pub fn added(
        polygons: &[Self],
        law: &SurfaceLaw,
        (motion, velocity): (&Vector6<f64>, &RelativeMotion<f64>),
    ) -> AddedByLaw {
        lanes::run(Added {
            polygons,
            law,
            motion,
            velocity,
        })
    }

    /// Returns the part under a positive pressure after a motion of B.
    #[cfg(test)]
    pub fn after<T: Scalar>(&self, motion: &[T; 6]) -> PlanePolygon<T> {
        let mut pressure = self.polygon.plane.pressure.map(lift::<T>);
        for (coefficient, by_motion) in pressure.iter_mut().zip(&self.pressure_by_motion) {
            for (by, change) in by_motion.iter().zip(motion) {
                *coefficient += *change * *by;
            }
        }
        self.polygon.under_pressure(pressure)
    }

    /// Adds the pieces on which the pressure is positive after a motion of B.
    fn divide(&self, number: usize, motion: &Vector6<f64>, pieces: &mut Pieces) {
        let PlanePolygon { plane, outline, .. } = &self.polygon;
        let mut plane = *plane;
        for (coefficient, by_motion) in plane.pressure.iter_mut().zip(&self.pressure_by_motion) {
            *coefficient += by_motion.dot(motion);
        }
        let under_pressure = outline.cut(&plane.pressure);
        pieces.divide(PolygonToDivide {
            number,
            plane: &plane,
            outline: under_pressure.as_ref().unwrap_or(outline),
            weights: self.polygon.weights,
            is_whole: false,
            has_area: true,
            faces: &[],
        });
    }
}

/// Computes the wrench and derivatives that the law adds over frozen polygons.
struct Added<'p> {
    polygons: &'p [FrozenPolygon],
    law: &'p SurfaceLaw,
    /// Motion of B.
    motion: &'p Vector6<f64>,
    /// Velocity of A relative to B.
    velocity: &'p RelativeMotion<f64>,
}

impl InLanes for Added<'_> {
    type Output = AddedByLaw;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> AddedByLaw {
        let mut sums = [[0.0; ROW]; NUMBERS];
        let mut pieces = Pieces::new(self.law, self.velocity);
        for number in 0..=self.polygons.len() {
            // After the last polygon, incomplete batches are integrated too.
            let least = match self.polygons.get(number) {
                Some(polygon) => {
                    polygon.divide(number, self.motion, &mut pieces);
                    ROW
                }
                None => 1,
            };
            while let Some(method) = pieces.method_with(least) {
                let (pieces, count) = pieces.batches[method].take();
                for first in (0..count).step_by(L::COUNT) {
                    let group = &pieces[first..first + L::COUNT];
                    self.add(lanes, &mut sums, (group, first), method);
                }
            }
        }
        let totals = lanes::totals(&sums);
        let (by_motion, rest) = totals.split_at(MATRIX);
        let (by_twist, wrench) = rest.split_at(MATRIX);
        AddedByLaw {
            wrench: Vector6::from_column_slice(wrench),
            by_motion: Matrix6::from_column_slice(by_motion),
            by_twist: Matrix6::from_column_slice(by_twist),
        }
    }
}

impl Added<'_> {
    /// Adds as many pieces as there are lanes, given the index of the first one in its batch.
    #[inline(always)]
    fn add<L: Lanes>(
        &self,
        lanes: L,
        sums: &mut [Row; NUMBERS],
        (pieces, first): (&[Piece], usize),
        method: usize,
    ) {
        let planes = PolygonFields::side_by_side(lanes, |lane| &pieces[lane].plane);
        let law_and_velocity = (self.law, self.velocity);
        let (law, area) = area_integrals(lanes, (pieces, method), &planes, law_and_velocity);
        let weight = lanes.gathered(|lane| pieces[lane].weights[0]);
        let wrench = times(&planes.in_a(&area.wrench()), weight);
        let [c0, c1, c2] = area.by_pressure();
        let by_pressure = [
            times(&planes.in_a(&c0), weight),
            times(&planes.in_a(&c1), weight),
            times(&planes.in_a(&c2), weight),
        ];
        let mut by_twist = planes.matrix_in_a(&area.by_twist());
        let mut by_motion: Columns<L::Numbers> = [[law.zero; 6]; 6];
        for column in 0..6 {
            by_twist[column] = times(&by_twist[column], weight);
            for (k, by_pressure) in by_pressure.iter().enumerate() {
                let by = lanes.gathered(|lane| {
                    self.polygons[pieces[lane].polygon].pressure_by_motion[k][column]
                });
                by_motion[column] = plus(&by_motion[column], &times(by_pressure, by));
            }
        }
        let (by_motions, rest) = sums.split_at_mut(MATRIX);
        let (by_twists, wrenches) = rest.split_at_mut(MATRIX);
        add_columns(lanes, by_motions, first, &by_motion);
        add_columns(lanes, by_twists, first, &by_twist);
        add_columns(lanes, wrenches, first, &[wrench]);
    }
}
