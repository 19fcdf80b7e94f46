"""Identification of a world from simulated measurements."""

import pickle

import numpy as np
import pytest

import hydroelastic as he

TRUTH = np.array([1e5, 1.0, 0.2])
PLAN = he.Plan(0.01, 30, integrator=he.Integrator.SDIRK3)


def tossed(modulus, dissipation, friction, velocity=(0.8, 0.1, -0.8)):
    skin = he.Material(modulus, dissipation=dissipation, friction=friction)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.05, 1), skin, 0.2, pose=he.pose([0.0, 0.0, 0.1]), velocity=list(velocity))
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    return he.World([ball, table], gravity=[0.0, 0.0, -9.81])


def unknowns():
    parameters = [he.Parameter.modulus("ball"), he.Parameter.dissipation("ball"), he.Parameter.friction("ball")]
    return [he.Unknown(parameter, logarithmic=True) for parameter in parameters]


def measurements():
    velocities = [(0.8, 0.1, -0.8), (0.5, -0.2, -1.0)]
    return [tossed(*TRUTH, velocity).rollout(PLAN).run() for velocity in velocities]


def test_clean_measurements_give_the_true_values():
    identification = he.Identification(tossed(2e5, 0.5, 0.1), PLAN, unknowns())
    iterations = []
    fit = identification.fit(measurements(), progress=lambda index, cost, values, _: iterations.append((index, cost, values)))
    assert fit.termination == "converged" and fit.errors == [None, None]
    np.testing.assert_allclose(fit.values, TRUTH, rtol=1e-3)
    assert fit.names[2] == 'the friction of "ball"' and "friction" in repr(fit)
    assert (fit.intervals[:, 0] < TRUTH).all() and (TRUTH < fit.intervals[:, 1]).all()
    costs = [cost for _, cost, _ in iterations]
    assert len(iterations) > 2 and costs == sorted(costs, reverse=True) and iterations[0][2].shape == (3,)
    # The directions diagonalize the inverse of the covariance.
    diagonal = fit.directions @ fit.covariance @ fit.directions.T
    np.testing.assert_allclose(diagonal, np.diag(fit.direction_deviations**2), atol=1e-9 * diagonal.max())
    for trajectory in measurements():
        simulated, positions, rotations = identification.predict(TRUTH, trajectory)
        assert positions.shape == rotations.shape == (31, 1) and len(simulated) == 31
        assert positions.max() < 1e-9 and rotations.max() < 1e-9


def test_a_fit_stops_and_continues():
    identification = he.Identification(tossed(2e5, 0.5, 0.1), PLAN, unknowns())
    stopped = identification.fit(measurements(), progress=lambda index, *_: index == 2)
    assert stopped.termination == "stopped" and stopped.iterations == 2
    saved = pickle.loads(pickle.dumps(stopped.checkpoint))
    assert saved.unknowns.shape == (3,) and saved.nuisances.shape == (2, 0) and saved.horizon == 0
    continued = identification.fit(measurements(), start=saved)
    assert continued.termination == "converged"
    np.testing.assert_allclose(continued.values, TRUTH, rtol=1e-3)
    checkpoints = []
    identification.fit(measurements(), start=saved, progress=lambda *iteration: checkpoints.append(iteration[3]) or True)
    np.testing.assert_array_equal(checkpoints[0].unknowns, saved.unknowns)

    def fail(*_):
        raise KeyError("progress")

    with pytest.raises(KeyError, match="progress"):
        identification.fit(measurements(), progress=fail)


def test_nuisances_absorb_errors_of_the_initial_velocity():
    trajectory = measurements()[0]
    states = list(trajectory)
    twists = states[0].twists.copy()
    twists[0, 5] += 0.05
    states[0] = he.State(states[0].time, states[0].poses, twists)
    measured = [he.Trajectory(states)]
    velocity = [(he.Parameter.initial_velocity("ball"), 0.05)]
    options = {"noise": (1e-3, 1e-2), "cauchy": 4.0, "horizons": [0.2], "bodies": ["ball"]}
    world = tossed(1.2e5, 1.0, 0.2)
    modulus = unknowns()[:1]
    with_nuisances = he.Identification(world, PLAN, modulus, nuisances=velocity, **options).fit(measured)
    without = he.Identification(world, PLAN, modulus, **options).fit(measured)
    errors = [abs(fit.values[0] / TRUTH[0] - 1.0) for fit in (with_nuisances, without)]
    assert errors[0] < 0.02 < errors[1]


def test_invalid_arguments_are_refused():
    world = tossed(*TRUTH)
    friction = he.Parameter.friction("ball")
    for create, match in [
        (lambda: he.Unknown(friction, logarithmic=True, bounds=(0.0, 1.0)), "not both"),
        (lambda: he.Identification(world, PLAN, [he.Unknown(friction, bounds=(0.3, 0.5))]), "must be between 0.3 and 0.5"),
        (lambda: he.Identification(world, PLAN, [he.Unknown(friction, component=1)]), "no component 1"),
        (lambda: he.Identification(world, PLAN, unknowns(), noise=(0.0, 1.0)), "must be positive"),
        (lambda: he.Identification(world, PLAN, unknowns(), huber=3.0, cauchy=3.0), "exclude each other"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies=["cube"]), "cube"),
        (lambda: he.Identification(world, PLAN, unknowns()).fit([]), "at least one measurement"),
    ]:
        with pytest.raises(he.HydroelasticError, match=match):
            create()
