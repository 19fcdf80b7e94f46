//! Panels and curves of charts.

/// A line through points.
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Curves over common axes.
pub struct Panel {
    pub x_label: &'static str,
    pub y_label: &'static str,
    /// Whether the y axis is logarithmic.
    pub is_log: bool,
    pub curves: Vec<Curve>,
}

impl Curve {
    pub fn new(name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (name, points) = (name.to_owned(), points.into_iter().collect());
        Self { name, points }
    }

    /// Creates a curve against the numbers 0, 1, 2 …
    pub fn counted(name: &str, values: impl Iterator<Item = f64>) -> Self {
        Self::new(
            name,
            values
                .enumerate()
                .map(|(count, value)| (count as f64, value)),
        )
    }
}

impl Panel {
    /// Creates a logarithmic panel of positive numbers against a count, for example of iterations.
    pub fn counted(x_label: &'static str, curves: Vec<Curve>) -> Self {
        let (y_label, is_log) = ("", true);
        Self {
            x_label,
            y_label,
            is_log,
            curves,
        }
    }
}
