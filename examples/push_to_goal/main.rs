//! Which pushes bring a block, sliding with friction, to rest at a goal pose?
//!
//! `cargo run --release -p hydroelastic-examples --example push_to_goal [-- --record FILE.glb --plot FILE.svg]`
//!
//! Found in two ways, with the same prices of pushes and of missing the goal. By a regulator: 20 pushes, by the motion linearized
//! over each of their intervals. By L-BFGS: a push of its own in each step, 3,000 numbers, by the gradient swept back.

mod quasi_newton;
mod regulator;
mod scene;
#[path = "../show/mod.rs"]
mod show;

use hydroelastic::dynamics::{Plan, Trajectory};
use hydroelastic::io::Recording;
use scene::{Found, NEAR, Pushed, STEPS, Scene, TIME_STEP};
use show::{Curve, Panel};

fn main() -> Found<()> {
    let wanted = show::wanted()?;
    let scene = Scene::new()?;
    let regulated = regulator::pushed(&scene)?;
    arrived("regulator, 20 pushes", &scene, &regulated)?;
    let pushed = quasi_newton::pushed(&scene)?;
    let trajectory = arrived("L-BFGS, 3,000 numbers", &scene, &pushed)?;
    let last = |found: &Pushed| found.costs[found.costs.len() - 1];
    assert!(last(&pushed) < last(&regulated), "finer pushes cost more");
    wanted.record(|| Ok(Recording::new(&pushed.world, &trajectory).slowed(2.0)))?;
    wanted.plot(|| {
        let curve = |name, found: &Pushed| Curve::counted(name, found.costs.iter().copied());
        let costs = vec![curve("regulator", &regulated), curve("L-BFGS", &pushed)];
        vec![
            Panel::counted("iteration", costs),
            Panel {
                x_label: "time (s)",
                y_label: "push along x (N)",
                is_log: false,
                curves: vec![forces("regulator", &regulated), forces("L-BFGS", &pushed)],
            },
            show::energies(&pushed.world, &trajectory.thinned(10)),
        ]
    })?;
    Ok(())
}

/// The pushes along x over time.
fn forces(name: &str, found: &Pushed) -> Curve {
    let control = &found.world.controls()[0];
    let pushes = control.wrenches().iter().enumerate();
    let drawn = pushes.flat_map(|(place, push)| {
        let ends = [place, place + 1].map(|end| end as f64 * control.interval());
        ends.map(|time| (time, push.force.x))
    });
    Curve::new(name, drawn)
}

/// Checks that the pushes bring the block to rest at the goal.
fn arrived(name: &str, scene: &Scene, found: &Pushed) -> Found<Trajectory> {
    let rollout = found.world.rollout(&Plan::new(TIME_STEP, STEPS)?);
    let trajectory = rollout.run()?;
    let missed = scene.missed(trajectory.last())?;
    let [place, angle, speed] = missed;
    let (iterations, cost) = (found.costs.len() - 1, found.costs[found.costs.len() - 1]);
    println!(
        "{name}: {iterations} iterations, cost {cost:.3}; {place:.1e} m and {angle:.1e} rad off, {speed:.1e} m/s"
    );
    let is_near = missed.iter().zip(NEAR).all(|(missed, near)| *missed < near);
    assert!(is_near, "{name}: {missed:?} from the goal");
    Ok(trajectory)
}
