"""Costs of `cube.py`, their minimization, and errors of predictions. A toss is an array with a state of 13 numbers for each frame."""

import sys
import time

import cma
import numpy as np
from cube_engines import EDGE, GRAVITY

WINDOW = 25  # frames
NOISE = 2e-3, 0.03  # m, rad
CAUCHY_SCALE = 4.0
PRIOR = -9.81, 0.1  # m/s², mean and standard deviation of gravity
FEW = 20  # tosses of the initial searches
WIDE, NARROW = 0.7, 0.2  # initial standard deviations of a search, in typical changes of the parameters
FAR = 1e3  # m, each coordinate of the position after a failure of the simulation
LARGEST = 1e3  # % of the edge, upper limit of an error


def read(path):
    """Returns the recordings of a CSV file. Its columns are toss, frame, and the 13 numbers of a state."""
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    return [rows[rows[:, 0] == toss][:, 2:] for toss in np.unique(rows[:, 0])]


def deviations(engine, values, recordings):
    """Returns position errors (m) and rotation errors (rad), with one row per recording. Rows of shorter recordings end with NaN."""
    counts = [len(recording) for recording in recordings]
    measured = np.full((len(recordings), max(counts), 7), np.nan)
    for row, recording in zip(measured, recordings):
        row[: len(recording)] = recording[:, :7]
    starts = np.array([recording[0] for recording in recordings])
    simulated = engine.rollouts(values, starts, [count - 1 for count in counts])
    simulated = np.concatenate([measured[:, :1], np.nan_to_num(simulated, nan=FAR)], axis=1)
    distances = np.linalg.norm(simulated[..., 4:] - measured[..., 4:], axis=-1)
    cosines = np.abs(np.sum(simulated[..., :4] * measured[..., :4], axis=-1))
    norms = np.linalg.norm(simulated[..., :4], axis=-1) * np.linalg.norm(measured[..., :4], axis=-1)
    return distances, 2 * np.arccos(np.minimum(cosines / norms, 1.0))


def errors(engine, values, tosses):
    """Returns the mean position error (% of the edge), the mean rotation error (°) and the final position error (%) of each toss."""
    distances, angles = deviations(engine, values, tosses)
    percent = np.minimum(100 / EDGE * distances, LARGEST)
    return {
        "position errors (%)": np.nanmean(percent, axis=1).tolist(),
        "rotation errors (°)": np.degrees(np.nanmean(angles, axis=1)).tolist(),
        "final position errors (%)": [row[len(toss) - 1] for row, toss in zip(percent.tolist(), tosses)],
    }


def summary(errors):
    """Returns the columns of the table."""
    position, rotation, final = errors.values()
    columns = [f"{np.mean(position):.1f} %", f"{np.median(position):.1f} %", f"{np.median(rotation):.1f}°"]
    return " | ".join([*columns, f"{np.mean(rotation):.1f}°", f"{np.median(final):.1f} %"])


def surprise(values):
    """Returns the squared deviation of gravity from the mean of its prior, in standard deviations."""
    return ((values[GRAVITY] - PRIOR[0]) / PRIOR[1]) ** 2


def window_cost(engine, values, tosses):
    """Returns the mean robust loss of a frame, as in the example `cube_tosses`. Each window begins at its first measured state."""
    windows = [toss[start : start + WINDOW] for toss in tosses for start in range(0, len(toss) - 1, WINDOW - 1)]
    distances, angles = deviations(engine, values, windows)
    squares = (distances / NOISE[0]) ** 2 + (angles / NOISE[1]) ** 2
    losses = CAUCHY_SCALE**2 * np.log1p(squares / CAUCHY_SCALE**2)
    return (np.nansum(losses) + surprise(values)) / np.isfinite(losses).sum()


def toss_cost(engine, values, tosses):
    """Returns the mean over whole tosses of the position error (% of the edge) plus the rotation error (°)."""
    position, rotation, _ = errors(engine, values, tosses).values()
    return np.mean(position) + np.mean(rotation) + surprise(values) / len(tosses)


COSTS = {"windows": window_cost, "tosses": toss_cost}


class Fit:
    """A minimization with CMA-ES: independent searches on few tosses, and a search on all tosses from the best result."""

    def __init__(self, engine, cost):
        self.engine, self.cost_of, self.evaluations, self.cost = engine, cost, 0, None

    def best(self, tosses, searches, evaluations):
        """Returns the values with the least cost."""
        guess = [parameter.coordinate() for parameter in self.engine.parameters]
        few = tosses[:FEW]
        found = [self.searched(guess, few, WIDE, evaluations, seed) for seed in range(1, searches + 1)]
        best = min(found, key=lambda result: result.fbest)
        best = self.searched(best.xbest, tosses, NARROW, evaluations, 1)
        self.cost = best.fbest
        return self.values(best.xbest)

    def values(self, coordinates):
        pairs = zip(self.engine.parameters, coordinates)
        return {parameter.name: float(parameter.value(coordinate)) for parameter, coordinate in pairs}

    def searched(self, start, tosses, size, evaluations, seed):
        began = time.time()
        changes = [parameter.change for parameter in self.engine.parameters]
        settings = {"CMA_stds": changes, "maxfevals": evaluations, "seed": seed, "tolfun": 1e-4, "verbose": -9}
        _, search = cma.fmin2(lambda x: self.cost_of(self.engine, self.values(x), tosses), start, size, settings)
        found = search.result
        self.evaluations += found.evaluations
        progress = f"{len(tosses)} tosses: cost {found.fbest:.4f}, {found.evaluations} evaluations, {time.time() - began:.0f} s"
        print(f"{progress}, {self.values(found.xbest)}", file=sys.stderr, flush=True)
        return found
