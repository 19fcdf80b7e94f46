//! Derivatives of built-in shapes with respect to their dimensions, against differences and changes of size.

use hydroelastic::mesh::{MeshError, PressureField, ShapeRates, TriangleSurface, shapes};
use nalgebra::Vector3;

/// Error of differences. Vertices are piecewise linear in the dimensions, so the only error is the rounding error of coordinates divided by
/// steps of a thousandth of the dimension. The tolerance includes needles, whose dimensions are small relative to coordinates.
const DIFFERENCES: f64 = 1e-12;
const STEP: f64 = 1e-3;

/// Rounding error of a few products, relative to the largest coordinate.
const EXACT: f64 = 4e-16;

type Maker = fn(&[f64]) -> Result<PressureField, MeshError>;
type RatesOf = fn(&[f64]) -> Result<Vec<ShapeRates>, MeshError>;

/// A shape as a function of its dimensions, and its rates.
struct Family {
    name: &'static str,
    dimensions: Vec<f64>,
    shape: Maker,
    rates: RatesOf,
}

fn three(dimensions: &[f64]) -> [f64; 3] {
    dimensions.try_into().unwrap()
}

fn family(name: &'static str, dimensions: &[f64]) -> Family {
    let (shape, rates): (Maker, RatesOf) = match name {
        "ball" => (
            |lengths| shapes::icosphere(lengths[0], 2),
            |lengths| shapes::icosphere_rates(lengths[0], 2).map(|rates| vec![rates]),
        ),
        "ellipsoid" => (
            |lengths| shapes::ellipsoid(three(lengths), 2),
            |lengths| shapes::ellipsoid_rates(three(lengths), 2).map(Vec::from),
        ),
        "cuboid" => (
            |lengths| shapes::cuboid(three(lengths)),
            |lengths| shapes::cuboid_rates(three(lengths)).map(Vec::from),
        ),
        "distance cuboid" => (
            |lengths| shapes::distance_cuboid(three(lengths)),
            |lengths| shapes::distance_cuboid_rates(three(lengths)).map(Vec::from),
        ),
        "capsule" => (
            |it| shapes::capsule(it[0], it[1], 9),
            |it| shapes::capsule_rates(it[0], it[1], 9).map(Vec::from),
        ),
        _ => (
            |lengths| shapes::cylinder(lengths[0], lengths[1], 9),
            |lengths| shapes::cylinder_rates(lengths[0], lengths[1], 9).map(Vec::from),
        ),
    };
    Family {
        name,
        dimensions: dimensions.to_vec(),
        shape,
        rates,
    }
}

/// Returns shapes with generic dimensions, including slender and flat ones.
fn generic() -> Vec<Family> {
    vec![
        family("ball", &[0.7]),
        family("ellipsoid", &[0.3, 0.5, 0.2]),
        family("ellipsoid", &[1.0, 1e-4, 1e-4]),
        family("cuboid", &[0.3, 0.5, 0.2]),
        family("cuboid", &[0.3, 0.3, 0.3]),
        family("cuboid", &[1.0, 1e-5, 2e-5]),
        family("distance cuboid", &[0.3, 0.5, 0.2]),
        family("distance cuboid", &[0.2, 0.5, 0.5]),
        family("distance cuboid", &[1.0, 1e-3, 2e-3]),
        family("capsule", &[0.2, 1.3]),
        family("capsule", &[0.7, 0.3]),
        family("capsule", &[1e-3, 1.0]),
        family("capsule", &[1.0, 1e-3]),
        family("cylinder", &[0.2, 1.3]),
        family("cylinder", &[0.7, 0.3]),
        family("cylinder", &[1e-3, 1.0]),
        family("cylinder", &[1.0, 1e-3]),
    ]
}

/// Returns shapes with two equally near faces.
fn kinked() -> Vec<Family> {
    let inscribed = 0.2 * (std::f64::consts::PI / 9.0).cos();
    vec![
        family("distance cuboid", &[0.3, 0.3, 0.3]),
        family("distance cuboid", &[0.3, 0.5, 0.3]),
        family("cylinder", &[0.2, 2.0 * inscribed]),
    ]
}

fn scaled(family: &Family, scale: f64) -> Vec<f64> {
    family
        .dimensions
        .iter()
        .map(|length| length * scale)
        .collect()
}

