"""Stability check of the explicit steps of ``mujoco``.

Let K and C be the stiffness and damping of the contacts in joint coordinates, and M the mass matrix. A semi-implicit
Euler step h is stable if no eigenvalue of M⁻¹(h²K + 2hC) exceeds 4, as in ``World.largest_stable_step``. K and C are
computed from the derivatives of the contacts, which cost more than a step. Each step therefore runs a *secant test*
first.

Between two evaluations the state moves by h v, v changes by Δv, and the contact forces change by ΔW. In one mode with
the stiffness k and the damping c per mass, ΔW = −(k h v + c Δv), and

    h ΔWᵀM⁻¹ΔW / (|ΔWᵀv| + |ΔWᵀΔv| / 2)

is a mean of h²k and 2hc, weighted by |v| and |Δv|/2. A mode that grows beyond the limit changes its sign in each step.
It has |Δv| ≈ 2|v|, and the mean is about (h²k + 2hc)/2 ≥ 2. If the mean exceeds 1, the limit is computed from the
derivatives. Each test uses the sum of all contacts and, in turn, one single contact.

If friction reverses the slip within a step, it has a small slope before and after the reversal. The derivatives are
therefore also evaluated at the mean of both velocities.

A contact that begins within a step is not linear. Even below the limit, it may push the bodies apart faster than they
approached. The secant from zero force detects this, because the mean then compares the energy that the contact returns
with the energy that it absorbs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import Pair, RolloutError

Floats: TypeAlias = NDArray[np.float64]
# Jᵀ w of each contact, (nv,); None for a contact whose bodies do not touch.
Forces: TypeAlias = list[Floats | None]

# Threshold of the secant test: half of the smallest mean of a growing mode.
_ALARM = 1.0
# Smaller changes of the contact forces, relative to the forces, are round-off.
_ROUND_OFF = 1e-6
# After the derivatives have shown that a step is stable, the next _REST evaluations raise no alarm unless the mean
# grows by the factor _GROWTH or a contact begins.
_REST, _GROWTH = 16, 1.5
# Maximum age of the mass matrix in the secant test (evaluations).
_MASS_AGE = 50
# Lower bound of the resistance, to avoid division by zero (W).
_LEAST = 1e-300
# Relative accuracy of a limit.
_SETTLED = 1e-9
# RK4 multiplies a mode with z = hμ by 1 + z + z²/2 + z³/6 + z⁴/24. No mode with |z| > 3 is stable.
_RK4 = (1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0)
_RADII = np.arange(0.01, 3.01, 0.01)[:, None]


class TimeStepError(RolloutError):
    """Time step that is too long for the contacts of a mechanism.

    Attributes
    ----------
    time_step : float
        Time step (s).
    limit : float
        Longest stable time step (s).
    contact : str
        Names of the two sides of the stiffest contact.
    step : int or None
        Index of the step in a rollout; None outside a rollout.
    time : float or None
        Time (s) of the step in a rollout; None outside a rollout.
    trajectory
        Recorded states of the rollout; None outside a rollout.
    """

    step: int | None = None
    time: float | None = None
    time_step: float
    limit: float
    contact: str

    def at_step(self, step: int, time: float) -> None:
        """Adds the step and its time to the error."""
        self.step, self.time = step, time
        self.args = (f"step {step} (t = {time:.6g} s): {self.args[0]}",)


class Fault(NamedTuple):
    """Reason why a time step is too long: the name of the stiffest contact and the limit (s).

    ``begins`` is the index of a contact that begins in a step below the stability limit and returns more energy than it
    absorbs.
    """

    contact: str
    limit: float
    begins: int | None = None

    def error(self, time_step: float) -> TimeStepError:
        """Returns the error for a time step (s)."""
        why = (
            f"exceeds {self.limit:.3g} s, the stability limit of the contacts at this state; the stiffest is that of "
            f"{self.contact}"
            if self.begins is None
            else f"exceeds about {self.limit:.3g} s, above which the contact of {self.contact} begins so deep that it returns more "
            "energy than it absorbs"
        )
        error = TimeStepError(
            f"the time step of {time_step:.3g} s {why}. Use shorter steps, a lower modulus or dissipation, or a larger slip "
            "tolerance; or simulate a hydroelastic.World with implicit steps. check_stability=False turns the check off"
        )
        error.time_step, error.limit, error.contact = time_step, self.limit, self.contact
        return error


class Rates(NamedTuple):
    """Stiffness and damping of each contact, (contacts, nv, nv), the mass matrix, and the damping of the joints.

    Implicit joint damping D changes the mass matrix of a step to M + hD, so the damping of the contacts may be larger
    by D. Explicit joint damping adds to the damping of the contacts.
    """

    stiffness: Floats
    damping: Floats
    mass: Floats
    joint_damping: Floats | float = 0.0
    is_implicit: bool = False


def resistance(
    pair: Pair, poses: Sequence[Floats], twists: Sequence[Floats], jacobian: Floats, law: Floats
) -> tuple[Floats, Floats]:
    """Computes stiffness and damping of a contact, (nv, nv). Its two twists are ``jacobian`` (12, nv) times the
    velocity.

    Friction adds nothing to the stiffness, because its derivative with respect to the poses is on one side of the
    diagonal only.
    """
    _, elastic = pair.linearized(*poses, *twists, law=law * [1.0, 0.0])
    _, of_law = pair.linearized(*poses, *twists, law=law)
    return -jacobian.T @ elastic[:, :12] @ jacobian, -jacobian.T @ of_law[:, 12:24] @ jacobian


class Watch:
    """Runs the secant test, and computes the limit from the derivatives if the test raises an alarm."""

    def __init__(self, names: Sequence[str], *, is_rk4: bool = False) -> None:
        self._names = names
        self._is_rk4 = is_rk4
        self._last: tuple[Forces, Floats] | None = None
        self._inverse_mass = np.zeros((0, 0))
        self._age = _MASS_AGE
        self._turn = 0
        self._alarm = _ALARM
        self._rest = 0

    def keep(self, forces: Forces, velocity: Floats) -> None:
        """Stores the forces and the velocity (nv,) of an evaluation without a test."""
        self._last = forces, velocity

    def fault(
        self, forces: Forces, velocity: Floats, time_step: float, mass: Callable[[], Floats], rates: Callable[[Floats], Rates]
    ) -> Fault | None:
        """Returns the reason why the time step is too long, or None if it is stable.

        The state has moved with ``velocity`` since the last evaluation. ``rates`` returns the stiffness and damping at
        a velocity. The first evaluation has no secant, so the limit is computed from the derivatives.
        """
        last, self._last = self._last, (forces, velocity)
        if last is None:
            touches = any(force is not None for force in forces)
            return self._decided(time_step, rates, velocity) if touches else None
        forces_before, velocity_before = last
        # A contact that has ended has no derivatives here. If the contact begins again, it is tested then.
        changes = [
            (force if before is None else force - before, force)
            for force, before in zip(forces, forces_before, strict=True)
            if force is not None
        ]
        if not changes:
            return None
        if self._age >= _MASS_AGE:
            self._inverse_mass, self._age = np.asarray(np.linalg.inv(mass()), dtype=np.float64), 0
        self._age += 1
        velocities = velocity, velocity_before
        self._turn += 1
        mean = self._mean(*changes[self._turn % len(changes)], *velocities, time_step)
        if len(changes) > 1:
            change, total = changes[0]
            for change_of_one, force in changes[1:]:
                change, total = change + change_of_one, total + force
            mean = max(mean, self._mean(change, total, *velocities, time_step))
        if self._rest:
            self._rest -= 1
        if mean <= _ALARM:
            return None
        begins = any(force is not None and before is None for force, before in zip(forces, forces_before, strict=True))
        if self._rest and not begins and mean <= self._alarm:
            return None
        fault = self._decided(time_step, rates, velocity, 0.5 * (velocity + velocity_before))
        if fault is None and not self._is_rk4:
            fault = self._bounced(forces, forces_before, velocity, time_step, rates(velocity))
        if fault is None:
            self._alarm, self._rest = _GROWTH * mean, _REST
        return fault

    def _mean(self, change: Floats, force: Floats, velocity: Floats, before: Floats, time_step: float) -> float:
        """Returns the mean of h²k and 2hc from the change of a force. Returns 0 if the mean is at most 1 or the change
        is round-off."""
        power = time_step * float(self._inverse_mass.dot(change).dot(change))
        along = float(change.dot(velocity))
        resistance = abs(along) + 0.5 * abs(along - float(change.dot(before)))
        if power <= _ALARM * resistance or np.abs(change).max() <= _ROUND_OFF * np.abs(force).max():
            return 0.0
        return power / max(resistance, _LEAST)

    def _decided(self, time_step: float, rates: Callable[[Floats], Rates], *velocities: Floats) -> Fault | None:
        """Returns a fault if the step exceeds the limit at one of the velocities. The limit of the fault is the
        smallest of the limits at these velocities and of the limit of sticking friction."""
        faults = [self._limit(rates(velocity)) for velocity in velocities]
        if not any(time_step > fault.limit for fault in faults):
            return None
        faults.append(self._limit(rates(np.zeros_like(velocities[0]))))
        return min(faults, key=lambda fault: fault.limit)

    def _limit(self, rates: Rates) -> Fault:
        """Returns the stiffest contact and the limit (s) of all contacts together."""
        per_mass = np.linalg.inv(np.linalg.cholesky(rates.mass))
        limit_of = _rk4_limit if self._is_rk4 else _euler_limit

        def limit(stiffness: Floats, damping: Floats) -> float:
            damping = damping - rates.joint_damping if rates.is_implicit else damping + rates.joint_damping
            return limit_of(*(0.5 * per_mass @ (matrix + matrix.T) @ per_mass.T for matrix in (stiffness, damping)))

        alone = [limit(*matrices) for matrices in zip(rates.stiffness, rates.damping, strict=True)]
        return Fault(self._names[int(np.argmin(alone))], limit(rates.stiffness.sum(axis=0), rates.damping.sum(axis=0)))

    def _bounced(
        self, forces: Forces, before: Forces, velocity: Floats, time_step: float, rates: Rates
    ) -> Fault | None:
        """Returns a contact that began in the last step and pushes the bodies apart faster than they approached."""
        mass = rates.mass + time_step * rates.joint_damping if rates.is_implicit else rates.mass
        for number, (force, earlier) in enumerate(zip(forces, before, strict=True)):
            if force is None or earlier is not None:
                continue
            absorbed = -2.0 * float(force.dot(velocity))
            returned = time_step * float(np.linalg.solve(mass, force).dot(force))
            if returned > absorbed > 0.0:
                # The force grows with the depth, and therefore with the time step h. So ``returned / absorbed`` grows
                # with h².
                return Fault(self._names[number], time_step * float(np.sqrt(absorbed / returned)), number)
        return None


def _euler_limit(stiffness: Floats, damping: Floats) -> float:
    """Returns the step h (s) at which the largest eigenvalue of h²K + 2hC is 4. It is infinite without stiffness and
    damping.

    Each mode has its own limit, and the search finds the smallest limit. At a longer step, the mode of the largest
    eigenvalue has a shorter limit, with which the search continues.
    """

    def of_mode(matrix: Floats) -> float:
        mode = np.linalg.eigh(matrix)[1][:, -1]
        return _step_of_mode(float(mode @ stiffness @ mode), float(mode @ damping @ mode))

    step = min(of_mode(stiffness), of_mode(damping))
    while np.isfinite(step):
        shorter = of_mode(step * stiffness + 2.0 * damping)
        if not shorter < (1.0 - _SETTLED) * step:
            break
        step = shorter
    return step


def _step_of_mode(stiffness: float, damping: float) -> float:
    """Returns the step h (s) with h²k + 2hc = 4. It is infinite without stiffness and damping."""
    resistance = damping + np.sqrt(max(damping**2 + 4.0 * stiffness, 0.0))
    return float(4.0 / resistance) if resistance > 0.0 else np.inf


def _rk4_limit(stiffness: Floats, damping: Floats) -> float:
    """Returns the step (s) at which a mode leaves the stability region of RK4. Modes that grow at any step are ignored.
    """
    still, unit = np.zeros_like(stiffness), np.eye(len(stiffness))
    modes = np.linalg.eigvals(np.block([[still, unit], [-stiffness, -damping]]))
    sizes = np.abs(modes)
    modes, sizes = modes[sizes > 0.0], sizes[sizes > 0.0]
    directions = modes / sizes
    decays = directions.real < _ROUND_OFF
    directions = np.minimum(directions.real[decays], 0.0) + 1j * directions.imag[decays]
    grows = np.abs(np.polyval(_RK4, _RADII * directions)) > 1.0 + _SETTLED
    radii: Any = _RADII[np.argmax(grows, axis=0), 0]
    return float((radii / sizes[decays]).min(initial=np.inf))

