//! Contact surfaces as arrays.

use crate::arrays::{array, check_kept, finite, real, signed, whole_array, wrong_shape};
use hydroelastic::contact::ContactSurface;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

type Floats = Py<PyArrayDyn<f64>>;
type Indices = Py<PyArrayDyn<i64>>;

/// Contact surface in the world frame: m polygons with k corners together.
///
/// Polygon i has the corners offsets[i] to offsets[i + 1] - 1, counter-clockwise about its normal. The normal points out of B into A. The
/// parameters of the constructor are the attributes. The pressure is linear in a polygon. If B is rigid, the polygons lie on the surface
/// of B, its sides included: for the image of a sensor, project them onto the face and select them by their normals.
///
/// Raises
/// ------
/// HydroelasticError
///     If an array has an unexpected shape, or a number is not finite.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Surface {
    /// Positions (m) of the corners, (k, 3) float64.
    vertices: Floats,
    /// Index of the first corner of each polygon, then k, (m + 1,) int64.
    offsets: Indices,
    /// Pressure (Pa) at each corner, (k,) float64.
    pressures: Floats,
    /// Unit normal of each polygon, (m, 3) float64.
    normals: Floats,
    /// Area (m²) of each polygon, (m,) float64.
    areas: Floats,
    /// Centroid (m) of each polygon, (m, 3) float64.
    centroids: Floats,
    /// Mean pressure (Pa) of each polygon, (m,) float64.
    mean_pressures: Floats,
    /// Indices of the tetrahedra of A and B that contain each polygon, (m, 2) int64.
    tets: Indices,
    /// Total area (m²).
    area: f64,
    /// Center of pressure (m), (3,) float64; None if the surface is empty or has no pressure.
    center_of_pressure: Option<Floats>,
}

impl Surface {
    /// Converts a surface of the library.
    pub fn of(py: Python<'_>, surface: &ContactSurface) -> PyResult<Self> {
        let polygons = &surface.polygons;
        let (mut vertices, mut pressures, mut offsets) = (vec![], vec![], vec![0]);
        for polygon in polygons {
            for corner in polygon.outline.corners() {
                vertices.extend(corner.iter().copied());
                pressures.push(polygon.pressure_at(corner));
            }
            offsets.push(pressures.len());
        }
        let (count, corners) = (polygons.len(), pressures.len());
        let floats =
            |values: Vec<f64>, shape: &[usize]| array(py, values, shape).map(Bound::unbind);
        let whole =
            |values: Vec<i64>, shape: &[usize]| whole_array(py, values, shape).map(Bound::unbind);
        let center = surface.center_of_pressure();
        Ok(Self {
            vertices: floats(vertices, &[corners, 3])?,
            offsets: whole(signed(offsets), &[count + 1])?,
            pressures: floats(pressures, &[corners])?,
            normals: floats(
                polygons
                    .iter()
                    .flat_map(|p| p.normal.iter().copied())
                    .collect(),
                &[count, 3],
            )?,
            areas: floats(polygons.iter().map(|p| p.area).collect(), &[count])?,
            centroids: floats(
                polygons
                    .iter()
                    .flat_map(|p| p.centroid.iter().copied())
                    .collect(),
                &[count, 3],
            )?,
            mean_pressures: floats(polygons.iter().map(|p| p.pressure).collect(), &[count])?,
            tets: whole(signed(polygons.iter().flat_map(|p| p.tets)), &[count, 2])?,
            area: surface.area(),
            center_of_pressure: center
                .map(|point| floats(point.as_slice().to_vec(), &[3]))
                .transpose()?,
        })
    }

    fn count(&self, py: Python<'_>) -> usize {
        self.tets.bind(py).shape()[0]
    }
}

#[pymethods]
impl Surface {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: Floats,
        offsets: Indices,
        pressures: Floats,
        normals: Floats,
        areas: Floats,
        centroids: Floats,
        mean_pressures: Floats,
        tets: Indices,
        #[pyo3(from_py_with = real)] area: f64,
        center_of_pressure: Option<Floats>,
    ) -> PyResult<Self> {
        check_kept(
            py,
            &[
                (&vertices, "vertices", &["k", "3"]),
                (&pressures, "pressures", &["k"]),
                (&normals, "normals", &["m", "3"]),
                (&areas, "areas", &["m"]),
                (&centroids, "centroids", &["m", "3"]),
                (&mean_pressures, "mean_pressures", &["m"]),
            ],
        )?;
        let count = areas.bind(py).shape()[0];
        for (array, name, expected) in [
            (&offsets, "offsets", &[count + 1][..]),
            (&tets, "tets", &[count, 2][..]),
        ] {
            let shape = array.bind(py).shape();
            if shape != expected {
                return Err(wrong_shape(name, &format!("{expected:?}"), shape));
            }
        }
        finite(area, "area")?;
        if let Some(point) = &center_of_pressure {
            check_kept(py, &[(point, "center_of_pressure", &["3"])])?;
        }
        Ok(Self {
            vertices,
            offsets,
            pressures,
            normals,
            areas,
            centroids,
            mean_pressures,
            tets,
            area,
            center_of_pressure,
        })
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.count(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("Surface({} polygons, {:.4e} m²)", self.count(py), self.area)
    }
    fn __getnewargs__(
        &self,
        py: Python<'_>,
    ) -> (
        Floats,
        Indices,
        Floats,
        Floats,
        Floats,
        Floats,
        Floats,
        Indices,
        f64,
        Option<Floats>,
    ) {
        let center = self.center_of_pressure.as_ref();
        (
            self.vertices.clone_ref(py),
            self.offsets.clone_ref(py),
            self.pressures.clone_ref(py),
            self.normals.clone_ref(py),
            self.areas.clone_ref(py),
            self.centroids.clone_ref(py),
            self.mean_pressures.clone_ref(py),
            self.tets.clone_ref(py),
            self.area,
            center.map(|point| point.clone_ref(py)),
        )
    }
}
