use nalgebra::DVector;

/// Coordinates of unknowns and nuisances, from which a fit can continue: see
/// [`Identification::resume`](super::Identification::resume).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Checkpoint {
    /// Index of the horizon. If it is the number of horizons, whole measurements are fitted. A larger index is an error.
    pub horizon: usize,
    /// Coordinates of the unknowns: see [`Unknown`](super::Unknown).
    pub unknowns: DVector<f64>,
    /// Coordinates of the nuisances of each measurement.
    pub nuisances: Vec<DVector<f64>>,
}

impl Checkpoint {
    /// Coordinates of the unknowns and of the nuisances of one measurement.
    pub(super) fn of(&self, measurement: usize) -> [&DVector<f64>; 2] {
        [&self.unknowns, &self.nuisances[measurement]]
    }
}

/// Progress of a fit, at the beginning of an iteration.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Iteration {
    /// Number of iterations before this iteration, over all horizons.
    pub index: usize,
    /// Horizon (s), or infinity for whole measurements.
    pub horizon: f64,
    /// Cost, in units of ½χ².
    pub cost: f64,
    /// Values of the unknowns, in the units of their parameters.
    pub values: Vec<f64>,
    /// Coordinates, from which a fit can continue.
    pub checkpoint: Checkpoint,
}
