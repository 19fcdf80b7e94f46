//! Contact surfaces as arrays.

use crate::arrays::{array, check_kept, finite, real, signed, whole_array, wrong_shape};
use hydroelastic::contact::ContactSurface;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

type Floats = Py<PyArrayDyn<f64>>;
type Whole = Py<PyArrayDyn<i64>>;

/// A contact surface in the world frame: m polygons, their k corners one after another. Polygon i has the corners
/// offsets[i] to offsets[i + 1], counter-clockwise about its normal, which points out of B into A.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Surface {
    /// (k, 3) float64: the corners (m).
    vertices: Floats,
    /// (m + 1,) int64: where the corners of each polygon begin.
    offsets: Whole,
    /// (k,) float64: the pressure (Pa) at each corner.
    pressures: Floats,
    /// (m, 3) float64: unit normals.
    normals: Floats,
    /// (m,) float64: areas (m²).
    areas: Floats,
    /// (m, 3) float64: centroids (m).
    centroids: Floats,
    /// (m,) float64: the mean pressure (Pa) of each polygon.
    mean_pressures: Floats,
    /// (m, 2) int64: the tetrahedra that each polygon lies in, of A and of B.
    tets: Whole,
    /// Total area (m²).
    area: f64,
    /// (3,) float64: the center of pressure (m), or None where nothing presses.
    center_of_pressure: Option<Floats>,
}

impl Surface {
    /// The arrays of a surface.
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
        offsets: Whole,
        pressures: Floats,
        normals: Floats,
        areas: Floats,
        centroids: Floats,
        mean_pressures: Floats,
        tets: Whole,
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
        Whole,
        Floats,
        Floats,
        Floats,
        Floats,
        Floats,
        Whole,
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
