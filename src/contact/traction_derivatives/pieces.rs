//! Pieces of contact polygons, sorted by the method that integrates slip over them.
//!
//! Every polygon, generic or special, is integrated as one or more pieces:
//!
//! - If the damping ψ changes its sign on a polygon, the polygon is divided where ψ = 0. The pressure is clamped to zero where ψ is
//!   negative.
//! - A polygon with more than [`SLOTS`] corners or moving edges has several pieces.

#![expect(
    clippy::needless_range_loop,
    reason = "adapters of iterators take closures, and a closure over lanes may stay a call, compiled for any processor"
)]

use super::area::{AreaMoments, LawOnPlane};
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::Outline;
use crate::contact::plane_motion::PlaneMotion;
use crate::contact::polygon_fields::PolygonFields;
use crate::friction::{
    ClosedForm, Edge, LEVELS, Slip, SlipAndLoad, SlipMoments, ends, slope_rules,
};
use crate::geometry::{PER_TRIANGLE, add_triangle};
use crate::lanes::{Lanes, ROW};
use crate::narrow_phase::{SLOTS, Weight, Weights};
use nalgebra::Vector3;
use std::cell::RefCell;

/// Number of methods that integrate slip: the levels of quadrature, and the closed form.
const METHODS: usize = LEVELS + 1;

/// Index of the closed form, which integrates slips that turn quickly.
const CLOSED_FORM: usize = LEVELS;

/// A face that moves an edge of a polygon, or a plane of taxels that bounds a part of the polygon.
#[derive(Clone, Copy)]
pub(in crate::contact) struct EdgeFace {
    /// The body with which the face moves: 0 for A, 1 for B.
    pub body: u8,
    /// The corner of the tetrahedron opposite to the face, or `None` for a plane of taxels.
    pub opposite: Option<usize>,
    /// Unit normal, out of the face's tetrahedron or out of the taxel, in A's axes.
    pub normal: Vector3<f64>,
    /// Shares of the face in the motion of the edge, if bodies move and if the modulus of B grows. They are negative if the face is the
    /// only owner of the edge and its normal points into the polygon. They are zero if the face lies in the plane.
    pub shares: [f64; 2],
}

/// An edge of a contact polygon, or a part of one, that moves with a face. The body, the opposite corner and the normal of the face are as in
/// [`EdgeFace`].
#[derive(Clone, Copy)]
pub(super) struct MovingEdge {
    pub ends: [[f64; 2]; 2],
    pub body: u8,
    pub opposite: Option<usize>,
    pub normal: Vector3<f64>,
}

/// A convex piece of a contact polygon, with some of the moving edges of the polygon. These edges need not bound the piece.
pub(super) struct Piece {
    pub plane: PolygonFields<f64>,
    /// Counter-clockwise. Copies of the first corner follow the last one and fill the array.
    pub corners: [[f64; 2]; SLOTS + 1],
    pub corner_count: usize,
    pub edges: [MovingEdge; SLOTS],
    pub edge_count: usize,
    /// The shares of the face of each edge (see [`EdgeFace::shares`]).
    pub shares: [[f64; 2]; SLOTS],
    /// Factors of the integrals over the area: for values, and for derivatives with respect to a motion.
    pub weights: [f64; 2],
    /// 1, or 0 if the pressure is clamped to zero.
    pub pressed_factor: f64,
    /// The index of the polygon.
    pub polygon: usize,
    /// The integrals of slip, if the method is the closed form.
    closed_form: Option<Box<ClosedIntegrals>>,
}

/// Closed-form integrals of slip along the edges of a piece, and over the area. If a part of a polygon has several pieces, the first piece
/// has the integrals over the whole area of the part, and the other pieces have zeros.
struct ClosedIntegrals {
    over_area: SlipMoments,
    along_edges: [[[f64; 6]; 2]; SLOTS],
}

/// Integrals that are all zero.
const NO_INTEGRALS: ClosedIntegrals = ClosedIntegrals {
    over_area: SlipMoments {
        direction: [[0.0; 10]; 2],
        by_slip: [[0.0; 6]; 3],
    },
    along_edges: [[[0.0; 6]; 2]; SLOTS],
};

/// Pieces that are integrated by one method. Only the first `len` elements of `pieces` are in use.
#[derive(Default)]
pub(super) struct Batch {
    pieces: Vec<Piece>,
    pub len: usize,
    /// Whether all pieces since the batch was last empty belong to polygons with weight 1 and one face for each edge.
    pub are_whole: bool,
}

