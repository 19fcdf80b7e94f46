use super::scenes::{grasp, per_solve, rollout, run};
use hydroelastic::dynamics::Integrator;

/// Difference between steps of 1 ms and of 5 ms, relative to the slip tolerance.
const SAME_CREEP: f64 = 0.03;

#[test]
fn a_ball_that_two_fingers_lift_creeps_alike_at_1_ms_and_at_5_ms() {
    for slip_tolerance in [1e-4, 1e-5] {
        let creep = [1e-3, 5e-3].map(|time_step| {
            let world = grasp(1e7, slip_tolerance);
            let mut rollout = rollout(&world, Integrator::Sdirk3, time_step);
            let mut work = run(&mut rollout, time_step, 0.8);
            let height = rollout.state().bodies[0].position().z;
            work += run(&mut rollout, time_step, 0.2);
            let after = rollout.state().bodies[0].position().z;
            let creep = (after - height) / 0.2 / slip_tolerance;
            println!(
                "v_s {slip_tolerance:.0e} h {time_step}: height {after:.6}, creep {creep:.4} v_s, evaluations per solve {:.2}, {work:?}",
                per_solve(&work)
            );
            assert!((after - 0.2).abs() < 2e-3);
            creep
        });
        assert!((creep[1] / creep[0] - 1.0).abs() < SAME_CREEP);
    }
}
