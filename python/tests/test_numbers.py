"""Every public callable raises errors for numeric arguments of other types, numbers out of range and wrong shapes."""

import ast
import importlib
import inspect
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

MESH = Path(__file__).parents[2] / "tests" / "data" / "field_files" / "gmsh_1.msh"

# Names in the annotations of numeric arguments.
NUMERIC = {"float", "int", "_Floats", "_Numbers", "_Rows", "_Indices", "_Whole", "_Array", "_Tensor", "NDArray"}
REFUSED = (he.HydroelasticError, TypeError, ValueError)
HUGE = 1e308


class Positive(float):
    """A number that must be above 0."""


class Slow(Positive):
    """A number that must be above 0, and that takes long to be refused if it is small."""


class NotNegative(float):
    """A number that must not be below 0."""


class Named(NotNegative):
    """A number that must not be below 0, or a name."""


class Signed(int):
    """An integer that may be negative."""


# Arrays of numbers that must not be negative.
NOT_NEGATIVE = {"moduli", "law"}


def refused_values(name, value):
    """Returns invalid values in place of a valid value, by the reason."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "i":
        return {"shape": value[None], "negative": -1 - value, "floats": value.astype(float)}
    if isinstance(value, np.ndarray):
        invalid = {"axes": value[None, None], "length": value.ravel()[:-1], "text": value.astype(str), "complex": value * 1j}
        numbers = {"NaN": np.nan, "infinite": np.inf, "minus infinity": -np.inf}
        if name in NOT_NEGATIVE:
            numbers["negative"] = -1.0
        return invalid | {what: changed(value, number) for what, number in numbers.items()}
    if isinstance(value, bool | Signed):
        return {"NaN": np.nan, "a fraction": 1.5}
    if isinstance(value, int):
        return {"negative": -1, "NaN": np.nan, "a fraction": 1.5, "text": "1", "a huge integer": 10**400, "a bool": True}
    invalid = {"NaN": np.nan, "infinite": np.inf, "minus infinity": -np.inf, "text": "1", "complex": 1j}
    invalid |= {"a huge integer": 10**400, "a bool": True}
    if isinstance(value, Named):
        del invalid["text"]
    if isinstance(value, Positive):
        invalid["zero"] = 0.0
    if isinstance(value, Positive | NotNegative):
        invalid["negative"] = -1.0
    return invalid


def changed(value, number):
    array = np.array(value, dtype=np.float64)
    array.flat[0] = number
    return array


def huge_values(value):
    """Returns values that must either raise an error or give finite results."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return [changed(value, HUGE), changed(value, -HUGE)]
    if isinstance(value, Slow):
        return [HUGE]
    return [HUGE, 1e-308] if isinstance(value, float) else []


def numbers_in(value):
    """Yields all numbers of a result."""
    if isinstance(value, float | np.ndarray | np.floating):
        yield np.asarray(value, dtype=np.float64)
    elif isinstance(value, dict):
        yield from numbers_in(list(value.values()))
    elif isinstance(value, list | tuple):
        for item in value:
            yield from numbers_in(item)
    elif type(value).__module__.startswith("hydroelastic") and not isinstance(value, he.World | he.Rollout):
        for name in dir(type(value)):
            if not name.startswith("_") and inspect.isgetsetdescriptor(getattr(type(value), name)):
                yield from numbers_in(getattr(value, name))
    elif hasattr(value, "__array__"):
        yield from numbers_in(np.asarray(value))


def check(call, arguments, takes_batches=False):
    """Checks that a callable accepts valid arguments and raises an error for every invalid value of each argument."""
    for numbers in numbers_in(call(**arguments)):
        assert np.isfinite(numbers).all()
    for name, value in arguments.items():
        for what, bad in refused_values(name, value).items():
            if takes_batches and what == "axes":
                continue
            try:
                result = call(**arguments | {name: bad})
            except REFUSED as error:
                assert str(error), f"{name}: {what}"
            else:
                pytest.fail(f"{name}: {what}: {bad!r} was accepted, and gave {result!r}")
        for huge in huge_values(value):
            try:
                result = call(**arguments | {name: huge})
            except REFUSED:
                continue
            for numbers in numbers_in(result):
                assert np.isfinite(numbers).all(), f"{name}: {huge!r} gave {result!r}"


def raised(results):
    """Returns the results of a batch. Raises the first error among them."""
    for result in results:
        if isinstance(result, he.HydroelasticError):
            raise result
    return results


def raised_in(states, errors):
    """Returns the results of Batch.advance. Raises the first error among them."""
    for error in errors.values():
        raise error
    return states


def scene():
    skin = he.Material(1e5, 0.2, 0.4)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=he.pose([0.0, 0.0, 0.09]))
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())
    return he.World([ball, floor], gravity=-9.81, controls=[he.Control("ball", 1.0, np.zeros((1, 6)))])


def jointed():
    ball, skin = he.Shape.icosphere(0.1, 1), he.Material(1e5)
    hinge = he.Joint.revolute("hinge", [0.0, 0.0, 1.0])
    socket = he.Joint.ball("socket", parent="arm", origin=he.pose([0.3, 0.0, 0.0]))
    arm = he.Body.dynamic("arm", ball, skin, 1.0, joint=hinge)
    return he.World([arm, he.Body.dynamic("head", ball, skin, 1.0, joint=socket)], gravity=-9.81)


