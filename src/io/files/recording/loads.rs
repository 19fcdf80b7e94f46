//! Contact forces and torques of all frames, and their points of application.

use super::frames::Frame;
use crate::dynamics::{Body, Contact};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// A force (N) or torque (N m), and its point of application (m, world frame).
#[derive(Clone, Copy)]
pub(super) struct Load {
    pub point: Vector3<f64>,
    pub vector: Vector3<f64>,
}

/// A named load in each frame, or `None` in frames without contact.
pub(super) struct Loads {
    pub name: String,
    pub by_frame: Vec<Option<Load>>,
}

/// Largest norm of the vectors (N or N m).
pub(super) fn largest(loads: &[Loads]) -> f64 {
    let all = loads.iter().flat_map(|loads| &loads.by_frame).flatten();
    all.map(|load| load.vector.norm()).fold(0.0, f64::max)
}

/// Contact force (N) on the first dynamic body of a pair, at the center of pressure, for all pairs that touch in any frame.
pub(super) fn forces(bodies: &[Body], frames: &[Frame]) -> Vec<Loads> {
    let of_frame = |frame: &Frame| {
        let contacts = frame.contacts.iter();
        contacts
            .filter_map(|contact| Some((contact.bodies, force(contact, bodies)?)))
            .collect()
    };
    let name = |[a, b]: &[usize; 2]| {
        format!(
            "force between {} and {}",
            bodies[*a].name(),
            bodies[*b].name()
        )
    };
    by_frame(frames, of_frame, name)
}

/// Torque (N m) of all contacts on a dynamic body about its center of mass, for all bodies that touch in any frame.
pub(super) fn torques(bodies: &[Body], frames: &[Frame]) -> Vec<Loads> {
    let name = |body: &usize| format!("contact torque on {}", bodies[*body].name());
    by_frame(frames, |frame| torques_of(frame, bodies), name)
}

fn force(contact: &Contact, bodies: &[Body]) -> Option<Load> {
    let is_a_dynamic = bodies[contact.bodies[0]].inertia().is_some();
    let wrench = if is_a_dynamic {
        contact.wrench.on_a
    } else {
        contact.wrench.on_b
    };
    let point = contact.surface.center_of_pressure()?;
    Some(Load {
        point,
        vector: wrench.force,
    })
}

fn torques_of(frame: &Frame, bodies: &[Body]) -> BTreeMap<usize, Load> {
    let mut torques: BTreeMap<usize, Load> = BTreeMap::new();
    for contact in &frame.contacts {
        let wrenches = [contact.wrench.on_a, contact.wrench.on_b];
        for (body, wrench) in contact.bodies.into_iter().zip(wrenches) {
            let Some(inertia) = bodies[body].inertia() else {
                continue;
            };
            let pose = &frame.state.bodies[body].pose;
            let to_center = pose.rotation() * inertia.center_of_mass;
            let load = torques.entry(body).or_insert(Load {
                point: pose.translation() + to_center,
                vector: Vector3::zeros(),
            });
            load.vector += wrench.about(&to_center).torque;
        }
    }
    torques
}

/// Groups the loads of all frames by key.
fn by_frame<K: Ord>(
    frames: &[Frame],
    of_frame: impl Fn(&Frame) -> BTreeMap<K, Load>,
    name: impl Fn(&K) -> String,
) -> Vec<Loads> {
    let mut groups: BTreeMap<K, Vec<Option<Load>>> = BTreeMap::new();
    for (index, frame) in frames.iter().enumerate() {
        for (key, load) in of_frame(frame) {
            let loads = groups
                .entry(key)
                .or_insert_with(|| vec![None; frames.len()]);
            loads[index] = Some(load);
        }
    }
    let named = groups.into_iter().map(|(key, by_frame)| Loads {
        name: name(&key),
        by_frame,
    });
    named.collect()
}
