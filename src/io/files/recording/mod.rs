//! Recording of a rollout as an animated glTF file.

mod arrows;
mod bodies;
mod data;
mod document;
mod drawing;
mod frames;
mod loads;
mod marks;
mod materials;
mod precision;
mod surfaces;
mod view;

use super::FileError;
use super::atomic_write::atomic_write;
use super::extension::known_extension;
use super::trajectory::check_fits;
use crate::dynamics::{Force, Model, Trajectory, World};
use document::{Document, Unwritable};
use marks::{Path as MarkedPath, Target};
use nalgebra::Vector3;
use precision::single;
use std::io::Write;
use std::path::Path;
use view::Camera;

/// Radius of the tube of a path, relative to the length of the longest arrow.
const TUBE_RADIUS: f64 = 0.015;

/// Torques are omitted if the largest torque, divided by the largest force, is below this fraction of the length of the longest arrow.
/// Such torques come from the facets of a sphere and from round-off.
const NEGLIGIBLE_TORQUE: f64 = 1e-2;

/// Extensions of recordings.
const EXTENSIONS: &[&str] = &["glb"];

/// A trajectory of a world, to be written as an animated glTF file (`.glb`). Blender and any other glTF viewer can open the file.
///
/// The recording shows
/// - the bodies, translucent; of a half-space, the polygon of [`World::half_space_outlines`];
/// - their contact surfaces, colored by pressure;
/// - for each pair of bodies, an arrow for the contact force at the center of pressure, on the first dynamic body of the pair;
/// - for each body, an arrow with two heads for the torque of its contacts about its center of mass, unless all torques are
///   negligible compared with the forces.
///
/// The names of the nodes contain the pressure of the brightest color and the magnitude of the longest arrows. The up direction is
/// opposite to gravity, or z without gravity.
///
/// The first and the last state are always shown, and at most 60 states per second between them. States with equal times in single
/// precision are merged. Viewers without animation show the first state.
///
/// Each shown contact surface has its own mesh, because its polygons change over time. The size of
/// a mesh is about 860 bytes, plus 25 bytes per polygon (`cargo test --test io recording::`). A
/// recording has at most 240 of these meshes. If more frames have contacts, a mesh is shown in
/// several frames.
///
/// ```
/// use hydroelastic::contact::Shape;
/// use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
/// use hydroelastic::io::Recording;
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let skin = Material::elastic(1e5);
/// let ball = Shape::new(shapes::icosphere(0.1, 2)?);
/// let floor = Shape::new(shapes::cuboid([1.0, 1.0, 0.2])?);
/// let world = World::new(vec![
///     Body::dynamic("ball", ball, skin, Mass::Total(1.0))?
///         .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.4])),
///     Body::fixed("floor", floor, skin)?,
/// ])?
/// .with_gravity(vector![0.0, 0.0, -9.81])?;
/// let trajectory = world.rollout(&Plan::new(5e-4, 2_000)?).run()?;
///
/// let path = std::env::temp_dir().join("bouncing_ball.glb");
/// Recording::new(&world, &trajectory).slowed(4.0).write(&path)?;
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recording {
    model: Model,
    trajectory: Trajectory,
    slowdown: f64,
    camera: Option<Camera>,
    targets: Vec<Target>,
    paths: Vec<MarkedPath>,
}

impl Recording {
    /// Creates a recording in real time, without targets, paths or a camera.
    #[must_use]
    pub fn new<F: Force>(world: &World<f64, F>, trajectory: &Trajectory) -> Self {
        Self {
            model: world.model.clone(),
            trajectory: trajectory.clone(),
            slowdown: 1.0,
            camera: None,
            targets: Vec::new(),
            paths: Vec::new(),
        }
    }

    /// Sets the playback speed: a second of the trajectory lasts `slowdown` seconds in the recording. The slowdown must be positive.
    /// A slowdown below 1 is faster than real time. A slower recording shows proportionally more frames if the trajectory has them.
    #[must_use]
    pub fn slowed(self, slowdown: f64) -> Self {
        Self { slowdown, ..self }
    }

    /// Adds a ball of a positive radius (m) that marks a point (m, world frame).
    #[must_use]
    pub fn with_target(mut self, name: &str, point: Vector3<f64>, radius: f64) -> Self {
        let name = name.to_owned();
        self.targets.push(Target {
            name,
            point,
            radius,
        });
        self
    }

