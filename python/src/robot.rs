//! Robots from URDF files.

use crate::arrays::{Whole, count, named_real, parts, real, whole};
use crate::body::Body;
use crate::errors::{urdf_error, value_error};
use crate::joint::{Joint, check_stops};
use crate::lists::optional_list_of;
use crate::material::Material;
use crate::mechanism::Mechanism;
use crate::poses::single_pose;
use crate::shape_files::emit;
use crate::world::{World, gravity};
use hydroelastic::io::urdf::{
    self, Base, JointOptions, MeshShape, RobotOptions, ShapeOptions, StopLaw,
};
use hydroelastic::nalgebra::Vector3;
use hydroelastic::spatial::Pose;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Robot of a URDF file: a tree of links and joints.
///
/// Create robots with Robot.read or Robot.parse.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Robot(urdf::Robot);

/// Converts an argument to a law of stops, or None.
fn stop_law(argument: &Bound<'_, PyAny>) -> PyResult<Option<StopLaw>> {
    if argument.is_none() {
        return Ok(None);
    }
    let expected = "a stiffness and a dissipation, or None";
    let [stiffness, dissipation] = parts(argument, "the law of stops", expected)?;
    let stiffness = named_real(&stiffness, "the stiffness of stops")?;
    let dissipation = named_real(&dissipation, "the dissipation of stops")?;
    check_stops(stiffness, dissipation)?;
    Ok(Some(StopLaw {
        stiffness,
        dissipation,
    }))
}

/// Reads the kind of the shapes of meshes.
fn mesh_shape(name: &str) -> PyResult<MeshShape> {
    match name {
        "rigid" => Ok(MeshShape::Rigid),
        "hull" => Ok(MeshShape::Hull),
        "compliant_hull" => Ok(MeshShape::CompliantHull),
        "star_shaped" => Ok(MeshShape::StarShaped),
        "none" => Ok(MeshShape::None),
        _ => Err(value_error(format!(
            "meshes must be \"rigid\", \"hull\", \"star_shaped\", \"compliant_hull\" or \"none\", but is {name:?}"
        ))),
    }
}

/// Reads the connection of the root link.
fn base_of(base: &Bound<'_, PyAny>, pose: Option<&Bound<'_, PyAny>>) -> PyResult<Base> {
    if let Ok(joint) = base.cast::<Joint>() {
        return match pose {
            None => Ok(Base::Joint(Box::new(joint.get().0.clone()))),
            Some(_) => Err(value_error(
                "the base is on a joint, which gives its pose: leave out pose",
            )),
        };
    }
    let pose = pose.map(|pose| single_pose(pose, "pose")).transpose()?;
    let pose = pose.unwrap_or_else(Pose::identity);
    match base.extract::<String>().as_deref() {
        Ok("fixed") => Ok(Base::Fixed(pose)),
        Ok("free") => Ok(Base::Free(pose)),
        _ => Err(value_error(format!(
            "base must be \"fixed\", \"free\" or a Joint, but is {}",
            base.repr()?
        ))),
    }
}

