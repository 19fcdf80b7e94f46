use super::element::{Element, Source};
use super::joint::Joint;
use super::link::Link;
use super::{Location, UrdfError, UrdfWarning, tree};
use roxmltree::Document;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Robot of a URDF file: a tree of links and joints. [The module](super) has an example.
#[derive(Debug, Clone)]
pub struct Robot {
    name: String,
    links: Vec<Link>,
    joints: Vec<Joint>,
    warnings: Vec<UrdfWarning>,
    path: Option<PathBuf>,
}

impl Robot {
    /// Reads a URDF file. Files of meshes are not opened.
    ///
    /// # Errors
    /// - If the file cannot be read or is not XML.
    /// - If an element or attribute is missing, repeated or out of range.
    /// - If names are not unique, or the links and joints are not one tree.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, UrdfError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|source| UrdfError::Read {
            path: path.into(),
            source,
        })?;
        let text = std::str::from_utf8(&bytes).map_err(|source| {
            let before = &bytes[..source.valid_up_to()];
            let line = before.split(|&byte| byte == b'\n').count();
            xml_error(Some(path), line, source.into())
        })?;
        Self::parse(text, Some(path))
    }

    fn parse(text: &str, path: Option<&Path>) -> Result<Self, UrdfError> {
        let document = Document::parse(text).map_err(|source| {
            let line = usize::try_from(source.pos().row).unwrap_or(usize::MAX);
            xml_error(path, line, source.into())
        })?;
        let source = Source::new(path, &document);
        let robot = source.root();
        if robot.tag() != "robot" {
            return Err(UrdfError::NotARobot {
                at: robot.location(),
            });
        }
        if let Some(element) = robot
            .elements()
            .find(|element| element.is_of_namespace("xacro"))
        {
            return Err(UrdfError::Macro {
                at: element.location(),
            });
        }
        Self::of(robot, path)
    }

    fn of(robot: Element, path: Option<&Path>) -> Result<Self, UrdfError> {
        let name = robot.name_in("name")?.to_owned();
        let links = robot.elements_named("link").map(Link::of);
        let links = links.collect::<Result<Vec<_>, _>>()?;
        let (links, warnings): (Vec<_>, Vec<_>) = links.into_iter().unzip();
        let mut warnings: Vec<_> = warnings.into_iter().flatten().collect();
        let joints = robot.elements_named("joint").map(Joint::of);
        let joints = joints.collect::<Result<Vec<_>, _>>()?;
        check_unique(robot.elements_named("link"))?;
        check_unique(robot.elements_named("joint"))?;
        warnings.extend(tree::mimic_warnings(&joints)?);
        let (links, joints) = tree::sorted(robot, links, joints)?;
        Ok(Self {
            name,
            links,
            joints,
            warnings,
            path: path.map(Path::to_owned),
        })
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Links, depth first: parents come before children, and children are in the order of their joints in the file.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Joints. Joint i is the joint above link i + 1. Link 0 is the root.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Defects that the reader accepts because published files have them. An example is an inertia that no solid can have.
    #[must_use]
    pub fn warnings(&self) -> &[UrdfWarning] {
        &self.warnings
    }

    /// The file, or `None` for a text that was not read from a file. Relative paths of meshes begin at its folder.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }
}

impl FromStr for Robot {
    type Err = UrdfError;

    /// Parses the text of a URDF file, as [`Self::read`] does. Relative paths of meshes begin at the working directory.
    fn from_str(text: &str) -> Result<Self, UrdfError> {
        Self::parse(text, None)
    }
}

fn xml_error(path: Option<&Path>, line: usize, source: Box<dyn Error + Send + Sync>) -> UrdfError {
    let at = Location {
        path: path.map(Path::to_owned),
        line,
        element: "the text".to_owned(),
    };
    UrdfError::Xml { at, source }
}

fn check_unique<'a>(elements: impl Iterator<Item = Element<'a>>) -> Result<(), UrdfError> {
    let mut lines = BTreeMap::new();
    for element in elements {
        if let Some(first_line) = lines.insert(element.name_in("name")?, element.line()) {
            return Err(UrdfError::DuplicateName {
                at: element.location(),
                first_line,
            });
        }
    }
    Ok(())
}
