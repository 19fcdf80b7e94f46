use super::edges::{Edges, NO_FACE};
use crate::contact::polygon_fields::Six;
use crate::contact::response::{FaceResponse, LawResponse, PolygonResponse};
use crate::contact::traction_derivatives::area::Rates;
use crate::lanes::space::vector_at;
use crate::lanes::{Numbers, ROW, Row};
use crate::narrow_phase::{Octet, SLOTS};
use nalgebra::Vector6;

/// Three wrenches of each polygon: those of 1, y₁ and y₂.
type Wrenches = [[Row; 6]; 3];

/// How polygons side by side answer to changes of shape: what a [`LawResponse`] says, about their origins.
pub(super) struct ResponseRows {
    /// By the speed of the plane.
    speed: Wrenches,
    pressure: Wrenches,
    /// By the face of each edge.
    faces: [Wrenches; SLOTS],
}

impl ResponseRows {
    pub const NONE: Self = Self {
        speed: [[[0.0; ROW]; 6]; 3],
        pressure: [[[0.0; ROW]; 6]; 3],
        faces: [[[[0.0; ROW]; 6]; 3]; SLOTS],
    };

    /// Writes those of the polygons from `first` on, but for their faces.
    #[inline(always)]
    pub fn store<N: Numbers>(&mut self, first: usize, rates: &Rates<N>) {
        store(&mut self.speed, first, &rates.by_speed);
        store(&mut self.pressure, first, &rates.by_pressure);
    }

    /// Writes the wrenches of the flux through an edge as its face moves outwards.
    #[inline(always)]
    pub fn store_face<N: Numbers>(&mut self, edge: usize, first: usize, wrenches: &[Six<N>; 3]) {
        store(&mut self.faces[edge], first, wrenches);
    }

    /// That of the polygon in a lane.
    pub fn response(&self, octets: &[Octet], edges: &Edges, lane: usize) -> PolygonResponse {
        let [octet, place] = edges.places[lane];
        let octet = &octets[octet];
        let mut by_faces = Vec::with_capacity(edges.corners.count(lane));
        for edge in
            (0..edges.corners.count(lane)).filter(|&edge| edges.faces[edge][lane] != NO_FACE)
        {
            by_faces.push(FaceResponse {
                face: usize::from(edges.faces[edge][lane]),
                normal: vector_at(&edges.normals[edge], lane),
                by_speed: at(&self.faces[edge], lane),
            });
        }
        let law = LawResponse {
            by_speed: at(&self.speed, lane),
            modulus_correction: None,
            by_pressure: at(&self.pressure, lane),
            by_faces,
        };
        PolygonResponse::at(octet, place, Some(law))
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

fn at(rows: &Wrenches, lane: usize) -> [Vector6<f64>; 3] {
    rows.each_ref()
        .map(|rows| Vector6::from_fn(|row, _| rows[row][lane % ROW]))
}