#[pymethods]
impl Robot {
    /// Reads a URDF file. Files of meshes are not opened.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    ///
    /// Returns
    /// -------
    /// Robot
    ///     Robot.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an element is missing or out of range, names are not unique, or the links are not one tree. The message gives the line.
    /// OSError
    ///     If the file cannot be read from the disk.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        urdf::Robot::read(path).map(Self).map_err(urdf_error)
    }

    /// Reads a text in the URDF format.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     Text.
    ///
    /// Returns
    /// -------
    /// Robot
    ///     Robot.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an element is missing or out of range, names are not unique, or the links are not one tree. The message gives the line.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        text.parse().map(Self).map_err(urdf_error)
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Names of the links, parents before children.
    #[getter]
    fn link_names(&self) -> Vec<&str> {
        let links = self.0.links().iter();
        links.map(|link| link.name.as_str()).collect()
    }

    /// Names of the joints, parents before children.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        let joints = self.0.joints().iter();
        joints.map(|joint| joint.name.as_str()).collect()
    }

    /// Defects of the file that do not prevent a simulation.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings().iter().map(ToString::to_string).collect()
    }

    /// Makes bodies that are connected by joints. Each body has the name and the frame of its link.
    ///
    /// The first collision geometry of a link is the shape of its body. Further geometries are shapes of massless bodies that are welded to
    /// the link, named "link/2", "link/3" and so on. Mechanism.with_joint sets servos of joints.
    ///
    /// Parameters
    /// ----------
    /// material : Material
    ///     Material of all collision geometries. Rigid shapes have its friction only.
    /// base : str or Joint
    ///     Connection of the root link: "fixed" or "free" in the world, or a joint to a body or the world.
    /// pose : (4, 4) array_like, optional
    ///     Pose of a fixed root link, or initial pose of a free one, in the world. Default: the identity.
    /// prefix : str
    ///     Text before all names. Robots in one world have different prefixes.
    /// packages : dict of str to path-like, optional
    ///     Folders of packages with meshes, by name. Default: none.
    /// meshes : str
    ///     Shapes of meshes: "rigid", "hull" (rigid), "star_shaped" (compliant), "compliant_hull" or "none". With "rigid", a mesh that is
    ///     not closed becomes the convex hulls of its connected components. With "none", the files are not opened.
    /// materials : dict of str to Material, optional
    ///     Materials of other links, by the name of the link in the file. Default: none.
    /// self_contact : bool
    ///     Whether the links touch each other. Links that a joint connects never do.
    /// subdivisions : int
    ///     Subdivisions k of a sphere, which has 20·4ᵏ triangles.
    /// segments : int
    ///     Number of sides of a cylinder or a capsule.
    /// revolute_stops : (float, float) or None
    ///     Stiffness (N m/rad) and dissipation (s/rad) of the stops of revolute joints; None for no stops.
    /// prismatic_stops : (float, float) or None
    ///     Stiffness (N/m) and dissipation (s/m) of the stops of prismatic joints; None for no stops.
    /// slip_tolerance : float
    ///     Slip tolerance (rad/s or m/s) of joint friction.
    ///
    /// Returns
    /// -------
    /// Mechanism
    ///     Bodies, parents before children.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a joint is floating or planar, a geometry cannot become a shape, the material or the mass properties of a link are out of
    ///     range, or an option is not valid.
    /// OSError
    ///     If a mesh cannot be read from the disk.
    #[pyo3(signature = (material, *, base=None, pose=None, prefix="", packages=None, meshes="rigid", materials=None, self_contact=false,
                        subdivisions=2, segments=16, revolute_stops=Some(StopLaw { stiffness: 1e3, dissipation: 1.0 }),
                        prismatic_stops=Some(StopLaw { stiffness: 1e5, dissipation: 10.0 }), slip_tolerance=1e-3),
           text_signature = "($self, material, *, base='fixed', pose=None, prefix='', packages=None, meshes='rigid', materials=None, \
                             self_contact=False, subdivisions=2, segments=16, revolute_stops=(1000.0, 1.0), \
                             prismatic_stops=(100000.0, 10.0), slip_tolerance=0.001)")]
    fn mechanism(
        &self,
        py: Python<'_>,
        material: &Material,
        base: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        prefix: &str,
        packages: Option<BTreeMap<String, PathBuf>>,
        meshes: &str,
        materials: Option<BTreeMap<String, Bound<'_, Material>>>,
        self_contact: bool,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
        #[pyo3(from_py_with = whole)] segments: Whole,
        #[pyo3(from_py_with = stop_law)] revolute_stops: Option<StopLaw>,
        #[pyo3(from_py_with = stop_law)] prismatic_stops: Option<StopLaw>,
        #[pyo3(from_py_with = real)] slip_tolerance: f64,
    ) -> PyResult<Mechanism> {
        let fixed = "fixed".into_pyobject(py)?.into_any();
        let materials = materials.into_iter().flatten();
        let options = RobotOptions {
            prefix: prefix.to_owned(),
            base: base_of(base.unwrap_or(&fixed), pose)?,
            materials: materials
                .map(|(link, material)| (link, material.get().inner()))
                .collect(),
            shapes: ShapeOptions {
                packages: packages.unwrap_or_default(),
                subdivisions: count(subdivisions, "subdivisions")?,
                segments: count(segments, "segments")?,
                meshes: mesh_shape(meshes)?,
            },
            joints: JointOptions {
                revolute_stops,
                prismatic_stops,
                slip_tolerance,
            },
            self_contact,
            ..RobotOptions::new(material.inner())
        };
        self.check_links(options.materials.keys())?;
        let mechanism = self.0.mechanism(&options).map_err(urdf_error)?;
        warn(py, &mechanism)?;
        Ok(converted(&mechanism))
    }

    fn __repr__(&self) -> String {
        let (name, links) = (self.name(), self.0.links().len());
        format!(
            "Robot({name:?}, {links} links, joints={:?})",
            self.joint_names()
        )
    }
}

/// Emits what may be mistakes in the meshes of a mechanism.
fn warn(py: Python<'_>, mechanism: &hydroelastic::dynamics::Mechanism) -> PyResult<()> {
    let mut warnings = mechanism.warnings().iter();
    warnings.try_for_each(|warning| emit(py, warning))
}

