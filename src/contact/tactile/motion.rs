//! Derivatives of the dissipation and friction forces on taxels, in closed form.
//!
//! A part of a contact polygon in a taxel is a polygon, too. Its edges lie in faces of both bodies and in planes of the taxel. The planes
//! move with the body of the grid. Therefore `traction_derivatives` can compute the derivatives of the force on the part. The elastic force
//! is in `rates`.
//!
//! If an edge of the contact polygon lies in a taxel plane, a small motion moves the edge into the taxel or out of it. If the edge moves in,
//! the part ends at the face of the edge. If the edge moves out, the part ends at the plane, and the strip between the plane and the face
//! belongs to the next taxel. The plane is therefore treated as another face that contains the edge. The derivatives are the mean of both
//! sides.
//!
//! If a whole polygon lies in a taxel plane, each adjacent taxel has half of its force. At the border of the patch, the only taxel has all of
//! it.

use super::GridBody;
use super::division::Division;
use super::rates::{Part, Position, Side};
use crate::contact::SurfaceLaw;
use crate::contact::integrate::{Integrand, Remainder};
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::NO_EDGE;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::sums::PartialSum;
use crate::contact::traction_derivatives::{EdgeFace, Edges, LawOnPart, LawOnParts};
use crate::friction::ends;
use crate::geometry::set_bits;
use crate::narrow_phase::{Cut, Weight};
use crate::search::GenericPairs;
use nalgebra::Vector3;
use std::marker::PhantomData;

/// A grid on a body, and the surface law of a pair in motion.
#[derive(Clone, Copy)]
pub(super) struct MovingGrid<'g> {
    pub division: &'g Division<f64>,
    pub body: GridBody,
    pub law_and_motion: (&'g SurfaceLaw, &'g RelativeMotion<f64>),
}

/// A part of a polygon, and a taxel on which its force acts.
pub(super) struct PartInTaxel {
    pub polygon_index: usize,
    pub taxel: [usize; 2],
    pub part_index: usize,
    /// Fraction of the force of the part that acts on the taxel: 1 or ½.
    pub share: f64,
}

/// The parts of several polygons.
struct PartsInTaxels<'l> {
    /// The body of the grid: 0 for A, 1 for B.
    body: u8,
    parts: LawOnParts<'l>,
    in_taxels: Vec<PartInTaxel>,
    /// The index of the current polygon.
    polygon_index: usize,
}

/// The moving edges of a contact polygon, with their owners.
struct MovingEdges<'e> {
    edges: Edges<'e>,
    owners: Vec<(usize, u8)>,
}

impl<'e> MovingEdges<'e> {
    fn of(edges: Edges<'e>) -> Self {
        let mut owners = Vec::new();
        edges.visit_loaded(|edge, of_edge| owners.push((edge, of_edge)));
        Self { edges, owners }
    }

    /// Appends the faces that move an edge of the polygon, with the index of this edge in a part. `plane` is the outward normal and the body
    /// of the taxel plane that contains the edge, if there is one.
    fn append_faces(
        &self,
        (polygon_edge, part_edge): (u8, usize),
        plane: Option<(Vector3<f64>, u8)>,
        faces: &mut Vec<(usize, EdgeFace)>,
    ) {
        let is_edge = |(edge, _): &&(usize, u8)| *edge == usize::from(polygon_edge);
        if let Some(edge_and_owners) = self.owners.iter().find(is_edge) {
            self.edges.visit_faces(*edge_and_owners, plane, |face| {
                faces.push((part_edge, face));
            });
        }
    }
}

impl MovingGrid<'_> {
    /// Integrates the law over the parts of polygons in taxels. Calls `add_polygon` with each polygon that has an index. Returns the results
    /// of all parts, and the parts in taxels by increasing index of the polygon.
    pub fn law_on_parts(
        self,
        source: &PolygonSource<f64>,
        (cuts, are_responses_kept): (&[Cut], bool),
        mut add_polygon: impl FnMut(&Cut, &PlanePolygon<f64>),
    ) -> (Vec<LawOnPart>, Vec<PartInTaxel>) {
        let mut run = PartsInTaxels {
            body: u8::from(self.body == GridBody::B),
            parts: LawOnParts::new(self.law_and_motion, are_responses_kept),
            in_taxels: Vec::new(),
            polygon_index: 0,
        };
        for cut in cuts {
            let Some(polygon) = source.polygon(cut) else {
                continue;
            };
            add_polygon(cut, &polygon);
            let edges = MovingEdges::of(Edges::of(source, (cut, &polygon)));
            self.division
                .visit_parts_with_sides(&polygon, |part| run.add(part, &edges));
            run.polygon_index += 1;
        }
        (run.parts.finish(), run.in_taxels)
    }
}

