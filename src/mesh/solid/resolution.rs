//! Refinement of a solid to a spacing or a tolerance.

use super::boundary::Boundary;
use super::error::SolidError;
use super::lattice::Lattice;
use super::region::Region;
use super::stuffing::{Stuffing, stuffed};
use crate::geometry::Aabb;
use crate::mesh::{MeshError, TetMesh};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Number of tetrahedra up to which the spacing is refined.
const MAX_TETS: f64 = 5e5;

/// Growth of the number of tetrahedra as the spacing is divided by √2.
const GROWTH: f64 = 2.0 * SQRT_2;

/// Depth up to which the distances of a mesh are compared with exact ones, over the largest distance.
const SKIN: f64 = 0.4;

/// Number of spacings of the first attempt along the longest edge of the bounds.
const FIRST_CELLS: f64 = 12.0;

/// Spacing or tolerance of a [`Solid`](super::Solid).
///
/// For a tolerance, the spacing is a power of √2 m. It is divided by √2 until the error is within the tolerance, or the next mesh is
/// expected to have more than 500,000 tetrahedra or needs more than 1e8 cells. A mesh has more tetrahedra if its lattice resolves walls
/// that the coarser lattice missed. [`Solid::warnings`](super::Solid::warnings) reports an error above the
/// tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// Spacing of the lattice (m): the longest edge of the tetrahedra next to the boundary.
    Spacing(f64),
    /// Largest relative error of the volume. The reference is the volume of a closed surface of one component. For other regions it is
    /// the volume at the spacing before.
    VolumeWithin(f64),
    /// Largest mean error of the distance to the surface that the mesh interpolates, over the mean distance. The means are over the middles
    /// of the tetrahedra that are at most two fifths of the largest distance deep, weighted by volume. [`Solid::field`](super::Solid::field)
    /// corrects the mean of this error, so that forces on patches with a radius above three spacings have a smaller one.
    DistanceWithin(f64),
}

impl Default for Resolution {
    /// The distance is within 2 %.
    fn default() -> Self {
        Self::DistanceWithin(0.02)
    }
}

/// An error above the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[error(
    "the {quantity} is off by a share of {reached:.2e} with {tet_count} tetrahedra, but the tolerance is {tolerance:.2e}: walls may be thin, or \
     triangles may leave holes or intersect each other; choose a spacing, allow a larger error, or use the convex hull"
)]
pub struct SolidWarning {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// Relative error of the quantity.
    pub reached: f64,
    /// Tolerance of the relative error.
    pub tolerance: f64,
    /// Number of tetrahedra.
    pub tet_count: usize,
}

/// A mesh of a region, and how exact it is.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    pub mesh: TetMesh,
    pub boundary: Boundary,
    pub spacing: f64,
    pub volume_error: Option<f64>,
    pub distance_error: Option<f64>,
    pub warnings: Vec<SolidWarning>,
}

impl Refined {
    /// Notes the error of the volume against a reference (m³), if there is one.
    fn compare_volume(&mut self, reference: Option<f64>) {
        let error = |reference: f64| (self.mesh.volume() / reference - 1.0).abs();
        self.volume_error = reference.map(error);
    }
}

/// Fills a region at this resolution.
pub(super) fn refined(
    region: &impl Region,
    volume: Option<f64>,
    resolution: Resolution,
    of_stuffing: impl Fn(Stuffing) -> Result<(TetMesh, Boundary), SolidError>,
) -> Result<Refined, SolidError> {
    let bounds = region.bounds();
    check_bounds(&bounds)?;
    let at = |spacing: f64| {
        let lattice = Lattice::around(&bounds, spacing)
            .map_err(|cells| SolidError::TooFine { spacing, cells })?;
        let filled = of_stuffing(stuffed(region, &lattice));
        let (mesh, boundary) = filled.map_err(|error| match error {
            SolidError::Mesh(MeshError::Empty) => SolidError::Empty { spacing },
            error => error,
        })?;
        Ok(Refined {
            mesh,
            boundary,
            spacing,
            volume_error: None,
            distance_error: None,
            warnings: Vec::new(),
        })
    };
    match resolution {
        Resolution::Spacing(spacing) => {
            check_number("spacing", spacing)?;
            let mut solid = at(spacing)?;
            solid.compare_volume(volume);
            Ok(solid)
        }
        Resolution::VolumeWithin(tolerance) => {
            let mut before = volume;
            within(("volume", tolerance), &bounds, at, |solid| {
                solid.compare_volume(before);
                // The error is of second order, so that it equals its change from a spacing √2 times as large.
                before = volume.or(Some(solid.mesh.volume()));
                solid.volume_error.unwrap_or(f64::INFINITY)
            })
        }
        Resolution::DistanceWithin(tolerance) => within(
            ("distance to the surface", tolerance),
            &bounds,
            at,
            |solid| {
                solid.compare_volume(volume);
                let error = distance_error(region, &solid.mesh);
                solid.distance_error = Some(error);
                error
            },
        ),
    }
}