/// A polygon to be divided into pieces.
#[derive(Clone, Copy)]
pub(super) struct PolygonToDivide<'p> {
    /// The index of the polygon.
    pub number: usize,
    pub plane: &'p PolygonFields<f64>,
    pub outline: &'p Outline<f64>,
    pub weights: Weights,
    /// Whether the polygon has weight 1, and one face for each edge.
    pub is_whole: bool,
    /// Whether integrals over the area are computed.
    pub has_area: bool,
    /// Faces that move edges of the outline, with the index of the edge.
    pub faces: &'p [(usize, EdgeFace)],
}

impl MovingEdge {
    /// An edge that contributes nothing.
    const NONE: Self = Self {
        ends: [[0.0; 2]; 2],
        body: 0,
        opposite: None,
        normal: Vector3::new(0.0, 0.0, 0.0),
    };
}

impl Piece {
    fn empty() -> Self {
        Self {
            plane: PolygonFields::ZERO,
            corners: [[0.0; 2]; SLOTS + 1],
            corner_count: 0,
            edges: [MovingEdge::NONE; SLOTS],
            edge_count: 0,
            shares: [[0.0; 2]; SLOTS],
            weights: [0.0; 2],
            pressed_factor: 0.0,
            polygon: 0,
            closed_form: None,
        }
    }

    /// Removes corners and edges.
    fn clear(&mut self) {
        (self.corner_count, self.edge_count) = (0, 0);
        self.closed_form = None;
    }

    #[inline]
    pub fn push_corner(&mut self, corner: [f64; 2]) {
        self.corners[self.corner_count % SLOTS] = corner;
        self.corner_count += 1;
    }

    /// Adds an edge. Returns its index.
    #[inline]
    pub fn push_edge(&mut self, ends: [[f64; 2]; 2], by: &EdgeFace) -> usize {
        let index = self.edge_count % SLOTS;
        self.edges[index] = MovingEdge {
            ends,
            body: by.body,
            opposite: by.opposite,
            normal: by.normal,
        };
        self.shares[index] = by.shares;
        self.edge_count += 1;
        index
    }

    /// Closes the polygon after its last corner.
    #[inline]
    pub fn close(&mut self) {
        let first = self.corners[0];
        self.corners[self.corner_count.min(SLOTS)..].fill(first);
    }

    fn integrals(&self) -> &ClosedIntegrals {
        self.closed_form
            .as_deref()
            .unwrap_or(const { &NO_INTEGRALS })
    }
}

impl Batch {
    /// Adds a piece of a polygon, without corners and edges.
    #[inline]
    fn add(&mut self, polygon: usize, plane: &PolygonFields<f64>) -> &mut Piece {
        if self.len == self.pieces.len() {
            self.pieces.resize_with(self.len + ROW, Piece::empty);
        }
        self.are_whole |= self.len == 0;
        let piece = &mut self.pieces[self.len];
        piece.clear();
        (piece.plane, piece.polygon) = (*plane, polygon);
        self.len += 1;
        piece
    }

    /// Adds a polygon of weight 1 as a single piece, without corners and edges.
    #[inline]
    pub fn add_whole(&mut self, polygon: usize, plane: &PolygonFields<f64>) -> &mut Piece {
        let piece = self.add(polygon, plane);
        (piece.weights, piece.pressed_factor) = ([1.0; 2], 1.0);
        piece
    }

    /// Removes up to eight pieces from the end, and returns them with their count. The returned slice always has eight elements, because
    /// empty pieces follow.
    pub fn take(&mut self) -> (&[Piece], usize) {
        let count = self.len.min(ROW);
        self.len -= count;
        let pieces = &mut self.pieces[self.len..self.len + ROW];
        let (filled, empty) = pieces.split_at_mut(count);
        for piece in empty {
            piece.clear();
            piece.corners[0] = [0.0; 2];
            piece.close();
            if let [first, ..] = filled {
                (piece.plane, piece.polygon) = (first.plane, first.polygon);
            }
            piece.weights = [0.0; 2];
        }
        // Overwrite unused edges, because data of earlier pieces may be infinite or NaN.
        let counts = pieces.iter().map(|piece| piece.edge_count);
        let most = counts.max().unwrap_or(0).min(SLOTS);
        for piece in &mut *pieces {
            for missing in piece.edge_count..most {
                piece.edges[missing] = MovingEdge::NONE;
                piece.shares[missing] = [0.0; 2];
            }
        }
        (pieces, count)
    }
}

thread_local! {
    /// Empty batches whose memory is reused.
    static SPARE: RefCell<Vec<[Batch; METHODS]>> = const { RefCell::new(Vec::new()) };
}

