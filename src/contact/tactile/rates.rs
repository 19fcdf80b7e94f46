//! Derivatives of the elastic forces on taxels, in closed form, at rest and in motion.
//!
//! Let p_A and p_B grow by δ_A and δ_B, at fixed points in the frame of the grid. The contact surface p_A = p_B then moves along its normal
//! n by h = (δ_B − δ_A)/|g|, with g = ∇p_A − ∇p_B. For f = p_A or p_B, the flux of f through the part of the surface in a taxel changes by
//!
//! dF = Σ ∫ (n δ_f + h ∇f) dA + ∮ p w × dl,
//!
//! where w is the velocity of the boundary. An edge between two polygons adds opposite terms to their parts, and the pressure is zero at
//! the boundary of the contact. This leaves the edges in planes of taxels. Let ν be the normal of the plane, out of the taxel. From w·n = h
//! and w·ν = 0, with s = 1/|ν − (ν·n)n|, follows w × dl = −s h ν dl.
//!
//! If only p_B grows, f = p_A. If only p_A grows, f = p_B. With x = 1, y₁, y₂ and h = Σ hᵢ xᵢ, both cases are sums of these vectors:
//!
//! dF = Σ δᵢ/|g| (∇p_A ∫ xᵢ dA − s ν ∫ p xᵢ dl),  dF = −Σ δᵢ (∇p_B/|g| ∫ xᵢ dA − s ν/|g| ∫ p xᵢ dl).
//!
//! A motion of B changes only p_B in the frame of A, and only p_A in the frame of B. Nothing is differentiated through a clip.
//!
//! If an edge or a polygon lies in a plane of taxels, both taxels have half of it. This is the mean of both sides:
//!
//! - *An edge of the contact polygon in the plane.* As the edge leaves the plane to one side, the plane cuts the polygon. As it leaves to
//!   the other side, the plane cuts the neighbor of the polygon. Each polygon therefore counts half of its flux between the taxels.
//!   At the border of the patch, the neighbor is outside of the patch, and its edge is a part without an area.
//! - *A whole polygon in the plane*, such as the side of a block. A small motion moves it into one taxel or the other. Each taxel therefore
//!   has half of its terms. At the border of the patch, the taxel has all of them, because its face of the body usually stays in the plane.

use super::division::{Division, in_plane};
use crate::contact::integrate::{Integrand, Remainder};
use crate::contact::outline::{NO_EDGE, Outline, at};
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::sums::PartialSum;
use crate::friction::{Affine, ends};
use crate::geometry::set_bits;
use crate::narrow_phase::{Cut, Weights};
use crate::search::GenericPairs;
use nalgebra::Vector3;
use std::marker::PhantomData;

/// Gauss–Legendre points of an edge, as fractions of its length. Both have the weight ½, and are exact up to degree 3.
const TWO_POINTS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Planes count as parallel up to this sine of their angle. It exceeds the rounding errors of the normals of short polygons.
const PARALLEL: f64 = 1e-6;

/// Contribution of a polygon to the derivatives of the force on a taxel: the area term or an edge term of the two vectors in the module
/// description.
pub(super) struct Term {
    /// Row and column.
    pub taxel: [usize; 2],
    /// Factors in the two vectors, in A's axes: ∇p_A and ∇p_B/|g| for the area, ν and ν/|g| with a sign for an edge.
    pub vectors: [Vector3<f64>; 2],
    /// ∫ xᵢ dA for the area, or s ∫ p xᵢ dl times the share of the taxel for an edge, with x = 1, y₁ and y₂.
    pub moments: [f64; 3],
}

/// A plane that bounds a taxel.
pub(super) struct Side {
    /// Family of the plane, and whether it is the upper plane of the taxel.
    number: (usize, bool),
    /// Unit normal, out of the taxel.
    pub outward: Vector3<f64>,
    /// The field of the plane as a function of y, and the rounding-error bound of its values.
    function: Affine<f64>,
    zero: f64,
}

impl Side {
    fn has(&self, corners: &[[f64; 2]]) -> bool {
        corners.iter().all(|y| self.distance(y) <= self.zero)
    }

    /// Returns whether the plane of the polygon is parallel to this plane.
    fn is_parallel(&self) -> bool {
        let [_, f1, f2] = self.function;
        f1 * f1 + f2 * f2 <= PARALLEL * PARALLEL
    }

    fn distance(&self, y: &[f64; 2]) -> f64 {
        at(&self.function, y).abs()
    }

