//! The surface of a mesh is closed, has outward orientation, and has the correct vertices.

use super::sample_meshes::{ROUND_OFF, assert_relative, enclosed_volume, grid, meshes};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn surfaces_are_closed() {
    for (name, mesh) in meshes() {
        let mut uses: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for &[a, b, c] in mesh.surface_triangles() {
            for edge in [[a, b], [b, c], [c, a]] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        for (&[from, to], &count) in &uses {
            assert_eq!(count, 1, "{name}: {from} → {to}");
            assert!(uses.contains_key(&[to, from]), "{name}: {to} → {from}");
        }
    }
}

#[test]
fn surfaces_turn_outwards_and_enclose_the_volume() {
    for (name, mesh) in meshes() {
        let (enclosed, volume) = (enclosed_volume(&mesh), mesh.volume());
        assert!(enclosed > 0.0, "{name}");
        assert_relative(enclosed, volume, ROUND_OFF);
    }
}

#[test]
fn vertices_are_on_the_surface_where_a_surface_triangle_has_them() {
    for (name, mesh) in meshes() {
        let used: BTreeSet<usize> = mesh.surface_triangles().iter().flatten().copied().collect();
        for vertex in 0..mesh.vertex_count() {
            assert_eq!(mesh.is_on_surface(vertex), used.contains(&vertex), "{name}");
        }
    }
    let block = grid([3, 3, 3], 1.0, |_| true);
    let inner = |v: &Vector3<f64>| v.iter().all(|x| *x > 0.5 && *x < 2.5);
    for (vertex, position) in block.vertices().iter().enumerate() {
        assert_eq!(block.is_on_surface(vertex), !inner(position));
    }
}