/// Divides polygons into pieces, and sorts the pieces into batches by method.
pub(super) struct Pieces<'l> {
    law: &'l SurfaceLaw,
    motion: &'l RelativeMotion<f64>,
    /// One batch for each method.
    pub batches: [Batch; METHODS],
}

impl<'l> Pieces<'l> {
    pub fn new(law: &'l SurfaceLaw, motion: &'l RelativeMotion<f64>) -> Self {
        Self {
            law,
            motion,
            batches: SPARE.with_borrow_mut(Vec::pop).unwrap_or_default(),
        }
    }

    /// Returns a method with at least this many pieces, if there is one.
    #[inline]
    pub fn method_with(&self, least: usize) -> Option<usize> {
        (0..METHODS).find(|&method| self.batches[method].len >= least)
    }

    /// Divides a polygon into pieces. Returns whether the pressure is clamped on a part of it.
    pub fn divide(&mut self, polygon: PolygonToDivide) -> bool {
        let motion = PlaneMotion::of(self.motion, polygon.plane);
        let damping = motion.damping(self.law.dissipation, 1.0);
        let slip = (&motion.slip_by(self.law), &damping);
        // A damping that is not finite clamps nothing, so that it makes the integrals NaN.
        let is_finite = damping.iter().all(|coefficient| coefficient.is_finite());
        let pressed = polygon.outline.cut(&damping).filter(|_| is_finite);
        let Some(pressed) = pressed else {
            self.add_part(polygon, polygon.outline, Some(slip));
            return false;
        };
        let negated = damping.map(|coefficient| -coefficient);
        let Some(clamped) = polygon.outline.cut(&negated) else {
            // The damping is positive nowhere. If it is zero along an edge, the clamped part has the edge.
            self.add_part(polygon, polygon.outline, None);
            return true;
        };
        self.add_part(polygon, &pressed, Some(slip));
        self.add_part(polygon, &clamped, None);
        true
    }

    /// Adds the pieces of a part of a polygon. `slip` has the slip and the damping, or is `None` if the pressure is clamped on the part.
    fn add_part(
        &mut self,
        polygon: PolygonToDivide,
        part: &Outline<f64>,
        slip: Option<(&Slip<f64>, &[f64; 3])>,
    ) {
        let corners = part.corners();
        let level = slip.map_or(Some(0), |(slip, _)| slip.level(corners));
        let closed_form = slip.filter(|_| level.is_none()).map(|(slip, damping)| {
            ClosedForm::on(corners, *slip, &polygon.plane.pressure, damping)
        });
        let edge_of_part = |(edge, face): &(usize, EdgeFace)| {
            let mut edges = part.edges().iter();
            let part_edge = edges.position(|&of| usize::from(of) == *edge)?;
            Some((ends(corners, part_edge), *face))
        };
        let mut edges = polygon.faces.iter().filter_map(edge_of_part).peekable();
        let weights = [polygon.weights.still, polygon.weights.moving].map(Weight::area);
        let batch = &mut self.batches[level.unwrap_or(CLOSED_FORM)];
        // A part with many corners is divided into a fan of pieces about its first corner.
        let mut next = if polygon.has_area { 1 } else { corners.len() };
        let mut over_area = closed_form.as_ref().filter(|_| polygon.has_area);
        while next + 1 < corners.len() || edges.peek().is_some() {
            let piece = batch.add(polygon.number, polygon.plane);
            (piece.weights, piece.pressed_factor) = (weights, f64::from(u8::from(slip.is_some())));
            if next + 1 < corners.len() {
                let end = corners.len().min(next + SLOTS - 1);
                piece.push_corner(corners[0]);
                corners[next..end]
                    .iter()
                    .for_each(|&y| piece.push_corner(y));
                next = end - 1;
            } else {
                piece.corners[0] = [0.0; 2];
            }
            piece.close();
            let mut integrals = closed_form.as_ref().map(|_| Box::new(NO_INTEGRALS));
            if let (Some(integrals), Some(closed_form)) = (&mut integrals, over_area.take()) {
                integrals.over_area = closed_form.moments();
            }
            for (ends, by) in edges.by_ref().take(SLOTS) {
                let index = piece.push_edge(ends, &by);
                if let (Some(integrals), Some(closed_form)) = (&mut integrals, &closed_form) {
                    integrals.along_edges[index] = closed_form.along(ends);
                }
            }
            piece.closed_form = integrals;
            batch.are_whole &= polygon.is_whole;
        }
    }
}

impl Drop for Pieces<'_> {
    fn drop(&mut self) {
        let mut batches = std::mem::take(&mut self.batches);
        for batch in &mut batches {
            batch.len = 0;
        }
        // This fails if the thread is ending. The memory is then freed.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(batches));
    }
}