#[test]
fn rates_are_what_differences_say_at_every_scale() {
    for family in generic() {
        for scale in [1.0, 1e-6, 1e6] {
            let dimensions = scaled(&family, scale);
            let rates = (family.rates)(&dimensions).unwrap();
            assert_eq!(rates.len(), dimensions.len());
            for (index, rates) in rates.iter().enumerate() {
                let step = STEP * dimensions[index];
                let moved = |sign: f64| {
                    let mut moved = dimensions.clone();
                    moved[index] += sign * step;
                    (family.shape)(&moved).unwrap()
                };
                let [ahead, behind] = [1.0, -1.0].map(moved);
                assert_eq!(ahead.extents(), behind.extents());
                assert_eq!(rates.extents, vec![0.0; ahead.extents().len()]);
                let pairs = ahead.mesh().vertices().iter().zip(behind.mesh().vertices());
                let differences = pairs.map(|(a, b)| (a - b) / (2.0 * step));
                // The rounding error of coordinates is that of the largest coordinate.
                let allowed = DIFFERENCES * (1.0 + ahead.reach() / dimensions[index]);
                assert_eq!(rates.vertices.len(), ahead.extents().len());
                for (difference, rate) in differences.zip(&rates.vertices) {
                    let error = (difference - rate).amax();
                    assert!(
                        error <= allowed,
                        "{} {dimensions:?}: {error:e}",
                        family.name
                    );
                }
                assert!(rates.ambiguous.is_empty());
            }
        }
    }
}

#[test]
fn by_all_dimensions_together_a_shape_grows() {
    for family in generic().into_iter().chain(kinked()) {
        for scale in [1.0, 1e-6, 1e6] {
            let dimensions = scaled(&family, scale);
            let rates = (family.rates)(&dimensions).unwrap();
            let field = (family.shape)(&dimensions).unwrap();
            for (vertex, at) in field.mesh().vertices().iter().enumerate() {
                let pairs = rates.iter().zip(&dimensions);
                let parts = pairs.map(|(rates, dimension)| rates.vertices[vertex] * *dimension);
                let error = (parts.sum::<Vector3<f64>>() - at).amax();
                assert!(error <= EXACT * field.reach(), "{}: {error:e}", family.name);
            }
        }
    }
}

#[test]
fn kinks_of_the_core_are_told() {
    for family in kinked() {
        for scale in [1.0, 1e-6, 1e6] {
            let dimensions = scaled(&family, scale);
            let field = (family.shape)(&dimensions).unwrap();
            let core = (0..field.extents().len()).filter(|&vertex| field.extents()[vertex] > 0.0);
            let core: Vec<_> = core.collect();
            for rates in (family.rates)(&dimensions).unwrap() {
                assert_eq!(rates.ambiguous, core, "{} {dimensions:?}", family.name);
            }
        }
    }
    // The ends of the core are equally far from the near faces on all four sides, so each edge moves them by half.
    let [by_x, by_y, by_z] = shapes::distance_cuboid_rates([0.3, 0.5, 0.3]).unwrap();
    let last = by_x.vertices.len() - 1;
    let ends = [by_x, by_y, by_z].map(|rates| rates.vertices[last]);
    let along_y = |rate: f64| Vector3::new(0.0, rate, 0.0);
    assert_eq!(ends, [-0.25, 0.5, -0.25].map(along_y));
    // A core that was omitted because the shape is slender remains omitted.
    let slender = shapes::distance_cuboid_rates([1.0, 4e-6, 6e-6]).unwrap();
    assert!(slender.iter().all(|rates| rates.ambiguous.is_empty()));
}

#[test]
fn rates_refuse_what_shapes_refuse() {
    let families = [
        family("ball", &[-1.0]),
        family("ellipsoid", &[1.0, 0.0, 1.0]),
        family("ellipsoid", &[1.0, 1e-7, 1e-7]),
        family("cuboid", &[1.0, f64::NAN, 1.0]),
        family("cuboid", &[1.0, 1.0, 1e-13]),
        family("distance cuboid", &[1.0, 1e-7, 1e-7]),
        family("cylinder", &[f64::INFINITY, 1.0]),
        family("cylinder", &[1e-7, 1.0]),
    ];
    for family in families {
        let refused = (family.shape)(&family.dimensions).unwrap_err();
        let error = (family.rates)(&family.dimensions).unwrap_err();
        // The comparison is as text, because NaN is not equal to NaN.
        assert_eq!(error.to_string(), refused.to_string());
    }
    assert!(shapes::capsule_rates(1.0, 1.0, 2).is_err());
    assert!(shapes::cylinder_rates(1.0, 1.0, 2).is_err());
    assert!(shapes::icosphere_rates(1.0, 9).is_err());
}

#[test]
fn the_surface_of_a_shape_moves_as_the_shape_does() {
    let lengths = [0.3, 0.5, 0.3];
    let field = shapes::distance_cuboid(lengths).unwrap();
    let [_, by_y, _] = shapes::distance_cuboid_rates(lengths).unwrap();
    let surface = TriangleSurface::around(field.mesh()).unwrap();
    let around = by_y.around(field.mesh()).unwrap();
    assert_eq!(around.vertices.len(), surface.vertices().len());
    for (vertex, rate) in surface.vertices().iter().zip(&around.vertices) {
        assert_eq!(*rate, Vector3::new(0.0, vertex.y / 0.5, 0.0));
    }
    assert!(around.extents.is_empty() && around.ambiguous.is_empty());
    let cuboid = shapes::cuboid(lengths).unwrap();
    assert_eq!(
        by_y.around(cuboid.mesh()).unwrap_err(),
        MeshError::RateCount {
            name: "vertices",
            found: 10,
            expected: 9
        }
    );
}
