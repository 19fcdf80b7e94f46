use super::area::Rates;
use super::pieces::Piece;
use crate::contact::polygon_fields::Six;
use crate::contact::response::{FaceResponse, LawResponse};
use crate::lanes::{Numbers, ROW, Row};
use crate::narrow_phase::SLOTS;
use nalgebra::Vector6;

/// Three wrenches of each piece, for 1, y₁ and y₂.
type Wrenches = [[Row; 6]; 3];

/// The responses of up to eight pieces to changes of shape (see [`LawResponse`]).
pub(super) struct ResponseRows {
    /// Derivatives with respect to the speed of the plane, if bodies move.
    speed: Wrenches,
    /// Derivatives with respect to the speed of the plane, if the modulus of B grows.
    growth: Wrenches,
    pressure: Wrenches,
    /// Derivatives with respect to the speed of the face of each edge.
    faces: [Wrenches; SLOTS],
}

impl ResponseRows {
    /// Allocates memory for responses.
    pub fn boxed() -> Box<Self> {
        let zeros = [[[0.0; ROW]; 6]; 3];
        Box::new(Self {
            speed: zeros,
            growth: zeros,
            pressure: zeros,
            faces: [zeros; SLOTS],
        })
    }

    /// Stores the responses of the pieces from `first` on, without the responses to their faces.
    #[inline(always)]
    pub fn store<N: Numbers>(&mut self, first: usize, rates: &Rates<N>, by_growth: &[Six<N>; 3]) {
        store(&mut self.speed, first, &rates.by_speed);
        store(&mut self.growth, first, by_growth);
        store(&mut self.pressure, first, &rates.by_pressure);
    }

    /// Stores the wrenches of the flux through one edge of each piece, whose face moves outwards at the speeds 1, y₁ and y₂.
    #[inline(always)]
    pub fn store_face<N: Numbers>(&mut self, edge: usize, first: usize, wrenches: &[Six<N>; 3]) {
        store(&mut self.faces[edge], first, wrenches);
    }

    /// Adds the response of the piece in a lane to the response of its polygon, or of its part of a polygon.
    pub fn add_to(&self, law: &mut LawResponse, piece: &Piece, lane: usize, is_whole: bool) {
        add(&mut law.by_speed, &self.speed, lane);
        add(&mut law.by_pressure, &self.pressure, lane);
        if !is_whole {
            let [speed, growth] = [&self.speed, &self.growth].map(|rows| at(rows, lane));
            // Generic polygons may be in the same batch.
            if growth != speed {
                let correction = law.modulus_correction.get_or_insert_default();
                for (m, sum) in correction.iter_mut().enumerate() {
                    *sum += growth[m] - speed[m];
                }
            }
        }
        law.by_faces.reserve_exact(piece.edge_count);
        let edges = piece.edges[..piece.edge_count.min(SLOTS)].iter();
        for (number, edge) in edges.enumerate() {
            // Some faces move an edge only if the modulus of B grows. Planes of taxels do not move with vertices.
            if let Some(opposite) = edge.opposite
                && piece.shares[number][0] != 0.0
            {
                law.by_faces.push(FaceResponse {
                    body: usize::from(edge.body),
                    opposite,
                    normal: edge.normal,
                    by_speed: at(&self.faces[number], lane),
                });
            }
        }
    }
}

#[inline(always)]
fn store<N: Numbers>(rows: &mut Wrenches, first: usize, wrenches: &[Six<N>; 3]) {
    for (rows, wrench) in rows.iter_mut().zip(wrenches) {
        for (row, number) in rows.iter_mut().zip(wrench) {
            number.store(row, first);
        }
    }
}

fn add(sums: &mut [Vector6<f64>; 3], rows: &Wrenches, lane: usize) {
    for (sum, rows) in sums.iter_mut().zip(rows) {
        for (sum, row) in sum.iter_mut().zip(rows) {
            *sum += row[lane % ROW];
        }
    }
}

fn at(rows: &Wrenches, lane: usize) -> [Vector6<f64>; 3] {
    rows.each_ref()
        .map(|rows| Vector6::from_fn(|row, _| rows[row][lane % ROW]))
}
