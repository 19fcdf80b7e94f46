//! Contact surfaces: their visibility, area, colors, number and size in bytes.

use super::recorded_worlds::{
    ELASTIC, NAMED, RATE, SLOWDOWN, SURFACE, assert_near, named, read_back, resting, resting_on,
    rollout, rubbing, standing, state_at, times, tumbling,
};
use crate::support::glb::Glb;
use crate::support::worlds::{at, cuboid, dynamic, fixed, icosphere};
use gltf_json::{Index, Node};
use hydroelastic::contact::{ContactPolygon, Shape};
use hydroelastic::dynamics::{Body, BodyState, Contact, Plan, Trajectory, World};
use hydroelastic::io::Recording;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, vector};
use std::sync::Arc;

/// Rounding error of corners. Corners are moved to nearby corners on a grid of 1e-6 of the largest coordinate, at most √3 grid steps away,
/// and rounded to single precision.
const WELDED: f64 = 1.8e-6;
/// Largest number of contact surfaces in a recording.
const MOST_SURFACES: usize = 240;

/// Returns the visible surface at a time, if any. At most one surface may be visible.
fn visible_surface(glb: &Glb, time: f32) -> Option<Index<Node>> {
    let mut visible = glb.nodes(SURFACE);
    visible.retain(|&node| glb.is_visible(node, time));
    assert!(visible.len() <= 1, "{} surfaces at {time} s", visible.len());
    visible.pop()
}

fn polygons(contacts: &[Contact]) -> Vec<&ContactPolygon> {
    let surfaces = contacts.iter().map(|contact| &contact.surface);
    surfaces.flat_map(|surface| &surface.polygons).collect()
}

/// Returns the corners of polygons with their pressures.
fn corners(contacts: &[Contact]) -> Vec<(Vector3<f64>, f64)> {
    let of_polygon = |polygon: &ContactPolygon| -> Vec<_> {
        let corners = polygon.outline.corners().iter();
        corners
            .map(|corner| (*corner, polygon.pressure_at(corner)))
            .collect()
    };
    polygons(contacts)
        .into_iter()
        .flat_map(of_polygon)
        .collect()
}

#[test]
fn a_contact_surface_shows_while_bodies_touch() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "surfaces",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let times = times(&glb, "block");
    let touch = |time: &f32| {
        !world
            .contacts(state_at(&trajectory, *time, SLOWDOWN))
            .unwrap()
            .is_empty()
    };
    let (touching, apart): (Vec<f32>, Vec<f32>) = times.iter().partition(|time| touch(time));
    assert!(touching.len() > 20 && apart.len() > 20);
    assert!(
        touching
            .iter()
            .all(|&time| visible_surface(&glb, time).is_some())
    );
    assert!(
        apart
            .iter()
            .all(|&time| visible_surface(&glb, time).is_none())
    );
    // No two frames have the same surface here, so each frame has its own.
    assert_eq!(glb.nodes(SURFACE).len(), touching.len());
}

#[test]
fn a_contact_surface_has_the_area_and_the_centroid_of_its_polygons() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "areas",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let mut largest_count = 0;
    for time in times(&glb, "block") {
        let Some(node) = visible_surface(&glb, time) else {
            continue;
        };
        let contacts = world
            .contacts(state_at(&trajectory, time, SLOWDOWN))
            .unwrap();
        largest_count = largest_count.max(contacts.len());
        let corners = corners(&contacts);
        let reach = corners
            .iter()
            .map(|(corner, _)| corner.amax())
            .fold(0.0, f64::max);
        let polygons = polygons(&contacts);
        let rims = polygons.iter().map(|polygon| {
            let corners = polygon.outline.corners();
            let next = corners.iter().cycle().skip(1);
            corners
                .iter()
                .zip(next)
                .map(|(a, b)| (a - b).norm())
                .sum::<f64>()
        });
        // If the corners of a polygon move by at most this distance, its area changes by at most the distance times its perimeter.
        let moved = WELDED * reach;
        let tolerance = moved * rims.sum::<f64>();

        let shown = glb.mesh(node);
        let area: f64 = polygons.iter().map(|polygon| polygon.area).sum();
        assert!(
            (shown.area() - area).abs() <= tolerance,
            "{} {area}",
            shown.area()
        );
        let weighted: Vector3<f64> = polygons.iter().map(|p| p.centroid * p.area).sum();
        let centroid = weighted / area;
        let extent = corners.iter().map(|(corner, _)| (corner - centroid).norm());
        let tolerance = moved * area + tolerance * extent.fold(0.0, f64::max);
        assert_near(
            &shown.first_moment_about(&centroid),
            &Vector3::zeros(),
            tolerance,
        );
    }
    assert!(largest_count > 1, "no frame has two contacts");
}

