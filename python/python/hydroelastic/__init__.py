"""Differentiable pressure-field (hydroelastic) contact between soft-skinned rigid bodies.

Conventions, everywhere:

- SI units, world frame.
- Poses are (4, 4) float64 arrays that map coordinates in a body frame to the world; n poses are (n, 4, 4).
- 6-vectors have the angular part first: wrenches are (torque, force), twists (angular, linear).
- Derivatives by a pose are by a twist in world axes: the body turns about its own origin, which moves (``moved_pose``).
- The normal of a contact points out of B into A; the wrench on B is the negative of that on A about the same point.
- Arrays have type float64 or integer, or are lists of numbers. Other types are refused, because a conversion
  would lose digits silently.
- Numbers that are not finite or out of range are refused, and so are arguments for which a result would not be finite.

What the library refuses raises ``HydroelasticError``, a ``ValueError``; an array of another type raises ``TypeError``.
"""

from ._core import (
    Accuracy,
    Batch,
    Body,
    Contact,
    ContactTopology,
    Control,
    DerivativeCheck,
    Diagnostics,
    DifferenceCheck,
    Drag,
    HalfSpace,
    HydroelasticError,
    Integrator,
    Kink,
    LinearizedShape,
    Material,
    Pair,
    Parameter,
    Path,
    Plan,
    RigidShape,
    Rollout,
    RolloutError,
    Shape,
    ShapeGradient,
    ShapeRates,
    Spring,
    State,
    StepReport,
    Surface,
    SurfaceLaw,
    Thruster,
    Trajectory,
    TrajectoryJacobian,
    World,
    __version__,
    moved_pose,
    pose,
)

__all__ = [
    "Accuracy",
    "Batch",
    "Body",
    "Contact",
    "ContactTopology",
    "Control",
    "DerivativeCheck",
    "Diagnostics",
    "DifferenceCheck",
    "Drag",
    "HalfSpace",
    "HydroelasticError",
    "Integrator",
    "Kink",
    "LinearizedShape",
    "Material",
    "Pair",
    "Parameter",
    "Path",
    "Plan",
    "RigidShape",
    "Rollout",
    "RolloutError",
    "Shape",
    "ShapeGradient",
    "ShapeRates",
    "Spring",
    "State",
    "StepReport",
    "Surface",
    "SurfaceLaw",
    "Thruster",
    "Trajectory",
    "TrajectoryJacobian",
    "World",
    "__version__",
    "moved_pose",
    "pose",
]
