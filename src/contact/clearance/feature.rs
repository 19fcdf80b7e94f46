use crate::broad_phase::SurfaceFace;
use crate::contact_shape::PartnerShape;
use crate::geometry::{FACES, TrianglePart};
use nalgebra::Vector3;

/// Part of a body that determines a [clearance](super::Clearance). Vertex indices refer to the vertices of the mesh of a compliant body, or
/// of the surface of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// A vertex.
    Vertex(usize),
    /// The edge between two vertices, of which the first has the smaller index.
    Edge([usize; 2]),
    /// A triangle of the boundary surface, by its vertices in counter-clockwise order as seen from outside.
    Face([usize; 3]),
    /// The plane of a half-space.
    Plane,
    /// The tetrahedron of a compliant body, or the triangle of a rigid body, at the deepest point of overlapping bodies.
    Cell(usize),
}

impl Feature {
    /// Creates the feature for a part of a triangle of the surface.
    pub(super) fn of_face(shape: PartnerShape, face: SurfaceFace, part: TrianglePart) -> Self {
        let corners = shape.corner_vertices(face.tet());
        // Only the apex behind a triangle has no vertex. No face of the surface contains the apex.
        let vertices = FACES[face.face()].map(|corner| corners[corner].unwrap_or_default());
        match part {
            TrianglePart::Corner(corner) => Self::Vertex(vertices[corner]),
            TrianglePart::Edge(edge) => {
                let ends = [vertices[edge], vertices[(edge + 1) % 3]];
                Self::Edge([ends[0].min(ends[1]), ends[0].max(ends[1])])
            }
            TrianglePart::Interior => Self::Face(vertices),
        }
    }

    /// Returns the vertices of the feature.
    pub(super) fn vertices(&self) -> &[usize] {
        match self {
            Self::Vertex(vertex) => std::slice::from_ref(vertex),
            Self::Edge(ends) => ends,
            Self::Face(corners) => corners,
            Self::Plane | Self::Cell(_) => &[],
        }
    }

    /// Returns the positions of the vertices (m), in the frame of the body.
    pub(super) fn points(&self, shape: PartnerShape) -> Vec<Vector3<f64>> {
        let points = match shape {
            PartnerShape::Compliant(shape) => shape.field().mesh().vertices(),
            PartnerShape::Rigid(shape) => shape.surface().vertices(),
            PartnerShape::HalfSpace(_) => &[],
        };
        self.vertices()
            .iter()
            .map(|&vertex| points[vertex])
            .collect()
    }
}
