//! Moments of polygons in a plane.

use crate::lanes::Linear;

/// Factors that convert the sums of [`add_triangle`] to moments.
pub(crate) const PER_TRIANGLE: [f64; 10] = [
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 6.0,
    1.0 / 12.0,
    1.0 / 12.0,
    1.0 / 12.0,
    1.0 / 20.0,
    1.0 / 20.0,
    1.0 / 20.0,
    1.0 / 20.0,
];

/// Adds the moments of the triangle (origin, `a`, `b`), divided by [`PER_TRIANGLE`]. The moments
/// are ∫ m dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂² and, if K is 10, y₁³, y₁²y₂, y₁y₂²,
/// y₂³. Their sign is the sign of a × b, so the sums over the edges of a polygon are its moments.
/// The last argument is [½, ⅓].
///
/// With turn = a × b, twice the area of the triangle:
///
/// - ∫ y₁ dA = turn/6·(a₁ + b₁),
/// - ∫ y₁² dA = turn/12·(a₁² + a₁b₁ + b₁²),
/// - ∫ y₁³ dA = turn/20·(a₁³ + a₁²b₁ + a₁b₁² + b₁³).
#[inline(always)]
pub(crate) fn add_triangle<N: Linear, const K: usize>(
    sums: &mut [N; K],
    [a1, a2]: [N; 2],
    [b1, b2]: [N; 2],
    [half, third]: [N; 2],
) {
    const { assert!(K == 6 || K == 10) };
    let turn = a1 * b2 - a2 * b1;
    let [s1, s2] = [a1 + b1, a2 + b2];
    let (squares1, squares2) = (a1 * a1 + b1 * b1, a2 * a2 + b2 * b2);
    let (product1, product2) = (a1 * b1, a2 * b2);
    let (mixed, crossed) = (a1 * a2 + b1 * b2, a1 * b2 + a2 * b1);
    sums[0] = sums[0] + turn;
    sums[1] = sums[1] + turn * s1;
    sums[2] = sums[2] + turn * s2;
    sums[3] = sums[3] + turn * (squares1 + product1);
    sums[4] = sums[4] + turn * (mixed + crossed * half);
    sums[5] = sums[5] + turn * (squares2 + product2);
    if K == 10 {
        let cubic = [
            squares1 * s1,
            a1 * a1 * a2 + b1 * b1 * b2 + (crossed * s1 + product1 * s2) * third,
            a2 * a2 * a1 + b2 * b2 * b1 + (crossed * s2 + product2 * s1) * third,
            squares2 * s2,
        ];
        for (sum, value) in sums[6..].iter_mut().zip(cubic) {
            *sum = *sum + turn * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding error of numbers of magnitude one.
    const EXACT: f64 = 1e-15;

    #[test]
    fn moments_of_a_triangle_are_exact_to_degree_three() {
        // ∫ y₁ⁱy₂ᵏ dA = i! k!/(i + k + 2)! over the triangle with legs of 1. Here it is shifted
        // along y₁ by 1.
        let corners = [[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
        let mut sums = [0.0; 10];
        for edge in 0..3 {
            let ends = [corners[edge], corners[(edge + 1) % 3]];
            add_triangle(&mut sums, ends[0], ends[1], [0.5, 1.0 / 3.0]);
        }
        let expected = [
            1.0 / 2.0,
            1.0 / 2.0 + 1.0 / 6.0,
            1.0 / 6.0,
            1.0 / 2.0 + 2.0 / 6.0 + 1.0 / 12.0,
            1.0 / 6.0 + 1.0 / 24.0,
            1.0 / 12.0,
            1.0 / 2.0 + 3.0 / 6.0 + 3.0 / 12.0 + 1.0 / 20.0,
            1.0 / 6.0 + 2.0 / 24.0 + 1.0 / 60.0,
            1.0 / 12.0 + 1.0 / 60.0,
            1.0 / 20.0,
        ];
        for (index, expected) in expected.into_iter().enumerate() {
            let actual = sums[index] * PER_TRIANGLE[index];
            assert!((actual - expected).abs() <= EXACT, "{index}: {actual}");
        }
        let mut quadratic = [0.0; 6];
        add_triangle(&mut quadratic, corners[1], corners[2], [0.5, 1.0 / 3.0]);
        let mut cubic = [0.0; 10];
        add_triangle(&mut cubic, corners[1], corners[2], [0.5, 1.0 / 3.0]);
        assert_eq!(
            quadratic.map(f64::to_bits)[..],
            cubic.map(f64::to_bits)[..6]
        );
    }
}
