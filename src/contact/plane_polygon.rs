use super::outline::Outline;
use super::polygon_fields::PolygonFields;
use crate::geometry::{AffineField, ConvexPolygon};
use crate::narrow_phase::{EquilibriumPlane, Octet, Weights};
use crate::scalar::{Scalar, change, lift, lift_vector, real_part, real_vector};
use nalgebra::Vector3;

/// A polygon is a sliver if its area is less than this fraction of its length squared. The centroid of a sliver is round-off.
const SLIVER: f64 = 1e-9;

/// A contact polygon in coordinates y of its own plane.
#[derive(Clone)]
pub(super) struct PlanePolygon<T> {
    pub plane: PolygonFields<T>,
    pub outline: Outline<T>,
    /// Weights in values and in derivatives.
    pub weights: Weights,
    /// Whether an edge lies in several faces.
    pub shares_edges: bool,
}

/// A contact polygon in A's frame, and the fields that meet in it.
pub(super) struct SpacePolygon<T> {
    pub outline: ConvexPolygon<T>,
    pub plane: EquilibriumPlane<T>,
    pub pressure_a: AffineField<T>,
    /// Pressure on the polygon (Pa). The fields of both bodies are equal there. This is the field with the smaller gradient, which has
    /// smaller rounding errors, or A's field if B is rigid.
    pub pressure: AffineField<T>,
}

impl<T: Scalar> SpacePolygon<T> {
    /// Returns the polygon in its plane, or `None` if it has no corner.
    ///
    /// The only derivative of the origin is the motion of the plane along its normal.
    #[inline]
    pub fn in_plane(&self, weights: Weights) -> Option<PlanePolygon<T>> {
        let Self {
            plane, pressure, ..
        } = self;
        let constant = lift_vector::<T>(&self.center()?);
        let origin = constant - plane.normal * change(plane.height_at(&constant));
        let [e1, e2] = axes_beside(&plane.normal);
        let mut outline = Outline::empty();
        for (edge, corner) in (0..).zip(self.outline.corners()) {
            let y = corner - origin;
            outline.push([e1.dot(&y), e2.dot(&y)], edge);
        }
        let gradient = &pressure.gradient;
        Some(PlanePolygon {
            plane: PolygonFields {
                origin: origin.into(),
                axes: [e1, e2, plane.normal].map(Into::into),
                pressure: [pressure.at(&origin), e1.dot(gradient), e2.dot(gradient)],
                gradient_a: self.pressure_a.gradient.into(),
                slopes: plane.slopes.map(Into::into),
                inverse_gradient_norm: plane.inverse_gradient_norm,
                moments: outline.moments(),
            },
            outline,
            weights,
            shares_edges: self.outline.shares_edges(),
        })
    }

    /// Returns the centroid, or the first corner of a sliver, because its centroid is round-off.
    fn center(&self) -> Option<Vector3<f64>> {
        let corners = self.outline.corners();
        let first = real_vector(corners.first()?);
        let normal = real_vector(&self.plane.normal);
        let (mut area, mut moment, mut length_squared) = (0.0, Vector3::zeros(), 0.0_f64);
        let mut before = Vector3::zeros();
        for corner in &corners[1..] {
            let now = real_vector(corner) - first;
            let triangle = 0.5 * normal.dot(&before.cross(&now));
            area += triangle;
            moment += (before + now) * (triangle / 3.0);
            length_squared = length_squared.max(now.norm_squared());
            before = now;
        }
        Some(if area > SLIVER * length_squared {
            first + moment / area
        } else {
            first
        })
    }
}

impl<T: Scalar> PlanePolygon<T> {
    /// Returns whether the signed area is positive. If not, the polygon is round-off.
    pub fn has_area(&self) -> bool {
        real_part(self.plane.moments[0]) > 0.0
    }

    /// Returns whether the area of the polygon counts in values or in derivatives.
    pub fn has_counted_area(&self) -> bool {
        self.has_area() && self.weights.have_area()
    }

    /// Replaces the outline, and its moments.
    pub fn set_outline(&mut self, outline: &Outline<T>) {
        self.outline = *outline;
        self.plane.moments = outline.moments();
    }

    /// Returns ∫ m dA for the monomials m up to cubic ones.
    pub fn moments(&self) -> [T; 10] {
        let mut moments: [T; 10] = self.outline.moments();
        moments[..6].copy_from_slice(&self.plane.moments);
        moments
    }

    /// Returns whether faces of both bodies coincide at the polygon.
    pub fn is_flush(&self) -> bool {
        !self.weights.are_whole() || self.shares_edges
    }

    /// Returns the point (m) with these coordinates, in A's frame.
    pub fn point(&self, [y1, y2]: [T; 2]) -> Vector3<T> {
        let [e1, e2, _] = self.plane.axes.map(Vector3::from);
        Vector3::from(self.plane.origin) + e1 * y1 + e2 * y2
    }

    /// Returns the polygon at an index of an octet. All derivatives are zero.
    pub fn at(octet: &Octet, index: usize) -> Self {
        let mut outline = Outline::empty();
        let mut edge = 0;
        octet.visit_edges(index, |_, corner| {
            outline.push(corner.map(lift), edge);
            edge += 1;
        });
        Self {
            plane: PolygonFields::at(octet, index),
            outline,
            weights: Weights::WHOLE,
            shares_edges: false,
        }
    }
}

#[cfg(test)]
impl PlanePolygon<f64> {
    /// Returns the polygon as a constant: all derivatives are zero.
    fn lifted<T: Scalar>(&self) -> PlanePolygon<T> {
        let vector = |v: [f64; 3]| v.map(lift);
        PlanePolygon {
            plane: PolygonFields {
                origin: vector(self.plane.origin),
                axes: self.plane.axes.map(vector),
                pressure: vector(self.plane.pressure),
                gradient_a: vector(self.plane.gradient_a),
                slopes: self.plane.slopes.map(vector),
                inverse_gradient_norm: lift(self.plane.inverse_gradient_norm),
                moments: self.plane.moments.map(lift),
            },
            outline: self.outline.lifted(),
            weights: self.weights,
            shares_edges: self.shares_edges,
        }
    }

    /// Returns the part of the polygon with a positive pressure, in another scalar, with this pressure. The outline of the part is a
    /// constant, because the pressure is zero at its moving boundary.
    pub fn under_pressure<T: Scalar>(&self, pressure: [T; 3]) -> PlanePolygon<T> {
        let part = self.outline.cut(&pressure.map(real_part));
        let mut polygon = self.lifted();
        polygon.set_outline(&part.unwrap_or(self.outline).lifted());
        polygon.plane.pressure = pressure;
        polygon
    }
}

/// Returns unit vectors that make orthonormal axes with this unit vector as the third, without a square root \[Duff 2017\].
fn axes_beside<T: Scalar>(n: &Vector3<T>) -> [Vector3<T>; 2] {
    let sign = if real_part(n.z) >= 0.0 { 1.0 } else { -1.0 };
    let a = -(n.z + sign).recip();
    let b = n.x * n.y * a;
    [
        Vector3::new(n.x * n.x * a * sign + 1.0, b * sign, -n.x * sign),
        Vector3::new(b, n.y * n.y * a + sign, -n.y),
    ]
}
