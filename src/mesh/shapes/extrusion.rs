use super::cross_section::CrossSection;
use super::{DISTANCE_ERROR, checked_lengths};
use crate::mesh::{MeshError, PressureField, ShapeRates, TetMesh};
use nalgebra::{Vector2, Vector3};

/// Largest number of layers of an extrusion.
const MOST_LAYERS: usize = 10_000;

/// Creates a prism along the z axis with a simple polygon (m) as its base. The polygon may be concave. The prism reaches from −`length`/2
/// to `length`/2.
///
/// The extent is the distance to the surface over the largest distance. Edges of the mesh are at most about the `resolution` (m) in the
/// base and along z. The mesh is then refined until the interpolated distance has a mean error of at most 0.5 %, as in
/// [`PressureField::from_distance_within`]. A coarse resolution suffices, because the refinement finds the kinks of the distance.
///
/// ```
/// use hydroelastic::mesh::shapes;
///
/// let angle = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.02], [0.02, 0.02], [0.02, 0.1], [0.0, 0.1]];
/// let iron = shapes::extrusion(&angle, 0.2, 0.02)?;
/// assert!((iron.mesh().volume() - 0.0036 * 0.2).abs() < 1e-15);
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// Returns an error if the polygon is not a simple polygon of 3 to 2,000 finite points, or if the length is not positive and finite. Also
/// returns an error if the resolution is not positive or too fine.
pub fn extrusion(
    polygon: &[[f64; 2]],
    length: f64,
    resolution: f64,
) -> Result<PressureField, MeshError> {
    let mesh = Layers::new(polygon, length, resolution)?.mesh()?;
    PressureField::from_distance_within(&mesh, DISTANCE_ERROR, None)
}

/// Computes the rates of change of an [`extrusion`] with respect to x and y (m) of each point of the polygon, in order, and
/// finally with respect to its length (m). The mesh keeps its tetrahedra.
///
/// # Errors
/// Returns the errors of [`extrusion`].
pub fn extrusion_rates(
    polygon: &[[f64; 2]],
    length: f64,
    resolution: f64,
) -> Result<Vec<ShapeRates>, MeshError> {
    let layers = Layers::new(polygon, length, resolution)?;
    let (_, distances) =
        PressureField::linearized_from_distance_within(&layers.mesh()?, DISTANCE_ERROR, None)?;
    let coordinates = (0..polygon.len()).flat_map(|point| [(point, 0), (point, 1)]);
    let by_points = coordinates.map(|(point, axis)| {
        let mut outline = vec![Vector2::zeros(); polygon.len()];
        outline[point][axis] = 1.0;
        layers.lifted(&layers.section.extended(&outline), 0.0)
    });
    let still = vec![Vector2::zeros(); layers.section.points.len()];
    let by_length = std::iter::once(layers.lifted(&still, 1.0));
    let velocities = by_points.chain(by_length);
    velocities
        .map(|velocities| distances.rates(&velocities))
        .collect()
}

/// A cross-section in parallel planes.
struct Layers {
    section: CrossSection,
    length: f64,
    /// Number of layers between the planes.
    count: usize,
}

impl Layers {
    fn new(polygon: &[[f64; 2]], length: f64, resolution: f64) -> Result<Self, MeshError> {
        let [length, resolution] =
            checked_lengths([("length", length), ("resolution", resolution)])?;
        let is_enough = |half: &usize| length / (2 * half) as f64 <= 1.001 * resolution;
        let Some(half) = (1..=MOST_LAYERS / 2).find(is_enough) else {
            return Err(MeshError::FineResolution {
                value: resolution,
                suggested: length / MOST_LAYERS as f64,
            });
        };
        Ok(Self {
            section: CrossSection::new(polygon, false, resolution)?,
            length,
            count: 2 * half,
        })
    }

    fn mesh(&self) -> Result<TetMesh, MeshError> {
        let points = &self.section.points;
        let vertex = |point: usize, plane: usize| plane * points.len() + point;
        // The inner points of the first and the last plane lie on the surface.
        let inner_side = |layer: usize| usize::from(layer + 1 < self.count);
        let tets = self.section.swept(self.count, vertex, inner_side)?;
        TetMesh::new(self.lifted(points, self.length), tets)
    }

    /// Returns the positions or velocities of all vertices, from those of the points of the cross-section and from the length or its
    /// rate.
    fn lifted(&self, values: &[Vector2<f64>], length: f64) -> Vec<Vector3<f64>> {
        let planes = 0..=self.count;
        let vertices = planes.flat_map(|plane| {
            let height = (plane as f64 / self.count as f64 - 0.5) * length;
            values
                .iter()
                .map(move |value| Vector3::new(value.x, value.y, height))
        });
        vertices.collect()
    }
}