    /// Returns s ∫ p xᵢ dl between two points.
    fn flux(&self, pressure: &Affine<f64>, [from, to]: &[[f64; 2]; 2]) -> [f64; 3] {
        let [d1, d2] = [to[0] - from[0], to[1] - from[1]];
        let [_, f1, f2] = self.function;
        let size = 0.5 * ((d1 * d1 + d2 * d2) / (f1 * f1 + f2 * f2)).sqrt();
        let mut flux = [0.0; 3];
        for share in TWO_POINTS {
            let y = [from[0] + share * d1, from[1] + share * d2];
            let value = size * at(pressure, &y);
            flux = [
                flux[0] + value,
                flux[1] + value * y[0],
                flux[2] + value * y[1],
            ];
        }
        flux
    }
}

/// The part of a polygon in a taxel.
pub(super) struct Part<'p> {
    division: &'p Division<f64>,
    pub polygon: &'p PlanePolygon<f64>,
    pub taxel: [usize; 2],
    pub outline: &'p Outline<f64>,
    sides: [Side; 4],
}

/// Position of a part of a polygon relative to the planes of its taxel.
pub(super) enum Position<'s> {
    /// The part has an area in the taxel. The plane is the taxel plane that contains the whole polygon, if there is one.
    Inside(Option<&'s Side>),
    /// The part is an edge in the first plane, and the polygon is beyond it. The second plane is as for `Inside`.
    Beyond(&'s Side, Option<&'s Side>),
}

impl Division<f64> {
    /// Visits the terms of a polygon in all taxels.
    pub fn visit_terms(&self, polygon: &PlanePolygon<f64>, mut visit: impl FnMut(&Term)) {
        self.visit_parts_with_sides(polygon, |part| part.visit_terms(&mut visit));
    }

    /// Visits the parts of a polygon in taxels, with the planes of the taxels.
    pub fn visit_parts_with_sides(
        &self,
        polygon: &PlanePolygon<f64>,
        mut visit: impl FnMut(&Part),
    ) {
        self.visit_parts(polygon, |taxel, outline| {
            if outline.corners().len() > 1 {
                visit(&Part {
                    division: self,
                    polygon,
                    taxel,
                    outline,
                    sides: self.sides(polygon, taxel),
                });
            }
        });
    }

    fn sides(&self, polygon: &PlanePolygon<f64>, [row, column]: [usize; 2]) -> [Side; 4] {
        [(0, false), (0, true), (1, false), (1, true)].map(|(family, is_upper)| {
            let plane = &self.planes[family][[column, row][family] + usize::from(is_upper)];
            let (function, zero) = in_plane(polygon, plane);
            Side {
                number: (family, is_upper),
                outward: plane.gradient * if is_upper { 1.0 } else { -1.0 },
                function,
                zero,
            }
        })
    }

    /// Returns the taxel beyond a side of a taxel, or `None` outside of the patch.
    fn beyond(&self, taxel: [usize; 2], side: &Side) -> Option<[usize; 2]> {
        let (family, is_upper) = side.number;
        let mut next = taxel;
        let index = &mut next[1 - family];
        *index = if is_upper {
            *index + 1
        } else {
            index.checked_sub(1)?
        };
        (*index + 1 < self.planes[family].len()).then_some(next)
    }
}

