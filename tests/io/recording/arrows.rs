//! Arrows for contact forces and contact torques: position, direction, length and shape.

use super::recorded_worlds::{
    ELASTIC, NAMED, SINGLE, SINGLE_TURN, SLOWDOWN, assert_near, named, read_back, resting, rollout,
    rubbing, standing, state_at, times, tumbling,
};
use crate::support::glb::Glb;
use gltf_json::{Index, Node};
use hydroelastic::contact::ContactPolygon;
use hydroelastic::io::Recording;
use nalgebra::{Vector3, vector};

/// Returns position and direction (times its length, m) of a force or torque node at a time.
fn arrow_at(glb: &Glb, node: Index<Node>, time: f32) -> (Vector3<f64>, Vector3<f64>) {
    let shown = glb.placement(node, time);
    let length = shown.scale.x;
    assert_eq!(shown.scale, Vector3::repeat(length));
    (shown.translation, shown.rotation * Vector3::z() * length)
}

/// Compares all arrows of one load, in frames with a time each, with the load: a point and a vector. The longest vector of all loads is
/// given.
fn assert_arrows(
    glb: &Glb,
    (beginning, unit): (&str, &str),
    loads: &[(f32, Option<[Vector3<f64>; 2]>)],
    largest: f64,
) {
    let node = glb.node(beginning);
    let name = glb.name(node);
    let length = named(name, ", ", " m for");
    assert!(
        (named(name, "m for", unit) / largest - 1.0).abs() <= NAMED,
        "{name}"
    );
    let mut longest: f64 = 0.0;
    for (time, load) in loads {
        let (point, arrow) = arrow_at(glb, node, *time);
        longest = longest.max(arrow.norm());
        let Some([at, vector]) = load else {
            assert!(arrow.norm() <= 0.0, "{name} at {time} s");
            continue;
        };
        assert_near(&point, at, SINGLE * at.amax());
        // The direction of an arrow is rounded, and so is the length in its name.
        let tolerance = SINGLE_TURN * vector.norm() + NAMED * vector.norm();
        assert_near(&(arrow * largest / length), vector, tolerance);
    }
    assert!(longest <= length * (1.0 + NAMED));
}

fn norms<'a>(loads: impl IntoIterator<Item = &'a Option<[Vector3<f64>; 2]>>) -> f64 {
    let vectors = loads.into_iter().flatten().map(|load| load[1].norm());
    vectors.fold(0.0, f64::max)
}

#[test]
fn an_arrow_is_the_force_on_the_first_body_that_moves() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "forces",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let times = times(&glb, "block");
    let force = |time: f32, bodies: [usize; 2]| {
        let contacts = world
            .contacts(state_at(&trajectory, time, SLOWDOWN))
            .unwrap();
        let contact = contacts
            .into_iter()
            .find(|contact| contact.bodies == bodies)?;
        // The floor is body 0, which does not move.
        let wrench = if bodies[0] == 0 {
            contact.wrench.on_b
        } else {
            contact.wrench.on_a
        };
        Some([contact.surface.center_of_pressure()?, wrench.force])
    };
    let loads = [[0, 1], [1, 2]].map(|bodies| -> Vec<_> {
        times
            .iter()
            .map(|&time| (time, force(time, bodies)))
            .collect()
    });
    let largest = norms(loads.iter().flatten().map(|(_, load)| load));
    let names = [
        "force between floor and block",
        "force between block and ball",
    ];
    for (name, loads) in names.into_iter().zip(&loads) {
        assert!(loads.iter().any(|(_, load)| load.is_some()));
        assert_arrows(&glb, (name, "N"), loads, largest);
    }
}

#[test]
fn an_arrow_is_the_torque_of_contacts_about_the_center_of_mass() {
    // The contact is elastic, so the torque is the sum over polygons of arm × pressure, independent of the wrench.
    let world = tumbling(ELASTIC);
    let trajectory = rollout(&world);
    let glb = read_back(
        "torques",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let center_of_mass = [vector![0.04, -0.02, 0.01], Vector3::zeros()];
    let torque = |time: f32, body: usize| {
        let state = state_at(&trajectory, time, SLOWDOWN);
        let center = state.bodies[body]
            .pose
            .transformed_point(&center_of_mass[body - 1]);
        let mut contacts = world.contacts(state).unwrap();
        contacts.retain(|contact| contact.bodies.contains(&body));
        let about_center = contacts.iter().flat_map(|contact| {
            let sign = if contact.bodies[0] == body { 1.0 } else { -1.0 };
            let torque = move |polygon: &ContactPolygon| {
                (polygon.center_of_pressure - center).cross(&polygon.force()) * sign
            };
            contact.surface.polygons.iter().map(torque)
        });
        (!contacts.is_empty()).then(|| [center, about_center.sum()])
    };
    let times = times(&glb, "block");
    let loads = [1, 2].map(|body| -> Vec<_> {
        times
            .iter()
            .map(|&time| (time, torque(time, body)))
            .collect()
    });
    let largest = norms(loads.iter().flatten().map(|(_, load)| load));
    for (name, loads) in ["block", "ball"].into_iter().zip(&loads) {
        let beginning = format!("contact torque on {name}");
        assert!(loads.iter().any(|(_, load)| load.is_some()));
        assert_arrows(&glb, (&beginning, "N m"), loads, largest);
    }
}

#[test]
fn an_arrow_is_a_closed_surface_of_length_one_along_z() {
    let world = tumbling(rubbing());
    let glb = read_back("arrows", &Recording::new(&world, &rollout(&world)));
    for beginning in ["force between floor and block", "contact torque on block"] {
        let arrow = glb.mesh(glb.node(beginning));
        let heights = arrow.points.iter().map(|point| point.z);
        let ends = [f64::min, f64::max].map(|extreme| heights.clone().reduce(extreme).unwrap());
        assert!(ends[0].abs() <= SINGLE && (ends[1] - 1.0).abs() <= SINGLE);
        assert!(arrow.points.iter().all(|point| point.xy().norm() < 0.1));
        let outwards: Vector3<f64> = arrow
            .corners()
            .map(|[a, b, c]| (b - a).cross(&(c - a)))
            .sum();
        assert!(
            outwards.norm() < SINGLE_TURN * arrow.area(),
            "the arrow has a hole"
        );
        assert!(arrow.volume() > 0.0, "the arrow is inside out");
    }
}

#[test]
fn a_central_blow_has_no_torque() {
    let world = resting();
    let glb = read_back("central", &Recording::new(&world, &standing(&world)));
    assert_eq!(glb.nodes("force between").len(), 1);
    assert_eq!(
        glb.nodes("contact torque").len(),
        0,
        "round-off has an arrow"
    );
}