impl Robot {
    /// Checks that the robot has the named links.
    fn check_links<'n>(&self, mut names: impl Iterator<Item = &'n String>) -> PyResult<()> {
        let known = self.link_names();
        match names.find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(value_error(format!(
                "no link is named {name:?}: the names are {known:?}"
            ))),
        }
    }
}

#[pymethods]
impl World {
    /// Creates a world of one robot from a URDF file, and other bodies.
    ///
    /// Robot.mechanism has more options. Mechanism.with_joint sets all numbers of a joint.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    /// material : Material
    ///     Material of all collision geometries. Rigid shapes have its friction only.
    /// base : str or Joint
    ///     Connection of the root link: "fixed" or "free" in the world, or a joint to a body or the world.
    /// pose : (4, 4) array_like, optional
    ///     Pose of a fixed root link, or initial pose of a free one, in the world. Default: the identity.
    /// packages : dict of str to path-like, optional
    ///     Folders of packages with meshes, by name. Default: none.
    /// meshes : str
    ///     Shapes of meshes: "rigid", "hull" (rigid), "star_shaped" (compliant), "compliant_hull" or "none". With "rigid", a mesh that is
    ///     not closed becomes the convex hulls of its connected components.
    /// servos : dict of str to (float, float), optional
    ///     Stiffness (N m/rad or N/m) and damping (N m s/rad or N s/m) of servos, by the name of the joint. Default: no servos.
    /// bodies : list of Body, optional
    ///     Other bodies. They come before the links in the world. Default: none.
    /// gravity : (3,) array_like or float, optional
    ///     Gravity (m/s²) in world axes, or its z component, such as -9.81. Default: no gravity.
    ///
    /// Returns
    /// -------
    /// World
    ///     World.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the file or an option is not valid, or the world has no such joint.
    /// OSError
    ///     If the file or a mesh cannot be read from the disk.
    #[staticmethod]
    #[pyo3(signature = (path, material, *, base=None, pose=None, packages=None, meshes="rigid", servos=None, bodies=None, gravity=None),
           text_signature = "(path, material, *, base='fixed', pose=None, packages=None, meshes='rigid', servos=None, bodies=None, \
                             gravity=None)")]
    fn from_urdf<'py>(
        py: Python<'py>,
        path: PathBuf,
        material: &Material,
        base: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        packages: Option<BTreeMap<String, PathBuf>>,
        meshes: &str,
        servos: Option<BTreeMap<String, Bound<'py, PyAny>>>,
        #[pyo3(from_py_with = optional_list_of)] bodies: Option<Vec<Bound<'py, Body>>>,
        #[pyo3(from_py_with = gravity)] gravity: Option<Vector3<f64>>,
    ) -> PyResult<Self> {
        let fixed = "fixed".into_pyobject(py)?.into_any();
        let options = RobotOptions {
            base: base_of(base.unwrap_or(&fixed), pose)?,
            shapes: ShapeOptions {
                packages: packages.unwrap_or_default(),
                meshes: mesh_shape(meshes)?,
                ..ShapeOptions::default()
            },
            ..RobotOptions::new(material.inner())
        };
        let robot = Robot::read(path)?.0;
        let mechanism = robot.mechanism(&options).map_err(urdf_error)?;
        warn(py, &mechanism)?;
        let mut mechanism = converted(&mechanism);
        for (joint, servo) in servos.into_iter().flatten() {
            let name = format!("the servo of joint {joint:?}");
            let [stiffness, damping] = parts(&servo, &name, "a stiffness and a damping")?;
            let number = |value, of| named_real(value, &format!("the {of} of {name}"));
            let servo = [
                number(&stiffness, "stiffness")?,
                number(&damping, "damping")?,
            ];
            mechanism = mechanism.with_servo(&joint, servo)?;
        }
        let mechanisms = vec![Bound::new(py, mechanism)?];
        let bodies = bodies.unwrap_or_default();
        Self::new(
            bodies,
            Some(mechanisms),
            None,
            gravity,
            None,
            None,
            None,
            None,
            None,
            None,
        )
    }
}

/// Converts a mechanism of the library.
fn converted(mechanism: &hydroelastic::dynamics::Mechanism) -> Mechanism {
    let bodies = mechanism.bodies().iter();
    let ignored = mechanism.ignored().iter();
    Mechanism {
        bodies: bodies
            .map(|body| Body {
                inner: body.clone(),
                path: None,
            })
            .collect(),
        ignored: ignored
            .map(|[first, second]| (first.clone(), second.clone()))
            .collect(),
    }
}