/// Returns the brightness of a linear color (CIE Y of sRGB primaries), from 0 to 255.
fn luminance(color: [u8; 4]) -> f64 {
    let [r, g, b, _] = color.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn colors_brighten_with_pressure_up_to_the_peak() {
    /// Rounding error of a color component. It is rounded once on the screen's scale, whose steps are up to 2.3 linear steps, and once on
    /// the linear scale.
    const ROUNDED: f64 = 2.3 + 1.0;

    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "colors",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let mut colored: Vec<(f64, [u8; 4])> = Vec::new();
    for time in times(&glb, "block") {
        let Some(node) = visible_surface(&glb, time) else {
            continue;
        };
        let corners = corners(
            &world
                .contacts(state_at(&trajectory, time, SLOWDOWN))
                .unwrap(),
        );
        let shown = glb.mesh(node);
        for (point, color) in shown.points.iter().zip(&shown.colors) {
            let apart = |corner: &Vector3<f64>| (corner - point).norm();
            let nearest = corners
                .iter()
                .min_by(|a, b| apart(&a.0).total_cmp(&apart(&b.0)));
            colored.push((nearest.unwrap().1, *color));
        }
    }
    colored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut brightest, mut darkest) = (0.0_f64, f64::MAX);
    for (_, color) in &colored {
        assert_eq!(color[3], u8::MAX);
        let bright = luminance(*color);
        assert!(bright >= brightest - ROUNDED);
        (brightest, darkest) = (brightest.max(bright), darkest.min(bright));
    }
    let (peak, color) = colored[colored.len() - 1];
    assert!(luminance(color) >= brightest);
    assert!(darkest < 10.0 && brightest > 200.0, "{darkest} {brightest}");
    let name = glb.name(glb.nodes(SURFACE)[0]);
    let claimed = named(name, "brightest at", "Pa");
    assert!(
        (claimed / peak - 1.0).abs() <= NAMED,
        "{name}, but {peak} Pa"
    );
}

/// Returns a hammer that touches a heavy block in every other frame.
fn hammering() -> World {
    let cube = || cuboid([0.1; 3]);
    let path = |time: f64| {
        let is_up = (time * RATE).round() % 2.0 > 0.5;
        let height = if is_up { 0.12 } else { 0.09 };
        BodyState {
            pose: at(0.0, 0.0, height),
            twist: Twist::zero(),
        }
    };
    World::new(vec![
        dynamic("block", cube(), ELASTIC, 1e9),
        Body::kinematic("hammer", cube(), ELASTIC, Arc::new(path)).unwrap(),
    ])
    .unwrap()
}

/// Returns the number of contact surfaces in a recording with many contact frames, in which the given body moves. Each contact frame shows
/// one surface, and no other frame shows a surface.
fn surfaces_of_a_long_recording(body: &str, world: &World, rollout: &Trajectory) -> usize {
    let glb = read_back(&format!("long_{body}"), &Recording::new(world, rollout));
    let mut touching = 0;
    for time in times(&glb, body) {
        let is_touching = !world
            .contacts(state_at(rollout, time, 1.0))
            .unwrap()
            .is_empty();
        touching += usize::from(is_touching);
        assert_eq!(visible_surface(&glb, time).is_some(), is_touching, "{time}");
    }
    assert!(touching > MOST_SURFACES);
    glb.nodes(SURFACE).len()
}

#[test]
fn a_long_contact_has_no_more_surfaces_than_a_recording_may() {
    let world = resting();
    let plan = Plan::new(1e-3, 7_000).unwrap().recording_every(10);
    let rollout = world.rollout(&plan).run().unwrap();
    let count = surfaces_of_a_long_recording("ball", &world, &rollout);
    assert!(
        (MOST_SURFACES / 2..=MOST_SURFACES).contains(&count),
        "{count}"
    );
}

#[test]
fn many_short_contacts_have_no_more_surfaces_than_a_recording_may() {
    let world = hammering();
    let rollout = world.rollout(&Plan::new(1.0 / RATE, 600).unwrap());
    let rollout = rollout.run().unwrap();
    let count = surfaces_of_a_long_recording("hammer", &world, &rollout);
    assert!(
        (MOST_SURFACES / 2..=MOST_SURFACES).contains(&count),
        "{count}"
    );
}

