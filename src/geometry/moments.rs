use crate::scalar::{Scalar, lift};
use nalgebra::{Matrix3, Vector3};

/// Area of a planar polygon and its first and second moments about a reference point near it.
///
/// With y = x − reference, the moments integrate every polynomial of degree two over the polygon
/// exactly: the contact wrench and its Jacobian need no more.
#[derive(Debug, Clone, Copy)]
pub struct PolygonMoments<T = f64> {
    /// The point the moments are taken about (m).
    pub reference: Vector3<T>,
    /// ∫ dA (m²).
    pub area: T,
    /// ∫ y dA (m³).
    pub first: Vector3<T>,
    /// ∫ y yᵀ dA (m⁴).
    pub second: Matrix3<T>,
}

impl<T: Scalar> PolygonMoments<T> {
    /// The moments of nothing.
    #[must_use]
    pub fn zero(reference: Vector3<T>) -> Self {
        let zero = lift(0.0);
        Self {
            reference,
            area: zero,
            first: Vector3::from_element(zero),
            second: Matrix3::from_element(zero),
        }
    }

    /// Adds the triangle (reference, reference + b, reference + c). Its area is signed: positive
    /// where it turns counter-clockwise about `normal`. With signed areas a corner that round-off
    /// doubled or put out of place contributes what it should, in value and derivative.
    ///
    /// ∫ y yᵀ = area/12·(b bᵀ + c cᵀ + (b+c)(b+c)ᵀ): the rule of the three edge midpoints, exact
    /// to degree two, written out.
    pub(crate) fn add_triangle(&mut self, normal: &Vector3<T>, b: &Vector3<T>, c: &Vector3<T>) {
        let area = normal.dot(&b.cross(c)) * 0.5;
        let sum = b + c;
        self.area += area;
        self.first += sum * (area / 3.0);
        let weight = area / 12.0;
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let entry = (b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j]) * weight;
            self.second[(i, j)] += entry;
            if i != j {
                self.second[(j, i)] += entry;
            }
        }
    }

    /// Centroid (m): not finite for a polygon without area.
    #[must_use]
    pub fn centroid(&self) -> Vector3<T> {
        self.reference + self.first / self.area
    }

    /// ∫ x dA (m³), x from the origin of the frame.
    #[must_use]
    pub fn first_about_origin(&self) -> Vector3<T> {
        self.reference * self.area + self.first
    }

    /// ∫ x xᵀ dA (m⁴), x from the origin of the frame.
    #[must_use]
    pub fn second_about_origin(&self) -> Matrix3<T> {
        let (r, first) = (&self.reference, &self.first);
        Matrix3::from_fn(|i, j| {
            self.second[(i, j)] + r[i] * first[j] + first[i] * r[j] + r[i] * r[j] * self.area
        })
    }
}
