//! The contribution of dissipation and friction to the force on each of several parts of contact polygons.

use super::linearize::{LaneGroup, NUMBERS};
use super::pieces::{EdgeFace, Piece, Pieces, PolygonToDivide};
use super::responses::ResponseRows;
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::Outline;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::response::LawResponse;
use crate::lanes::{self, InLanes, Lanes, ROW, Row};
use nalgebra::{SMatrix, Vector3};

/// First columns of the blocks of [`LawOnPart::columns`]. The derivatives with respect to the motion of B begin at column 0.
const BY_TWIST: usize = 6;
const FORCE: usize = 12;
const BY_MODULUS_B: usize = 13;
const BY_LAW: usize = 14;

/// The contribution of dissipation and friction on a part of a contact polygon.
pub(in crate::contact) struct LawOnPart {
    /// The derivatives of the force on A with respect to the motion of B and the velocity of A relative to B, the force, E_B ∂F/∂E_B, and
    /// the derivatives with respect to dissipation and friction. All are in A's axes.
    columns: SMatrix<f64, 3, 16>,
    /// The response to changes of shape, or zero if responses are not kept.
    pub response: LawResponse,
}

impl LawOnPart {
    fn zero() -> Self {
        Self {
            columns: SMatrix::zeros(),
            response: LawResponse::default(),
        }
    }

    /// Returns the force on A.
    pub fn force(&self) -> Vector3<f64> {
        self.columns.column(FORCE).into_owned()
    }

    /// Returns the derivatives of the force with respect to the relative inputs (see `ContactPair::tangent`). The force is homogeneous of
    /// degree one in the moduli, so E_A ∂F/∂E_A + E_B ∂F/∂E_B = F.
    pub fn by_relative(&self, [modulus_a, modulus_b]: [f64; 2]) -> SMatrix<f64, 3, 16> {
        let of = |row: usize, column: usize| self.columns[(row, column)];
        SMatrix::from_fn(|row, input| match input {
            0..6 => of(row, input),
            6 => (of(row, FORCE) - of(row, BY_MODULUS_B)) / modulus_a,
            7 => of(row, BY_MODULUS_B) / modulus_b,
            8..14 => of(row, BY_TWIST + input - 8),
            _ => of(row, BY_LAW + input - 14),
        })
    }
}

/// Integrates the surface law over parts of contact polygons.
pub(in crate::contact) struct LawOnParts<'l> {
    law_and_motion: (&'l SurfaceLaw, &'l RelativeMotion<f64>),
    pieces: Pieces<'l>,
    rows: Option<Box<ResponseRows>>,
    parts: Vec<LawOnPart>,
}

impl<'l> LawOnParts<'l> {
    pub fn new(
        (law, motion): (&'l SurfaceLaw, &'l RelativeMotion<f64>),
        are_responses_kept: bool,
    ) -> Self {
        Self {
            law_and_motion: (law, motion),
            pieces: Pieces::new(law, motion),
            rows: are_responses_kept.then(ResponseRows::boxed),
            parts: Vec::new(),
        }
    }

    /// Adds a part of a polygon. `faces` has the faces that move edges, with the indices of the edges in the outline. Returns the index of
    /// the part.
    pub fn add(
        &mut self,
        polygon: &PlanePolygon<f64>,
        outline: &Outline<f64>,
        faces: &[(usize, EdgeFace)],
        has_area: bool,
    ) -> usize {
        let number = self.parts.len();
        self.parts.push(LawOnPart::zero());
        self.pieces.divide(PolygonToDivide {
            number,
            plane: &polygon.plane,
            outline: &outline.renumbered(),
            weights: polygon.weights,
            is_whole: false,
            has_area: has_area && polygon.weights.have_area(),
            faces,
        });
        self.integrate(ROW);
        number
    }

    /// Returns the results for all parts.
    pub fn finish(mut self) -> Vec<LawOnPart> {
        self.integrate(1);
        self.parts
    }

    /// Integrates batches with at least this many pieces.
    fn integrate(&mut self, least: usize) {
        while let Some(method) = self.pieces.method_with(least) {
            let (pieces, count) = self.pieces.batches[method].take();
            let sums = lanes::run(Sums {
                law_and_motion: self.law_and_motion,
                pieces,
                method,
                rows: &mut self.rows,
            });
            for (lane, piece) in pieces[..count].iter().enumerate() {
                let part = &mut self.parts[piece.polygon];
                part.columns += SMatrix::<f64, 3, 16>::from_fn(|row, column| {
                    sums[6 * column + 3 + row][lane % ROW]
                });
                if let Some(rows) = &self.rows {
                    rows.add_to(&mut part.response, piece, lane, false);
                }
            }
        }
    }
}

/// Computes the sums of [`LaneGroup`] for each of [`ROW`] pieces.
struct Sums<'p> {
    law_and_motion: (&'p SurfaceLaw, &'p RelativeMotion<f64>),
    pieces: &'p [Piece],
    method: usize,
    rows: &'p mut Option<Box<ResponseRows>>,
}

impl InLanes for Sums<'_> {
    type Output = [Row; NUMBERS];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [Row; NUMBERS] {
        let mut sums = [[0.0; ROW]; NUMBERS];
        for first in (0..ROW).step_by(L::COUNT) {
            let group = LaneGroup {
                law_and_motion: self.law_and_motion,
                pieces: &self.pieces[first..first + L::COUNT],
                first,
                are_whole: false,
                method: self.method,
            };
            group.add(lanes, &mut sums, self.rows);
        }
        sums
    }
}