impl PartsInTaxels<'_> {
    fn add(&mut self, part: &Part, moving: &MovingEdges) {
        let coincident = match part.position() {
            Position::Inside(coincident) => coincident,
            Position::Beyond(side, coincident) => {
                return self.add_edge_beyond(part, (side, coincident), moving);
            }
        };
        let mut faces = Vec::new();
        for (edge, &owner) in part.outline.edges().iter().enumerate() {
            let is_cut = owner == NO_EDGE;
            let side = part.side_with(&ends(part.outline.corners(), edge), is_cut, coincident);
            if let Some(side) = side.filter(|_| is_cut) {
                faces.push((edge, self.plane_of(part, side)));
                continue;
            }
            let plane = side.map(|side| (side.outward, self.body));
            moving.append_faces((owner, edge), plane, &mut faces);
            if let Some(side) = side
                && let Some(taxel) = part.beyond(side)
            {
                let mut strip = Vec::new();
                let plane = Some((-side.outward, self.body));
                moving.append_faces((owner, edge), plane, &mut strip);
                self.add_part(part, (&strip, false), (taxel, coincident));
            }
        }
        self.add_part(part, (&faces, true), (part.taxel, coincident));
    }

    /// Adds the edges of a part that lie in a side of its taxel, if the polygon is beyond that side. Adds nothing inside of the patch, because
    /// the next taxel adds these edges.
    fn add_edge_beyond(
        &mut self,
        part: &Part,
        (side, coincident): (&Side, Option<&Side>),
        moving: &MovingEdges,
    ) {
        if part.beyond(side).is_some() {
            return;
        }
        let mut faces = Vec::new();
        for (edge, &owner) in part.outline.edges().iter().enumerate() {
            if owner != NO_EDGE {
                let plane = Some((side.outward, self.body));
                moving.append_faces((owner, edge), plane, &mut faces);
            }
        }
        self.add_part(part, (&faces, false), (part.taxel, coincident));
    }

    /// Adds a part. Its force acts on one taxel, or half on each of two taxels if the whole polygon lies in the plane between them.
    fn add_part(
        &mut self,
        part: &Part,
        (faces, has_area): (&[(usize, EdgeFace)], bool),
        (taxel, coincident): ([usize; 2], Option<&Side>),
    ) {
        let part_index = self.parts.add(part.polygon, part.outline, faces, has_area);
        let next = coincident.and_then(|side| part.beyond_from(taxel, side));
        let share = if next.is_some() { 0.5 } else { 1.0 };
        for taxel in [Some(taxel), next].into_iter().flatten() {
            self.in_taxels.push(PartInTaxel {
                polygon_index: self.polygon_index,
                taxel,
                part_index,
                share,
            });
        }
    }

    /// Converts a taxel plane that cuts the polygon to a face that moves the edge of the cut.
    fn plane_of(&self, part: &Part, side: &Side) -> EdgeFace {
        let weights = [part.polygon.weights.moving, part.polygon.weights.still];
        EdgeFace {
            body: self.body,
            opposite: None,
            normal: side.outward,
            shares: weights.map(Weight::area),
        }
    }
}

/// Integrand that passes each batch of cuts to a closure.
pub(super) struct CutsIntegrand<F, S> {
    add: F,
    sum: PhantomData<fn() -> S>,
}

impl<S, F: Fn(&PolygonSource<f64>, &[Cut], &mut S)> CutsIntegrand<F, S> {
    pub fn new(add: F) -> Self {
        Self {
            add,
            sum: PhantomData,
        }
    }
}

impl<S, F> Integrand<f64> for CutsIntegrand<F, S>
where
    S: PartialSum,
    F: Fn(&PolygonSource<f64>, &[Cut], &mut S) + Sync,
{
    type Sum = S;

    const OCTETS: usize = 16;

    fn add(&self, source: &PolygonSource<f64>, cut: &Cut, sum: &mut S) {
        self.add_cuts(source, std::slice::from_ref(cut), sum);
    }

    fn add_cuts(&self, source: &PolygonSource<f64>, cuts: &[Cut], sum: &mut S) {
        (self.add)(source, cuts, sum);
    }

    fn add_octets(
        &self,
        source: &PolygonSource<f64>,
        generic: GenericPairs,
        _: &mut Remainder,
        sum: &mut S,
    ) {
        let octets = generic.octets.iter();
        let cuts: Vec<_> = octets
            .flat_map(|octet| set_bits(octet.polygons()).map(move |index| (octet, index)))
            .map(|(octet, index)| generic.cut(octet, index, &source.pair))
            .collect();
        (self.add)(source, &cuts, sum);
    }
}
