//! Quadrature rules: symmetric rules on the triangle, and Gauss–Legendre on an edge.
//!
//! The nodes on the triangle are, unless noted, those of H. Xiao and Z. Gimbutas, "A numerical algorithm for the construction of efficient
//! quadrature rules in two and higher dimensions", Comput. Math. Appl. 59 (2010). All nodes are inside, and all weights are positive. They
//! are stored as orbits of the triangle's symmetries and expanded at compile time.
#![expect(
    clippy::unreadable_literal,
    reason = "nodes and weights are compared with the source as they are"
)]

/// Two points of a rule on the triangle (first corner, b, c): the barycentric coordinates of b and of c, and the weights, as fractions of
/// the area. Points are processed in pairs so that the compiler can use whole registers.
pub(crate) type PointPair = [[f64; 2]; 3];

/// A rule on the triangle, exact for polynomials up to its degree.
pub(crate) struct TriangleRule {
    pairs: [PointPair; Self::CAPACITY],
    len: usize,
}

impl TriangleRule {
    /// Half the 60 points of the rule of degree 17.
    const CAPACITY: usize = 30;

    /// Returns the points. If their number is odd, the last one has a weight of zero.
    pub fn pairs(&self) -> &[PointPair] {
        &self.pairs[..self.len]
    }

    const fn expanded(orbits: &Orbits) -> Self {
        let mut points = Points {
            rule: Self {
                pairs: [[[0.0; 2]; 3]; Self::CAPACITY],
                len: 0,
            },
            count: 0,
        };
        if orbits.centroid > 0.0 {
            points.push(1.0 / 3.0, 1.0 / 3.0, orbits.centroid);
        }
        let mut i = 0;
        while i < orbits.cyclic.len() {
            let [a, b, weight] = orbits.cyclic[i];
            points.push_turned([a, b], weight);
            i += 1;
        }
        i = 0;
        while i < orbits.medians.len() {
            let [a, weight] = orbits.medians[i];
            points.push_turned([a, a], weight);
            i += 1;
        }
        i = 0;
        while i < orbits.general.len() {
            let [a, b, weight] = orbits.general[i];
            points.push_turned([a, b], weight);
            points.push_turned([b, a], weight);
            i += 1;
        }
        points.rule
    }
}

/// A rule under construction.
struct Points {
    rule: TriangleRule,
    count: usize,
}

impl Points {
    const fn push(&mut self, b: f64, c: f64, weight: f64) {
        let (pair, lane) = (self.count / 2, self.count % 2);
        self.rule.pairs[pair][0][lane] = b;
        self.rule.pairs[pair][1][lane] = c;
        self.rule.pairs[pair][2][lane] = weight;
        self.count += 1;
        self.rule.len = pair + 1;
    }

    /// Adds the point with the barycentric coordinates a, b and the rest, and its two cyclic permutations.
    const fn push_turned(&mut self, [a, b]: [f64; 2], weight: f64) {
        let rest = 1.0 - a - b;
        self.push(a, b, weight);
        self.push(b, rest, weight);
        self.push(rest, a, weight);
    }
}

/// The points of a rule that is the same seen from each corner of the triangle.
struct Orbits {
    /// Weight of the centroid, or 0 if it is not a point of the rule.
    centroid: f64,
    /// Orbits of three points under rotations only: two barycentric coordinates and the weight.
    cyclic: &'static [[f64; 3]],
    /// Orbits of three points on the medians: the barycentric coordinate of two corners, and the weight.
    medians: &'static [[f64; 2]],
    /// Orbits of six points: two barycentric coordinates and the weight.
    general: &'static [[f64; 3]],
}

const NONE: Orbits = Orbits {
    centroid: 0.0,
    cyclic: &[],
    medians: &[],
    general: &[],
};

/// A Gauss–Legendre rule, exact for polynomials of degree 2n − 1.
pub(crate) struct EdgeRule {
    pairs: [[[f64; 2]; 2]; Self::CAPACITY],
    len: usize,
}

impl EdgeRule {
    const CAPACITY: usize = 5;

    /// Returns the nodes in [−1, 1] and their weights as fractions of the length, in pairs.
    pub fn pairs(&self) -> &[[[f64; 2]; 2]] {
        &self.pairs[..self.len]
    }

