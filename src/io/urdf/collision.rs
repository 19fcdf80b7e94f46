use super::element::Element;
use super::origin::origin_of;
use super::{Location, UrdfError};
use crate::spatial::Pose;

/// Shape of a link for contact.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Collision {
    /// Pose of the geometry in the link frame.
    pub origin: Pose,
    /// Geometry.
    pub geometry: Geometry,
    /// Place of the geometry in the file.
    pub at: Location,
}

/// Geometry of a [`Collision`], around the origin of its frame.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// Box.
    Box {
        /// Lengths of the edges (m).
        lengths: [f64; 3],
    },
    /// Sphere.
    Sphere {
        /// Radius (m).
        radius: f64,
    },
    /// Cylinder along the z axis.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Length (m).
        length: f64,
    },
    /// Cylinder along the z axis with half spheres at its ends.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Length of the cylinder (m), without the half spheres.
        length: f64,
    },
    /// Triangle mesh in a file.
    Mesh {
        /// File name as in the URDF file: a path, or an address such as `package://arm/meshes/hand.stl`.
        path: String,
        /// Factors of the coordinates. A negative factor mirrors the mesh.
        scale: [f64; 3],
    },
}

/// Geometries of the file format.
const GEOMETRIES: &str = "<box>, <sphere>, <cylinder>, <capsule> or <mesh>";

impl Collision {
    pub(super) fn of(element: Element) -> Result<Self, UrdfError> {
        let around = element.required_child("geometry", "<geometry>")?;
        let mut known = around.elements().filter_map(|element| {
            let geometry = geometry_of(element).transpose()?;
            Some((element, geometry))
        });
        let (geometry_element, geometry) = known
            .next()
            .ok_or_else(|| around.missing_element(GEOMETRIES))?;
        if let Some((second, _)) = known.next() {
            return Err(UrdfError::RepeatedElement {
                at: second.location(),
            });
        }
        Ok(Self {
            origin: origin_of(element)?,
            geometry: geometry?,
            at: geometry_element.location(),
        })
    }
}

/// Geometry of an element, or `None` if the tag is unknown.
fn geometry_of(element: Element) -> Result<Option<Geometry>, UrdfError> {
    let length = |attribute| element.positive(attribute).map(|[length]| length);
    let geometry = match element.tag() {
        "box" => Geometry::Box {
            lengths: element.positive("size")?,
        },
        "sphere" => Geometry::Sphere {
            radius: length("radius")?,
        },
        "cylinder" => Geometry::Cylinder {
            radius: length("radius")?,
            length: length("length")?,
        },
        "capsule" => Geometry::Capsule {
            radius: length("radius")?,
            length: length("length")?,
        },
        "mesh" => Geometry::Mesh {
            path: element.name_in("filename")?.to_owned(),
            scale: scale_of(element)?,
        },
        _ => return Ok(None),
    };
    Ok(Some(geometry))
}

fn scale_of(mesh: Element) -> Result<[f64; 3], UrdfError> {
    let scale = mesh.numbers("scale")?.unwrap_or([1.0; 3]);
    if scale.contains(&0.0) {
        return Err(mesh.out_of_range("scale", 0.0, "factors other than zero"));
    }
    Ok(scale)
}