impl Part<'_> {
    /// Returns the position of the part relative to the planes of the taxel.
    pub fn position(&self) -> Position<'_> {
        let (corners, all) = (self.outline.corners(), self.polygon.outline.corners());
        let mut coincident = self.sides.iter().filter(|side| side.has(all));
        // A polygon without an area may also lie in planes that cross its own plane.
        let coincident = coincident.find(|side| side.is_parallel());
        let mut containing = self.sides.iter().filter(|side| side.has(corners));
        match containing.find(|side| !side.has(all)) {
            Some(side) => Position::Beyond(side, coincident),
            None => Position::Inside(coincident),
        }
    }

    /// Returns the taxel beyond a side, or `None` outside of the patch.
    pub fn beyond(&self, side: &Side) -> Option<[usize; 2]> {
        self.beyond_from(self.taxel, side)
    }

    /// Returns the taxel beyond a side of `taxel`, or `None` outside of the patch.
    pub fn beyond_from(&self, taxel: [usize; 2], side: &Side) -> Option<[usize; 2]> {
        self.division.beyond(taxel, side)
    }

    fn visit_terms(&self, visit: &mut impl FnMut(&Term)) {
        let plane = &self.polygon.plane;
        let corners = self.outline.corners();
        let coincident = match self.position() {
            Position::Beyond(side, coincident) => {
                return self.visit_edge_on(side, coincident, visit);
            }
            Position::Inside(coincident) => coincident,
        };
        let [area, y1, y2, ..]: [f64; 6] = self.outline.moments();
        let along = [plane.gradient_a, plane.slopes[1]].map(Vector3::from);
        let mut add = |taxel, vectors, moments| {
            let term = Term {
                taxel,
                vectors,
                moments,
            };
            self.visit_shared(term, coincident, visit);
        };
        add(self.taxel, along, [area, y1, y2]);
        for (edge, &owner) in self.outline.edges().iter().enumerate() {
            let ends = ends(corners, edge);
            let is_cut = owner == NO_EDGE;
            let Some(side) = self.side_with(&ends, is_cut, coincident) else {
                continue;
            };
            let share = if is_cut { 1.0 } else { 0.5 };
            let (vectors, flux) = self.outflow(side, &ends, share);
            add(self.taxel, vectors.map(|vector| -vector), flux);
            if !is_cut && let Some(taxel) = self.beyond(side) {
                add(taxel, vectors, flux);
            }
        }
    }

    /// Returns the vectors and the moments of a share of the flux out of the taxel through an edge.
    fn outflow(
        &self,
        side: &Side,
        ends: &[[f64; 2]; 2],
        share: f64,
    ) -> ([Vector3<f64>; 2], [f64; 3]) {
        let plane = &self.polygon.plane;
        let flux = side.flux(&plane.pressure, ends).map(|flux| flux * share);
        let across = side.outward;
        ([across, across * plane.inverse_gradient_norm], flux)
    }

    /// Visits the term of an edge on a side, whose polygon is beyond the side. If the side is not a border of the patch, the polygon has parts
    /// with an area in the next taxel, which have this term.
    fn visit_edge_on(&self, side: &Side, coincident: Option<&Side>, visit: &mut impl FnMut(&Term)) {
        if self.beyond(side).is_some() {
            return;
        }
        for (edge, &owner) in self.outline.edges().iter().enumerate() {
            if owner != NO_EDGE {
                let ends = ends(self.outline.corners(), edge);
                let (vectors, moments) = self.outflow(side, &ends, 0.5);
                let term = Term {
                    taxel: self.taxel,
                    vectors: vectors.map(|vector| -vector),
                    moments,
                };
                self.visit_shared(term, coincident, visit);
            }
        }
    }

    /// Visits a term, or its halves in two taxels if the part lies in the plane between them.
    fn visit_shared(&self, mut term: Term, between: Option<&Side>, visit: &mut impl FnMut(&Term)) {
        let next = between.and_then(|side| self.division.beyond(term.taxel, side));
        let Some(next) = next else {
            return visit(&term);
        };
        term.moments = term.moments.map(|moment| 0.5 * moment);
        visit(&term);
        visit(&Term {
            taxel: next,
            ..term
        });
    }

    /// Returns the taxel plane that contains an edge. An edge from a cut belongs to the nearest plane. If the whole part lies in a taxel
    /// plane, this plane does not count, and other planes only count if they contain the edge up to round-off.
    pub fn side_with(
        &self,
        ends: &[[f64; 2]; 2],
        is_cut: bool,
        coincident: Option<&Side>,
    ) -> Option<&Side> {
        let number = coincident.map(|side| side.number);
        let sides = self.sides.iter().filter(|side| Some(side.number) != number);
        let distance = |side: &&Side| side.distance(&ends[0]).max(side.distance(&ends[1]));
        let nearest = sides.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (is_cut && number.is_none() || nearest.has(ends)).then_some(nearest)
    }
}

/// Integrand that passes each contact polygon and its two tetrahedra to a closure.
pub(super) struct PolygonIntegrand<F, S> {
    add: F,
    sum: PhantomData<fn() -> S>,
}

impl<S, F: Fn([usize; 2], &PlanePolygon<f64>, &mut S)> PolygonIntegrand<F, S> {
    pub fn new(add: F) -> Self {
        Self {
            add,
            sum: PhantomData,
        }
    }
}

impl<S, F> Integrand<f64> for PolygonIntegrand<F, S>
where
    S: PartialSum,
    F: Fn([usize; 2], &PlanePolygon<f64>, &mut S) + Sync,
{
    type Sum = S;

    const OCTETS: usize = 16;

    fn add(&self, source: &PolygonSource<f64>, cut: &Cut, sum: &mut S) {
        if let Some(polygon) = source.counted_polygon(cut, Weights::have_area) {
            (self.add)(cut.tets, &polygon, sum);
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<f64>,
        generic: GenericPairs,
        _: &mut Remainder,
        sum: &mut S,
    ) {
        for octet in generic.octets {
            for index in set_bits(octet.polygons()) {
                let tets = octet.tets()[index].map(|tet| tet as usize);
                (self.add)(tets, &PlanePolygon::at(octet, index), sum);
            }
        }
    }
}
