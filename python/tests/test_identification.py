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
        prediction = identification.predict(TRUTH, trajectory)
        assert prediction.position_errors.shape == prediction.rotation_errors.shape == (31, 1) and len(prediction.trajectory) == 31
        assert prediction.position_errors.max() < 1e-9 and prediction.rotation_errors.max() < 1e-9


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


def test_squared_residuals_and_priors_add_up_to_the_costs():
    identification = he.Identification(
        tossed(1.2e5, 1.0, 0.2), PLAN, unknowns(), nuisances=[(he.Parameter.initial_velocity("ball"), 0.05)], max_iterations=2
    )
    trajectories = measurements()
    fit = identification.fit(trajectories)
    residuals = identification.residuals(trajectories, fit.checkpoint)
    for residual, cost, nuisances in zip(residuals, fit.costs, fit.checkpoint.nuisances, strict=True):
        priors = np.sum((nuisances / 0.05) ** 2)
        np.testing.assert_allclose(0.5 * (np.sum(residual.normalized_errors[1:] ** 2) + priors), cost, rtol=1e-9)
        np.testing.assert_allclose(residual.mean_squares, np.mean(residual.normalized_errors[1:] ** 2, axis=0), rtol=1e-12)
        positions, rotations = residual.position_errors / 1e-3, 2.0 * np.sin(0.5 * residual.rotation_errors) / 1e-2
        np.testing.assert_allclose(residual.normalized_errors, np.hypot(positions, rotations), rtol=1e-9, atol=1e-12)
        assert residual.trajectory.times.shape == (31,) and repr(residual) == "Prediction(31 states, 1 bodies)"


def test_a_measurement_that_cannot_be_simulated_has_an_exception_alone():
    identification = he.Identification(tossed(*TRUTH), PLAN, unknowns())
    trajectories = measurements()
    states = list(trajectories[0])
    states[0] = he.State(0.0, np.stack([he.pose([0.0, 0.0, -1.0]), np.eye(4)]), states[0].twists)
    trajectories[0] = he.Trajectory(states)
    fit = identification.fit(trajectories)
    assert fit.errors[0] and fit.errors[1] is None
    failed, simulated = identification.residuals(trajectories, fit.checkpoint)
    assert isinstance(failed, he.HydroelasticError) and str(failed) == fit.errors[0]
    assert simulated.position_errors.max() < 1e-4


def test_pickled_identifications_give_the_same_fit():
    unknown = [
        he.Unknown(he.Parameter.modulus("ball"), logarithmic=True, prior=(1e5, 1.0)),
        he.Unknown(he.Parameter.friction("ball"), bounds=(0.0, 1.0), name="friction"),
        he.Unknown(he.Parameter.gravity(), component=2),
        he.Unknown(he.Parameter.dissipation("ball"), tied_to=[he.Parameter.dissipation("table")]),
    ]
    deviations = np.array([0.05])
    options = {"nuisances": [(he.Parameter.initial_velocity("ball"), deviations[0])], "noise": (2e-3, 2e-2), "cauchy": 4.0}
    world = tossed(1.5e5, 0.8, 0.15)
    identification = he.Identification(world, PLAN, unknown, **options, horizons=[0.2], max_iterations=3, bodies=["ball"])
    fits = [each.fit(measurements()) for each in (identification, pickle.loads(pickle.dumps(identification)))]
    assert fits[0].names == fits[1].names and fits[0].iterations == fits[1].iterations
    for name in ("values", "covariance", "costs"):
        assert getattr(fits[0], name).tobytes() == getattr(fits[1], name).tobytes()


