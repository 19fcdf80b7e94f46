"""Prints how many steps of 20 ms 1,000 copies of a pushed block make in a second of processor time, and the errors of their derivatives.

Run ``python tests/times_worlds.py``. Each block is pushed by a force of its own, with two entries of a standard deviation of 3 N, for 1 s. An
error is the difference of the derivatives of the last position (m) with respect to the force (N) from those of steps of 1 ms at the finest
accuracy, relative to their norm. Blocks that stick creep by micrometers, and have errors of their own. MuJoCo, if it is installed, simulates the same block on one thread.
"""

import time

import numpy as np

import hydroelastic as he

COUNT, SAMPLES, STEPS, TIME_STEP = 1000, 40, 50, 0.02
PUSH = [he.Parameter.control("block", 0)]
SLIDING = 0.01  # m/N, the least norm of the derivatives of a block that slides


def world():
    skin = he.Material(1e6, dissipation=5.0, friction=0.4)
    block = he.Body.dynamic("block", he.Shape.cuboid([0.1, 0.1, 0.06]), skin, 0.5, pose=he.pose([0.0, 0.0, 0.03]))
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    return he.World([block, table], gravity=-9.81, controls=[he.Control("block", 1e6, np.zeros((1, 6)))])


def pushes():
    values = np.zeros((COUNT, 6))
    values[:, 3:5] = np.random.default_rng(1).normal(0.0, 3.0, (COUNT, 2))
    return values


def steps_per_second(plan, values):
    """Returns steps per second of processor time, and whether all copies succeeded."""
    template, batch = world(), he.Batch(plan)
    states = he.States([template.initial_state] * COUNT)
    start, failures = time.process_time(), 0
    for _ in range(STEPS):
        states, errors = batch.advance(template, states, PUSH, values)
        failures += len(errors)
    return COUNT * STEPS / (time.process_time() - start), failures


def slopes(plan, values):
    """Returns derivatives of the last horizontal positions with respect to the horizontal forces, (samples, 2, 2)."""
    worlds = [world().with_values(PUSH, row) for row in values[:SAMPLES]]
    results = he.Batch(plan).jacobians(worlds, PUSH)
    return np.array([jacobian.poses[-1, 0, :2, 3, 3:5] for _, jacobian in results])


def mujoco_steps_per_second(values, substeps):
    try:
        import mujoco
        import mujoco.rollout
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{TIME_STEP / substeps}"/><worldbody><geom type="plane" size="50 50 1"/>
        <body pos="0 0 .03"><freejoint/><geom type="box" size=".05 .05 .03" mass=".5" friction=".4"/><site name="push"/></body>
        </worldbody><actuator><general site="push" gear="1 0 0 0 0 0"/><general site="push" gear="0 1 0 0 0 0"/></actuator></mujoco>"""
    )
    data, kind = mujoco.MjData(model), mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    controls = np.repeat(values[:, None, 3:5], STEPS * substeps, axis=1)
    start = time.process_time()
    mujoco.rollout.rollout(model, data, np.tile(state, (COUNT, 1)), controls)
    return COUNT * STEPS / (time.process_time() - start)


def main():
    values = pushes()
    finest = slopes(he.Plan(1e-3, 1000, "sdirk3", accuracy=he.Accuracy(1e-5, 1e-4), record_every=1000), values)
    norms = np.linalg.norm(finest, axis=(1, 2))
    accuracies = {"Sdirk3, accuracy (5e-2, 5e-1)": he.Accuracy(5e-2, 5e-1), "Sdirk3, default accuracy": he.Accuracy()}
    plans = {"implicit Euler": he.Plan(TIME_STEP, STEPS, "implicit_euler", record_every=STEPS)}
    plans |= {name: he.Plan(TIME_STEP, STEPS, "sdirk3", accuracy=accuracy, record_every=STEPS) for name, accuracy in accuracies.items()}
    for name, plan in plans.items():
        rate, failures = steps_per_second(he.Plan(TIME_STEP, 1, plan.integrator, accuracy=plan.accuracy), values)
        errors = np.linalg.norm(slopes(plan, values) - finest, axis=(1, 2)) / norms
        print(f"{name}: {rate:,.0f} steps, {failures} failures")
        for kind, of_kind in (("slide", errors[norms > SLIDING]), ("stick", errors[norms <= SLIDING])):
            median, most = np.median(of_kind), np.quantile(of_kind, 0.9)
            print(f"    {len(of_kind)} blocks that {kind}: derivatives off by {median:.1%} (median), {most:.1%} (90 %)")
    for substeps in (1, 10):
        rate = mujoco_steps_per_second(values, substeps)
        print("MuJoCo is not installed" if rate is None else f"MuJoCo, {substeps} time steps: {rate:,.0f} steps")


if __name__ == "__main__":
    main()
