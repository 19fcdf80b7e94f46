//! Files of meshes.

use super::UrdfError;
use super::collision::{Collision, Geometry};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

impl Collision {
    /// Path of the file of a mesh, or `None` for another geometry. The file need not exist.
    ///
    /// - `package://name/rest` is below the folder of the package.
    /// - `file://path` is an absolute path.
    /// - A relative path begins at the folder of the URDF file.
    ///
    /// # Errors
    /// If the folder of a package is not given, or if the scheme is neither `package` nor `file`.
    pub fn mesh_path(
        &self,
        packages: &BTreeMap<String, PathBuf>,
    ) -> Result<Option<PathBuf>, UrdfError> {
        let Geometry::Mesh { path, .. } = &self.geometry else {
            return Ok(None);
        };
        if let Some(rest) = path.strip_prefix("package://") {
            return self.path_in_package(rest, packages).map(Some);
        }
        if let Some(absolute) = path.strip_prefix("file://") {
            return Ok(Some(absolute.into()));
        }
        if path.contains("://") {
            return Err(UrdfError::UnknownScheme {
                at: self.at.clone(),
                found: path.clone(),
            });
        }
        let urdf_path = self.at.path.as_deref();
        let folder = urdf_path.and_then(Path::parent).unwrap_or(Path::new(""));
        Ok(Some(folder.join(path)))
    }

    /// Path below the folder of a package. Some files have a third slash before the name of the package.
    fn path_in_package(
        &self,
        rest: &str,
        packages: &BTreeMap<String, PathBuf>,
    ) -> Result<PathBuf, UrdfError> {
        let rest = rest.trim_start_matches('/');
        let (package, inner) = rest.split_once('/').unwrap_or((rest, ""));
        match packages.get(package) {
            Some(folder) => Ok(folder.join(inner.trim_start_matches('/'))),
            None => Err(UrdfError::UnknownPackage {
                at: self.at.clone(),
                package: package.to_owned(),
                known: packages.keys().cloned().collect(),
            }),
        }
    }
}
