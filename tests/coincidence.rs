//! Linearised contacts of pairs in motion, at special positions above all, against differences.

mod support;

use support::moving::bodies::Bodies;
use support::moving::poses::{Family, scene};
use support::moving::verdict::{Checked, Finding, checked};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Pairs that share a set of shapes.
const BATCH: usize = 512;

const SHORT: usize = 4 * BATCH;

fn tried(batch: usize, numbers: std::ops::Range<usize>) -> Vec<(usize, Vec<Checked>)> {
    let bodies = Bodies::new(batch as u64);
    numbers
        .map(|number| {
            let family = Family::ALL[number % Family::ALL.len()];
            (number, checked(&scene(&bodies, family, number as u64)))
        })
        .collect()
}

#[test]
#[ignore = "exploration"]
fn explore() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<usize>().unwrap());
    let (first, count) = (number("FIRST").unwrap_or(0), number("PAIRS").unwrap_or(SHORT));
    let (end, next) = (first + count, AtomicUsize::new(first / BATCH));
    let work = || {
        let mut all = Vec::new();
        loop {
            let batch = next.fetch_add(1, Ordering::Relaxed);
            let numbers = first.max(batch * BATCH)..end.min((batch + 1) * BATCH);
            if numbers.is_empty() {
                return all;
            }
            all.extend(tried(batch, numbers));
        }
    };
    let all: Vec<_> = thread::scope(|scope| {
        let handles: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
        handles.into_iter().flat_map(|handle| handle.join().unwrap()).collect()
    });
    for (f, family) in Family::ALL.iter().enumerate() {
        let of: Vec<_> = all.iter().filter(|(n, _)| n % Family::ALL.len() == f).collect();
        let mut counts = std::collections::BTreeMap::new();
        for (number, found) in &of {
            let mut names: Vec<String> = found.iter().map(|c| match c.finding {
                Finding::Wrong(e) => { println!("{family:?} {number} column {} wrong {e:.1e}", c.column); "Wrong".to_string() }
                Finding::NotMean(e) => { println!("{family:?} {number} column {} notmean {e:.2}", c.column); "NotMean".to_string() }
                other => format!("{other:?}"),
            }).collect();
            names.sort();
            names.dedup();
            for name in names { *counts.entry(name).or_insert(0) += 1; }
        }
        println!("{family:?}: {} {counts:?}", of.len());
    }
}