/// Returns the mean error of the distances to the boundary of a region that a mesh interpolates, over the mean distance, at the middles of
/// its tetrahedra that are at most [`SKIN`] times the largest distance deep, weighted by volume.
fn distance_error(region: &impl Region, mesh: &TetMesh) -> f64 {
    let mut distances = region.clearances(mesh.vertices());
    for (vertex, distance) in distances.iter_mut().enumerate() {
        if mesh.is_on_surface(vertex) {
            *distance = 0.0;
        }
    }
    let largest = distances.iter().copied().fold(0.0, f64::max);
    let mean = |tet: &[usize; 4]| tet.map(|vertex| distances[vertex]).iter().sum::<f64>() / 4.0;
    let middles = (0..mesh.tet_count()).map(|tet| mesh.tetrahedron(tet).centroid());
    let middles: Vec<_> = middles.collect();
    let (mut error, mut sum) = (0.0, 0.0);
    for (tet, exact) in region.clearances(&middles).into_iter().enumerate() {
        let interpolated = mean(&mesh.tets()[tet]);
        if exact.min(interpolated) <= SKIN * largest {
            let volume = mesh.tetrahedron(tet).signed_volume();
            error += volume * (interpolated - exact).abs();
            sum += volume * exact;
        }
    }
    // A mesh without such tetrahedra is too coarse.
    if sum > 0.0 {
        error / sum
    } else {
        f64::INFINITY
    }
}

/// Refines the spacing until an error is within its tolerance.
fn within(
    (quantity, tolerance): (&'static str, f64),
    bounds: &Aabb,
    at: impl Fn(f64) -> Result<Refined, SolidError>,
    mut error_of: impl FnMut(&mut Refined) -> f64,
) -> Result<Refined, SolidError> {
    check_number("largest error", tolerance)?;
    // The spacing is a power of √2 m, so that small changes of the region do not change the spacing.
    let length = 2.0 * bounds.half_extents().max() / FIRST_CELLS;
    let first_spacing = power_below(length, [SQRT_2, FRAC_1_SQRT_2]);
    let mut spacing = first_spacing;
    loop {
        let solid = at(spacing);
        if matches!(solid, Err(SolidError::Empty { .. })) && spacing > first_spacing / 16.0 {
            spacing *= FRAC_1_SQRT_2;
            continue;
        }
        let mut solid = solid?;
        let reached = error_of(&mut solid);
        if reached <= tolerance {
            return Ok(solid);
        }
        let tet_count = solid.mesh.tet_count();
        let next = Lattice::around(bounds, spacing * FRAC_1_SQRT_2);
        if tet_count as f64 * GROWTH > MAX_TETS || next.is_err() {
            solid.warnings.push(SolidWarning {
                quantity,
                reached,
                tolerance,
                tet_count,
            });
            return Ok(solid);
        }
        spacing *= FRAC_1_SQRT_2;
    }
}

/// Returns the largest power of a base that is at most `number`, which must be positive. The second argument is the base and its inverse.
pub(super) fn power_below(number: f64, [base, inverse]: [f64; 2]) -> f64 {
    let mut power = 1.0;
    while power < number {
        power *= base;
    }
    while power > number {
        power *= inverse;
    }
    power
}

fn check_number(name: &'static str, value: f64) -> Result<(), SolidError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(SolidError::InvalidResolution { name, value })
}

pub(super) fn check_bounds(bounds: &Aabb) -> Result<(), SolidError> {
    let size = bounds.upper - bounds.lower;
    // The second moments (m⁵) of the region neither overflow nor underflow.
    if size.iter().all(|&x| x > 0.0 && x.powi(5).is_normal()) {
        return Ok(());
    }
    Err(SolidError::NoSize { size: size.into() })
}