    /// Adds a line through points (m, world frame). It is not shown if there are fewer than two points. The colors of the paths vary
    /// from pale to strong in the order in which they are added.
    #[must_use]
    pub fn with_path(mut self, name: &str, points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let (name, points) = (name.to_owned(), Vec::from_iter(points));
        self.paths.push(MarkedPath { name, points });
        self
    }

    /// Adds a camera at `eye` that looks at `point` (m, world frame). The two points must differ. Most viewers start with their own
    /// view, and offer this camera as another view.
    #[must_use]
    pub fn seen_from(self, eye: Vector3<f64>, point: Vector3<f64>) -> Self {
        let camera = Some(Camera { eye, point });
        Self { camera, ..self }
    }

    /// Writes the file. An existing file is replaced atomically after the new file has reached the disk.
    ///
    /// # Errors
    /// - If the extension is not `.glb`.
    /// - If the slowdown is not positive and finite.
    /// - If the trajectory belongs to another world.
    /// - If the radius of a target is not positive.
    /// - If the camera coincides with the point that it looks at.
    /// - If a number is not finite in single precision.
    /// - If the file would be larger than 4 GiB, or cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        let path = path.as_ref();
        known_extension(path, EXTENSIONS)?;
        check_fits(path, &self.model.bodies, &self.trajectory)?;
        self.check_numbers(path)?;
        let glb = self.glb().map_err(|cause| file_error(path, cause))?;
        atomic_write(path, |file| file.write_all(&glb))
    }

    /// Checks the slowdown, the radii of the targets and the distance of the camera.
    fn check_numbers(&self, path: &Path) -> Result<(), FileError> {
        let error = |name: String, found, expected| {
            Err(FileError::Option {
                path: path.into(),
                name,
                found,
                expected,
            })
        };
        if !(self.slowdown > 0.0 && self.slowdown.is_finite()) {
            return error("slowdown".into(), self.slowdown, "positive and finite");
        }
        for Target { name, radius, .. } in &self.targets {
            let [rounded] = single([*radius]);
            if !(rounded > 0.0 && rounded.is_finite()) {
                let name = format!("radius (m) of the target {name:?}");
                return error(name, *radius, "positive and finite in single precision");
            }
        }
        match self.camera.and_then(|camera| camera.too_near()) {
            Some(distance) => {
                let name = "distance (m) from the camera to its point".into();
                error(name, distance, "larger")
            }
            None => Ok(()),
        }
    }

    fn glb(&self) -> Result<Vec<u8>, Unwritable> {
        let bodies = &self.model.bodies;
        let frames = frames::frames(&self.model, &self.trajectory, self.slowdown);
        let mut document = Document::new();
        let times = frames.iter().flat_map(|frame| single([frame.time]));
        document.data.set_subject("the times");
        document.data.check(times);
        bodies::add(&mut document, &self.model, &frames);
        surfaces::add(&mut document, &frames);
        let length = view::arrow_length(bodies);
        let (forces, torques) = (
            loads::forces(bodies, &frames),
            loads::torques(bodies, &frames),
        );
        arrows::add(&mut document, &arrows::FORCES, &forces, &frames, length);
        if loads::largest(&torques) > NEGLIGIBLE_TORQUE * length * loads::largest(&forces) {
            arrows::add(&mut document, &arrows::TORQUES, &torques, &frames, length);
        }
        marks::add_targets(&mut document, &self.targets);
        marks::add_paths(&mut document, &self.paths, TUBE_RADIUS * length);
        let up = view::up(&self.model.gravity);
        if let Some(camera) = &self.camera {
            camera.add_to(&mut document, &up);
        }
        document.into_glb(view::to_y_up(&up))
    }
}

fn file_error(path: &Path, cause: Unwritable) -> FileError {
    match cause {
        Unwritable::NotFinite(part) => FileError::NotFinite {
            path: path.into(),
            part,
        },
        Unwritable::TooLong(found) => FileError::TooLong {
            path: path.into(),
            part: "recording".to_owned(),
            found,
            limit: u32::MAX as usize,
        },
        Unwritable::Json(error) => FileError::Write {
            path: path.into(),
            source: error.into(),
        },
    }
}