def test_pickled_fits_and_predictions_have_the_same_bits():
    identification = he.Identification(tossed(*TRUTH), PLAN, unknowns())
    trajectories = measurements()
    states = list(trajectories[0])
    states[0] = he.State(0.0, np.stack([he.pose([0.0, 0.0, -1.0]), np.eye(4)]), states[0].twists)
    fit = identification.fit([he.Trajectory(states), trajectories[1]])
    # Without a contact, the friction is not determined.
    flight = tossed(*TRUTH, velocity=(0.0, 0.0, 5.0))
    unknown = he.Identification(flight, PLAN, unknowns()[2:]).fit([flight.rollout(PLAN).run()])
    prediction = identification.predict(TRUTH, trajectories[1])
    assert fit.errors[0] and np.isinf(unknown.covariance).all() and np.isinf(unknown.sandwich_covariance).all()
    for value in (fit, unknown, prediction):
        again = pickle.loads(pickle.dumps(value))
        for name in (name for name in dir(value) if not name.startswith("_")):
            found, expected = getattr(again, name), getattr(value, name)
            if isinstance(expected, np.ndarray):
                assert found.shape == expected.shape and found.tobytes() == expected.tobytes(), name
            elif isinstance(expected, he.Checkpoint | he.Trajectory):
                assert pickle.dumps(found) == pickle.dumps(expected), name
            else:
                assert found == expected, name
        assert repr(again) == repr(value) and pickle.dumps(again) == pickle.dumps(value)


def test_a_single_item_in_place_of_a_list_is_refused():
    world, trajectory = tossed(*TRUTH), measurements()[0]
    identification = he.Identification(world, PLAN, unknowns())
    friction = he.Parameter.friction("ball")
    for create, match in [
        (lambda: he.Identification(world, PLAN, unknowns()[0]), "a list of Unknown is expected, but the argument is a single Unknown"),
        (lambda: he.Identification(world, PLAN, [friction]), "but the item at index 0 is <class 'hydroelastic.Parameter'>"),
        (lambda: he.Identification(world, PLAN, 1.0), "a list of Unknown is expected, but the argument is <class 'float'>"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies="ball"), 'a list of names .* is the name "ball": put it into a list'),
        (lambda: he.Unknown(friction, tied_to=friction), "put it into a list"),
        (lambda: he.Identification(world, PLAN, [], nuisances=(friction, 0.1)), "a nuisance must be a Parameter and a standard deviation"),
        (lambda: identification.fit(trajectory), "a list of Trajectory is expected, but the argument is a single Trajectory"),
        (lambda: he.World(world.bodies, controls=he.Control("ball", 0.1, np.zeros((1, 6)))), "a single Control: put it into a list"),
        (lambda: he.States(world.initial_state), "a single State: put it into a list"),
        (lambda: he.Trajectory(world.initial_state), "a single State: put it into a list"),
        (lambda: he.Batch(PLAN).rollouts(world), "a single World: put it into a list"),
        (lambda: he.Parameter.controls("ball", 1), "put it into a list"),
    ]:
        with pytest.raises(TypeError, match=match):
            create()


def test_invalid_arguments_are_refused():
    world = tossed(*TRUTH)
    friction = he.Parameter.friction("ball")
    for create, match in [
        (lambda: he.Unknown(friction, logarithmic=True, bounds=(0.0, 1.0)), "not both"),
        (lambda: he.Identification(world, PLAN, [he.Unknown(friction, bounds=(0.3, 0.5))]), "must be between 0.3 and 0.5"),
        (lambda: he.Identification(world, PLAN, [he.Unknown(friction, component=1)]), "no component 1"),
        (lambda: he.Identification(world, PLAN, unknowns(), noise=(0.0, 1.0)), "must be positive"),
        (lambda: he.Identification(world, PLAN, unknowns(), huber=3.0, cauchy=3.0), "exclude each other"),
        (lambda: he.Identification(world, PLAN, [he.Unknown(friction, prior=(0.2, 1e-200))]), "from 1e-150 to 1e150"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies=["cube"]), "cube"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies=[]), "no body is observed"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies=["ball", "ball"]), "observed twice"),
        (lambda: he.Identification(world, PLAN, unknowns(), bodies=["ball", "table"]), "must be dynamic"),
        (lambda: he.Identification(world, PLAN, unknowns()).fit([]), "at least one measurement"),
        (lambda: he.Identification(world, PLAN, []).fit(measurements(), start=he.Checkpoint(1, [], np.zeros((2, 0)))), "the largest index is 0"),
        (lambda: he.Identification(world, PLAN, []).residuals(measurements(), he.Checkpoint(0, [], np.zeros((1, 0)))), "2 measurements"),
    ]:
        with pytest.raises(he.HydroelasticError, match=match):
            create()
