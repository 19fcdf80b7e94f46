"""Docstrings of ``hydroelastic.jax`` and ``hydroelastic.torch``, whose functions differ only in the type of their arrays."""

from collections.abc import Callable
from typing import Any, TypeVar

_T = TypeVar("_T", bound=Callable[..., Any])


def documented(array: str) -> Callable[[_T], _T]:
    """Returns a decorator that sets the docstring of a function or class, for the type of an array."""

    def decorated(function: _T) -> _T:
        function.__doc__ = _DOCSTRINGS[function.__name__].replace("ARRAY", array)
        return function

    return decorated


_DOCSTRINGS = {
    "State": """State of the n bodies, the m revolute and prismatic joints and the b ball joints of a world at one time.

Bodies have the order of ``World.names``. Joints have the order of ``World.joint_names`` and ``World.ball_joint_names``.
If a function returns k recorded states, all attributes have an additional first axis of length k.

Attributes
----------
poses : (n, 4, 4) ARRAY of float64
    Poses of the body frames in the world.
twists : (n, 6) ARRAY of float64
    Angular velocity (rad/s), then velocity of the center of mass (m/s), in world axes.
joint_positions : (m,) ARRAY of float64 or None
    Positions (rad or m). None if m = 0.
joint_velocities : (m,) ARRAY of float64 or None
    Velocities (rad/s or m/s). None if m = 0.
ball_joint_rotations : (b, 3, 3) ARRAY of float64 or None
    Rotations from the body frame to the joint frame. None if b = 0.
ball_joint_velocities : (b, 3) ARRAY of float64 or None
    Angular velocities (rad/s) in the axes of the joint frame. None if b = 0.
""",
    "pose": """Creates the pose of a frame as a 4×4 homogeneous matrix.

Parameters
----------
translation : (3,) array_like
    Position (m) of the origin of the frame.
rotation_vector : (3,) array_like
    Rotation of the frame: axis times angle (rad). Derivatives of all orders are correct at zero too.

Returns
-------
(4, 4) ARRAY of float64
    Matrix that maps coordinates in the frame to coordinates in the outer frame.

Raises
------
HydroelasticError
    If a number is not finite, or an argument has an unexpected shape.
TypeError
    If an argument is not of float64 or integers.
""",
    "moved_pose": """Moves a pose by a twist in world axes.

The frame turns about its own origin by the angular part, and its origin moves by the linear part.

Parameters
----------
pose : (4, 4) array_like
    Pose before the motion.
twist : (6,) array_like
    Rotation vector (rad), then translation (m).

Returns
-------
(4, 4) ARRAY of float64
    Pose after the motion.

Raises
------
HydroelasticError
    If a number is not finite, or an argument has an unexpected shape.
TypeError
    If an argument is not of float64 or integers.
""",
    "tactile_image": """Computes the forces on the taxels of a grid that is fixed to A or to B.

Each force acts on the body of the grid. Its components are along the axes of the taxel: two components of shear, then
the normal component, which is negative if the taxel is pressed. With a twist, forces include dissipation and friction.
Reverse mode also computes the whole Jacobian, with 3 H W rows.

Parameters
----------
pair : Pair
    Shapes and default numbers. It has no derivative.
grid : TaxelGrid
    Grid of H rows and W columns. It has no derivative.
pose_a, pose_b : (4, 4) array_like
    Poses of A and B in the world.
twist_a, twist_b : (6,) array_like, optional
    Angular velocity (rad/s), then velocity (m/s) of the origin of the body frame, in world axes. If one is given,
    the other is zero by default.
body : str, optional
    Body of the grid, "a" or "b".
moduli : (2,) array_like, optional
    Moduli (Pa) of A and B, in place of those of the pair. If B is rigid, the second has no effect.
law : (2,) array_like, optional
    Dissipation (s/m) and friction coefficient, in place of those of the pair. They have no effect without twists.

Returns
-------
(H, W, 3) ARRAY of float64
    Forces (N).

Raises
------
HydroelasticError
    If an argument is not valid, as in ``Pair.wrench``.
TypeError
    If an argument is not of float64 or integers.
""",
    "clearance": """Computes the signed distance between the bodies of a pair.

The distance also has derivatives before contact. It has kinks where the closest features change, as in
``Pair.clearance``.

Parameters
----------
pair : Pair
    Shapes and default moduli. The result is not differentiated with respect to the pair.
pose_a, pose_b : (4, 4) array_like
    Poses of A and B in the world.
moduli : (2,) array_like, optional
    Moduli (Pa) of A and B, if they differ from those of the pair. They matter only if the bodies overlap.

Returns
-------
() ARRAY of float64
    Distance (m) between the surfaces, or minus the depth (m) if the bodies overlap.

Raises
------
HydroelasticError
    If an argument is not valid, as in ``Pair.clearance``.
TypeError
    If an argument has another class, or its elements are neither float64 nor integers.
""",
    "wrench": """Computes the wrenches on both bodies of a contact.

Without twists, the bodies are at rest. With a twist, the wrenches include dissipation and friction.

Parameters
----------
pair : Pair
    Shapes and default numbers. It has no derivative.
pose_a, pose_b : (4, 4) array_like
    Poses of A and B in the world.
twist_a, twist_b : (6,) array_like, optional
    Angular velocity (rad/s), then velocity (m/s) of the origin of the body frame, in world axes. If one is given,
    the other is zero by default.
moduli : (2,) array_like, optional
    Moduli (Pa) of A and B, in place of those of the pair. If B is rigid, the second has no effect.
law : (2,) array_like, optional
    Dissipation (s/m) and friction coefficient, in place of those of the pair. They have no effect without twists.

Returns
-------
(12,) ARRAY of float64
    Torque (N m) and force (N) on A about the origin of its frame, then on B about the origin of its frame, in world
    axes.

Raises
------
HydroelasticError
    If an argument is not valid, as in ``Pair.wrench``.
TypeError
    If an argument is not of float64 or integers.
""",
    "initial_state": """Returns the initial state of rollouts of a world.

Parameters
----------
world : World
    World.

Returns
-------
State
    Initial state.
""",
    "rollout": """Runs a rollout and returns the recorded states, as a function of its initial state and of changes of parameters.

Gradients with respect to more than 12 numbers (more than 96 numbers if steps are implicit) use reverse mode, whose
time does not depend on p. With ``start``, each free body adds 12 numbers, each revolute or prismatic joint 2, and each
ball joint 6. Otherwise, and in forward mode, the
Jacobian is computed, whose time grows with the number of numbers.

Parameters
----------
world : World
    World. It has no derivative except with respect to its parameters.
plan : Plan
    Steps, and the states to record.
parameters : sequence of Parameter, or mapping
    Parameters to change, with p components in total. A mapping has new values instead, without ``changes``: for each body
    a mapping of "position", "velocity", "angular_velocity" (3,), "modulus", "dissipation", "friction" and "mass";
    "gravity" (3,); the names of force parameters; and "joints", a mapping from names of joints to mappings from the
    quantities of ``Parameter.joint`` to values.
changes : (p,) array_like, optional
    Changes that are added to the parameters, as in ``World.perturbed``. Default: zeros.
start : State, optional
    Initial state. Default: the initial state of the world, which has no derivative except with respect to
    parameters. The default is faster if there are few parameters. Fixed and kinematic bodies keep their state of
    the world, and bodies on joints follow their joints, so their part of ``start`` has no effect.
start_step : int or array of int
    Number of time steps between the initial time of the world and the start. It needs ``start``, and matters for
    worlds with controls and paths. An integer has no derivatives.

Returns
-------
State
    k recorded states: poses (k, n, 4, 4), twists (k, n, 6), and the arrays of joints.

Raises
------
HydroelasticError
    If a parameter does not belong to the world, an argument has an unexpected shape, a number is not valid, or
    ``start_step`` is given without ``start``.
TypeError
    If an argument is not of float64 or integers, or ``start_step`` is not an integer.
RolloutError
    If the rollout ends early.
""",
    "final_state": """Runs a rollout and returns its last state.

Parameters
----------
world, plan, parameters, changes, start, start_step
    Arguments of ``rollout``.

Returns
-------
State
    Last state: poses (n, 4, 4), twists (n, 6), and the arrays of joints.

Raises
------
HydroelasticError
    If an argument is not valid, as in ``rollout``.
RolloutError
    If the rollout ends early.
""",
    "step": """Takes a single time step.

To differentiate with respect to a control, use ``Parameter.control`` of the interval that contains the step.

Parameters
----------
world, plan, parameters, changes, start_step
    Arguments of ``rollout``. The number of steps and the recording of the plan are ignored.
state : State
    State before the step.

Returns
-------
State
    State after the step: poses (n, 4, 4), twists (n, 6), and the arrays of joints.

Raises
------
HydroelasticError
    If an argument is not valid, as in ``rollout``.
RolloutError
    If the step fails.
""",
}
