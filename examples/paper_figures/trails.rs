//! The edges of many faces in few polylines, each edge once. Files stay small, and translucent edges are not drawn twice.

use super::view::Pixel;
use std::collections::{BTreeMap, BTreeSet};

/// For each end of a remaining edge, the other ends.
type Ends = BTreeMap<Pixel, BTreeSet<Pixel>>;

/// Traverses the edges of closed outlines, each edge in one polyline only.
pub fn trails(outlines: &[Vec<Pixel>]) -> Vec<Vec<Pixel>> {
    let mut ends = ends_of(outlines);
    let mut trails = Vec::new();
    while let Some(start) = place_with_edges(&ends) {
        let mut trail = vec![start];
        let mut here = start;
        while let Some(next) = step_from(&mut ends, here) {
            trail.push(next);
            here = next;
        }
        trails.push(trail);
    }
    trails
}

fn ends_of(outlines: &[Vec<Pixel>]) -> Ends {
    let mut ends = Ends::new();
    for outline in outlines {
        let next = outline.iter().cycle().skip(1);
        for (&from, &to) in outline.iter().zip(next).filter(|(from, to)| from != to) {
            ends.entry(from).or_default().insert(to);
            ends.entry(to).or_default().insert(from);
        }
    }
    ends
}

fn place_with_edges(ends: &Ends) -> Option<Pixel> {
    let mut left = ends.iter().filter(|(_, others)| !others.is_empty());
    left.next().map(|(place, _)| *place)
}

/// Removes an edge and returns its other end.
fn step_from(ends: &mut Ends, here: Pixel) -> Option<Pixel> {
    let next = ends.get_mut(&here)?.pop_first()?;
    ends.get_mut(&next)?.remove(&here);
    Some(next)
}
