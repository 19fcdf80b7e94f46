//! The fit of distances to their means.
//!
//! The distance to a surface is concave almost everywhere inside, so that its interpolation between vertices is too small, most of all in
//! tetrahedra with a face on a curved surface. The distances of inner vertices are therefore raised until the mean error around each
//! vertex is about zero.
//!
//! 1. The *gap* of a tetrahedron is the distance D at its centroid less the mean of the distances d at its corners.
//! 2. The mean error of the interpolation in a tetrahedron is 4/5 of its gap if the error is quadratic. The mean of the interpolated
//!    distance grows by that error if each of the m inner corners is raised by a = 16/(5m) (D − Σ d/4).
//! 3. A vertex is raised by the mean of a over the tetrahedra around it, weighted by their volumes V: r = Σ V a / Σ V.
//! 4. The fitted distance is d + r, or d/2 if that is larger, so that the field stays positive inside.

use super::TetMesh;
use super::splitting::Center;
use super::surface_distance::SurfaceDistance;
use crate::parallel;
use nalgebra::Vector3;

/// Rise of the inner corner of a tetrahedron with one inner corner, over its gap.
const RISE_OVER_GAP: f64 = 16.0 / 5.0;

/// Least fitted distance over the distance.
const LEAST: f64 = 0.5;

/// Difference of a rise from the limit, over the limit, below which a small change of the mesh changes whether the limit applies.
const TIE: f64 = 1e-9;

/// The linearized fit of the distances of a mesh.
#[derive(Debug, Clone)]
pub(super) struct DistanceFit {
    pub tets: Vec<FittedTet>,
    /// Volume of the tetrahedra around each vertex (m³).
    volumes: Vec<f64>,
    /// The rise r of each vertex (m).
    rises: Vec<f64>,
    /// Flag of each vertex that is fitted without the limit.
    is_free: Vec<bool>,
}

/// A tetrahedron of a fit.
#[derive(Debug, Clone)]
pub(super) struct FittedTet {
    pub corners: [usize; 4],
    /// Distance (m) of the centroid from the surface.
    pub distance: f64,
    volume: f64,
    /// Derivatives of the volume with respect to the corners (m²).
    by_corners: [Vector3<f64>; 4],
    /// The rise a (m), and its derivative with respect to the gap.
    rise: f64,
    rise_by_gap: f64,
}

impl DistanceFit {
    /// Fits the distances (m) of the vertices of a mesh. Each tetrahedron must have a corner inside.
    pub fn of(mesh: &TetMesh, surface: &SurfaceDistance, distances: &[f64]) -> Self {
        let count = distances.len();
        let tets = parallel::values_of(mesh.tet_count(), |tet| {
            FittedTet::of(mesh, surface, distances, tet)
        });
        let (mut sums, mut volumes) = (vec![0.0; count], vec![0.0; count]);
        for tet in &tets {
            for vertex in tet.corners {
                sums[vertex] += tet.volume * tet.rise;
                volumes[vertex] += tet.volume;
            }
        }
        let is_inner = |&vertex: &usize| !mesh.is_on_surface(vertex);
        let mut rises = vec![0.0; count];
        for vertex in (0..count).filter(is_inner) {
            rises[vertex] = sums[vertex] / volumes[vertex];
        }
        let is_free = |vertex: usize| rises[vertex] > (LEAST - 1.0) * distances[vertex];
        Self {
            is_free: (0..count).map(is_free).collect(),
            tets,
            volumes,
            rises,
        }
    }

    /// Returns the fitted distances (m) of vertices at these distances (m).
    pub fn of_distances(&self, distances: &[f64]) -> Vec<f64> {
        let fitted = |(vertex, &distance): (usize, &f64)| {
            if self.is_free[vertex] {
                distance + self.rises[vertex]
            } else {
                LEAST * distance
            }
        };
        distances.iter().enumerate().map(fitted).collect()
    }

