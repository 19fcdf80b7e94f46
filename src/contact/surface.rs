use super::plane_polygon::{PlanePolygon, SpacePolygon};
use crate::geometry::ConvexPolygon;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// The part of the contact surface in one pair of tetrahedra, in the world frame.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ContactPolygon<T = f64> {
    /// Indices of the tetrahedra of A and of B that contain the polygon. If B is rigid, the second index is a triangle of its surface. If B
    /// is a half-space, the second index is 0.
    pub tets: [usize; 2],
    /// Corners (m), counter-clockwise about the normal.
    pub outline: ConvexPolygon<T>,
    /// Unit normal, out of B into A.
    pub normal: Vector3<T>,
    /// Area (m²), positive: the area of the outline, or half of it if the polygon lies in a face of a tetrahedron. If two tetrahedra share
    /// the face, each has a polygon with half of the area.
    pub area: T,
    /// Centroid (m).
    pub centroid: Vector3<T>,
    /// Mean pressure (Pa): the pressure at the centroid.
    pub pressure: T,
    /// Pressure gradient (Pa/m) of the body with the flatter field there. Along the polygon, both gradients are equal.
    pub pressure_gradient: Vector3<T>,
    /// Point (m) through which the polygon's force acts: ∫ p x dA / ∫ p dA, or the centroid if the force rounds to zero.
    pub center_of_pressure: Vector3<T>,
}

/// The contact surface of a body pair, in the world frame. It is empty if the bodies do not touch.
#[derive(Debug, Clone)]
pub struct ContactSurface<T = f64> {
    /// The polygons, one for each pair of tetrahedra that touch.
    pub polygons: Vec<ContactPolygon<T>>,
}

impl<T: Scalar> ContactPolygon<T> {
    pub(super) fn of(
        tets: [usize; 2],
        (polygon, in_plane): (&SpacePolygon<T>, &PlanePolygon<T>),
        pose_wa: &Pose<T>,
    ) -> Self {
        let [area, y1, y2, y11, y12, y22] = in_plane.plane.moments;
        let [p0, p1, p2] = in_plane.plane.pressure;
        let [c1, c2] = [y1 / area, y2 / area];
        let pressure = p0 + p1 * c1 + p2 * c2;
        // The product may round to zero even if both factors are positive.
        let load = pressure * area;
        let center_of_pressure = if real_part(load) > 0.0 {
            // About the centroid c: ∫ p (y − c) dA = (∫ (y − c)(y − c)ᵀ dA)·∇p.
            let (y11, y12, y22) = (y11 - c1 * y1, y12 - c1 * y2, y22 - c2 * y2);
            [
                c1 + (y11 * p1 + y12 * p2) / load,
                c2 + (y12 * p1 + y22 * p2) / load,
            ]
        } else {
            [c1, c2]
        };
        let in_world = |y: [T; 2]| pose_wa.transformed_point(&in_plane.point(y));
        Self {
            tets,
            outline: polygon.outline.transformed(pose_wa),
            normal: pose_wa.rotation() * polygon.plane.normal,
            area: area * lift::<T>(in_plane.weights.still.area()),
            centroid: in_world([c1, c2]),
            pressure,
            pressure_gradient: pose_wa.rotation() * polygon.pressure.gradient,
            center_of_pressure: in_world(center_of_pressure),
        }
    }

    /// Returns the pressure (Pa) at a point of the polygon (m, world frame).
    #[must_use]
    pub fn pressure_at(&self, point: &Vector3<T>) -> T {
        self.pressure + self.pressure_gradient.dot(&(point - self.centroid))
    }

    /// Returns the force on A (N): ∫ p n dA.
    #[must_use]
    pub fn force(&self) -> Vector3<T> {
        self.normal * (self.pressure * self.area)
    }
}

impl<T: Scalar> ContactSurface<T> {
    /// Returns whether the bodies do not touch.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// Returns the total area (m²).
    #[must_use]
    pub fn area(&self) -> T {
        self.sum(|polygon| polygon.area)
    }

    /// Returns the pressure-weighted mean position (m), or `None` if there is no pressure.
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
