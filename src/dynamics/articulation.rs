//! Connections of the bodies of a world by joints, with names resolved to indices.

use super::joint::{Joint, JointKind};
use super::{Body, WorldError};
use std::collections::BTreeSet;

/// Connections of the bodies of a world. They do not change after the world is built.
#[derive(Debug)]
pub(super) struct Articulation {
    /// Parent of each body on a joint, or `None` if the parent is the world.
    pub parents: Vec<Option<usize>>,
    /// Index of the state of the joint of each body in [`State::joints`](super::State), if the joint has a state.
    pub state_indices: Vec<Option<usize>>,
    /// Dependence of the joint of each body on its leader. Chains are resolved: the leader is not a mimicking joint.
    pub mimics: Vec<Option<BodyMimic>>,
    /// Pairs of bodies that a joint connects, or that are welded to such bodies, the smaller index first.
    pub adjacent: BTreeSet<(usize, usize)>,
    /// First body to which each body is welded, or the body itself.
    weld_roots: Vec<usize>,
}

impl Articulation {
    /// Checks the names and the parents of all joints, and resolves the names.
    ///
    /// # Errors
    /// If two joints have the same name, or if a parent does not come before its child.
    pub fn of(bodies: &[Body]) -> Result<Self, WorldError> {
        let mut names = BTreeSet::new();
        let (mut parents, mut state_indices) = (Vec::new(), Vec::new());
        let mut next_state = 0;
        for (index, body) in bodies.iter().enumerate() {
            let joint = body.connecting_joint();
            if let Some(joint) = joint
                && !names.insert(&joint.name)
            {
                return Err(WorldError::DuplicateJoint(joint.name.clone()));
            }
            parents.push(parent_index(joint, body, &bodies[..index])?);
            let has_state = body.joint_with_state().is_some();
            state_indices.push(has_state.then_some(next_state));
            next_state += usize::from(has_state);
        }
        Ok(Self {
            mimics: mimics(bodies)?,
            adjacent: adjacent_pairs(bodies, &parents),
            weld_roots: weld_roots(bodies, &parents),
            parents,
            state_indices,
        })
    }
}

impl Articulation {
    /// Pairs of bodies that are these two bodies or are welded to them, the smaller index first.
    pub fn welded_pairs(&self, bodies: [usize; 2]) -> impl Iterator<Item = (usize, usize)> + '_ {
        let roots = bodies.map(|body| self.weld_roots[body]);
        let welded = move |root: usize| {
            let indices = self.weld_roots.iter().enumerate();
            indices.filter_map(move |(index, other)| (*other == root).then_some(index))
        };
        welded(roots[0]).flat_map(move |i| welded(roots[1]).map(move |j| (i.min(j), i.max(j))))
    }
}

/// Dependence of a joint on the joint of another body.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyMimic {
    /// Index of the body of the leader.
    pub leader: usize,
    pub multiplier: f64,
    /// Position (rad or m) if the position of the leader is zero.
    pub offset: f64,
}

/// Resolves the names of leaders. A chain of leaders is replaced by its last leader.
fn mimics(bodies: &[Body]) -> Result<Vec<Option<BodyMimic>>, WorldError> {
    let resolve = |body: &Body| {
        let Some(joint) = body
            .connecting_joint()
            .filter(|joint| joint.mimic.is_some())
        else {
            return Ok(None);
        };
        let error = |leader: &str| WorldError::Mimic {
            joint: joint.name.clone(),
            leader: leader.to_owned(),
        };
        let (mut multiplier, mut offset, mut next) = (1.0, 0.0, joint.mimic.as_ref());
        let mut leader = bodies.len();
        for _ in bodies {
            let Some(mimic) = next else { break };
            let named = |body: &Body| {
                let joint = body.connecting_joint();
                joint.is_some_and(|joint| joint.name == mimic.joint && joint.kind.is_scalar())
            };
            offset += multiplier * mimic.offset;
            multiplier *= mimic.multiplier;
            leader = bodies
                .iter()
                .position(named)
                .ok_or_else(|| error(&mimic.joint))?;
            next = bodies[leader]
                .joint()
                .and_then(|joint| joint.mimic.as_ref());
        }
        if let Some(mimic) = next {
            return Err(error(&mimic.joint));
        }
        if multiplier == 0.0 || !multiplier.is_finite() || !offset.is_finite() {
            let leader = bodies[leader].joint().map(Joint::name);
            return Err(WorldError::MimicChain {
                joint: joint.name.clone(),
                leader: leader.unwrap_or_default().to_owned(),
                multiplier,
                offset,
            });
        }
        Ok(Some(BodyMimic {
            leader,
            multiplier,
            offset,
        }))
    };
    bodies.iter().map(resolve).collect()
}

/// Index of the parent among the bodies before a body.
fn parent_index(
    joint: Option<&Joint>,
    body: &Body,
    before: &[Body],
) -> Result<Option<usize>, WorldError> {
    let Some((joint, parent)) = joint.and_then(|joint| Some((joint, joint.parent()?))) else {
        return Ok(None);
    };
    let index = before
        .iter()
        .position(|candidate| candidate.name() == parent);
    if index.is_some() {
        return Ok(index);
    }
    Err(WorldError::JointParent {
        joint: joint.name.clone(),
        body: body.name().to_owned(),
        parent: parent.to_owned(),
    })
}

/// First body to which each body is welded, or the body itself.
fn weld_roots(bodies: &[Body], parents: &[Option<usize>]) -> Vec<usize> {
    let mut roots: Vec<usize> = (0..bodies.len()).collect();
    // Parents come before children.
    for (index, body) in bodies.iter().enumerate() {
        let is_welded = |joint: &Joint| joint.kind == JointKind::Fixed;
        if let Some(parent) = parents[index]
            && body.connecting_joint().is_some_and(is_welded)
        {
            roots[index] = roots[parent];
        }
    }
    roots
}

fn adjacent_pairs(bodies: &[Body], parents: &[Option<usize>]) -> BTreeSet<(usize, usize)> {
    let roots = weld_roots(bodies, parents);
    let mut connected = BTreeSet::new();
    for (index, body) in bodies.iter().enumerate() {
        let (Some(parent), Some(joint)) = (parents[index], body.connecting_joint()) else {
            continue;
        };
        if joint.kind != JointKind::Fixed {
            connected.insert((roots[parent], index));
        }
    }
    let mut pairs = BTreeSet::new();
    for (i, &first) in roots.iter().enumerate() {
        for (j, &second) in roots.iter().enumerate().skip(i + 1) {
            let is_connected = |a: usize, b: usize| connected.contains(&(a, b));
            if first == second || is_connected(first, second) || is_connected(second, first) {
                pairs.insert((i, j));
            }
        }
    }
    pairs
}
