/// Divides the prism between two triangles into tetrahedra by a staircase that climbs from the low to the high triangle one vertex at a
/// time. Tetrahedra with a repeated vertex, as in pyramids, are omitted.
///
/// Two prisms divide their common side alike if their vertices have the same order.
pub(super) fn prism(low: [usize; 3], high: [usize; 3]) -> impl Iterator<Item = [usize; 4]> {
    let step = move |climbed: usize| {
        std::array::from_fn(|corner| {
            if corner <= climbed {
                low[corner]
            } else {
                high[corner - 1]
            }
        })
    };
    (0..3).rev().map(step).filter(|tet| !has_repeats(tet))
}

fn has_repeats(tet: &[usize; 4]) -> bool {
    (1..4).any(|corner| tet[..corner].contains(&tet[corner]))
}
