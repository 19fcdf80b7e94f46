//! Generalized coordinates of the dynamic bodies of an island.
//!
//! A [`Multibody`] is a forest of links. A link is a dynamic body with the joint that connects it to its parent: another link, a body that
//! is not dynamic, or the world. A free body is a tree of one link whose joint allows all six motions. The number of generalized velocities
//! u is the sum of the degrees of freedom of the joints. Each generalized velocity has a *column*.
//!
//! Quantities of a tree are spatial vectors in world axes, angular before linear, about the reference point of the tree. The reference
//! point is the real part of a point of the root link, so that quantities of a tree far from the origin lose no digits to round-off.
//! Derivatives treat the reference point as a constant, because generalized momenta and forces do not depend on it. The product of two
//! motions is v × m, and the product of a motion and a wrench is v ×* f. The symbols are:
//!
//! | symbol | meaning | code |
//! |---|---|---|
//! | S | axis of a column: the velocity of the link per unit of u | [`Column::axis`] |
//! | Ṡ = v × S | rate of the axis, with the velocity v of the frame in which the axis is constant | [`Column::axis_rate`] |
//! | H | momentum of the link of a column and all its descendants | [`Kinematics::momenta`] |
//! | A | armature of a column | [`JointLaw::armature`](crate::dynamics::JointLaw) |
//! | p = SᵀH + A·u | generalized momentum | [`Multibody::generalized_momenta`] |
//!
//! Lagrange's equations are dp/dt = ṠᵀH + SᵀF + Q. F is the wrench on a link and its descendants, and Q is the force of the joint. The
//! equations have no other velocity-dependent term. [`loops`] adds constraints that close loops of links. [`slopes`] has the derivatives in
//! closed form \[Featherstone 2008, Rigid Body Dynamics Algorithms, chapters 2 and 6\].

mod coordinates;
mod inverse_dynamics;
mod jacobian;
mod kinematics;
mod loops;
mod mass_matrix;
mod mimic;
mod momentum;
mod screw;
mod slopes;
#[cfg(test)]
mod tests;
mod world_states;

pub(in crate::dynamics) use coordinates::{Coordinates, zeros};
pub(in crate::dynamics) use inverse_dynamics::Accelerations;
pub(in crate::dynamics) use jacobian::convective;
pub(in crate::dynamics) use kinematics::{Column, Kinematics};
pub(in crate::dynamics) use loops::{Loop, LoopRegularization};
pub(in crate::dynamics) use mass_matrix::MassFactors;
pub(in crate::dynamics) use mimic::Coupling;
pub(in crate::dynamics) use slopes::{BodyColumn, Directions};

use super::Inertia;
use super::joint::{Joint, JointKind, JointLaw};
use crate::scalar::{Scalar, lift};
use crate::spatial::Pose;
use nalgebra::DMatrix;
use std::ops::Range;

/// Dynamic bodies of an island with their joints.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Multibody<T = f64> {
    /// Links, parents before children.
    pub links: Vec<Link<T>>,
    /// Columns of each tree. Trees that a mimicking joint couples are one tree.
    pub trees: Vec<Range<usize>>,
    /// World indices of the neighbors, that is, of the bodies of the island that are not dynamic.
    pub neighbors: Vec<usize>,
    /// Loop joints between the participants.
    pub loops: Vec<Loop>,
}

/// Dynamic body with its joint.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Link<T = f64> {
    /// Index of the body in the world.
    pub body: usize,
    /// Index of the state of the joint in [`State::joints`](crate::dynamics::State). Free, fixed and mimicking joints have no state.
    pub state_index: Option<usize>,
    pub inertia: Inertia<T>,
    pub kind: JointKind,
    /// Pose of the joint frame in the frame of the parent.
    pub origin: Pose,
    pub law: JointLaw<T>,
    pub parent: Parent,
    pub mimic: Option<LinkMimic>,
    pub columns: Range<usize>,
    /// Columns that move the link: the columns of its ancestors, then its own columns.
    pub moving_columns: Vec<usize>,
    /// Index of the tree.
    pub tree: usize,
}

/// Dependence of the joint of a link on the joint of another link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::dynamics) struct LinkMimic {
    /// Index of the link of the leader.
    pub leader: usize,
    pub multiplier: f64,
    /// Position (rad or m) if the position of the leader is zero.
    pub offset: f64,
}

/// Parent of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::dynamics) enum Parent {
    World,
    /// Index of a link.
    Link(usize),
    /// Index of a body of the island that is not dynamic.
    Neighbor(usize),
}

