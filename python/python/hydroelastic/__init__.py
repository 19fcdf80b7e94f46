"""Differentiable pressure-field (hydroelastic) contact between soft-skinned rigid bodies.

All functions and classes share these conventions:

- Quantities have SI units and are in the world frame, unless the documentation names another frame.
- A pose is a (4, 4) array of float64 that maps coordinates in a body frame to the world. n poses are an (n, 4, 4)
  array.
- 6-vectors have the angular part first: a wrench is (torque, force), and a twist is (angular, linear).
- Derivatives with respect to a pose are with respect to a twist in world axes. The body turns about the origin of its
  frame, and the origin moves (``moved_pose``).
- The normal of a contact points out of B into A. The wrench on B is the negative of the wrench on A about the same
  point.
- Arguments are arrays of integers or of floats of up to 64 bits, or lists of numbers. Other types raise ``TypeError``,
  because a conversion to float64 could lose digits silently.
- Numbers that are not finite or out of range raise ``HydroelasticError``, a ``ValueError``. So do arguments for which a
  result would not be finite.
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
    Joint,
    Kinetics,
    Kink,
    LinearizedShape,
    LoopJoint,
    Material,
    Mechanism,
    Pair,
    Parameter,
    Path,
    Plan,
    RigidShape,
    Robot,
    Rollout,
    RolloutError,
    Shape,
    ShapeGradient,
    ShapeRates,
    Spring,
    State,
    StepReport,
    Stops,
    Surface,
    SurfaceLaw,
    Thruster,
    Trajectory,
    TrajectoryJacobian,
    VectorJacobianProduct,
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
    "Joint",
    "Kinetics",
    "Kink",
    "LinearizedShape",
    "LoopJoint",
    "Material",
    "Mechanism",
    "Pair",
    "Parameter",
    "Path",
    "Plan",
    "RigidShape",
    "Robot",
    "Rollout",
    "RolloutError",
    "Shape",
    "ShapeGradient",
    "ShapeRates",
    "Spring",
    "State",
    "StepReport",
    "Stops",
    "Surface",
    "SurfaceLaw",
    "Thruster",
    "Trajectory",
    "TrajectoryJacobian",
    "VectorJacobianProduct",
    "World",
    "__version__",
    "moved_pose",
    "pose",
]
