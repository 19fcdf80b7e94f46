use super::cross_section::CrossSection;
use super::{DISTANCE_ERROR, check_resolution};
use crate::mesh::{MeshError, PressureField, ShapeRates, TetMesh};
use crate::scalar::portable::sin_cos;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Smallest and largest number of segments of a solid of revolution.
const SEGMENTS: [usize; 2] = [3, 10_000];

/// Creates a solid of revolution: a profile of points (radius, height) (m) that is turned about the z axis in `segments` steps.
///
/// A profile whose first and last points have the radius 0 makes a solid that meets the axis, such as a cup or a bottle. A profile whose
/// radii are all positive is closed from its last point to its first, and makes a ring. The points may be in either order.
///
/// The extent is the distance to the surface over the largest distance. Edges of the profile's cross-section are at most about the
/// `resolution` (m). The mesh is then refined until the interpolated distance has a mean error of at most 0.5 %, as in
/// [`PressureField::from_distance_within`].
///
/// ```
/// use hydroelastic::mesh::shapes;
///
/// // A cup with a wall and a bottom of 4 mm.
/// let profile = [[0.0, 0.0], [0.03, 0.0], [0.04, 0.1], [0.036, 0.1], [0.026, 0.004], [0.0, 0.004]];
/// let cup = shapes::lathe(&profile, 32, 0.01)?;
/// assert!((cup.mesh().volume() - 9.4e-5).abs() < 2e-6);
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// Returns an error if the profile is not a simple polygon of 3 to 2,000 finite points, if a radius is negative, or if only one end lies on
/// the axis. Also returns an error if there are fewer than 3 or more than 10,000 segments, or if the resolution is not positive or too
/// fine.
pub fn lathe(
    profile: &[[f64; 2]],
    segments: usize,
    resolution: f64,
) -> Result<PressureField, MeshError> {
    let solid = Turned::new(profile, segments, resolution)?;
    PressureField::from_distance_within(&solid.mesh()?, DISTANCE_ERROR, None)
}

/// Computes the rates of change of a [`lathe`] with respect to the radius and the height (m) of each point of the profile, in
/// order: radius and height of the first point, of the second point and so on.
///
/// The mesh keeps its tetrahedra. Points on the axis stay there, so the rates with respect to their radii are zero.
///
/// # Errors
/// Returns the errors of [`lathe`].
pub fn lathe_rates(
    profile: &[[f64; 2]],
    segments: usize,
    resolution: f64,
) -> Result<Vec<ShapeRates>, MeshError> {
    let solid = Turned::new(profile, segments, resolution)?;
    let (_, distances) =
        PressureField::linearized_from_distance_within(&solid.mesh()?, DISTANCE_ERROR, None)?;
    let coordinates = (0..profile.len()).flat_map(|point| [(point, 0), (point, 1)]);
    let rates = coordinates.map(|(point, axis)| {
        let mut outline = vec![Vector2::zeros(); profile.len()];
        if axis == 1 || profile[point][0] > 0.0 {
            outline[point][axis] = 1.0;
        }
        distances.rates(&solid.turned(&solid.section.extended(&outline)))
    });
    rates.collect()
}

/// A cross-section to be turned about the z axis.
struct Turned {
    section: CrossSection,
    segments: usize,
    /// The first vertex of each point of the cross-section.
    starts: Vec<usize>,
}

impl Turned {
    fn new(profile: &[[f64; 2]], segments: usize, resolution: f64) -> Result<Self, MeshError> {
        check_resolution("segments", segments, SEGMENTS)?;
        let is_open = check_radii(profile)?;
        let section = CrossSection::new(profile, is_open, resolution)?;
        let mut next = 0;
        let starts = section.points.iter().map(|point| {
            let start = next;
            next += if point.x > 0.0 { segments } else { 1 };
            start
        });
        let starts = starts.collect();
        Ok(Self {
            section,
            segments,
            starts,
        })
    }

    fn mesh(&self) -> Result<TetMesh, MeshError> {
        let points = &self.section.points;
        let vertex = |point: usize, step: usize| {
            let is_on_axis = points[point].x <= 0.0;
            self.starts[point] + if is_on_axis { 0 } else { step % self.segments }
        };
        let tets = self.section.swept(self.segments, vertex, |_| 1)?;
        TetMesh::new(self.turned(points), tets)
    }

    /// Returns the positions or velocities of all vertices, from those (radius, height) of the points of the cross-section.
    fn turned(&self, values: &[Vector2<f64>]) -> Vec<Vector3<f64>> {
        let turn = |step: usize| sin_cos(TAU * step as f64 / self.segments as f64);
        let turns: Vec<_> = (0..self.segments).map(turn).collect();
        let pairs = self.section.points.iter().zip(values);
        let vertices = pairs.flat_map(|(point, value)| {
            let steps = if point.x > 0.0 {
                &turns[..]
            } else {
                &turns[..1]
            };
            steps
                .iter()
                .map(move |(sine, cosine)| Vector3::new(value.x * cosine, value.x * sine, value.y))
        });
        vertices.collect()
    }
}

/// Checks the radii of a profile. Returns true if its first and last points lie on the axis.
fn check_radii(profile: &[[f64; 2]]) -> Result<bool, MeshError> {
    let ends = [0, profile.len().saturating_sub(1)];
    let is_on_axis = |point: usize| profile.get(point).is_some_and(|point| point[0] == 0.0);
    let is_open = ends.into_iter().all(is_on_axis);
    let is_wrong = |&(point, &[radius, _]): &(usize, &[f64; 2])| {
        radius.is_finite() && radius <= 0.0 && !(is_open && ends.contains(&point))
    };
    match profile.iter().enumerate().find(is_wrong) {
        Some((point, &[radius, _])) => Err(MeshError::ProfileRadius { point, radius }),
        None => Ok(is_open),
    }
}