    /// Returns the vertices at the limit of the fit, where a small change of the mesh can begin or end the limit.
    pub fn at_limits(&self, distances: &[f64]) -> Vec<usize> {
        let is_at_limit = |&vertex: &usize| {
            let limit = (1.0 - LEAST) * distances[vertex];
            (self.rises[vertex] + limit).abs() < TIE * limit
        };
        (0..distances.len()).filter(is_at_limit).collect()
    }

    /// Returns the rates of the fitted distances, from the velocities of the vertices, and from the rates of the distances of the vertices
    /// and then of the centroids.
    pub fn rates(&self, velocities: &[Vector3<f64>], rates: &[f64]) -> Vec<f64> {
        let (of_vertices, of_centroids) = rates.split_at(self.rises.len());
        let mut sums = vec![0.0; self.rises.len()];
        for (tet, rate) in self.tets.iter().zip(of_centroids) {
            let terms = tet.by_corners.iter().zip(tet.corners);
            let volume: f64 = terms.map(|(by, vertex)| by.dot(&velocities[vertex])).sum();
            let rise = tet.rise_by_gap * tet.gap(*rate, of_vertices);
            for vertex in tet.corners {
                sums[vertex] += volume * (tet.rise - self.rises[vertex]) + tet.volume * rise;
            }
        }
        let rate = |vertex: usize| {
            if self.is_free[vertex] {
                of_vertices[vertex] + sums[vertex] / self.volumes[vertex]
            } else {
                LEAST * of_vertices[vertex]
            }
        };
        (0..self.rises.len()).map(rate).collect()
    }

    /// Returns the derivatives of a scalar with respect to the distances of the vertices and then of the centroids, from those with
    /// respect to the fitted distances. Adds the derivatives with respect to the vertices.
    pub fn pullback(&self, by_fitted: &[f64], by_vertices: &mut [Vector3<f64>]) -> Vec<f64> {
        let (mut by_distances, mut by_sums) = (by_fitted.to_vec(), vec![0.0; by_fitted.len()]);
        for (vertex, by_distance) in by_distances.iter_mut().enumerate() {
            if self.is_free[vertex] {
                by_sums[vertex] = *by_distance / self.volumes[vertex];
            } else {
                *by_distance *= LEAST;
            }
        }
        for tet in &self.tets {
            let by_rise: f64 = tet.corners.iter().map(|&vertex| by_sums[vertex]).sum();
            let by_gap = by_rise * tet.volume * tet.rise_by_gap;
            let by_volume: f64 = tet
                .corners
                .iter()
                .map(|&vertex| by_sums[vertex] * (tet.rise - self.rises[vertex]))
                .sum();
            for (vertex, by_corner) in tet.corners.into_iter().zip(&tet.by_corners) {
                by_vertices[vertex] += by_corner * by_volume;
                by_distances[vertex] -= by_gap / 4.0;
            }
            by_distances.push(by_gap);
        }
        by_distances
    }
}

impl FittedTet {
    fn of(mesh: &TetMesh, surface: &SurfaceDistance, distances: &[f64], tet: usize) -> Self {
        let (corners, tetrahedron) = (mesh.tets()[tet], mesh.tetrahedron(tet));
        let volume = tetrahedron.signed_volume();
        let inner = corners
            .iter()
            .filter(|&&vertex| !mesh.is_on_surface(vertex));
        let rise_by_gap = RISE_OVER_GAP / inner.count().max(1) as f64;
        let mut fitted = Self {
            corners,
            distance: surface.to(&tetrahedron.centroid()),
            volume,
            by_corners: tetrahedron
                .barycentric_fields()
                .map(|field| field.gradient * volume),
            rise: 0.0,
            rise_by_gap,
        };
        fitted.rise = rise_by_gap * fitted.gap(fitted.distance, distances);
        fitted
    }

    /// Returns the gap for this distance of the centroid and these distances of the vertices. It also maps their rates.
    fn gap(&self, of_centroid: f64, of_vertices: &[f64]) -> f64 {
        let sum: f64 = self.corners.iter().map(|&vertex| of_vertices[vertex]).sum();
        of_centroid - sum / 4.0
    }

    /// Returns the centroid as a point of the corners.
    pub fn centroid(&self) -> Center {
        Center::in_tet(self.corners, [0.25; 4])
    }
}
