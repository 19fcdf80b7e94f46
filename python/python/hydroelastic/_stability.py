"""The stability check of explicit steps, which ``mujoco`` and ``pin`` share.

Contacts have the stiffness K and the damping C in joint coordinates, the mechanism the mass matrix M. A semi-implicit Euler step h
is stable if no eigenvalue of M⁻¹(h²K + 2hC) exceeds 4: the rule of ``World.largest_stable_step``. K and C are made of the
derivatives of the contacts, which cost more than a step. Each step therefore makes a *secant test* first.

Between two evaluations the state moves by h v, v changes by Δv, and the contact forces change by ΔW. In one mode with the
stiffness k and the damping c per mass, ΔW = −(k h v + c Δv), and

    h ΔWᵀM⁻¹ΔW / (|ΔWᵀv| + |ΔWᵀΔv| / 2)

is a mean of h²k and 2hc, weighted by |v| and |Δv|/2. The mode that grows beyond the limit changes its sign in each step,
so Δv is −2v or more, and the mean is at least (h²k + 2hc)/2 ≥ 2. If the mean of any contact, or of all together, exceeds 1, the
derivatives decide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import Pair, RolloutError

Floats: TypeAlias = NDArray[np.float64]
# Jᵀ w of each contact, (nv,); None for a contact that touches nothing.
Forces: TypeAlias = list[Floats | None]

# The secant test: half of the least mean of a mode that grows.
_ALARM = 1.0
# A change of the contact forces that is smaller, relative to the forces, is round-off.
_ROUND_OFF = 1e-6
# After the derivatives have found a step stable, so many evaluations raise no new alarm unless the mean grows by this factor.
_REST, _GROWTH = 32, 2.0
# The secant test takes a mass matrix that is at most so many evaluations old.
_MASS_AGE = 50
# Instead of a resistance of zero (W).
_LEAST = 1e-300
# Relative accuracy of a limit.
_SETTLED = 1e-9
# RK4 multiplies a mode z = hμ by 1 + z + z²/2 + z³/6 + z⁴/24; it is stable nowhere beyond |z| = 3.
_RK4 = (1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0)
_RADII = np.arange(0.01, 3.01, 0.01)[:, None]


class TimeStepError(RolloutError):
    """A time step that is too long for the contacts of a mechanism.

    ``time_step`` and ``limit`` are in s, and ``contact`` names the two sides of the stiffest contact. ``step`` and ``time`` (s) say
    where; both are None for a step that belongs to no rollout. ``trajectory`` holds the recorded states of a rollout, else it is
    None.
    """

    step: int | None = None
    time: float | None = None
    time_step: float
    limit: float
    contact: str

    def at_step(self, step: int, time: float) -> None:
        """Says where the error came."""
        self.step, self.time = step, time
        self.args = (f"step {step} (t = {time:.6g} s): {self.args[0]}",)


def time_step_error(contact: str, limit: float, time_step: float) -> TimeStepError:
    error = TimeStepError(
        f"the time step of {time_step:.3g} s exceeds the stability limit of {limit:.3g} s of the contacts, stiffest that of "
        f"{contact}. Take shorter steps, a lower modulus or dissipation, or a larger slip tolerance; or simulate a "
        "hydroelastic.World by implicit steps. check_stability=False allows the step"
    )
    error.time_step, error.limit, error.contact = time_step, limit, contact
    return error


class Rates(NamedTuple):
    """Stiffness and damping of each contact, (contacts, nv, nv), the mass matrix, and the damping of joints that a step takes
    implicitly; explicit damping is negative.

    The implicit damping D has the mass M + hD in the step, which allows the damping C of the contacts to be larger by D.
    """

    stiffness: Floats
    damping: Floats
    mass: Floats
    implicit_damping: Floats | float = 0.0


def resistance(
    pair: Pair, poses: Sequence[Floats], twists: Sequence[Floats], jacobian: Floats, moduli: Floats | None, law: Floats
) -> tuple[Floats, Floats]:
    """Stiffness and damping of a contact, (nv, nv), whose two twists are ``jacobian`` (12, nv) times the velocity.

    Friction adds nothing to the stiffness, because its derivative by the poses is on one side of the diagonal only.
    """
    _, elastic = pair.linearised(*poses, *twists, moduli=moduli, law=law * [1.0, 0.0])
    _, of_law = pair.linearised(*poses, *twists, moduli=moduli, law=law)
    return -jacobian.T @ elastic[:, :12] @ jacobian, -jacobian.T @ of_law[:, 12:24] @ jacobian


class Watch:
    """Makes the secant test, and has the derivatives decide if it gives alarm."""

    def __init__(self, names: Sequence[str], *, is_rk4: bool = False) -> None:
        self._names = names
        self._is_rk4 = is_rk4
        self._last: tuple[Forces, Floats | None, Floats] | None = None
        self._inverse_mass: Floats | None = None
        self._age = 0
        self._turn = 0
        self._alarm = _ALARM
        self._rest = 0

    def forget(self) -> None:
        """Forgets the last evaluation."""
        self._last = None
        self._inverse_mass = None

    def keep(self, forces: Forces, velocity: Floats) -> None:
        """Takes the forces of an evaluation and the velocity (nv,), without a test."""
        self._last = forces, _sum(forces), velocity

    def fault(
        self, forces: Forces, velocity: Floats, time_step: float, mass: Callable[[], Floats], rates: Callable[[Floats], Rates]
    ) -> tuple[str, float] | None:
        """The name of the stiffest contact and the limit (s), if the time step exceeds it.

        The state has moved by ``velocity`` since the last evaluation. ``rates`` gives the derivatives at a velocity. A first
        evaluation has no secant, so the derivatives decide.
        """
        last, total = self._last, _sum(forces)
        self._last = forces, total, velocity
        if last is None:
            return None if total is None else self._decided(time_step, rates, velocity)
        forces_before, total_before, velocity_before = last
        if total is None and total_before is None:
            return None
        if self._inverse_mass is None or self._age >= _MASS_AGE:
            self._inverse_mass, self._age = np.asarray(np.linalg.inv(mass()), dtype=np.float64), 0
        self._age += 1
        growth = velocity - velocity_before
        mean = self._mean(total, total_before, velocity, growth, time_step)
        if len(forces) > 1:
            self._turn = (self._turn + 1) % len(forces)
            of_one = self._mean(forces[self._turn], forces_before[self._turn], velocity, growth, time_step)
            mean = max(mean, of_one)
        if self._rest:
            self._rest -= 1
        if mean <= (self._alarm if self._rest else _ALARM):
            return None
        found = self._decided(time_step, rates, velocity, 0.5 * (velocity + velocity_before))
        found = found or self._bounced(forces, forces_before, velocity, time_step)
        if found is None:
            self._alarm, self._rest = _GROWTH * mean, _REST
        return found

    def _mean(
        self, force: Floats | None, before: Floats | None, velocity: Floats, growth: Floats, time_step: float
    ) -> float:
        """The mean of h²k and 2hc that the change of a force tells; 0 if it is round-off."""
        if force is None:
            if before is None:
                return 0.0
            change = before
        else:
            change = force if before is None else force - before
        power = time_step * float(self._inverse_mass.dot(change).dot(change))
        resistance = abs(float(change.dot(velocity))) + 0.5 * abs(float(change.dot(growth)))
        if power <= resistance or (force is not None and _is_round_off(change, force)):
            return 0.0
        return power / max(resistance, _LEAST)

    def _decided(self, time_step: float, rates: Callable[[Floats], Rates], *velocities: Floats) -> tuple[str, float] | None:
        """By the derivatives at each velocity. The limit is the least of these and of sticking friction."""
        limits = [self._limit(rates(velocity)) for velocity in velocities]
        if not any(time_step > limit for _, limit in limits):
            return None
        limits.append(self._limit(rates(np.zeros_like(velocities[0]))))
        return min(limits, key=lambda it: it[1])

    def _limit(self, rates: Rates) -> tuple[str, float]:
        """The stiffest contact and the limit (s) of all."""
        per_mass = np.linalg.inv(np.linalg.cholesky(rates.mass))
        limit_of = _rk4_limit if self._is_rk4 else _euler_limit

        def limit(stiffness: Floats, damping: Floats) -> float:
            damping = damping - rates.implicit_damping
            return limit_of(*(0.5 * per_mass @ (it + it.T) @ per_mass.T for it in (stiffness, damping)))

        alone = [limit(*it) for it in zip(rates.stiffness, rates.damping, strict=True)]
        return self._names[int(np.argmin(alone))], limit(rates.stiffness.sum(axis=0), rates.damping.sum(axis=0))

    def _bounced(
        self, forces: Forces, before: Forces, velocity: Floats, time_step: float
    ) -> tuple[str, float] | None:
        """A contact that began in the last step, and pushes the bodies apart faster than they came: it gives more energy than it
        took."""
        for name, force, earlier in zip(self._names, forces, before, strict=True):
            if force is None or earlier is not None:
                continue
            taken, given = -2.0 * force.dot(velocity), time_step * float(self._inverse_mass.dot(force).dot(force))
            if given > taken > 0.0:
                # The force grows with the depth, and so with the time step: ``given`` with its square.
                return name, time_step * float(np.sqrt(taken / given))
        return None


def _sum(forces: Forces) -> Floats | None:
    total = None
    for force in forces:
        if force is not None:
            total = force if total is None else total + force
    return total


def _is_round_off(change: Floats, force: Floats) -> bool:
    return bool(np.abs(change).max() <= _ROUND_OFF * np.abs(force).max())


def _euler_limit(stiffness: Floats, damping: Floats) -> float:
    """The step (s) at which the largest eigenvalue of h²K + 2hC is 4; infinite if nothing resists.

    The mode of that eigenvalue at a longer step has its own limit between both, from which the search goes on.
    """
    largest = [float(np.linalg.eigvalsh(it)[-1]) for it in (stiffness, damping)]
    step = min(_step_of_mode(largest[0], 0.0), _step_of_mode(0.0, largest[1]))
    while np.isfinite(step):
        mode = np.linalg.eigh(step * stiffness + 2.0 * damping)[1][:, -1]
        shorter = _step_of_mode(float(mode @ stiffness @ mode), float(mode @ damping @ mode))
        if not shorter < (1.0 - _SETTLED) * step:
            break
        step = shorter
    return step


def _step_of_mode(stiffness: float, damping: float) -> float:
    """The step (s) with h²k + 2hc = 4; infinite if nothing resists."""
    resistance = damping + np.sqrt(max(damping**2 + 4.0 * stiffness, 0.0))
    return float(4.0 / resistance) if resistance > 0.0 else np.inf


def _rk4_limit(stiffness: Floats, damping: Floats) -> float:
    """The step (s) at which a mode leaves the region of stability of RK4. Modes that grow by themselves do not count."""
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