impl<T> Link<T> {
    /// Creates a link without columns. [`Multibody::new`] adds the columns.
    pub fn new(
        body: usize,
        inertia: Inertia<T>,
        (joint, law): (&Joint<T>, JointLaw<T>),
        parent: Parent,
    ) -> Self {
        Self {
            body,
            state_index: None,
            inertia,
            kind: joint.kind,
            origin: joint.origin,
            law,
            parent,
            mimic: None,
            columns: 0..0,
            moving_columns: Vec::new(),
            tree: 0,
        }
    }
}

impl<T> Multibody<T> {
    /// Creates the columns of links, tree by tree. Parents come before children.
    pub fn new(mut links: Vec<Link<T>>, neighbors: &[usize]) -> Self {
        let mut tree_count = 0;
        for link in 0..links.len() {
            links[link].tree = match links[link].parent {
                Parent::Link(parent) => links[parent].tree,
                Parent::World | Parent::Neighbor(_) => {
                    tree_count += 1;
                    tree_count - 1
                }
            };
        }
        if links.iter().any(|link| link.mimic.is_some()) {
            tree_count = join_coupled_trees(&mut links);
        }
        let (mut trees, mut next) = (Vec::new(), 0);
        for tree in 0..tree_count {
            let first = next;
            for link in 0..links.len() {
                if links[link].tree != tree {
                    continue;
                }
                let columns = next..next + links[link].kind.width();
                next = columns.end;
                let mut moving_columns = match links[link].parent {
                    Parent::Link(parent) => links[parent].moving_columns.clone(),
                    Parent::World | Parent::Neighbor(_) => Vec::new(),
                };
                moving_columns.extend(columns.clone());
                let link = &mut links[link];
                (link.columns, link.moving_columns) = (columns, moving_columns);
            }
            trees.push(first..next);
        }
        Self {
            links,
            trees,
            neighbors: neighbors.to_vec(),
            loops: Vec::new(),
        }
    }
}

impl Multibody {
    /// The links with zero derivatives.
    pub fn lifted<T: Scalar>(&self) -> Multibody<T> {
        let links = self.links.iter().map(|link| Link {
            body: link.body,
            state_index: link.state_index,
            inertia: link.inertia.lifted(),
            kind: link.kind,
            origin: link.origin,
            law: link.law.lifted(),
            parent: link.parent,
            mimic: link.mimic,
            columns: link.columns.clone(),
            moving_columns: link.moving_columns.clone(),
            tree: link.tree,
        });
        Multibody {
            links: links.collect(),
            trees: self.trees.clone(),
            neighbors: self.neighbors.clone(),
            loops: self.loops.clone(),
        }
    }
}

impl<T: Scalar> Multibody<T> {
    /// Number of generalized velocities.
    pub fn width(&self) -> usize {
        self.trees.last().map_or(0, |columns| columns.end)
    }

    /// Neighbor that carries the tree of a link, or `None` if the world carries it.
    pub fn carrier(&self, link: usize) -> Option<usize> {
        match self.links[link].parent {
            Parent::Link(parent) => self.carrier(parent),
            Parent::Neighbor(neighbor) => Some(neighbor),
            Parent::World => None,
        }
    }

    /// Index of the parent link.
    fn parent_link(&self, link: usize) -> Option<usize> {
        match self.links[link].parent {
            Parent::Link(parent) => Some(parent),
            Parent::World | Parent::Neighbor(_) => None,
        }
    }

    /// Block-diagonal matrix with one block for each tree.
    pub fn assembled(&self, matrices: &[DMatrix<T>]) -> DMatrix<T> {
        let mut sum = DMatrix::from_element(self.width(), self.width(), lift(0.0));
        for (columns, matrix) in self.trees.iter().zip(matrices) {
            let corner = (columns.start, columns.start);
            sum.view_mut(corner, matrix.shape()).copy_from(matrix);
        }
        sum
    }

    /// Adds the value of each link to the values of its ancestors.
    fn summed_over_subtrees<V: Copy>(&self, mut values: Vec<V>, sum: impl Fn(V, V) -> V) -> Vec<V> {
        for link in (0..values.len()).rev() {
            if let Some(parent) = self.parent_link(link) {
                values[parent] = sum(values[parent], values[link]);
            }
        }
        values
    }
}

/// Merges the trees that a mimicking joint couples, because they share one block in each matrix. Returns the number of trees.
fn join_coupled_trees<T>(links: &mut [Link<T>]) -> usize {
    for link in 0..links.len() {
        let Some(mimic) = links[link].mimic else {
            continue;
        };
        let [one, other] = [links[link].tree, links[mimic.leader].tree];
        let (kept, joined) = (one.min(other), one.max(other));
        for link in links.iter_mut().filter(|link| link.tree == joined) {
            link.tree = kept;
        }
    }
    let mut kept: Vec<usize> = links.iter().map(|link| link.tree).collect();
    kept.sort_unstable();
    kept.dedup();
    for link in links {
        link.tree = kept.partition_point(|tree| *tree < link.tree);
    }
    kept.len()
}
