use super::polygon::CutPolygon;
use crate::geometry::ConvexPolygon;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// The part of the contact surface in one pair of tetrahedra, in the world frame.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ContactPolygon<T = f64> {
    /// The tetrahedra it lies in, of A and of B. For one of B stands the triangle of a rigid body, or 0 for a half-space.
    pub tets: [usize; 2],
    /// Its corners (m), counter-clockwise about the normal.
    pub outline: ConvexPolygon<T>,
    /// Unit normal, out of B into A.
    pub normal: Vector3<T>,
    /// Area (m²), positive: that of the outline, or half of it where the polygon lies in a face of a tetrahedron; where
    /// the face is shared, the polygon of the tetrahedron beyond it has the other half.
    pub area: T,
    /// Centroid (m).
    pub centroid: Vector3<T>,
    /// Mean pressure (Pa): the pressure at the centroid.
    pub pressure: T,
    /// Gradient (Pa/m) of the pressure of the body whose field is the flatter there; along the polygon, the
    /// other's is the same.
    pub pressure_gradient: Vector3<T>,
    /// The point (m) through which the polygon's force acts: ∫ p x dA / ∫ p dA; the centroid where the force rounds to 0.
    pub center_of_pressure: Vector3<T>,
}

/// The contact surface of a body pair, in the world frame: empty where the bodies do not touch.
#[derive(Debug, Clone)]
pub struct ContactSurface<T = f64> {
    /// The polygons, one for each pair of tetrahedra that touch.
    pub polygons: Vec<ContactPolygon<T>>,
}

impl<T: Scalar> ContactPolygon<T> {
    pub(super) fn of(tets: [usize; 2], polygon: &CutPolygon<T>, pose_wa: &Pose<T>) -> Self {
        let moments = &polygon.moments;
        let centroid = moments.centroid();
        let pressure = polygon.pressure.at(&centroid);
        let gradient = &polygon.pressure.gradient;
        // About the centroid c: ∫ p (x − c) dA = (∫ (x − c)(x − c)ᵀ dA)·∇p.
        let offset = moments.first / moments.area;
        let moment = moments.second * gradient - offset * moments.first.dot(gradient);
        let area = moments.area * lift::<T>(polygon.weights.still.area());
        // May round to 0 where neither factor does.
        let load = pressure * moments.area;
        let center_of_pressure = if real_part(load) > 0.0 {
            centroid + moment / load
        } else {
            centroid
        };
        Self {
            tets,
            outline: polygon.polygon.transformed(pose_wa),
            normal: pose_wa.rotation() * polygon.plane.normal,
            area,
            centroid: pose_wa.transformed_point(&centroid),
            pressure,
            pressure_gradient: pose_wa.rotation() * gradient,
            center_of_pressure: pose_wa.transformed_point(&center_of_pressure),
        }
    }

    /// Pressure (Pa) at a point of the polygon (m, world frame).
    #[must_use]
    pub fn pressure_at(&self, point: &Vector3<T>) -> T {
        self.pressure + self.pressure_gradient.dot(&(point - self.centroid))
    }

    /// The force on A (N): ∫ p n dA.
    #[must_use]
    pub fn force(&self) -> Vector3<T> {
        self.normal * (self.pressure * self.area)
    }
}

impl<T: Scalar> ContactSurface<T> {
    /// Whether the bodies do not touch.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// Total area (m²).
    #[must_use]
    pub fn area(&self) -> T {
        self.sum(|polygon| polygon.area)
    }

    /// The pressure-weighted mean position (m), or `None` where nothing presses.
    #[must_use]
    pub fn center_of_pressure(&self) -> Option<Vector3<T>> {
        let total = self.sum(|polygon| polygon.pressure * polygon.area);
        (real_part(total) > 0.0).then(|| {
            let zero = Vector3::from_element(lift(0.0));
            let weighted = self.polygons.iter().fold(zero, |sum, polygon| {
                sum + polygon.center_of_pressure * (polygon.pressure * polygon.area)
            });
            weighted / total
        })
    }

    fn sum(&self, term: impl Fn(&ContactPolygon<T>) -> T) -> T {
        self.polygons.iter().map(term).sum()
    }
}
