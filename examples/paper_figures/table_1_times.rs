//! The times (s) of Table I, by order of the icospheres.

/// A row of the table.
pub struct Row {
    pub name: &'static str,
    /// The paper's Julia program on its authors' machine, orders 1 to 3: its Table I.
    pub paper: &'static [f64],
    /// This library, orders 1 to 4: `cargo bench --bench ablation`, the run in docs/dev/measurements.md.
    pub ours: &'static [f64],
}

pub const ROWS: [Row; 6] = [
    Row {
        name: "(a) all pairs",
        paper: &[0.263, 3.77, 58.16],
        ours: &[445e-6, 8.79e-3, 136e-3, 1.65],
    },
    Row {
        name: "(b) + bounding boxes",
        paper: &[0.077, 0.957, 14.52],
        ours: &[216e-6, 2.51e-3, 32.9e-3, 498e-3],
    },
    Row {
        name: "(c) + plane check",
        paper: &[0.071, 0.943, 13.71],
        ours: &[196e-6, 2.34e-3, 32.0e-3, 494e-3],
    },
    Row {
        name: "(d) + R*-tree",
        paper: &[0.041, 0.445, 5.30],
        ours: &[161e-6, 1.63e-3, 21.7e-3, 315e-3],
    },
    Row {
        name: "(e) + projections",
        paper: &[0.036, 0.368, 3.82],
        ours: &[127e-6, 1.01e-3, 11.3e-3, 145e-3],
    },
    Row {
        name: "(f) following",
        paper: &[],
        ours: &[50.2e-6, 156e-6, 605e-6, 2.75e-3],
    },
];

/// Every optimization pays at every order, in both programs.
pub fn check_rows() {
    for pair in ROWS.windows(2) {
        let both = [(pair[0].paper, pair[1].paper), (pair[0].ours, pair[1].ours)];
        for (slower, faster) in both {
            assert!(slower.iter().zip(faster).all(|(slow, fast)| fast < slow));
        }
    }
}
