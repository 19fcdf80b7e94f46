//! Growth with the number of contact polygons: two icospheres of increasing resolution at random poses.

use super::panel::{Curve, Panel};
use super::picture::time_tick;
use super::timing::{count, median, median_processor_seconds, time};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::hint::black_box;
use std::time::Duration;

const DISTANCES: [f64; 2] = [1.0, 1.7];
const POSES: usize = 5;
const BUDGET: Duration = Duration::from_millis(60);

/// Smallest number of polygons in the fit. With fewer polygons, the search for the first polygon distorts the exponent.
const FITTED_FROM: f64 = 500.0;

/// Medians over the poses.
struct Cost {
    polygons: f64,
    wrench: f64,
    jacobian: f64,
}

fn random_vector(random: &mut StdRng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-1.0..1.0))
}

/// Returns poses of both bodies, randomly rotated, at the given distance. The poses are the same for every mesh.
fn poses(distance: f64) -> Vec<[Pose; 2]> {
    let mut random = StdRng::seed_from_u64(1);
    let mut pose = |distance: f64| {
        let position = random_vector(&mut random).normalize() * distance;
        Pose::from_rotation_vector(&(random_vector(&mut random) * 3.0), position)
    };
    (0..POSES).map(|_| [pose(distance), pose(0.0)]).collect()
}

fn cost(shape: &Shape, distance: f64) -> Cost {
    let (mut polygons, mut wrench, mut jacobian) = (Vec::new(), Vec::new(), Vec::new());
    for [pose_a, pose_b] in poses(distance) {
        let body = |pose| ContactBody::new(shape, pose, 1.0).unwrap();
        let pair = ContactPair::new(body(pose_a), body(pose_b));
        polygons.push(pair.work_count().polygons as f64);
        wrench.push(median_processor_seconds(BUDGET, || {
            black_box(black_box(&pair).wrench());
        }));
        jacobian.push(median_processor_seconds(BUDGET, || {
            black_box(black_box(&pair).linearized());
        }));
    }
    Cost {
        polygons: median(polygons),
        wrench: median(wrench),
        jacobian: median(jacobian),
    }
}

/// Prints a line for each mesh and distance.
pub fn measured(is_quick: bool) -> Panel {
    println!("| order, distance | polygons | wrench | of it a polygon | wrench and Jacobian |");
    println!("| --- | --- | --- | --- | --- |");
    let mut wrench = Curve::new("wrench", FITTED_FROM);
    let mut jacobian = Curve::new("wrench and Jacobian", FITTED_FROM);
    for order in 1..=if is_quick { 5 } else { 6 } {
        let shape = Shape::new(shapes::icosphere(1.0, order).unwrap());
        for distance in DISTANCES {
            let cost = cost(&shape, distance);
            wrench.push(cost.polygons, cost.wrench);
            jacobian.push(cost.polygons, cost.jacobian);
            println!(
                "| {order}, {distance:.1} | {} | {} | {:.0} ns | {} |",
                count(cost.polygons),
                time(cost.wrench),
                cost.wrench / cost.polygons * 1e9,
                time(cost.jacobian),
            );
        }
    }
    Panel {
        title: "Contact polygons",
        x_label: "contact polygons",
        y_label: "time of one contact",
        y_tick: time_tick,
        curves: vec![wrench, jacobian],
    }
}
