//! A rollout as an animated glTF file.

mod arrows;
mod bodies;
mod data;
mod document;
mod drawing;
mod frames;
mod loads;
mod marks;
mod materials;
mod surfaces;
mod view;

use super::FileError;
use super::extension::known_extension;
use super::replacement::write_whole;
use super::trajectory::check_fits;
use crate::dynamics::{Force, Model, Trajectory, World};
use document::{Document, Unwritable};
use drawing::single;
use marks::{Path as MarkedPath, Target};
use nalgebra::Vector3;
use std::io::Write;
use std::path::Path;
use view::Camera;

/// Radius of a path's tube, as a part of the longest arrow's length.
const TUBE: f64 = 0.015;

/// Torques with a lever arm below this part of the longest arrow's length, to the largest force, are
/// left out: those of facets that stand for a sphere, and round-off.
const NO_TORQUE: f64 = 1e-2;

/// What the name of a recording can end in.
const EXTENSIONS: &[&str] = &["glb"];

/// A trajectory of a world to be written as one animated glTF file (`.glb`), which opens in Blender and in
/// any other viewer of glTF.
///
/// It shows
/// - the bodies, seen through;
/// - their contact surfaces, colored by pressure;
/// - for each pair of bodies an arrow for the force, at the center of pressure, on the first of the two
///   that moves;
/// - for each body an arrow with two heads for the torque of its contacts about its center of mass, if any
///   torque is worth an arrow beside the forces.
///
/// Names say what the brightest color and the longest arrows stand for. Up is against gravity, or z
/// without it.
///
/// The first state and the last are always shown, and of those between them at most 60 for each second;
/// states that single precision puts at one time are one. Viewers that play no animation show the first
/// state.
///
/// A contact surface has other polygons at any time, so each shown has a mesh of its own: some 25 bytes
/// for each polygon, and 860 bytes (`cargo test --test io recording::`). A recording has no more than 240 of
/// them; where more frames have contacts, one stands for several.
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
    system: Model,
    trajectory: Trajectory,
    slowdown: f64,
    camera: Option<Camera>,
    targets: Vec<Target>,
    paths: Vec<MarkedPath>,
}

impl Recording {
    /// In real time, without marks.
    #[must_use]
    pub fn new<F: Force>(world: &World<f64, F>, trajectory: &Trajectory) -> Self {
        Self {
            system: world.model.clone(),
            trajectory: trajectory.clone(),
            slowdown: 1.0,
            camera: None,
            targets: Vec::new(),
            paths: Vec::new(),
        }
    }

    /// The same recording in slow motion, with as many more frames, if the trajectory has them: a second
    /// lasts `slowdown` seconds, a positive number; below 1 it is faster.
    #[must_use]
    pub fn slowed(self, slowdown: f64) -> Self {
        Self { slowdown, ..self }
    }

    /// The same recording with a ball of some positive radius (m) that marks a point (m, world frame).
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

    /// The same recording with a line through points (m, world frame); not shown if there are fewer than
    /// two. Paths are colored from pale to strong in the order in which they are added.
    #[must_use]
    pub fn with_path(mut self, name: &str, points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let (name, points) = (name.to_owned(), Vec::from_iter(points));
        self.paths.push(MarkedPath { name, points });
        self
    }

    /// The same recording with a camera at `eye` that looks at `point` (m, world frame), which is another. Most viewers
    /// begin with a view of their own, and offer this one.
    #[must_use]
    pub fn seen_from(self, eye: Vector3<f64>, point: Vector3<f64>) -> Self {
        let camera = Some(Camera { eye, point });
        Self { camera, ..self }
    }

    /// Writes the file. It takes the place of an older one all at once, when it is whole and on the disk.
    ///
    /// # Errors
    /// If the extension is not `.glb`, the slowdown is no positive, finite number, the trajectory is of
    /// another world, a radius is not positive, the camera is where it looks, a number is not finite in
    /// single precision, the file would be larger than 4 GiB, or
    /// it cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        let path = path.as_ref();
        known_extension(path, EXTENSIONS)?;
        if !(self.slowdown > 0.0 && self.slowdown.is_finite()) {
            return Err(FileError::Slowdown {
                path: path.into(),
                found: self.slowdown,
            });
        }
        check_fits(path, &self.system.bodies, &self.trajectory)?;
        self.check_marks(path)?;
        let glb = self.glb().map_err(|why| unwritable(path, why))?;
        write_whole(path, |file| file.write_all(&glb))
    }

    /// Checks that the targets can be seen and the camera looks in a direction.
    fn check_marks(&self, path: &Path) -> Result<(), FileError> {
        for target in &self.targets {
            let [radius] = single([target.radius]);
            if !(radius > 0.0 && radius.is_finite()) {
                return Err(FileError::TargetRadius {
                    path: path.into(),
                    target: target.name.clone(),
                    radius: target.radius,
                });
            }
        }
        match self.camera.and_then(|camera| camera.too_near()) {
            Some(distance) => Err(FileError::CameraTooNear {
                path: path.into(),
                distance,
            }),
            None => Ok(()),
        }
    }

    fn glb(&self) -> Result<Vec<u8>, Unwritable> {
        let bodies = &self.system.bodies;
        let frames = frames::frames(&self.system, &self.trajectory, self.slowdown);
        let mut document = Document::new();
        let times = frames.iter().flat_map(|frame| single([frame.time]));
        document.data.begin("the times");
        document.data.check(times);
        bodies::add(&mut document, bodies, &frames);
        surfaces::add(&mut document, &frames);
        let length = view::arrow_length(bodies);
        let (forces, torques) = (
            loads::forces(bodies, &frames),
            loads::torques(bodies, &frames),
        );
        arrows::add(&mut document, &arrows::FORCES, &forces, &frames, length);
        if loads::largest(&torques) > NO_TORQUE * length * loads::largest(&forces) {
            arrows::add(&mut document, &arrows::TORQUES, &torques, &frames, length);
        }
        marks::add_targets(&mut document, &self.targets);
        marks::add_paths(&mut document, &self.paths, TUBE * length);
        let up = view::up(&self.system.gravity);
        if let Some(camera) = &self.camera {
            camera.add_to(&mut document, &up);
        }
        document.into_glb(view::to_y_up(&up))
    }
}

fn unwritable(path: &Path, why: Unwritable) -> FileError {
    match why {
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