/// Returns the size in bytes, in the JSON and in the buffer, of the data used only by contact surfaces.
fn bytes_of_surfaces(glb: &Glb) -> usize {
    let root = &glb.root;
    let surfaces = glb.nodes(SURFACE);
    let animation = &root.animations[0];
    let mut json = 0;
    let mut accessors = Vec::new();
    for &node in &surfaces {
        let node = root.get(node).unwrap();
        json += length(node) + length(root.get(node.mesh.unwrap()).unwrap());
        let primitive = &root.get(node.mesh.unwrap()).unwrap().primitives[0];
        accessors.extend(primitive.attributes.values().chain(&primitive.indices));
    }
    for channel in &animation.channels {
        if surfaces.contains(&channel.target.node) {
            let sampler = &animation.samplers[channel.sampler.value()];
            json += length(channel) + length(sampler);
            accessors.extend([sampler.input, sampler.output]);
        }
    }
    accessors.sort_unstable();
    accessors.dedup();
    let accessors: Vec<_> = accessors
        .into_iter()
        .map(|index| root.get(index).unwrap())
        .collect();
    json += accessors.iter().map(length).sum::<usize>();
    let numbers = accessors.into_iter().map(|accessor| {
        let size = accessor.component_type.unwrap().0.size();
        let together = accessor.type_.unwrap().multiplicity();
        let count = usize::try_from(accessor.count.0).unwrap();
        (size * together * count).next_multiple_of(4)
    });
    // A comma follows each piece of JSON: node, mesh, channel, sampler and about five accessors.
    json + 9 * surfaces.len() + numbers.sum::<usize>()
}

/// Returns the number of bytes of its JSON.
fn length(part: &impl serde::Serialize) -> usize {
    serde_json::to_vec(part).unwrap().len()
}

#[test]
fn contact_surfaces_are_as_long_as_the_documentation_says() {
    let floor = |_| cuboid([1.0, 1.0, 0.2]);
    let ball = |order| icosphere(0.1, order);
    let on_floor = bytes_of_polygons_and_surfaces("floor", floor);
    let on_ball = bytes_of_polygons_and_surfaces("ball", ball);
    for [of_polygon, of_surface] in [on_floor, on_ball] {
        assert!((20.0..30.0).contains(&of_polygon), "{of_polygon}");
        assert!((800.0..900.0).contains(&of_surface), "{of_surface}");
    }
}

/// Returns the bytes per polygon, and the additional bytes per surface. The recordings have few and many polygons in equally many surfaces,
/// of a ball on a body of some resolution.
fn bytes_of_polygons_and_surfaces(name: &str, below: impl Fn(usize) -> Shape) -> [f64; 2] {
    let sizes = [1, 3].map(|order| {
        let world = resting_on(below(order), order);
        let plan = Plan::new(1e-3, 1_000).unwrap().recording_every(20);
        let trajectory = world.rollout(&plan).run().unwrap();
        let recording = Recording::new(&world, &trajectory);
        let glb = read_back(&format!("sizes_on_{name}_{order}"), &recording);
        let states = trajectory.states().iter();
        let polygons: usize = states
            .map(|state| polygons(&world.contacts(state).unwrap()).len())
            .sum();
        let surfaces = glb.nodes(SURFACE).len();
        assert_eq!(surfaces, trajectory.states().len());
        [bytes_of_surfaces(&glb), polygons, surfaces].map(|number| number as f64)
    });
    let [[few_bytes, few, surfaces], [many_bytes, many, _]] = sizes;
    let of_polygon = (many_bytes - few_bytes) / (many - few);
    let of_surface = (few_bytes - of_polygon * few) / surfaces;
    println!("on a {name}: {of_polygon:.1} bytes a polygon, {of_surface:.0} a surface");
    [of_polygon, of_surface]
}

/// Returns two cubes whose corners overlap by a small depth (m).
fn barely_touching(depth: f64) -> World {
    let cube = || cuboid([0.1; 3]);
    let axis = vector![1.0, -1.0, 0.0].normalize();
    let corner_down = axis * (1.0_f64 / 3.0).sqrt().acos();
    let height = 0.05 + 0.05 * 3.0_f64.sqrt() - depth;
    let tilted = Pose::from_rotation_vector(&corner_down, vector![0.0, 0.0, height]);
    World::new(vec![
        dynamic("tilted", cube(), ELASTIC, 1.0).with_pose(tilted),
        fixed("flat", cube(), ELASTIC),
    ])
    .unwrap()
}

#[test]
fn a_contact_smaller_than_single_precision_has_no_surface() {
    for (name, depth, count) in [("touch", 1e-9, 0), ("press", 1e-3, 1)] {
        let world = barely_touching(depth);
        assert_eq!(world.contacts(&world.initial_state()).unwrap().len(), 1);
        let glb = read_back(name, &Recording::new(&world, &standing(&world)));
        assert_eq!(glb.nodes(SURFACE).len(), count);
        let primitives = glb.root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        for indices in primitives.filter_map(|primitive| primitive.indices) {
            assert!(glb.root.get(indices).unwrap().count.0 > 0);
        }
    }
}
