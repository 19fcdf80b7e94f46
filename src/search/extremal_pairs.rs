use super::following::Walk;
use crate::broad_phase::Projections;
use crate::bvh::{Bvh, Node, PerNode};
use crate::contact_shape::Shape;
use crate::geometry::AffineField;
use crate::narrow_phase::RelativePair;
use crate::seeds::{FieldBounds, Seeds};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Slopes up to this fraction of the fields' sensitivities may be rounding errors.
const FLATNESS: f64 = 1e-10;

/// A search for pairs of tetrahedra in which a closed component of the contact surface may be extremal in a direction.
///
/// Let K be a closed component of {f = 0}, f = p_A − p_B. Both fields are positive inside, so K is compact and inside both bodies. Let y be
/// a highest point of K in a direction u. Other components are at a distance, so f is not zero in a half ball above y. It has one sign
/// there, and on the closed half ball f has its maximum or minimum at y. By the multiplier rule \[Clarke 1983, §6.1\], a convex combination
/// of the gradients of f at y is a multiple of u. Each of these gradients is that of a pair of tetrahedra that contain y. So for every
/// direction d perpendicular to u
///
/// 1. ∂f/∂d ≤ 0 in at least one of these pairs, and ≥ 0 in at least one;
/// 2. ∂f/∂d has both signs (or is zero) in the pairs at y, and therefore in the pairs of tetrahedra that share a vertex with them.
///
/// So the walk can start at the pairs with ∂f/∂d ≤ 0, for one fixed direction d perpendicular to u. Components that are already found
/// contain such pairs too. There are few if d is the direction in which f mostly rises on these components, and (2) excludes most of
/// them.
struct ExtremalPairs<'s, 'a> {
    pair: &'s RelativePair<'a>,
    trees: [BoundsTree<'s>; 2],
    /// |R|. It maps the half extents of a box in B to the half extents of its bounding box in A's axes.
    reach: Matrix3<f64>,
    /// The directions d of (2). The first is also the direction of (1).
    across: [Direction; 4],
    /// A stack of lists of nodes of A's tree. Each list has the nodes that may meet one node of B's tree, from the root down to the current
    /// node.
    partners: Vec<Node>,
}

/// A body's tree of tetrahedra, with bounds of the field for each node.
struct BoundsTree<'s> {
    bvh: &'s Bvh<usize>,
    bounds: &'s PerNode<FieldBounds>,
}

/// A unit vector in the frames of A and B, and the absolute values of its components. Their scalar product with the half extents of a box is
/// the half extent of the box along the vector.
struct Direction {
    of: [Vector3<f64>; 2],
    reach: [Vector3<f64>; 2],
}

/// Bounds of B's pressure in some tetrahedra, in A's frame.
struct PosedBounds {
    lower: Vector3<f64>,
    upper: Vector3<f64>,
    /// Approximation of the pressure (Pa).
    mean: AffineField,
    /// Largest difference of the pressure from `mean` (Pa).
    error: f64,
    /// The largest slope in the direction of (1) (Pa/m).
    steepest: f64,
    /// Center and half the range of the slopes around, in each direction (Pa/m).
    slopes_around: [[f64; 2]; 4],
    /// Bound on the change of the pressure per rounding error of a coordinate (Pa/m).
    sensitivity: f64,
    /// Half the diagonal of the box in B, squared (m²).
    squared_size: f64,
}

impl<'s> BoundsTree<'s> {
    fn of(shape: &'s Shape, seeds: &'s Seeds) -> Self {
        Self {
            bvh: shape.tet_bvh().pressing(),
            bounds: &seeds.bounds,
        }
    }

    /// The tree, and the bounds at one of its nodes.
    #[inline]
    fn at(&self, node: Node) -> (&'s Bvh<usize>, &'s FieldBounds) {
        (self.bvh, &self.bounds.level(node.level)[node.index])
    }
}

