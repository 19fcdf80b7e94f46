//! What is measured of one growth, and its exponent.

/// One growth: curves over the same axes.
pub struct Panel {
    pub title: &'static str,
    pub x_label: &'static str,
    pub y_label: &'static str,
    /// How a round value on the y axis is written.
    pub y_tick: fn(f64) -> String,
    pub curves: Vec<Curve>,
}

/// A cost over what it grows with.
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    /// Smaller x do not count in the fit: fixed costs still show there.
    pub fitted_from: f64,
    /// Or else a known law to compare with.
    pub is_measured: bool,
}

impl Curve {
    /// A measured curve without points.
    pub fn new(name: impl Into<String>, fitted_from: f64) -> Self {
        Self {
            name: name.into(),
            points: Vec::new(),
            fitted_from,
            is_measured: true,
        }
    }

    /// Adds a point, in the order of x.
    pub fn push(&mut self, x: f64, y: f64) {
        let place = self.points.partition_point(|point| point.0 < x);
        self.points.insert(place, (x, y));
    }

    /// The points that count in the fit.
    pub fn fitted(&self) -> &[(f64, f64)] {
        let first = self.points.partition_point(|(x, _)| *x < self.fitted_from);
        &self.points[first..]
    }

    /// The exponent k of y = c·xᵏ, by least squares in log-log.
    pub fn exponent(&self) -> f64 {
        let [center_x, center_y] = self.log_center();
        let (mut across, mut square) = (0.0, 0.0);
        for (x, y) in self.fitted() {
            across += (x.ln() - center_x) * (y.ln() - center_y);
            square += (x.ln() - center_x).powi(2);
        }
        across / square
    }

    /// The exponent with two decimals.
    pub fn exponent_text(&self) -> String {
        // Adding 0 takes the sign from −0.
        format!("{:.2}", (self.exponent() * 100.0).round() / 100.0 + 0.0)
    }

    /// The fitted y at an x.
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
