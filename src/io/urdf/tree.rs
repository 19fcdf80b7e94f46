//! Checks that links and joints form one tree, and sorts them.

use super::element::Element;
use super::joint::Joint;
use super::link::Link;
use super::{UrdfError, UrdfWarning};
use std::collections::BTreeMap;

/// Tree of links and joints, by their indices in the file.
struct Tree {
    /// Joint above each link, or `None` for a root.
    joint_above: Vec<Option<usize>>,
    /// Joints below each link, in the order of the file.
    joints_below: Vec<Vec<usize>>,
    /// Parent and child of each joint.
    ends: Vec<[usize; 2]>,
}

/// Sorts the links depth first, so that parents come before children. Joint i becomes the joint above link i + 1.
///
/// # Errors
/// If the links and joints are not one tree.
pub(super) fn sorted(
    robot: Element,
    links: Vec<Link>,
    joints: Vec<Joint>,
) -> Result<(Vec<Link>, Vec<Joint>), UrdfError> {
    let tree = Tree::of(&links, &joints)?;
    let root = tree.root(robot, &links, &joints)?;
    let order = tree.depth_first(root);
    if order.len() < links.len() {
        return Err(tree.cycle_error(&order, &joints));
    }
    let joint_order = order.iter().filter_map(|&link| tree.joint_above[link]);
    let joints = permuted(joints, joint_order);
    Ok((permuted(links, order.iter().copied()), joints))
}

/// Returns the values at these indices, in this order.
fn permuted<T>(values: Vec<T>, order: impl Iterator<Item = usize>) -> Vec<T> {
    let mut values: Vec<_> = values.into_iter().map(Some).collect();
    order.filter_map(|index| values[index].take()).collect()
}

impl Tree {
    fn of(links: &[Link], joints: &[Joint]) -> Result<Self, UrdfError> {
        let names = links.iter().map(|link| link.name.as_str());
        let indices: BTreeMap<&str, usize> = names.zip(0..).collect();
        let mut tree = Self {
            joint_above: vec![None; links.len()],
            joints_below: vec![Vec::new(); links.len()],
            ends: Vec::new(),
        };
        for (index, joint) in joints.iter().enumerate() {
            let link = |role, name: &str| {
                let found = indices.get(name).copied();
                found.ok_or_else(|| UrdfError::UnknownLink {
                    at: joint.at.clone(),
                    role,
                    name: name.to_owned(),
                })
            };
            let ends = [link("parent", &joint.parent)?, link("child", &joint.child)?];
            let [parent, child] = ends;
            if let Some(other) = tree.joint_above[child].replace(index) {
                return Err(UrdfError::TwoParents {
                    at: joint.at.clone(),
                    child: joint.child.clone(),
                    other: joints[other].name.clone(),
                });
            }
            tree.joints_below[parent].push(index);
            tree.ends.push(ends);
        }
        Ok(tree)
    }

    /// Index of the only link without a parent.
    fn root(&self, robot: Element, links: &[Link], joints: &[Joint]) -> Result<usize, UrdfError> {
        let all = 0..self.joint_above.len();
        let roots: Vec<usize> = all
            .filter(|&link| self.joint_above[link].is_none())
            .collect();
        match roots[..] {
            [root] => Ok(root),
            [first, second, ..] => Err(UrdfError::SeveralRoots {
                at: robot.location(),
                count: roots.len(),
                first: links[first].name.clone(),
                second: links[second].name.clone(),
            }),
            [] if links.is_empty() => Err(UrdfError::NoLinks {
                at: robot.location(),
            }),
            [] => Err(self.cycle_error(&[], joints)),
        }
    }

    /// Indices of the links below the root, depth first.
    fn depth_first(&self, root: usize) -> Vec<usize> {
        let mut order = Vec::new();
        let mut stack = vec![root];
        while let Some(link) = stack.pop() {
            order.push(link);
            let joints = self.joints_below[link].iter().rev();
            stack.extend(joints.map(|&joint| self.ends[joint][1]));
        }
        order
    }

    /// Error for a cycle of joints. Requires at least one link that was not reached from the root. The cycle contains this link, or is
    /// above it.
    fn cycle_error(&self, reached: &[usize], joints: &[Joint]) -> UrdfError {
        let mut is_reached = vec![false; self.joint_above.len()];
        for &link in reached {
            is_reached[link] = true;
        }
        let first = is_reached.iter().position(|&reached| !reached);
        // Every unreached link has a joint above it, and all links above it are unreached too.
        let mut link = first.unwrap_or_default();
        let mut above = Vec::new();
        while let Some(joint) = self.joint_above[link].filter(|_| !is_reached[link]) {
            is_reached[link] = true;
            above.push(joint);
            link = self.ends[joint][0];
        }
        // The walk ends at a link of the cycle. This is the joint above that link.
        let start = above.iter().position(|&joint| self.ends[joint][1] == link);
        let cycle = &above[start.unwrap_or_default()..];
        UrdfError::Cycle {
            at: joints[cycle[0]].at.clone(),
            length: cycle.len(),
        }
    }
}

/// Returns the warnings about joints that mimic joints that do not exist.
///
/// # Errors
/// If a joint mimics itself, directly or through other joints.
pub(super) fn mimic_warnings(joints: &[Joint]) -> Result<Vec<UrdfWarning>, UrdfError> {
    let names = joints.iter().map(|joint| joint.name.as_str());
    let indices: BTreeMap<&str, usize> = names.zip(0..).collect();
    let mut warnings = Vec::new();
    // Start of the walk that first visited each joint.
    let mut walks = vec![None; joints.len()];
    for start in 0..joints.len() {
        let mut joint = start;
        while walks[joint].is_none() {
            walks[joint] = Some(start);
            let Some(mimic) = &joints[joint].mimic else {
                break;
            };
            let Some(&leader) = indices.get(mimic.joint.as_str()) else {
                warnings.push(UrdfWarning::UnknownMimic {
                    at: joints[joint].at.clone(),
                    name: mimic.joint.clone(),
                });
                break;
            };
            if walks[leader] == Some(start) {
                return Err(UrdfError::MimicCycle {
                    at: joints[leader].at.clone(),
                });
            }
            joint = leader;
        }
    }
    Ok(warnings)
}
