//! Reading of shapes from files: the placement, errors and warnings that all readers share.

use crate::arrays::row;
use crate::errors::{file_error, value_error};
use crate::poses::single_pose;
use hydroelastic::io::{FileError, FileWarning, Placement};
use hydroelastic::mesh::{SolidWarning, SurfaceWarning};
use pyo3::prelude::*;
use std::fmt::Display;

/// Extensions of files that only hold surfaces.
const SURFACES: &[&str] = &["stl", "obj", "ply", "off", "glb", "gltf", "dae", "vtp"];

/// Extensions of files that only hold tetrahedra.
const MESHES: &[&str] = &["mesh", "node", "ele", "inp"];

/// Reads the arguments `unit`, `scale` and `pose`.
pub fn placement(
    unit: Option<f64>,
    scale: Option<&Bound<'_, PyAny>>,
    pose: Option<&Bound<'_, PyAny>>,
) -> PyResult<Placement> {
    let mut placement = Placement::default();
    placement.unit = unit.unwrap_or(placement.unit);
    if let Some(scale) = scale {
        placement.scale = row::<3>(scale, "scale")?.into();
    }
    if let Some(pose) = pose {
        placement.pose = single_pose(pose, "pose")?;
    }
    Ok(placement)
}

/// Creates the exception for a file that was read as a mesh of tetrahedra.
pub fn mesh_error(why: FileError) -> PyErr {
    let path = match &why {
        FileError::HoldsSurface { path } => path,
        FileError::UnknownExtension { path, found, .. } if SURFACES.contains(&found.as_str()) => {
            path
        }
        _ => return file_error(why),
    };
    let path = path.display();
    value_error(format!(
        "{path} holds a surface, not a mesh of tetrahedra: RigidShape.read reads it as a rigid body, and Solid.read fills it with \
         tetrahedra"
    ))
}

/// Creates the exception for a file that was read as a surface.
pub fn surface_error(why: FileError) -> PyErr {
    let path = match &why {
        FileError::HoldsGrid { path } => path,
        FileError::UnknownExtension { path, found, .. } if MESHES.contains(&found.as_str()) => path,
        _ => return file_error(why),
    };
    let path = path.display();
    value_error(format!(
        "{path} holds a mesh of tetrahedra, not a surface: Shape.read reads it, and RigidShape.around(Shape.read(path)) makes a rigid \
         body of it"
    ))
}

/// A warning of the library.
pub trait Warning: Display {
    /// Returns whether the warning doubts the unit of a file.
    fn is_about_size(&self) -> bool;
}

impl Warning for FileWarning {
    fn is_about_size(&self) -> bool {
        matches!(self, Self::Size { .. })
    }
}

impl Warning for SurfaceWarning {
    fn is_about_size(&self) -> bool {
        matches!(self, Self::Size { .. })
    }
}

impl Warning for SolidWarning {
    fn is_about_size(&self) -> bool {
        false
    }
}

/// Emits warnings about a file, a surface or a solid. An explicit unit is not a mistake.
pub fn warn(
    py: Python<'_>,
    name: impl Display,
    warnings: impl IntoIterator<Item = impl Warning>,
    is_unit_given: bool,
) -> PyResult<()> {
    for warning in warnings {
        let remedy = match (warning.is_about_size(), is_unit_given) {
            (true, true) => continue,
            (true, false) => "; unit=1.0 reads meters without this warning",
            (false, _) => "",
        };
        emit(py, &format!("{name}: {warning}{remedy}"))?;
    }
    Ok(())
}

/// Emits a `UserWarning`.
pub fn emit(py: Python<'_>, message: &str) -> PyResult<()> {
    py.import("warnings")?.call_method1("warn", (message,))?;
    Ok(())
}
