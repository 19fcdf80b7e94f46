//! Division of the dynamic bodies into islands.

use super::StepContext;
use super::island::Island;
use crate::dynamics::sweep::Sweep;
use crate::geometry::Aabb;

impl StepContext<'_> {
    /// Islands of bodies that stay within these boxes, in the order of their first bodies.
    pub fn islands(&self, boxes: &[Aabb]) -> Vec<Island> {
        let model = self.model;
        let mut sets = Sets::new(boxes.len());
        let mut sweep = Sweep::default();
        let pairs = sweep.overlapping(boxes.iter().copied(), |i, j| model.ordered_pair(i, j));
        let is_dynamic = |body: usize| model.bodies[body].inertia().is_some();
        for &(i, j) in pairs {
            if is_dynamic(i) && is_dynamic(j) {
                sets.join(i, j);
            }
        }
        for (body, parent) in model.parents().chain(model.leaders()) {
            if is_dynamic(parent) {
                sets.join(body, parent);
            }
        }
        for [i, j] in model.loop_pairs() {
            if is_dynamic(i) && is_dynamic(j) {
                sets.join(i, j);
            }
        }
        for group in self.coupled {
            let mut dynamic = group.iter().copied().filter(|&body| is_dynamic(body));
            if let Some(first) = dynamic.next() {
                dynamic.for_each(|body| sets.join(first, body));
            }
        }
        let mut islands: Vec<Island> = Vec::new();
        let mut island_of_root = vec![usize::MAX; boxes.len()];
        for body in model.dynamic_bodies() {
            let root = sets.root(body);
            if island_of_root[root] == usize::MAX {
                island_of_root[root] = islands.len();
                islands.push(Island {
                    dynamic: Vec::new(),
                    neighbors: Vec::new(),
                });
            }
            islands[island_of_root[root]].dynamic.push(body);
        }
        for (body, neighbor) in self.neighbors(pairs) {
            islands[island_of_root[sets.root(body)]]
                .neighbors
                .push(neighbor);
        }
        for island in &mut islands {
            island.neighbors.sort_unstable();
            island.neighbors.dedup();
        }
        islands
    }

    /// Pairs of a dynamic body and a neighbor: a body that it may touch, the parent of its joint, or a body that a loop joint or a force
    /// couples to it.
    fn neighbors(&self, pairs: &[(usize, usize)]) -> Vec<(usize, usize)> {
        let is_dynamic = |body: usize| self.model.bodies[body].inertia().is_some();
        let touching = pairs.iter().flat_map(|&(i, j)| [(i, j), (j, i)]);
        let coupled = self.coupled.iter().flat_map(|group| {
            let first = group.iter().copied().find(|&body| is_dynamic(body));
            let others = group.iter().copied();
            first
                .into_iter()
                .flat_map(move |first| others.clone().map(move |other| (first, other)))
        });
        let loops = self.model.loop_pairs();
        let loops = loops.flat_map(|[i, j]| [(i, j), (j, i)]);
        let all = touching.chain(self.model.parents()).chain(loops);
        let all = all.chain(coupled);
        all.filter(|&(body, neighbor)| is_dynamic(body) && !is_dynamic(neighbor))
            .collect()
    }
}

/// Disjoint sets (union–find). The root of a set is its smallest member.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
