//! The contact surface of two octahedra, polygon by polygon. All of its public properties have closed forms.

use crate::support::octahedra::{OVERLAP, fall, force, octahedron, poses, slope, stacked, stage};
use crate::support::scenes::{Random, grid, mixed_shapes, pair, random_pair};
use crate::support::worlds::{at, cuboid};
use hydroelastic::contact::{ContactBody, ContactPair, ContactPolygon, Partner, Shape};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Rounding error, relative to the largest number of the same kind.
const EXACT: f64 = 1e-12;

/// Moduli (Pa) of A and B: equal, A softer, and B softer.
const MODULI: [[f64; 2]; 3] = [[1e5, 1e5], [1e5, 3e5], [4e5, 1e5]];

fn assert_near(actual: f64, expected: f64, scale: f64) {
    let error = (actual - expected).abs();
    assert!(error <= EXACT * scale, "{actual} {expected} {error:e}");
}

/// One of the four triangles of the roof-shaped contact surface, on the stage.
struct Triangle {
    signs: [f64; 2],
    moduli: [f64; 2],
}

impl Triangle {
    /// Returns the expected triangle of a polygon.
    fn of(polygon: &ContactPolygon, moduli: [f64; 2]) -> Self {
        let centroid = stage().inverse().transformed_point(&polygon.centroid);
        let signs = [centroid.x.signum(), centroid.y.signum()];
        Self { signs, moduli }
    }

    /// Returns a point of the roof in this quadrant, given its distances from the middle along x and y.
    fn point(&self, x: f64, y: f64) -> Vector3<f64> {
        let z = slope(self.moduli) * (OVERLAP - x - y);
        stage().transformed_point(&vector![self.signs[0] * x, self.signs[1] * y, z])
    }

    fn turned(&self, x: f64, y: f64, z: f64) -> Vector3<f64> {
        stage().rotation() * vector![self.signs[0] * x, self.signs[1] * y, z]
    }

    fn steepness(&self) -> f64 {
        (1.0 + 2.0 * slope(self.moduli).powi(2)).sqrt()
    }

    /// Returns the area (m²).
    fn area(&self) -> f64 {
        OVERLAP * OVERLAP / 2.0 * self.steepness()
    }

    fn normal(&self) -> Vector3<f64> {
        let c = slope(self.moduli);
        self.turned(c, c, 1.0) / self.steepness()
    }

    fn flatter_gradient(&self) -> Vector3<f64> {
        let [a, b] = self.moduli;
        let upward = if a <= b { 1.0 } else { -1.0 };
        self.turned(-1.0, -1.0, upward) * a.min(b)
    }
}

#[test]
fn every_polygon_is_a_triangle_of_the_roof() {
    let shape = octahedron(0);
    for moduli in MODULI {
        let surface = stacked(&shape, moduli).surface();
        assert_eq!(surface.polygons.len(), 4);
        for polygon in &surface.polygons {
            let triangle = Triangle::of(polygon, moduli);
            let third = OVERLAP / 3.0;
            assert_near(polygon.area, triangle.area(), polygon.area);
            let centroid = triangle.point(third, third);
            assert_near((polygon.centroid - centroid).amax(), 0.0, 1.0);
            assert_near((polygon.normal - triangle.normal()).amax(), 0.0, 1.0);
            for corner in [[0.0, 0.0], [OVERLAP, 0.0], [0.0, OVERLAP]] {
                let expected = triangle.point(corner[0], corner[1]);
                let is_near = |c: &Vector3<f64>| (c - expected).amax() <= EXACT;
                assert!(polygon.outline.corners().iter().any(is_near));
            }
        }
    }
}

#[test]
fn pressure_of_a_polygon_falls_from_the_middle_to_the_rim() {
    let shape = octahedron(0);
    for moduli in MODULI {
        let (k, scale) = (fall(moduli), fall(moduli) * OVERLAP);
        for polygon in stacked(&shape, moduli).surface().polygons {
            let triangle = Triangle::of(&polygon, moduli);
            assert_near(polygon.pressure, k * OVERLAP / 3.0, scale);
            for [x, y] in [[0.0, 0.0], [OVERLAP, 0.0], [0.0, OVERLAP], [0.1, 0.05]] {
                let pressure = polygon.pressure_at(&triangle.point(x, y));
                assert_near(pressure, k * (OVERLAP - x - y), scale);
            }
            let gradient = triangle.flatter_gradient();
            assert_near((polygon.pressure_gradient - gradient).amax(), 0.0, k);
        }
    }
}

#[test]
fn force_of_a_polygon_acts_through_its_center_of_pressure() {
    let shape = octahedron(0);
    for moduli in MODULI {
        for polygon in stacked(&shape, moduli).surface().polygons {
            let triangle = Triangle::of(&polygon, moduli);
            // The expected force is a quarter of the upward force. The slope accounts for the inclination of the roof.
            let expected = triangle.normal() * triangle.steepness() * force(moduli) / 4.0;
            let error = (polygon.force() - expected).amax();
            assert_near(error, 0.0, force(moduli));
            // ∫ x (L − x − y)/∫ (L − x − y) = (L⁴/24)/(L³/6).
            let center = triangle.point(OVERLAP / 4.0, OVERLAP / 4.0);
            assert_near((polygon.center_of_pressure - center).amax(), 0.0, 1.0);
        }
    }
}

