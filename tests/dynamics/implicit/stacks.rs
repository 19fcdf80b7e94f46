use super::scenes::{IMPLICIT, per_solve, rollout, run, stack};

#[test]
fn stacks_stand() {
    for modulus in [1e7, 1e9] {
        for integrator in IMPLICIT {
            let world = stack(5, modulus, 1e-5);
            let mut rollout = rollout(&world, integrator, 5e-3);
            let work = run(&mut rollout, 5e-3, 1.0);
            let start = world.initial_state();
            let top = &rollout.state().bodies[4];
            let aside = (top.position() - start.bodies[4].position()).xy().norm();
            println!(
                "{integrator:?} E {modulus:.0e}: aside {aside:.1e} m, speed {:.1e} m/s, evaluations per solve {:.2}, {work:?}",
                top.velocity().norm(),
                per_solve(&work)
            );
            assert!(aside < 1e-3);
        }
    }
}