/// Integrates the surface law over the area of pieces by a method, one piece in each lane. Takes their planes. Returns the law on the planes,
/// too.
#[inline(always)]
pub(super) fn area_integrals<L: Lanes>(
    lanes: L,
    (pieces, method): (&[Piece], usize),
    planes: &PolygonFields<L::Numbers>,
    law_and_motion: (&SurfaceLaw, &RelativeMotion<f64>),
) -> (LawOnPlane<L::Numbers>, AreaMoments<L::Numbers>) {
    let pressed_factor = lanes.gathered(|lane| pieces[lane].pressed_factor);
    let law = LawOnPlane::on(lanes, planes, pressed_factor, law_and_motion);
    let (corners, count) = corners(lanes, pieces);
    let slip = slip_moments(lanes, pieces, &corners[..count], &law.load, method);
    let area = AreaMoments::of(&law, &slip, &area_moments(lanes, &corners[..=count]));
    (law, area)
}

/// Returns the corners of pieces, one piece in each lane, and the largest corner count of a piece. The first corner is repeated after the
/// last one.
#[inline(always)]
fn corners<L: Lanes>(lanes: L, pieces: &[Piece]) -> ([[L::Numbers; 2]; SLOTS + 1], usize) {
    let mut corners = [[lanes.splat(0.0); 2]; SLOTS + 1];
    let mut count = 0;
    for piece in pieces {
        count = piece.corner_count.max(count);
    }
    let count = count.min(SLOTS);
    for number in 0..=count {
        corners[number] = [
            lanes.gathered(|lane| pieces[lane].corners[number][0]),
            lanes.gathered(|lane| pieces[lane].corners[number][1]),
        ];
    }
    (corners, count)
}

/// Returns ∫ m dA over polygons for the ten monomials m up to degree 3. Each edge contributes the integral over its triangle with the
/// origin, which is exactly 0 if the ends of the edge are equal. `corners` must end with the first corner.
#[inline(always)]
fn area_moments<L: Lanes>(lanes: L, corners: &[[L::Numbers; 2]]) -> [L::Numbers; 10] {
    let mut sums = [lanes.splat(0.0); 10];
    let constants = [lanes.splat(0.5), lanes.splat(1.0 / 3.0)];
    for end in 1..corners.len() {
        add_triangle(&mut sums, corners[end - 1], corners[end], constants);
    }
    for (sum, factor) in sums.iter_mut().zip(PER_TRIANGLE) {
        *sum = *sum * lanes.splat(factor);
    }
    sums
}

/// Integrates slip over the area of pieces by a method.
#[inline(always)]
fn slip_moments<L: Lanes>(
    lanes: L,
    pieces: &[Piece],
    corners: &[[L::Numbers; 2]],
    load: &SlipAndLoad<L::Numbers>,
    method: usize,
) -> SlipMoments<L::Numbers> {
    if method < LEVELS {
        let (over_area, _) = slope_rules(method);
        return load.over_area(lanes, corners, over_area);
    }
    let mut moments = SlipMoments {
        direction: [[load.one; 10]; 2],
        by_slip: [[load.one; 6]; 3],
    };
    for (axis, numbers) in moments.direction.iter_mut().enumerate() {
        for (m, number) in numbers.iter_mut().enumerate() {
            *number = lanes.gathered(|lane| pieces[lane].integrals().over_area.direction[axis][m]);
        }
    }
    for (entry, numbers) in moments.by_slip.iter_mut().enumerate() {
        for (m, number) in numbers.iter_mut().enumerate() {
            *number = lanes.gathered(|lane| pieces[lane].integrals().over_area.by_slip[entry][m]);
        }
    }
    moments
}

/// Integrates slip along one edge of each piece by a method.
#[inline(always)]
pub(super) fn slip_along<L: Lanes>(
    lanes: L,
    pieces: &[Piece],
    number: usize,
    (load, edge): (&SlipAndLoad<L::Numbers>, &Edge<L::Numbers>),
    method: usize,
) -> [[L::Numbers; 6]; 2] {
    if method < LEVELS {
        let (_, along_edges) = slope_rules(method);
        return load.along(lanes, edge, along_edges);
    }
    let mut sums = [[load.one; 6]; 2];
    for (axis, numbers) in sums.iter_mut().enumerate() {
        for (m, sum) in numbers.iter_mut().enumerate() {
            *sum = lanes.gathered(|lane| pieces[lane].integrals().along_edges[number][axis][m]);
        }
    }
    sums
}