    /// Creates a rule from the positive nodes and their weights. The negative nodes are symmetric.
    const fn mirrored(half: &[[f64; 2]]) -> Self {
        let mut rule = Self {
            pairs: [[[0.0; 2]; 2]; Self::CAPACITY],
            len: half.len(),
        };
        let mut i = 0;
        while i < half.len() {
            let [node, weight] = half[i];
            rule.pairs[i] = [[node, -node], [weight; 2]];
            i += 1;
        }
        rule
    }
}

pub(super) static TRIANGLE_4: TriangleRule = TriangleRule::expanded(&DEGREE_4);
pub(super) static TRIANGLE_5: TriangleRule = TriangleRule::expanded(&DEGREE_5);
pub(super) static TRIANGLE_7: TriangleRule = TriangleRule::expanded(&DEGREE_7);
pub(super) static TRIANGLE_8: TriangleRule = TriangleRule::expanded(&DEGREE_8);
pub(super) static TRIANGLE_12: TriangleRule = TriangleRule::expanded(&DEGREE_12);
pub(super) static TRIANGLE_17: TriangleRule = TriangleRule::expanded(&DEGREE_17);

pub(super) static EDGE_4: EdgeRule = EdgeRule::mirrored(&[
    [0.33998104358485626, 0.3260725774312731],
    [0.8611363115940526, 0.17392742256872692],
]);
pub(super) static EDGE_6: EdgeRule = EdgeRule::mirrored(&[
    [0.2386191860831969, 0.23395696728634552],
    [0.6612093864662645, 0.1803807865240693],
    [0.932469514203152, 0.08566224618958517],
]);
pub(super) static EDGE_8: EdgeRule = EdgeRule::mirrored(&[
    [0.1834346424956498, 0.181341891689181],
    [0.525532409916329, 0.15685332293894363],
    [0.7966664774136267, 0.11119051722668724],
    [0.9602898564975363, 0.05061426814518813],
]);
pub(super) static EDGE_10: EdgeRule = EdgeRule::mirrored(&[
    [0.14887433898163122, 0.14776211235737644],
    [0.4333953941292472, 0.13463335965499818],
    [0.6794095682990244, 0.10954318125799102],
    [0.8650633666889845, 0.0747256745752903],
    [0.9739065285171717, 0.03333567215434407],
]);

/// Degree 4, 6 points.
const DEGREE_4: Orbits = Orbits {
    medians: &[
        [0.4459484909159649, 0.22338158967801147],
        [0.09157621350977085, 0.10995174365532188],
    ],
    ..NONE
};

/// Degree 5, 7 points.
const DEGREE_5: Orbits = Orbits {
    centroid: 0.225,
    medians: &[
        [0.10128650732345633, 0.12593918054482717],
        [0.47014206410511505, 0.13239415278850616],
    ],
    ..NONE
};

/// Degree 7, 12 points, by K. Gatermann, "The construction of symmetric cubature formulas for the square and the triangle",
/// Computing 40 (1988).
const DEGREE_7: Orbits = Orbits {
    cyclic: &[
        [
            0.06238226509440212,
            0.06751786707391609,
            0.053034056314872506,
        ],
        [0.05522545665692661, 0.3215024938519818, 0.08776281742889211],
        [
            0.03432430294509715,
            0.6609491961867356,
            0.057550085569963175,
        ],
        [0.5158423343535917, 0.2777161669763918, 0.13498637401960556],
    ],
    ..NONE
};

/// Degree 8, 16 points.
const DEGREE_8: Orbits = Orbits {
    centroid: 0.1443156076777872,
    medians: &[
        [0.17056930775176027, 0.10321737053471824],
        [0.4592925882927231, 0.09509163426728463],
        [0.05054722831703107, 0.03245849762319808],
    ],
    general: &[[
        0.008394777409957675,
        0.26311282963463806,
        0.027230314174434996,
    ]],
    ..NONE
};