#[test]
#[ignore = "exploration"]
fn detail() {
    use support::moving::differences::Scaled;
    let number: usize = std::env::var("NUMBER").unwrap().parse().unwrap();
    let bodies = Bodies::new((number / BATCH) as u64);
    let mut scene = scene(&bodies, Family::ALL[number % Family::ALL.len()], number as u64);
    if let Ok(f) = std::env::var("FACTOR") {
        let f: f64 = f.parse().unwrap();
        let ab = scene.pair.a().pose().inverse() * *scene.pair.b().pose();
        let r0 = ab.rotation().map(|x| x.round());
        let w = r0.transpose() * ab.rotation();
        let w = nalgebra::Vector3::new(w[(2, 1)] - w[(1, 2)], w[(0, 2)] - w[(2, 0)], w[(1, 0)] - w[(0, 1)]) * (0.5 * f);
        let t = ab.translation().map(|x| if x.abs() < 1e-5 { x * f } else { x });
        use hydroelastic::spatial::Pose;
        let pose = Pose::new(r0, nalgebra::Vector3::zeros()).unwrap() * Pose::from_rotation_vector(&w, nalgebra::Vector3::zeros());
        let pose = pose.with_translation(t);
        let pose = match std::env::var("T") { Ok(t) => { let v: Vec<f64> = t.split(',').map(|x| x.parse().unwrap()).collect(); pose.with_translation(nalgebra::Vector3::new(v[0], v[1], v[2])) } _ => pose };
        let shapes = [[ "SA", "SB"]].map(|n| n.map(|n| std::env::var(n).ok().map(|i| &bodies.shapes[i.parse::<usize>().unwrap()])))[0];
        scene.pair = support::scenes::pair((shapes[0].unwrap_or(scene.pair.a().shape()), *scene.pair.a().pose(), scene.pair.a().modulus()), (shapes[1].unwrap_or(scene.pair.b().shape()), *scene.pair.b().pose(), scene.pair.b().modulus()));
        let inv = scene.pair.a().pose().inverse();
        for t in &mut scene.twists { t.angular = inv.rotation() * t.angular; t.linear = inv.rotation() * t.linear; }
        if let Ok(d) = std::env::var("D") { scene.dissipation = d.parse().unwrap(); }
        if let Ok(d) = std::env::var("MU") { scene.friction = d.parse().unwrap(); }
        if let Ok(d) = std::env::var("EB") { scene.pair = support::scenes::pair((scene.pair.a().shape(), Pose::identity(), scene.pair.a().modulus()), (scene.pair.b().shape(), pose, d.parse().unwrap())); }
        scene.pair = support::scenes::pair((scene.pair.a().shape(), Pose::identity(), scene.pair.a().modulus()), (scene.pair.b().shape(), pose, scene.pair.b().modulus()));
    }
    let scene = scene;
    let index = |shape: &hydroelastic::contact::Shape| bodies.shapes.iter().position(|s| std::ptr::eq(s, shape)).unwrap();
    println!("size {} shapes {} {}", bodies.size, index(scene.pair.a().shape()), index(scene.pair.b().shape()));
    let ab = scene.pair.a().pose().inverse() * *scene.pair.b().pose();
    println!("R {:?} t {:?}", ab.rotation().as_slice(), ab.translation().as_slice() );
    println!("moduli {} {} d {} mu {} vs {:e}", scene.pair.a().modulus(), scene.pair.b().modulus(), scene.dissipation, scene.friction, scene.slip_tolerance);
    let inv = scene.pair.a().pose().inverse();
    for t in scene.twists { println!("twist in A: w {:?} v {:?}", (inv.rotation()*t.angular).as_slice(), (inv.rotation()*t.linear).as_slice()); }
    println!("reach {} {}", scene.pair.a().shape().field().reach(), scene.pair.b().shape().field().reach());
    let b = |s: &hydroelastic::contact::Shape| hydroelastic::geometry::Aabb::around(s.field().mesh().vertices());
    println!("boxes {:?} {:?}", b(scene.pair.a().shape()).upper.as_slice(), b(scene.pair.b().shape()).upper.as_slice());
    let scaled = Scaled::of(&scene);
    let found = scaled.relative(&scene.linearised());
    println!("force {:?}", scaled.at(0, 0.0).as_slice());
    for p in scene.pair.surface().polygons.iter().take(12) { println!("  tets {:?} area {:e} n {:.6?} p {:e} corners {}", p.tets, p.area, (inv.rotation()*p.normal).as_slice(), p.pressure, p.outline.corners().len()); }
    let all = checked(&scene);
    println!("{:?}", all.iter().map(|c| (c.column, c.finding)).collect::<Vec<_>>());
    let worst = |c: &&Checked| match c.finding { Finding::Wrong(e) => e, _ => 0.0 };
    for c in all.iter().max_by(|a, b| worst(a).total_cmp(&worst(b))) {
        let column = found.column(c.column).into_owned();
        println!("column {} {:?}  (largest {:e})", c.column, c.finding, column.amax());
        for step in [1e-3, 1e-4,1e-5,1e-6,1e-7,1e-8,1e-9,1e-10,1e-11,1e-12,1e-13] {
            let central = scaled.central(c.column, step);
            let e = (column - central).abs();
            let row = e.imax();
            let sides = scaled.sides(c.column, step);
            if let Some(s) = sides {
            println!("  h {step:e} off {:.3e} row {row}: J {:.9e} central {:.9e} behind {:.9e} ahead {:.9e}  jump0 {:.3e}", e[row], column[row], central[row], s.slopes[0][row], s.slopes[1][row], s.values[1][row]-s.values[0][row]);
            } else { println!("  h {step:e} off {:.3e} row {row}", e[row]); }
        }
    }
}
