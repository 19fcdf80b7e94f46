//! Serialization of surfaces by serde.

use super::TriangleSurface;
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

/// The stored part of a surface. Derived data are recomputed on loading.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "TriangleSurface", deny_unknown_fields)]
struct SurfaceLayout {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Serialize for TriangleSurface {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = SurfaceLayout {
            vertices: self.vertices().iter().map(|&v| v.into()).collect(),
            triangles: self.triangles().to_vec(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TriangleSurface {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = SurfaceLayout::deserialize(deserializer)?;
        let vertices = layout.vertices.into_iter().map(Into::into).collect();
        Self::new(vertices, layout.triangles).map_err(D::Error::custom)
    }
}
