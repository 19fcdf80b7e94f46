//! Measurements of one kind of growth, and their exponent.

/// One kind of growth: curves over the same axes.
pub struct Panel {
    pub title: &'static str,
    pub x_label: &'static str,
    pub y_label: &'static str,
    /// Formats a round value of the y axis.
    pub y_tick: fn(f64) -> String,
    pub curves: Vec<Curve>,
}

/// Cost against the quantity with which it grows.
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Smallest x in the fit. At smaller x, fixed costs distort the exponent.
    pub fitted_from: f64,
    /// False for a known law, drawn for comparison.
    pub is_measured: bool,
}

impl Curve {
    /// Creates a measured curve without points.
    pub fn new(name: impl Into<String>, fitted_from: f64) -> Self {
        Self {
            name: name.into(),
            points: Vec::new(),
            fitted_from,
            is_measured: true,
        }
    }

    /// Adds a point. Points must be added in the order of x.
    pub fn push(&mut self, x: f64, y: f64) {
        let index = self.points.partition_point(|point| point.0 < x);
        self.points.insert(index, (x, y));
    }

    /// Returns the points in the fit.
    pub fn fitted(&self) -> &[(f64, f64)] {
        let first = self.points.partition_point(|(x, _)| *x < self.fitted_from);
        &self.points[first..]
    }

    /// Returns the exponent k of y = c·xᵏ, fitted by least squares in log-log coordinates.
    pub fn exponent(&self) -> f64 {
        let [center_x, center_y] = self.log_center();
        let (mut across, mut square) = (0.0, 0.0);
        for (x, y) in self.fitted() {
            across += (x.ln() - center_x) * (y.ln() - center_y);
            square += (x.ln() - center_x).powi(2);
        }
        across / square
    }

    /// Returns the exponent with two decimals.
    pub fn exponent_text(&self) -> String {
        // Adding 0 turns −0 into 0.
        format!("{:.2}", (self.exponent() * 100.0).round() / 100.0 + 0.0)
    }

    /// Returns the fitted y at an x.
    pub fn fit_at(&self, x: f64) -> f64 {
        let [center_x, center_y] = self.log_center();
        (center_y + self.exponent() * (x.ln() - center_x)).exp()
    }

    fn log_center(&self) -> [f64; 2] {
        let points = self.fitted();
        let mean = |sum: f64| sum / points.len() as f64;
        [
            mean(points.iter().map(|(x, _)| x.ln()).sum()),
            mean(points.iter().map(|(_, y)| y.ln()).sum()),
        ]
    }
}