/// Degree 12, 33 points.
const DEGREE_12: Orbits = Orbits {
    medians: &[
        [0.27146250701492614, 0.06254121319590276],
        [0.10925782765935432, 0.02848605206887755],
        [0.4401116486585931, 0.04991833492806095],
        [0.4882037509455415, 0.024266838081452035],
        [0.02464636343633564, 0.007931642509973639],
    ],
    general: &[
        [0.1162960196779266, 0.25545422863851736, 0.04322736365941421],
        [
            0.021382490256170623,
            0.12727971723358936,
            0.015083677576511441,
        ],
        [
            0.023034156355267166,
            0.29165567973834094,
            0.02178358503860756,
        ],
    ],
    ..NONE
};

/// Degree 17, 60 points.
const DEGREE_17: Orbits = Orbits {
    medians: &[
        [0.4171034443615992, 0.027310926528102106],
        [0.18035811626637066, 0.026312630588017985],
        [0.2857065024365867, 0.03771623715279528],
        [0.06665406347959701, 0.012459000802305444],
        [0.014755491660754072, 0.002773887577637642],
        [0.46559787161889027, 0.02501945095049736],
    ],
    general: &[
        [
            0.011575175903180683,
            0.07250547079900238,
            0.004584348401735868,
        ],
        [
            0.013229672760086951,
            0.41547545929522905,
            0.010398439955839537,
        ],
        [
            0.013135870834002753,
            0.27179187005535477,
            0.008692214501001192,
        ],
        [
            0.15750547792686992,
            0.29921894247697034,
            0.02617162593533699,
        ],
        [
            0.06734937786736123,
            0.3062815917461865,
            0.022487772546691067,
        ],
        [
            0.07804234056828245,
            0.16872251349525944,
            0.02055789832045452,
        ],
        [
            0.016017642362119337,
            0.15919228747279268,
            0.007978300205929593,
        ],
    ],
    ..NONE
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of 60 products below 1.
    const ROUND_OFF: f64 = 1e-15;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    fn triangle_integral(rule: &TriangleRule, [a, b]: [i32; 2]) -> f64 {
        let lane =
            |pair: &PointPair, i: usize| pair[2][i] * pair[0][i].powi(a) * pair[1][i].powi(b);
        let pairs = rule.pairs().iter();
        pairs.map(|pair| lane(pair, 0) + lane(pair, 1)).sum()
    }

    #[test]
    fn triangle_rules_are_exact_up_to_their_degree() {
        for (degree, rule) in [
            (4, &TRIANGLE_4),
            (5, &TRIANGLE_5),
            (7, &TRIANGLE_7),
            (8, &TRIANGLE_8),
            (12, &TRIANGLE_12),
            (17, &TRIANGLE_17),
        ] {
            for a in 0..=degree {
                for b in 0..=degree - a {
                    let exact = 2.0 * factorial(a) * factorial(b) / factorial(a + b + 2);
                    let error = triangle_integral(rule, [a, b]) - exact;
                    assert!(error.abs() < ROUND_OFF, "{degree}: {a} {b}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn points_are_inside_and_weights_are_positive() {
        for rule in [
            &TRIANGLE_4,
            &TRIANGLE_5,
            &TRIANGLE_7,
            &TRIANGLE_8,
            &TRIANGLE_12,
            &TRIANGLE_17,
        ] {
            for pair in rule.pairs() {
                for [b, c, weight] in [0, 1].map(|lane| pair.map(|numbers| numbers[lane])) {
                    let is_filler = b == 0.0 && c == 0.0 && weight == 0.0;
                    assert!(is_filler || b.min(c).min(1.0 - b - c).min(weight) > 0.0);
                }
            }
        }
    }

    #[test]
    fn edge_rules_are_exact_to_twice_their_points() {
        for (count, rule) in [(4, &EDGE_4), (6, &EDGE_6), (8, &EDGE_8), (10, &EDGE_10)] {
            assert_eq!(2 * rule.pairs().len(), count);
            for power in 0..i32::try_from(2 * count).unwrap() {
                let exact = f64::from((power + 1) % 2) / f64::from(power + 1);
                let lane = |[x, w]: &[[f64; 2]; 2], i: usize| w[i] * x[i].powi(power);
                let pairs = rule.pairs().iter();
                let integral: f64 = pairs.map(|pair| lane(pair, 0) + lane(pair, 1)).sum();
                let error = integral - exact;
                assert!(error.abs() < ROUND_OFF, "{count}: {power}: {error:e}");
            }
        }
    }
}
