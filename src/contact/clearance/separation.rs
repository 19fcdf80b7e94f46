use crate::scalar::{Scalar, lift, lift_vector, norm, real_part, real_vector};
use nalgebra::Vector3;

/// Squared sine of the angle between two edges below which their common normal is ill-conditioned. The rounding error of the normal is then
/// above 1e-12.
const PARALLEL: f64 = 1e-8;

/// Distance between two features, and their closest points.
#[derive(Clone, Copy)]
pub(super) struct Separation<T> {
    /// Distance (m). Because of round-off, it may be negative if the features touch.
    pub distance: T,
    /// Closest points (m).
    pub points: [Vector3<T>; 2],
}

impl<T: Scalar> Separation<T> {
    /// Computes the distance between two features from their vertices (m). One feature is a vertex, or both are edges. If the features
    /// touch, `touching` is the direction from the first feature to the second. It need not be perpendicular to an edge. The distance is
    /// negative if the features have passed each other.
    pub fn between(a: &[Vector3<T>], b: &[Vector3<T>], touching: Option<&Vector3<f64>>) -> Self {
        match (a, b) {
            ([vertex], [_, _, _]) => Self::above_face(vertex, b).unsigned(touching),
            ([_, _, _], [vertex]) => Self::above_face(vertex, a).unsigned(touching).reversed(),
            ([_, _], [_, _]) => Self::between_edges(a, b, touching),
            ([vertex], [start, end]) => {
                let normal = touching.map(|normal| beside(normal, &(end - start)));
                Self::along([*vertex, foot_on_edge(vertex, b)], normal)
            }
            ([start, end], [vertex]) => {
                let normal = touching.map(|normal| beside(normal, &(end - start)));
                Self::along([foot_on_edge(vertex, a), *vertex], normal)
            }
            _ => Self::along([a[0], b[0]], touching.map(unit)),
        }
    }

    /// Computes the height of a vertex above the plane of a face. The height is positive outside of the body.
    pub fn above_face(vertex: &Vector3<T>, face: &[Vector3<T>]) -> Self {
        let normal = (face[1] - face[0]).cross(&(face[2] - face[0]));
        let normal = normal / norm(&normal);
        let height = normal.dot(&(vertex - face[0]));
        Self {
            distance: height,
            points: [*vertex, vertex - normal * height],
        }
    }

    /// Returns the separation with a distance that is not negative, unless the features touch.
    fn unsigned(self, touching: Option<&Vector3<f64>>) -> Self {
        let is_behind = touching.is_none() && real_part(self.distance) < 0.0;
        Self {
            distance: if is_behind {
                -self.distance
            } else {
                self.distance
            },
            ..self
        }
    }

    /// Computes the distance between two edges along their common normal. The closest points lie between the ends of the edges.
    fn between_edges(a: &[Vector3<T>], b: &[Vector3<T>], touching: Option<&Vector3<f64>>) -> Self {
        let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
        let across = along_a.cross(&along_b);
        let square = across.dot(&across);
        let share = |along: &Vector3<T>| between.cross(along).dot(&across) / square;
        let points = [
            a[0] + along_a * share(&along_b),
            b[0] + along_b * share(&along_a),
        ];
        let lengths = along_a.dot(&along_a) * along_b.dot(&along_b);
        if real_part(square) < PARALLEL * real_part(lengths) {
            let normal = touching.map(|normal| beside(normal, &along_a));
            return Self::along(points, normal);
        }
        let distance = across.dot(&between) / square.sqrt();
        let is_outward = match touching {
            Some(normal) => real_vector(&across).dot(normal) >= 0.0,
            None => real_part(distance) >= 0.0,
        };
        Self {
            distance: if is_outward { distance } else { -distance },
            points,
        }
    }

    /// Computes the distance between two points. If the points touch, `normal` is the direction of the distance.
    fn along(points: [Vector3<T>; 2], normal: Option<Vector3<f64>>) -> Self {
        let between = points[1] - points[0];
        let distance = match normal {
            Some(normal) => between.dot(&lift_vector(&normal)),
            None => norm(&between),
        };
        Self { distance, points }
    }

    fn reversed(self) -> Self {
        let [a, b] = self.points;
        Self {
            points: [b, a],
            ..self
        }
    }

    /// Computes the height of a vertex above the plane z = 0.
    pub fn above_plane(vertex: Vector3<T>) -> Self {
        Self {
            distance: vertex.z,
            points: [vertex, Vector3::new(vertex.x, vertex.y, lift(0.0))],
        }
    }
}

fn foot_on_edge<T: Scalar>(vertex: &Vector3<T>, edge: &[Vector3<T>]) -> Vector3<T> {
    let (start, along) = (edge[0], edge[1] - edge[0]);
    start + along * ((vertex - start).dot(&along) / along.dot(&along))
}

/// Returns the unit vector along the component of a normal that is perpendicular to an edge. It is zero if the normal is along the edge.
fn beside<T: Scalar>(normal: &Vector3<f64>, edge: &Vector3<T>) -> Vector3<f64> {
    let along = real_vector(edge).normalize();
    let beside = normal - along * along.dot(normal);
    unit(&beside)
}

/// Returns the unit vector along a vector, or zero if the vector has the size of round-off.
pub(super) fn unit(vector: &Vector3<f64>) -> Vector3<f64> {
    vector.try_normalize(f64::EPSILON).unwrap_or_default()
}
