/// The connected components of a closed surface. Triangles are connected if they share an edge.
pub(super) struct Components {
    /// The triangles, grouped by component. Each group starts with its lowest index.
    members: Vec<usize>,
    /// End of each component in `members`.
    ends: Vec<usize>,
}

impl Components {
    /// Finds the components from the neighbors of each triangle by breadth-first search.
    pub fn of(neighbors: &[[u32; 3]]) -> Self {
        let mut is_visited = vec![false; neighbors.len()];
        let mut members = Vec::with_capacity(neighbors.len());
        let mut ends = Vec::new();
        for start in 0..neighbors.len() {
            if is_visited[start] {
                continue;
            }
            is_visited[start] = true;
            let mut next = members.len();
            members.push(start);
            while next < members.len() {
                for &neighbor in &neighbors[members[next]] {
                    let neighbor = neighbor as usize;
                    if !is_visited[neighbor] {
                        is_visited[neighbor] = true;
                        members.push(neighbor);
                    }
                }
                next += 1;
            }
            ends.push(members.len());
        }
        Self { members, ends }
    }

    /// Returns the triangles of each component.
    pub fn iter(&self) -> impl Iterator<Item = &[usize]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let spans = starts.zip(&self.ends);
        spans.map(|(start, &end)| &self.members[start..end])
    }

    /// Returns the first triangle of each component.
    pub fn starts(&self) -> impl Iterator<Item = usize> {
        self.iter().map(|members| members[0])
    }
}