#[test]
fn whole_surface_has_the_area_center_force_and_energy_of_the_roof() {
    let shape = octahedron(0);
    for moduli in MODULI {
        let (pair, c) = (stacked(&shape, moduli), slope(moduli));
        let surface = pair.surface();
        assert!(!surface.is_empty());
        let area = 2.0 * OVERLAP * OVERLAP * (1.0 + 2.0 * c * c).sqrt();
        assert_near(surface.area(), area, area);
        // The center is at half the height of the roof: over a quarter, ∫ c (L − s)²/∫ (L − s) is c (L⁴/12)/(L³/6).
        let center = stage().transformed_point(&vector![0.0, 0.0, c * OVERLAP / 2.0]);
        let error = (surface.center_of_pressure().unwrap() - center).amax();
        assert_near(error, 0.0, 1.0);
        let expected = stage().rotation() * Vector3::z() * force(moduli);
        let actual = pair.wrench().on_a.force;
        assert_near((actual - expected).amax(), 0.0, force(moduli));
        // The force does work over the distance 2 dL: ∫ 2 k l³/3 · 2 dl = k L⁴/3.
        let energy = fall(moduli) * OVERLAP.powi(4) / 3.0;
        assert_near(pair.potential_energy(), energy, energy);
    }
}

#[test]
fn derivatives_of_area_and_center_by_an_approach_are_the_closed_ones() {
    use hydroelastic::contact::{ContactBody, ContactPair};
    use num_dual::Dual64;
    let (shape, moduli) = (octahedron(0), MODULI[1]);
    let [above, below] = poses();
    // L grows by half of A's downward displacement.
    let down = stage().rotation() * vector![0.0, 0.0, -1.0];
    let lowered = Pose::<Dual64>::lifted(&above);
    let moved = lowered.translation() + down.map(|part| Dual64::new(0.0, part));
    let a = ContactBody::new(&shape, lowered.with_translation(moved), moduli[0].into()).unwrap();
    let b = ContactBody::new(&shape, Pose::lifted(&below), moduli[1].into()).unwrap();
    let surface = ContactPair::new(a, b).surface();
    let (c, area) = (slope(moduli), surface.area());
    let expected = 2.0 * OVERLAP * (1.0 + 2.0 * c * c).sqrt();
    assert_near(area.eps, expected, expected);
    // The middle moves down by half of the displacement, and half the roof's height grows by c/4.
    let center = surface.center_of_pressure().unwrap().map(|x| x.eps);
    let expected = down * (0.5 - c / 4.0);
    assert_near((center - expected).amax(), 0.0, 1.0);
}

/// Along a polygon, both fields have the same gradient. Across the polygon, the gradient of the flatter field has the smaller rounding
/// error.
#[test]
fn pressure_gradient_of_a_polygon_is_that_of_the_flatter_field() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(81));
    let mut count = 0;
    for _ in 0..50 {
        let pair = random_pair(&shapes, &mut random);
        for polygon in pair.surface().polygons {
            let gradients = [
                (pair.a(), polygon.tets[0]),
                (&pair.b().body().unwrap(), polygon.tets[1]),
            ]
            .map(|(body, tet)| {
                let extent = body.shape().field().tets()[tet].extent.gradient;
                body.pose().rotation() * extent * body.modulus()
            });
            let [a, b] = gradients;
            let flatter = if a.norm() <= b.norm() { a } else { b };
            assert_near(
                (polygon.pressure_gradient - flatter).amax(),
                0.0,
                flatter.norm(),
            );
            count += 1;
        }
    }
    assert!(count > 1_000, "{count}");
}

#[test]
fn a_shape_is_printed_by_its_number_of_tetrahedra() {
    assert_eq!(format!("{:?}", octahedron(0)), "Shape { tets: 8, .. }");
}

/// In both grids, a layer of inner faces lies in the contact surface. The tetrahedra above the layer in one grid and below the layer in the
/// other share a polygon with zero weight.
#[test]
fn all_polygons_have_an_area_where_inner_faces_of_both_bodies_lie_in_the_surface() {
    let layers = Shape::new(grid(&[4, 4, 4], 0.25, |_| true).unwrap());
    for aside in [[0.03, 0.02], [0.0, 0.02], [0.125, 0.0]] {
        let above = at(aside[0], aside[1], 0.5);
        let pair = pair((&layers, above, 2e4), (&layers, Pose::identity(), 2e4));
        let surface = pair.surface();
        assert!(!surface.polygons.is_empty());
        assert!(surface.polygons.iter().all(|polygon| polygon.area > 0.0));
        assert_eq!(pair.touching_tets().len(), surface.polygons.len());
    }
}

#[test]
fn the_center_of_pressure_is_the_centroid_where_the_force_is_less_than_the_least_number() {
    let cube = cuboid([1.0; 3]);
    let pressed_in = at(0.0, 0.0, 0.4);
    let plane = Partner::rigid_half_space(Pose::identity()).unwrap();
    // With the first modulus, the pressure is 0 in double precision; with the second, the force of small polygons is 0.
    for modulus in [5e-324, 1e-322] {
        let cube = ContactBody::new(&cube, pressed_in, modulus).unwrap();
        let mut polygons = ContactPair::new(cube, plane).surface().polygons;
        polygons.retain(|polygon| polygon.pressure * polygon.area == 0.0);
        assert!(!polygons.is_empty());
        for polygon in polygons {
            assert_eq!(polygon.center_of_pressure, polygon.centroid);
        }
    }
}