impl Walk<'_, '_> {
    /// Queues the pairs in which closed components may be extremal.
    pub fn enter_at_extremal_pairs(&mut self, shape_b: &Shape, seeds: [&Seeds; 2]) {
        let pair = self.pair;
        let trees = [
            BoundsTree::of(pair.shape_a, seeds[0]),
            BoundsTree::of(shape_b, seeds[1]),
        ];
        let mut normals = self.normals.take().unwrap_or_default();
        normals.add_cuts(&self.scratch.cuts, pair);
        let mut extremal_pairs = ExtremalPairs::of(pair, trees, normals.directions());
        extremal_pairs.partners.push(Node::ROOT);
        extremal_pairs.descend(Node::ROOT, 0, &mut |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b);
        });
    }
}

impl<'s, 'a> ExtremalPairs<'s, 'a> {
    /// Creates a search with the directions u and d.
    fn of(
        pair: &'s RelativePair<'a>,
        trees: [BoundsTree<'s>; 2],
        [up, rise]: [Vector3<f64>; 2],
    ) -> Self {
        let side = up.cross(&rise);
        let rotation = pair.pose_ab.rotation();
        let between = [(rise + side) * FRAC_1_SQRT_2, (rise - side) * FRAC_1_SQRT_2];
        let across = [rise, side, between[0], between[1]].map(|in_a| {
            let of = [in_a, rotation.tr_mul(&in_a)];
            Direction {
                of,
                reach: of.map(|vector| vector.abs()),
            }
        });
        Self {
            pair,
            trees,
            reach: rotation.abs(),
            across,
            partners: Vec::new(),
        }
    }

    /// Visits the pairs of tetrahedra in which a component may be extremal. The tetrahedra of B are below `node_b`, and the tetrahedra of A
    /// below its partners `partners[from..]`.
    fn descend(&mut self, node_b: Node, from: usize, visit: &mut impl FnMut(usize, usize)) {
        let (bvh, bounds) = self.trees[1].at(node_b);
        let posed = self.posed(bounds);
        let to = self.partners.len();
        for index in from..to {
            self.keep(self.partners[index], &posed);
        }
        if self.partners.len() > to {
            for child in bvh.child_nodes(node_b) {
                self.descend(child, to, visit);
            }
            for &tet_b in bvh.leaf_items(node_b) {
                self.visit_partners(tet_b, bounds, to, visit);
            }
        }
        self.partners.truncate(to);
    }

    /// Visits the tetrahedra of A below `partners[from..]` in which, paired with the tetrahedron of B, a component may be extremal.
    fn visit_partners(
        &self,
        tet_b: usize,
        around: &FieldBounds,
        from: usize,
        visit: &mut impl FnMut(usize, usize),
    ) {
        let (pair, field_tet) = (self.pair, self.pair.tet_b(tet_b));
        let posed = self.posed(&around.narrowed_to(field_tet));
        let mut shadow = None;
        for &node_a in &self.partners[from..] {
            self.visit_tets(node_a, &posed, &mut |tet_a| {
                let shadow = shadow.get_or_insert_with(|| {
                    Projections::of(&field_tet.tetrahedron.posed(&pair.pose_ab))
                });
                let projections_a = pair.shape_a.projections(tet_a);
                if !projections_a.separate(shadow, Projections::COUNT, pair.margin()) {
                    visit(tet_a, tet_b);
                }
            });
        }
    }

    /// Adds the nodes at and below a node of A to the partners, if they are no larger than a node of B and may meet it.
    fn keep(&mut self, node_a: Node, b: &PosedBounds) {
        let (bvh, bounds) = self.trees[0].at(node_a);
        if !self.may_be_extremal(bounds, b) {
            return;
        }
        let is_leaf = !bvh.leaf_items(node_a).is_empty();
        if is_leaf || bounds.half.norm_squared() <= b.squared_size {
            self.partners.push(node_a);
        } else {
            for child in bvh.child_nodes(node_a) {
                self.keep(child, b);
            }
        }
    }

    /// Visits the tetrahedra below a node of A that may form an extremal pair with a tetrahedron of
    /// B. `b` has the bounds of the tetrahedron of B.
    fn visit_tets(&self, node_a: Node, b: &PosedBounds, visit: &mut impl FnMut(usize)) {
        let (bvh, bounds) = self.trees[0].at(node_a);
        if !self.may_be_extremal(bounds, b) {
            return;
        }
        for child in bvh.child_nodes(node_a) {
            self.visit_tets(child, b, visit);
        }
        for &tet in bvh.leaf_items(node_a) {
            let narrowed = bounds.narrowed_to(self.pair.tet_a(tet));
            if self.may_be_extremal(&narrowed, b) {
                visit(tet);
            }
        }
    }

    /// Bounds of B's field in A's frame.
    fn posed(&self, bounds: &FieldBounds) -> PosedBounds {
        let (pair, modulus) = (self.pair, self.pair.scales[1]);
        let center = pair.pose_ab.transformed_point(&bounds.center);
        let half = (self.reach * bounds.half).add_scalar(pair.margin());
        let slope = |direction: &Direction, center: &Vector3<f64>, spread: &Vector3<f64>| {
            let at_center = center.dot(&direction.of[1]);
            [at_center, spread.dot(&direction.reach[1])].map(|slope| modulus * slope)
        };
        let around = |direction: &Direction| {
            slope(direction, &bounds.gradient_around, &bounds.spread_around)
        };
        let [rise, spread] = slope(&self.across[0], &bounds.mean.gradient, &bounds.spread);
        PosedBounds {
            lower: center - half,
            upper: center + half,
            mean: bounds.mean.posed(&pair.pose_ab).scaled(modulus),
            error: modulus * bounds.error,
            steepest: rise + spread,
            slopes_around: self.across.each_ref().map(around),
            sensitivity: modulus * bounds.sensitivity,
            squared_size: bounds.half.norm_squared(),
        }
    }

    /// Returns whether tetrahedra within these bounds may have a point of the contact surface with ∂f/∂d ≤ 0 (1) and slopes of both
    /// signs around (2).
    #[inline]
    fn may_be_extremal(&self, a: &FieldBounds, b: &PosedBounds) -> bool {
        let (lower, upper) = (
            (a.center - a.half).sup(&b.lower),
            (a.center + a.half).inf(&b.upper),
        );
        let half = (upper - lower) * 0.5;
        if half.min() < 0.0 {
            return false;
        }
        let modulus = self.pair.scales[0];
        let sensitivity = modulus * a.sensitivity + b.sensitivity;
        let rise = &self.across[0];
        let flattest = modulus * (a.mean.gradient.dot(&rise.of[0]) - a.spread.dot(&rise.reach[0]));
        if flattest - b.steepest > FLATNESS * sensitivity {
            return false;
        }
        let gradient = a.mean.gradient * modulus - b.mean.gradient;
        let excess =
            gradient.dot(&((upper + lower) * 0.5)) + modulus * a.mean.offset - b.mean.offset;
        let reach = gradient.abs().dot(&half) + modulus * a.error + b.error;
        excess.abs() <= reach + self.pair.margin() * sensitivity
            && self.may_slope_both_ways(a, b, FLATNESS * sensitivity)
    }

    /// Returns whether p_A − p_B may rise and fall in each direction in the tetrahedra around (2).
    fn may_slope_both_ways(&self, a: &FieldBounds, b: &PosedBounds, tolerance: f64) -> bool {
        let modulus = self.pair.scales[0];
        let mut directions = self.across.iter().zip(&b.slopes_around);
        directions.all(|(direction, [slope_b, spread_b])| {
            let slope_a = modulus * a.gradient_around.dot(&direction.of[0]);
            let spread_a = modulus * a.spread_around.dot(&direction.reach[0]);
            (slope_a - slope_b).abs() <= spread_a + spread_b + tolerance
        })
    }
}