ROBOT = """<robot name="robot"><link name="base"/><link name="arm"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
    <collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision></link>
    <link name="hand"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TET, FACES = np.array([[0, 1, 2, 3]]), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
EYE, TWIST, POINT = np.eye(4), np.full(6, 0.1), np.full(3, 0.1)


def cases(folder):
    """Returns callables with valid arguments, by name. A suffix in parentheses distinguishes cases of one callable."""
    ball, skin, world, plan = he.Shape.icosphere(0.1, 1), he.Material(1e5), scene(), he.Plan(1e-3, 2)
    rigid = he.RigidShape.around(ball)
    pair = he.Pair(ball, ball, 1e5, 1e5, he.SurfaceLaw(0.1, 0.2))
    linearized = he.LinearizedShape(CORNERS, TET)
    solid = he.Solid.of_surface(rigid, spacing=0.05)
    boundary = solid.vertices[solid.boundary_vertices]
    ring = {"profile": [[0.05, 0.0], [0.08, 0.01], [0.06, 0.03]], "segments": 8, "resolution": Positive(0.02)}
    prism = {"polygon": [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]], "length": Positive(0.1), "resolution": Positive(0.05)}
    state, trajectory = world.initial_state, world.rollout(plan).run()
    surface = pair.surface(EYE, he.pose([0.0, 0.0, 0.19]))
    gravity, batch = [he.Parameter.gravity()], he.Batch(plan)
    poses = {"pose_a": he.pose([0.0, 0.0, 0.19]), "pose_b": EYE}
    moduli = {"moduli": np.array([1e5, 2e5])}
    moving = poses | {"twist_a": TWIST, "twist_b": -TWIST} | moduli | {"law": np.array([0.1, 0.2])}
    taxels, counts = he.TaxelGrid.dome([2.0, 2.0], 3, 2), {"columns": 3, "rows": 2, "frame": EYE}
    columns, rows = (np.array([[*axis, d] for d in (0.1, 0.0, -0.1)]) for axis in np.eye(3)[:2])
    planes = {"column_planes": columns, "row_planes": rows, "lower": -POINT, "upper": POINT}
    by_mass = {"density": Positive(2.0), "by_mass": 1.0, "by_center": POINT, "by_inertia": np.eye(3)}
    hinge = {"axis": POINT, "origin": EYE, "position": 0.1, "velocity": 0.1, "armature": NotNegative(0.1)}
    hinge |= {"damping": NotNegative(0.1), "friction": NotNegative(0.1), "slip_tolerance": Positive(1e-3)}
    hinge |= {"servo_stiffness": NotNegative(1.0), "servo_damping": NotNegative(1.0), "target_position": 0.1}
    hinge |= {"target_velocity": 0.1, "torque": 0.1, "torque_limit": NotNegative(1.0)}
    socket = {"origin": EYE, "rotation": np.eye(3), "angular_velocity": POINT, "armature": NotNegative(0.1)}
    arm = jointed()
    kinetics, accelerations = arm.kinetics(), np.ones(4)
    robot, axis = he.Robot.parse(ROBOT), [0.0, 0.0, 1.0]
    mechanism = robot.mechanism(skin)
    (folder / "robot.urdf").write_text(ROBOT)
    implicit = he.Batch(he.Plan(1e-3, 2, he.Integrator.IMPLICIT_EULER))
    states = he.States([arm.initial_state] * 2)
    state_arrays = {name: getattr(states, name) for name in ("times", "poses", "twists", "joint_positions", "joint_velocities")}
    state_arrays |= {name: getattr(states, name) for name in ("ball_joint_rotations", "ball_joint_velocities")}
    of_joints = {"by_poses": np.zeros((1, 3, 2, 4, 4)), "by_twists": np.zeros((1, 3, 2, 6))}
    of_joints |= {"by_joint_positions": np.zeros((1, 3, 1)), "by_joint_velocities": np.zeros((1, 3, 1))}
    of_joints |= {"by_ball_joint_rotations": np.zeros((1, 3, 1, 3, 3)), "by_ball_joint_velocities": np.zeros((1, 3, 1, 3))}
    of_jacobian = {"poses": np.ones((2, 1, 4, 4, 3)), "twists": np.ones((2, 1, 6, 3))}
    of_jacobian |= {"joint_positions": np.ones((2, 1, 3)), "joint_velocities": np.ones((2, 1, 3))}
    of_jacobian |= {"ball_joint_rotations": np.ones((2, 1, 3, 3, 3)), "ball_joint_velocities": np.ones((2, 1, 3, 3))}
    covectors = {"by_poses": np.zeros((3, 2, 4, 4)), "by_twists": np.zeros((3, 2, 6))}
    many = {name: array[None] for name, array in covectors.items()}
    shown = {"pressure_limit": Positive(1e3), "height": 300}
    stl = folder / "part.obj"
    stl.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "".join(f"f {a} {b} {c}\n" for a, b, c in FACES + 1))
    elastic = he.Material(1e5)

    def from_ball(points):
        return np.linalg.norm(points, axis=1) - 0.09

    def recording(slowdown, targets, radius, paths, camera, at):
        marks = {"targets": {"a": (targets, radius)}, "paths": {"b": paths}, "camera": (camera, at)}
        world.write_recording(folder / "a.glb", trajectory, slowdown=slowdown, **marks)

    def spring(points, second, rest_length, stiffness, damping):
        return he.Spring(("ball", "floor"), (points, second), rest_length, stiffness, damping)

    def state_of(joints, velocity, rotation, spin, **it):
        return he.State(joints=[(joints, velocity), (rotation, spin)], **it)

    def with_joints(positions, velocities, rotation, spin):
        return arm.state_with_joints({"hinge": positions, "socket": rotation}, {"hinge": velocities, "socket": spin})

    def joint(kind, **it):
        return getattr(he.Joint, kind)("a", axis, **it)

    def identification_of(unknown=("modulus", {}), deviation=1e-3, **it):
        quantity, options = unknown
        unknown = he.Unknown(getattr(he.Parameter, quantity)("ball"), **options)
        nuisances = [(he.Parameter.initial_velocity("ball"), deviation)]
        return he.Identification(world, plan, [unknown], nuisances=nuisances, **it)

    # Cases of the arguments that are pairs or triples.
    scheduled = {}
    for kind in ("revolute", "prismatic"):
        for name in ("torques", "targets"):
            scheduled[f"Joint.{kind} ({name})"] = (
                lambda kind=kind, **it: joint(kind, **{name: (number, [0.1]) for name, number in it.items()}),
                {name: Positive(0.1)},
            )
        scheduled[f"Joint.{kind} (mimic)"] = (lambda mimic, kind=kind: joint(kind, mimic=("b", mimic, 0.1)), {"mimic": 0.1})
    for kind, axes in (("revolute", [axis]), ("prismatic", [axis]), ("ball", []), ("fixed", [])):
        closing = getattr(he.LoopJoint, kind)
        scheduled[f"LoopJoint.{kind} (frames)"] = (
            lambda first, second, closing=closing, axes=axes: closing("pin", *axes, ("a", first), ("b", second)),
            {"first": EYE, "second": EYE},
        )
    moved = {name: value for name, value in hinge.items() if name not in ("axis", "origin")}
    identification = identification_of()

    fields = ("vertices", "pressures", "normals", "areas", "centroids", "mean_pressures", "area", "center_of_pressure")
    arrays = {name: getattr(surface, name) for name in fields}
    whole = {"offsets": surface.offsets, "tets": surface.tets}
    report = world.diagnostics(state)
    energies = {name: float(getattr(report, name)) for name in ("kinetic_energy", "gravitational_energy", "contact_energy", "total_energy")}

    return {
        "pose": (he.pose, {"translation": POINT, "rotation_vector": POINT}),
        "moved_pose": (he.moved_pose, {"pose": EYE, "twist": TWIST}),
        "Shape": (he.Shape, {"vertices": CORNERS, "tets": TET}),
        "Shape (within a tolerance)": (lambda tolerance: he.Shape(CORNERS, TET, tolerance=tolerance), {"tolerance": Positive(0.1)}),
        "Shape (with extents)": (lambda **it: he.Shape(ball.vertices, ball.tets, **it), {"extents": ball.extents}),
        "Shape.read": (
            lambda **it: he.Shape.read(MESH, **it),
            {"unit": Positive(1.0), "scale": np.ones(3), "pose": EYE, "weld_tolerance": NotNegative(0.0)}
            | {"tolerance": Positive(0.1)},
        ),
        "Shape.icosphere": (he.Shape.icosphere, {"radius": Positive(0.1), "subdivisions": 1}),
        "Shape.ellipsoid": (he.Shape.ellipsoid, {"semi_axes": POINT, "subdivisions": 1}),
        "Shape.cuboid": (he.Shape.cuboid, {"lengths": POINT}),
        "Shape.distance_cuboid": (he.Shape.distance_cuboid, {"lengths": POINT}),
        "Shape.cylinder": (he.Shape.cylinder, {"radius": Positive(0.1), "length": Positive(0.3), "segments": 8}),
        "Shape.capsule": (he.Shape.capsule, {"radius": Positive(0.1), "length": Positive(0.3), "segments": 8}),
        "Shape.torus": (
            he.Shape.torus,
            {"radius": Positive(0.1), "tube_radius": Positive(0.03), "segments": 8, "sides": 6},
        ),
        "Shape.lathe": (he.Shape.lathe, ring),
        "Shape.extrusion": (he.Shape.extrusion, prism),
        "Shape.compound": (lambda parts: he.Shape.compound([(ball, parts)]), {"parts": EYE}),
        "Shape.from_distance_up_to": (
            he.Shape.from_distance_up_to,
            {"vertices": CORNERS, "tets": TET, "depth": Positive(0.01)},
        ),
        "Shape.icosphere_rates": (he.Shape.icosphere_rates, {"radius": Positive(0.1), "subdivisions": 1}),
        "Shape.ellipsoid_rates": (he.Shape.ellipsoid_rates, {"semi_axes": POINT, "subdivisions": 1}),
        "Shape.cuboid_rates": (he.Shape.cuboid_rates, {"lengths": POINT}),
        "Shape.distance_cuboid_rates": (he.Shape.distance_cuboid_rates, {"lengths": POINT}),
        "Shape.cylinder_rates": (he.Shape.cylinder_rates, {"radius": Positive(0.1), "length": Positive(0.3), "segments": 8}),
        "Shape.capsule_rates": (he.Shape.capsule_rates, {"radius": Positive(0.1), "length": Positive(0.3), "segments": 8}),
        "Shape.torus_rates": (
            he.Shape.torus_rates,
            {"radius": Positive(0.1), "tube_radius": Positive(0.03), "segments": 8, "sides": 6},
        ),
        "Shape.lathe_rates": (he.Shape.lathe_rates, ring),
        "Shape.extrusion_rates": (he.Shape.extrusion_rates, prism),
        "Shape.convex_hull": (he.Shape.convex_hull, {"points": CORNERS}),
        "Shape.star_shaped": (he.Shape.star_shaped, {"vertices": CORNERS, "triangles": FACES, "inner_point": POINT}),
        "Shape.mass_properties": (ball.mass_properties, {"density": Positive(2.0)}),
        "Shape.mass_gradient": (ball.mass_gradient, by_mass),
        "RigidShape": (he.RigidShape, {"vertices": CORNERS, "triangles": FACES}),
        "RigidShape.read": (
            lambda **it: he.RigidShape.read(stl, **it),
            {"unit": Positive(1.0), "scale": np.ones(3), "pose": EYE},
        ),
        "RigidShape.convex_hull": (he.RigidShape.convex_hull, {"points": CORNERS}),
        "RigidShape.mass_properties": (rigid.mass_properties, {"density": Positive(2.0)}),
        "RigidShape.mass_gradient": (rigid.mass_gradient, by_mass),
        "HalfSpace": (he.HalfSpace, {"thickness": Positive(0.1)}),
        "Material": (he.Material, {"modulus": Positive(1e5), "dissipation": NotNegative(0.1), "friction": NotNegative(0.1)}),
        "Material.rigid": (he.Material.rigid, {"friction": NotNegative(0.1)}),
        "Material.combined_with": (lambda **it: elastic.combined_with(elastic, **it), {"slip_tolerance": Positive(1e-3)}),
        "SurfaceLaw": (
            he.SurfaceLaw,
            {"dissipation": NotNegative(0.1), "friction": NotNegative(0.1), "slip_tolerance": Positive(1e-3)},
        ),
        "Pair": (lambda **it: he.Pair(ball, ball, **it), {"modulus_a": Positive(1e5), "modulus_b": Positive(1e5)}),
        "Pair.wrench": (pair.wrench, moving),
        "Pair.wrench_and_jacobian": (pair.wrench_and_jacobian, poses | moduli),
        "Pair.linearized": (pair.linearized, moving),
        "Pair.shape_gradients": (pair.shape_gradients, moving | {"by_wrenches": np.ones(12)}),
        "Pair.vertex_jacobians": (pair.vertex_jacobians, moving),
        "Pair.vertex_jacobians (vertices)": (
            lambda vertices_a, vertices_b: pair.vertex_jacobians(EYE, EYE, [vertices_a], [vertices_b]),
            {"vertices_a": 0, "vertices_b": 1},
        ),
        "Pair.tactile_image": (lambda **it: pair.tactile_image(taxels, **it), moving),
        "Pair.tactile_image_and_jacobian": (lambda **it: pair.tactile_image_and_jacobian(taxels, **it), poses | moduli),
        "Pair.tactile_shape_gradients": (
            lambda **it: pair.tactile_shape_gradients(taxels, **it),
            moving | {"by_forces": np.ones((taxels.rows, taxels.columns, 3))},
        ),
        "Pair.linearized_tactile_image": (lambda **it: pair.linearized_tactile_image(taxels, **it), moving),
        "TaxelGrid": (he.TaxelGrid, planes),
        "TaxelGrid.flat": (he.TaxelGrid.flat, {"size": np.ones(2)} | counts),
        "TaxelGrid.cylindrical": (he.TaxelGrid.cylindrical, {"angle": Positive(1.0), "length": Positive(0.1)} | counts),
        "TaxelGrid.dome": (he.TaxelGrid.dome, {"angles": np.ones(2)} | counts),
        "Pair.potential_energy": (pair.potential_energy, poses | moduli),
        "Pair.clearance": (pair.clearance, poses | moduli),
        "Pair.surface": (pair.surface, poses),
        "Pair.has_sunk_through": (pair.has_sunk_through, poses),
        "Pair.write_surface": (lambda **it: pair.write_surface(folder / "a.vtp", **it), poses),
        "ShapeGradient": (he.ShapeGradient, {"by_vertices": np.ones((4, 3)), "by_extents": np.ones(4)}),
        "ShapeRates": (
            lambda ambiguous, **it: he.ShapeRates(ambiguous=[ambiguous], **it),
            {"vertices": np.ones((4, 3)), "extents": np.ones(4), "ambiguous": 0},
        ),
        "LinearizedShape": (he.LinearizedShape, {"vertices": CORNERS, "tets": TET}),
        "LinearizedShape (of a skin)": (lambda depth: he.LinearizedShape(CORNERS, TET, depth), {"depth": Positive(0.1)}),
        "LinearizedShape (within a tolerance)": (
            lambda tolerance: he.LinearizedShape(CORNERS, TET, tolerance=tolerance),
            {"tolerance": Positive(0.1)},
        ),
        "LinearizedShape.pullback": (
            linearized.pullback,
            {"by_vertices": np.ones_like(linearized.shape.vertices), "by_extents": np.ones_like(linearized.shape.extents)},
        ),
        "LinearizedShape.rates": (linearized.rates, {"velocities": CORNERS}),
        "Solid.of_surface": (lambda **it: he.Solid.of_surface(rigid, **it), {"spacing": Positive(0.05)}),
        "Solid.of_surface (of a volume error)": (
            lambda **it: he.Solid.of_surface(rigid, **it),
            {"volume_error": Slow(0.1)},
        ),
        "Solid.of_surface (of a distance error)": (
            lambda **it: he.Solid.of_surface(rigid, **it),
            {"distance_error": Slow(0.3)},
        ),
        "Solid.of_triangles": (he.Solid.of_triangles, {"vertices": CORNERS, "triangles": FACES, "spacing": Positive(0.3)}),
        "Solid.of_triangles (of a volume error)": (
            lambda **it: he.Solid.of_triangles(CORNERS, FACES, **it),
            {"volume_error": Slow(0.1)},
        ),
        "Solid.of_triangles (of a distance error)": (
            lambda **it: he.Solid.of_triangles(CORNERS, FACES, **it),
            {"distance_error": Slow(0.3)},
        ),
        "Solid.of_distance": (
            lambda **it: he.Solid.of_distance(from_ball, **it),
            {"lower": np.full(3, -0.1), "upper": np.full(3, 0.1), "spacing": Positive(0.05)},
        ),
        "Solid.of_distance (of a volume error)": (
            lambda **it: he.Solid.of_distance(from_ball, [-0.1] * 3, [0.1] * 3, **it),
            {"volume_error": Slow(0.1)},
        ),
        "Solid.of_distance (of a distance error)": (
            lambda **it: he.Solid.of_distance(from_ball, [-0.1] * 3, [0.1] * 3, **it),
            {"distance_error": Slow(0.3)},
        ),
        "Solid.read": (
            lambda **it: he.Solid.read(stl, **it),
            {"unit": Positive(1.0), "scale": np.ones(3), "pose": EYE, "spacing": Positive(0.3)},
        ),
        "Solid.read (of a volume error)": (lambda **it: he.Solid.read(stl, **it), {"volume_error": Slow(0.1)}),
        "Solid.read (of a distance error)": (lambda **it: he.Solid.read(stl, **it), {"distance_error": Slow(0.3)}),
        "Solid.pullback": (
            solid.pullback,
            {"by_vertices": np.ones_like(solid.vertices), "by_extents": np.ones_like(solid.shape.extents)},
        ),
        "Solid.rates": (solid.rates, {"velocities": rigid.vertices}),
        "Solid.rates_of_distance": (
            solid.rates_of_distance,
            {"gradients": boundary, "by_parameter": np.ones(len(boundary))},
        ),
        "Surface": (lambda **it: he.Surface(**whole, **it), arrays),
        "Surface.show": (surface.show, shown),
        "Stops": (
            he.Stops,
            {"range": np.array([-1.0, 1.0]), "stiffness": NotNegative(1.0), "dissipation": NotNegative(0.1)},
        ),
        "Joint.revolute": (lambda **it: he.Joint.revolute("hinge", **it), hinge),
        "Joint.prismatic": (lambda **it: he.Joint.prismatic("slide", **it), hinge),
        "Joint.ball": (lambda **it: he.Joint.ball("socket", **it), socket),
        "Joint.fixed": (lambda **it: he.Joint.fixed("weld", **it), {"origin": EYE}),
        "LoopJoint.revolute": (lambda **it: he.LoopJoint.revolute("pin", first=("a", EYE), second=("b", EYE), **it), {"axis": axis}),
        "LoopJoint.prismatic": (lambda **it: he.LoopJoint.prismatic("pin", first=("a", EYE), second=("b", EYE), **it), {"axis": axis}),
        **scheduled,
        "Mechanism.with_joint": (lambda **it: mechanism.with_joint("hinge", **it), moved),
        "Mechanism.with_joint (torques)": (
            lambda torques: mechanism.with_joint("hinge", torques=(torques, [0.1])),
            {"torques": Positive(0.1)},
        ),
        "Mechanism.with_joint (targets)": (
            lambda targets: mechanism.with_joint("hinge", targets=(targets, [0.1])),
            {"targets": Positive(0.1)},
        ),
        "Robot.mechanism": (
            lambda **it: robot.mechanism(skin, **it),
            {"pose": EYE, "subdivisions": 1, "segments": 8, "slip_tolerance": Positive(1e-3)},
        ),
        "Robot.mechanism (stops)": (
            lambda revolute_stops, prismatic_stops: robot.mechanism(
                skin, revolute_stops=(revolute_stops, 0.1), prismatic_stops=(prismatic_stops, 0.1)
            ),
            {"revolute_stops": NotNegative(1.0), "prismatic_stops": NotNegative(1.0)},
        ),
        "World.from_urdf": (
            lambda **it: he.World.from_urdf(folder / "robot.urdf", skin, **it),
            {"pose": EYE, "gravity": POINT},
        ),
        "World.from_urdf (servos)": (
            lambda servos: he.World.from_urdf(folder / "robot.urdf", skin, servos={"hinge": (servos, 0.1)}),
            {"servos": NotNegative(1.0)},
        ),
        "Kinetics.jacobian": (lambda point: kinetics.jacobian("arm", point), {"point": POINT}),
        "Kinetics.bias_acceleration": (lambda point: kinetics.bias_acceleration("arm", point), {"point": POINT}),
        "Kinetics.generalized_forces": (
            lambda wrenches: kinetics.generalized_forces({"arm": wrenches}),
            {"wrenches": np.ones(6)},
        ),
        "Kinetics.inverse_dynamics": (kinetics.inverse_dynamics, {"accelerations": accelerations}),
        "Kinetics.inverse_dynamics_derivatives": (kinetics.inverse_dynamics_derivatives, {"accelerations": accelerations}),
        "Kinetics.forward_dynamics": (kinetics.forward_dynamics, {"forces": accelerations}),
        "Kinetics.forward_dynamics_derivatives": (kinetics.forward_dynamics_derivatives, {"forces": accelerations}),
        "Body.dynamic": (
            lambda **it: he.Body.dynamic("ball", ball, skin, **it),
            {"mass": Positive(1.0), "center_of_mass": POINT, "inertia": np.eye(3)}
            | {"pose": EYE, "velocity": POINT, "angular_velocity": POINT},
        ),
        "Body.dynamic (of a density)": (lambda **it: he.Body.dynamic("ball", ball, skin, **it), {"density": Positive(1.0)}),
        "Body.fixed": (lambda **it: he.Body.fixed("ball", ball, skin, **it), {"pose": EYE}),
        "Path": (he.Path, {"times": np.array([0.0, 1.0]), "poses": np.stack([EYE, EYE]), "twists": np.zeros((2, 6))}),
        "Path.steady": (he.Path.steady, {"pose": EYE, "twist": TWIST}),
        "Path.at": (he.Path.steady(EYE, TWIST).at, {"time": 0.5}),
        "Path.at (of a fast one)": (lambda **it: he.Path.steady(EYE, **it).at(10.0), {"twist": TWIST}),
        "Path.at (between poses)": (
            lambda **it: he.Path([0.0, 1.0], np.stack([EYE, EYE]), **it).at(0.5),
            {"twists": np.zeros((2, 6))},
        ),
        "Spring": (
            spring,
            {"points": POINT, "second": POINT, "rest_length": Named(0.1), "stiffness": Named(1.0), "damping": Named(1.0)},
        ),
        "Drag": (lambda **it: he.Drag("ball", **it), {"linear": Named(0.1), "angular": Named(0.1)}),
        "Thruster": (lambda **it: he.Thruster("ball", **it), {"point": POINT, "force": POINT}),
        "Control": (lambda **it: he.Control("ball", **it), {"interval": Positive(0.1), "wrenches": np.ones((2, 6))}),
        "World": (lambda **it: he.World([], **it), {"gravity": POINT, "slip_tolerance": Positive(1e-3)}),
        "World (of force parameters)": (
            lambda force_parameters: he.World([], force_parameters={"k": force_parameters}),
            {"force_parameters": 1.0},
        ),
        "World.replace (of force parameters)": (
            lambda force_parameters: world.replace(force_parameters={"k": force_parameters}),
            {"force_parameters": 1.0},
        ),
        "World._sweeps_back": (lambda **it: world._sweeps_back(plan, gravity, **it), {"losses": 1}),
        "World (along z)": (lambda **it: he.World([], **it), {"gravity": -9.81}),
        "World.replace": (world.replace, {"gravity": POINT, "slip_tolerance": Positive(1e-3)}),
        "World.perturbed": (lambda **it: world.perturbed(gravity, **it), {"changes": POINT}),
        "World.with_values": (lambda **it: world.with_values(gravity, **it), {"values": POINT}),
        "World.integrate": (lambda **it: world.integrate(state, **it), {"change": np.full(12, 0.1)}),
        "World.vjp": (lambda **it: world.vjp(plan, gravity, **it), {"memory": 4096}),
        "World.vjp (the product)": (world.vjp(plan, gravity)[1], covectors),
        "World.write_recording": (
            recording,
            {"slowdown": Positive(1.0), "targets": POINT, "radius": Positive(0.1), "paths": CORNERS}
            | {"camera": 2.0 * POINT, "at": POINT},
        ),
        "World.show": (world.show, shown),
        "Plan": (
            he.Plan,
            {"time_step": Positive(1e-3), "steps": 5, "record_every": 1, "solver_tolerance": Positive(1e-9)},
        ),
        "Accuracy": (
            he.Accuracy,
            {"values": Positive(1e-3), "slopes": Positive(2e-3), "resting_speed": Positive(0.1)},
        ),
        "State": (
            state_of,
            {"time": 0.5, "poses": EYE[None], "twists": TWIST[None]}
            | {"joints": 0.1, "velocity": 0.1, "rotation": np.eye(3), "spin": POINT},
        ),
        "World.state_with_joints": (
            with_joints,
            {"positions": 0.1, "velocities": 0.1, "rotation": np.eye(3), "spin": POINT},
        ),
        "Trajectory.show": (trajectory.show, shown | {"frames": 2}),
        "Batch.rollouts_perturbed": (
            lambda **it: raised(batch.rollouts_perturbed(world, gravity, **it)),
            {"samples": np.zeros((2, 3))},
        ),
        "Batch.jacobians_perturbed": (
            lambda **it: raised(batch.jacobians_perturbed(world, gravity, **it)),
            {"samples": np.zeros((2, 3))},
        ),
        "States.replace": (states.replace, state_arrays),
        "Batch.advance": (
            lambda values: raised_in(*implicit.advance(arm, states, gravity, values)),
            {"values": np.zeros((2, 3))},
        ),
        "Batch.vjps": (lambda **it: raised(batch.vjps([world], gravity, **it)), many),
        "Batch.vjps (of joints)": (lambda **it: raised(implicit.vjps([arm], gravity, **it)), of_joints),
        "Parameter.joint": (lambda **it: he.Parameter.joint("hinge", "scheduled_torque", **it), {"index": 0}),
        "Parameter.control": (lambda **it: he.Parameter.control("ball", **it), {"interval": 0}),
        "Parameter.controls": (lambda **it: he.Parameter.controls(["ball"], **it), {"intervals": 1}),
        "TrajectoryJacobian": (he.TrajectoryJacobian, of_jacobian),
        "Kink": (
            lambda **it: he.Kink("flush faces", ["ball", "floor"], **it),
            {"steps": 2, "first_step": 1, "last_step": 4},
        ),
        "Diagnostics": (
            lambda momenta, **it: he.Diagnostics(momenta=(momenta, POINT), **it),
            energies | {"momenta": POINT},
        ),
        "Contact": (lambda **it: he.Contact(("a", "b"), surface=surface, **it), {"wrench": np.ones(12)}),
        "Checkpoint": (lambda **it: he.Checkpoint(unknowns=POINT, **it), {"horizon": 0, "nuisances": np.ones((2, 3))}),
        "Checkpoint (of unknowns)": (lambda unknowns: he.Checkpoint(0, [unknowns], np.ones((2, 3))), {"unknowns": 0.1}),
        "Unknown": (
            lambda **it: identification_of(("modulus", it)),
            {"component": 0, "prior": np.array([1e5, 0.1])},
        ),
        "Unknown (between bounds)": (
            lambda **it: identification_of(("friction", it)),
            {"bounds": np.array([0.05, 0.9])},
        ),
        "Identification": (
            identification_of,
            {"noise": np.array([1e-3, 1e-2]), "huber": Positive(2.0), "max_iterations": 2},
        ),
        "Identification (of Cauchy's loss)": (identification_of, {"cauchy": Positive(2.0)}),
        "Identification (of horizons)": (
            lambda horizons: identification_of(horizons=[horizons]),
            {"horizons": Positive(1e-3)},
        ),
        "Identification (of nuisances)": (
            lambda nuisances: identification_of(deviation=nuisances),
            {"nuisances": Positive(1e-3)},
        ),
        "Identification.predict": (
            lambda **it: identification.predict(trajectory=trajectory, **it),
            {"values": np.array([1e5]), "fitted_duration": Positive(1e-3)},
        ),
        "ContactTopology.touches": (world.topology(state).touches, {"first": 0, "second": 1}),
    }


def takes_numbers(annotation):
    """Returns whether an annotation is that of a numeric argument. The numbers of functions are not arguments."""
    names = {node.id for node in ast.walk(annotation) if isinstance(node, ast.Name)}
    return bool(names & NUMERIC) and "Callable" not in names


def callables_of_the_stub():
    """Returns the numeric arguments of each callable of the compiled module, by name."""
    stub = ast.parse((Path(he.__file__).parent / "_core.pyi").read_text())
    numeric_of = {}

    def add(name, function):
        arguments = [*function.args.args, *function.args.kwonlyargs]
        annotated = [argument for argument in arguments if argument.annotation is not None]
        numeric = {argument.arg for argument in annotated if takes_numbers(argument.annotation)}
        if numeric:
            numeric_of[name] = numeric

    for node in stub.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            add(node.name, node)
        for method in node.body if isinstance(node, ast.ClassDef) else []:
            if isinstance(method, ast.FunctionDef) and method.name == "__new__":
                add(node.name, method)
            elif isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                add(f"{node.name}.{method.name}", method)
    return numeric_of


def callables_of(module):
    """Returns the numeric arguments of each callable of a Python module, by name, without named tuples."""
    numeric_of = {}

    def add(name, function):
        parameters = inspect.signature(function).parameters.values()
        annotated = (parameter for parameter in parameters if isinstance(parameter.annotation, str))
        numeric = {parameter.name for parameter in annotated if takes_numbers(ast.parse(parameter.annotation).body[0])}
        if numeric:
            numeric_of[name] = numeric

    for name in module.__all__:
        member = getattr(module, name)
        if not inspect.isclass(member):
            add(name, member)
        elif not hasattr(member, "_fields") and not issubclass(member, Exception):
            add(name, member)
            for method, function in inspect.getmembers(member, inspect.isfunction):
                if not method.startswith("_"):
                    add(f"{name}.{method}", function)
    return numeric_of


def arguments_in(table):
    """Returns the arguments in a table of cases, by callable."""
    numeric_of = {}
    for name, (_, arguments) in table.items():
        numeric_of.setdefault(name.split(" (")[0], set()).update(arguments)
    return numeric_of


def assert_complete(expected, table, excluded):
    """Checks that a table has all numeric arguments except the excluded ones, which the callers explain."""
    known = arguments_in(table)
    missing = {name: arguments - known.get(name, set()) - excluded.get(name, set()) for name, arguments in expected.items()}
    assert not {name: arguments for name, arguments in missing.items() if arguments}


# Arguments of the stub that are not tested: integers that only pickles pass.
NOT_TESTED = {"Surface": {"offsets", "tets"}}


def test_every_callable_that_takes_numbers_is_in_the_table(tmp_path):
    expected = callables_of_the_stub()
    assert len(expected) > 60
    assert_complete(expected, cases(tmp_path), NOT_TESTED)


NAMES = sorted(callables_of_the_stub())


def test_arrays_in_column_order_are_read_by_their_rows():
    ball = he.Shape.icosphere(0.1, 1)
    columns = np.asfortranarray(ball.vertices)
    shape = he.Shape(columns, np.asfortranarray(ball.tets), ball.extents)
    assert np.array_equal(shape.vertices, ball.vertices) and np.array_equal(shape.tets, ball.tets)


@pytest.mark.parametrize("name", NAMES)
def test_numbers_out_of_range_are_refused(name, tmp_path):
    of_name = {case: item for case, item in cases(tmp_path).items() if case.split(" (")[0] == name and item[1]}
    assert of_name
    for call, arguments in of_name.values():
        check(call, arguments)


@pytest.mark.parametrize("framework", ["jax", pytest.param("torch", marks=pytest.mark.torch)])
def test_jax_and_torch_refuse_what_the_package_refuses(framework):
    arrays = pytest.importorskip(framework)
    if framework == "jax":
        arrays.config.update("jax_enable_x64", True)
    soft = importlib.import_module(f"hydroelastic.{framework}")
    world, plan, gravity = scene(), he.Plan(1e-3, 2), [he.Parameter.gravity()]
    pair = he.Pair(he.Shape.icosphere(0.1, 1), he.Shape.icosphere(0.1, 1), 1e5, 1e5)
    state = world.initial_state
    start = soft.State(state.poses, state.twists)
    changes = {"changes": np.full(3, 0.1)}
    table = {
        "pose": (soft.pose, {"translation": POINT, "rotation_vector": POINT}),
        "moved_pose": (soft.moved_pose, {"pose": EYE, "twist": TWIST}),
        "wrench": (
            lambda **it: soft.wrench(pair, **it),
            {"pose_a": he.pose([0.0, 0.0, 0.19]), "pose_b": EYE, "twist_a": TWIST, "twist_b": TWIST}
            | {"moduli": np.array([1e5, 1e5]), "law": np.array([0.1, 0.2])},
        ),
        "clearance": (
            lambda **it: soft.clearance(pair, **it),
            {"pose_a": he.pose([0.0, 0.0, 0.19]), "pose_b": EYE, "moduli": np.array([1e5, 1e5])},
        ),
        "tactile_image": (
            lambda **it: soft.tactile_image(pair, he.TaxelGrid.dome([2.0, 2.0], 3, 2), **it),
            {"pose_a": he.pose([0.0, 0.0, 0.19]), "pose_b": EYE, "twist_a": TWIST, "twist_b": TWIST}
            | {"moduli": np.array([1e5, 1e5]), "law": np.array([0.1, 0.2])},
        ),
        "rollout": (lambda **it: soft.rollout(world, plan, gravity, start=start, **it), changes | {"start_step": 0}),
        "final_state": (
            lambda **it: soft.final_state(world, plan, gravity, start=start, **it),
            changes | {"start_step": 0},
        ),
        "final_state (of a start)": (
            lambda poses, twists: soft.final_state(world, plan, start=soft.State(poses, twists)),
            {"poses": state.poses, "twists": state.twists},
        ),
        "step": (lambda **it: soft.step(world, plan, start, gravity, **it), changes | {"start_step": 0}),
    }
    assert_complete(callables_of(soft), table, {})
    for call, arguments in table.values():
        check(call, arguments, takes_batches=True)
    if framework == "jax":
        # Inside transformations, the results for invalid rows are NaN.
        assert np.isnan(arrays.jit(soft.pose)(np.full(3, np.nan))[:3, 3]).all()


def test_pinocchio_refuses_what_the_package_refuses():
    pinocchio = pytest.importorskip("pinocchio")
    soft = importlib.import_module("hydroelastic.pin")
    skin, model = he.Material(1e5, 0.1, 0.2), pinocchio.Model()
    slide = he.Joint.prismatic("slide", [0.0, 0.0, 1.0])
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, joint=slide)
    world = he.World([ball, he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid())])
    joint = model.addJoint(0, pinocchio.JointModelPZ(), pinocchio.SE3.Identity(), "slide")
    model.appendBodyToJoint(joint, pinocchio.Inertia.FromSphere(1.0, 0.1), pinocchio.SE3.Identity())
    model.addBodyFrame("ball", joint, pinocchio.SE3.Identity(), 0)
    robot = soft.Adapter(world, model)
    state = {"q": np.full(1, 0.09), "v": np.full(1, 0.09)}
    table = {
        "Adapter.state": (robot.state, state),
        "Adapter.velocity_map": (robot.velocity_map, {"q": state["q"]}),
        "Adapter.contact_torques": (robot.contact_torques, state),
        "Adapter.linearized_contact_torques": (robot.linearized_contact_torques, state),
    }
    assert_complete(callables_of(soft), table, {})
    for call, arguments in table.values():
        check(call, arguments)
    # Integers and lists are converted.
    assert robot.contact_torques([0], np.zeros(1, dtype=int)) == robot.contact_torques(*np.zeros((2, 1)))


def test_mujoco_refuses_what_the_package_refuses():
    mujoco = pytest.importorskip("mujoco")
    soft = importlib.import_module("hydroelastic.mujoco")
    xml = '<mujoco><worldbody><geom name="ball" type="sphere" size=".1"/></worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(xml)
    carriers = {kind: (lambda kind=kind, **it: getattr(soft, kind)("ball", **it), {"pose": EYE}) for kind in ("geom", "body", "site")}
    table = carriers | {
        "Attachment": (lambda **it: soft.Attachment("geom", "ball", **it), {"pose": EYE}),
        "shape_from_geom": (lambda **it: soft.shape_from_geom(model, "ball", **it), {"refinement": 1}),
    }
    assert_complete(callables_of(soft), table, {})
    for call, arguments in table.values():
        check(call, arguments)


def test_pictures_refuse_what_the_package_refuses():
    soft = importlib.import_module("hydroelastic.view")
    world = scene()
    trajectory = world.rollout(he.Plan(1e-3, 2)).run()
    (contact,) = world.contacts(world.initial_state)
    shown = {"pressure_limit": Positive(1e3), "height": 300}
    table = {
        "Picture": (lambda **it: soft.Picture("", shows="nothing", **it), {"height": 300}),
        "of_surface": (lambda **it: soft.of_surface(contact.surface, **it), shown),
        "of_world": (lambda **it: soft.of_world(world, **it), shown),
        "of_trajectory": (lambda **it: soft.of_trajectory(trajectory, **it), shown | {"frames": 2}),
    }
    image = {"image": np.ones((2, 3, 3)), "size": np.ones(2)}
    table["of_tactile_image"] = (soft.of_tactile_image, image | shown)
    assert_complete(callables_of(soft), table, {})
    for call, arguments in table.values():
        check(call, arguments)


def test_batches_of_ray_refuse_what_the_package_refuses():
    pytest.importorskip("ray")
    soft = importlib.import_module("hydroelastic.ray")
    plan, world = he.Plan(1e-3, 2), scene()
    refused = {"samples": np.full((2, 3), 0.1)}
    tasks = {"chunk": 1, "max_retries": Signed(1)}
    table = {"Batch": (lambda **it: soft.Batch(plan, **it) and None, tasks)}
    # The evaluator checks the numbers of a fit before any work is sent.
    table["fit"] = (lambda **it: soft._Evaluator(None, [], **it) and None, tasks)
    # The local batch checks the samples before any work is sent, and raises errors of their shape or type.
    excluded = {"Batch": {"progress"}, "Batch.rollouts_perturbed": {"samples"}, "Batch.jacobians_perturbed": {"samples"}}
    assert_complete(callables_of(soft), table, excluded)
    for call, arguments in table.values():
        check(call, arguments)
    with pytest.raises(he.HydroelasticError, match="max_retries must be at least -1"):
        soft.Batch(plan, max_retries=-2)
    for what, bad in refused_values("samples", refused["samples"]).items():
        if what in ("axes", "text", "complex"):
            for method in ("rollouts_perturbed", "jacobians_perturbed"):
                with pytest.raises(REFUSED):
                    getattr(soft.Batch(plan), method)(world, [he.Parameter.gravity()], bad)
