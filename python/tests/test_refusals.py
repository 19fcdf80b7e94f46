"""Errors of invalid arguments: types of exceptions and reasons."""

from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

FIELD = Path(__file__).parents[2] / "tests" / "data" / "field_files"


@pytest.mark.parametrize("kind", [np.longdouble, np.complex128, np.bool_, np.str_, object])
def test_arrays_of_other_types(ball_on_block, kind):
    pair, pose_a, pose_b = ball_on_block
    with pytest.raises(TypeError, match=r"pose_b must be a numpy array of floats of up to 64 bits or of integers, .* but is an array of"):
        pair.wrench(pose_a, np.zeros((4, 4), dtype=kind))
    with pytest.raises(TypeError, match="gravity must be a numpy array of floats"):
        he.World([], gravity=np.zeros(3, dtype=kind))


def test_what_is_no_array(ball_on_block):
    pair, pose_a, _ = ball_on_block
    complex_rows = [[1j] * 4] * 4
    for other in ("pose", None, 1.0, [[1.0], [1.0, 2.0]], [["1"] * 4] * 4, complex_rows, [[None] * 4] * 4):
        with pytest.raises(TypeError, match="pose_b"):
            pair.wrench(pose_a, other)


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint8, np.float32, list])
def test_other_arrays_and_lists_are_converted(kind):
    def array(rows):
        return rows if kind is list else np.array(rows, dtype=kind)

    ball, eye, push = he.Shape.icosphere(0.1, 1), np.eye(4, dtype=int).tolist(), [0, 0, 0, 1, 0, 0]
    pair = he.Pair(ball, ball, 1e5, 1e5)
    assert np.array_equal(pair.wrench(array([eye, eye]), array(eye)), pair.wrench(np.stack([np.eye(4)] * 2), np.eye(4)))
    assert np.array_equal(he.moved_pose(array(eye), array(push)), he.pose([1.0, 0.0, 0.0]))
    assert np.array_equal(he.Control("ball", 1.0, array([push])).wrenches, [push])
    assert np.array_equal(he.State(0.0, array([eye]), array([push])).twists, [push])
    tets = [[0, 1, 2, 3]] if kind is np.float32 else array([[0, 1, 2, 3]])
    assert he.Shape(array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), tets).volume == pytest.approx(1 / 6)
    body = he.Body.dynamic("ball", ball, he.Material(10**5), 1, pose=array(eye), velocity=array([1, 0, 0]))
    assert np.array_equal(body.twist, push)


def test_a_number_for_gravity_is_its_component_along_z():
    for number in (-9.81, np.float64(-9.81)):
        assert np.array_equal(he.World([], gravity=number).gravity, [0.0, 0.0, -9.81])
    assert np.array_equal(he.World([], gravity=-10).gravity, [0.0, 0.0, -10.0])


def test_an_integrator_can_be_given_by_its_name():
    assert he.Plan(1e-3, 10, "sdirk3") == he.Plan(1e-3, 10, he.Integrator.SDIRK3)
    assert he.Plan(1e-3, 10, "IMPLICIT_EULER").integrator == he.Integrator.IMPLICIT_EULER
    names = 'no integrator "rk4": expected "symplectic_euler", "leapfrog", "sdirk3", "implicit_euler"'
    with pytest.raises(he.HydroelasticError, match=names):
        he.Plan(1e-3, 10, "rk4")


def test_errors_of_wrong_arguments_show_the_right_call():
    with pytest.raises(TypeError, match=r'bodies must be the names of two bodies, but is ball: write Spring\(\("a", "b"\), '):
        he.Spring("ball", "floor", 1.0, 1.0, 1.0)
    with pytest.raises(TypeError, match=r"points must be a point \(3,\) of each body"):
        he.Spring(["ball", "floor"], 1.0, 1.0, 1.0)
    with pytest.raises(TypeError, match=r"a must be a compliant Shape, but is HalfSpace\(\)"):
        he.Pair(he.HalfSpace(), he.Shape.icosphere(0.1, 1), 1e5)


    with pytest.raises(TypeError, match="a force must be a Spring, a Drag or a Thruster, but is 1"):
        he.World([], forces=[1])
    with pytest.raises(TypeError, match='integrator must be an Integrator or its name, "symplectic_euler", .*, but is 1'):
        he.Plan(1e-3, 5, 1)
    with pytest.raises(TypeError, match="a shape must be a Shape, a RigidShape or a HalfSpace, but is 1"):
        he.Body.fixed("floor", 1, he.Material(1e5))
    with pytest.raises(TypeError, match="a number is expected, but the argument is a bool"):
        he.World([], gravity=True)
    with pytest.raises(he.HydroelasticError, match="an integer argument is too large"):
        he.Plan(1e-3, 10**400)


def tetrahedron(size, path):
    corners = size * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    if path.suffix == ".obj":
        lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f 1 3 2", "f 1 2 4", "f 2 3 4", "f 1 4 3"]
        path.write_text("\n".join(lines) + "\n")
    else:
        nodes = "\n".join(f"{x} {y} {z}" for x, y, z in corners)
        tags = "\n".join("1234")
        path.write_text(
            f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n{tags}\n{nodes}\n$EndNodes\n"
            "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"
        )
    return path


@pytest.mark.parametrize(("kind", "name"), [(he.RigidShape, "part.obj"), (he.Shape, "part.msh")])
def test_a_file_without_a_unit_that_is_over_10_m_large_gets_a_warning(tmp_path, recwarn, kind, name):
    small, large = (tetrahedron(size, tmp_path / f"{size}_{name}") for size in (9.9, 200.0))
    assert kind.read(small).volume == pytest.approx(9.9**3 / 6)
    assert kind.read(large, unit=1.0).volume == pytest.approx(200.0**3 / 6)
    assert kind.read(large, unit=1e-3).volume == pytest.approx(0.2**3 / 6)
    assert not recwarn
    with pytest.warns(UserWarning, match=r"is (200\.0000|2\.000e2) m large.*unit=1\.0 (meters|reads meters) without this warning"):
        kind.read(large)


def refusals():
    ball = he.Shape.icosphere(0.1, 1)
    skin = he.Material(1e5)
    body = he.Body.dynamic("ball", ball, skin, 1.0)
    world = he.World([body])
    pair = he.Pair(ball, ball, 1e5, 1e5)
    eye = np.eye(4)
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    nan = np.full((4, 4), np.nan)
    nan[3] = [0, 0, 0, 1]
    plan = he.Plan(1e-3, 5)
    tets = np.array([[0, 1, 2, 3]])
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])

    def driven(**numbers):
        """Returns a world with a spring of stiffness "k"."""
        spring = he.Spring(("ball", "wall"), ([0.0] * 3, [0.0] * 3), 0.1, "k")
        return he.World([body, he.Body.fixed("wall", ball, skin)], forces=[spring], **numbers)

    return {
        "pose_a must have the shape (4, 4) or (n, 4, 4), but has (3, 4)": lambda: pair.wrench(eye[:3], eye),
        "pose_a is a batch of 3, but pose_b one of 2": lambda: pair.wrench(np.stack([eye] * 3), np.stack([eye] * 2)),
        "pose_b[1]: a rotation must be orthonormal": lambda: pair.wrench(eye, np.stack([eye, mirror])),
        "orthonormal with determinant 1": lambda: pair.wrench(2 * eye - np.diag([0, 0, 0, 1.0]), eye),
        "the last row of a pose must be (0, 0, 0, 1)": lambda: pair.wrench(2 * eye, eye),
        "a pose must be finite": lambda: pair.wrench(nan, eye),
        "a twist must be finite": lambda: pair.wrench(eye, eye, np.full(6, np.nan), np.zeros(6)),
        "twist_a must have the shape (6,) or (n, 6)": lambda: pair.wrench(eye, eye, [0.0] * 5),
        "the hydroelastic modulus must be positive": lambda: he.Pair(ball, ball, 1e5, 0.0),
        "hydroelastic modulus must be positive and finite, but is NaN": lambda: pair.wrench(
            eye, eye, moduli=[1e5, float("nan")]
        ),
        "the friction of a surface law is -1": lambda: he.SurfaceLaw(0.0, -1.0),
        "the dissipation of a surface law is": lambda: pair.wrench(eye, eye, [0.0] * 6, law=[-1.0, 0.0]),
        "the radius": lambda: he.Shape.icosphere(-1.0, 2),
        "extents must have the shape (n,)": lambda: he.Shape(corners, tets, corners),
        "tetrahedron 0 refers to vertex 4, but the mesh has 4 vertices": lambda: he.Shape(corners, tets + 1),
        "indices count from 0": lambda: he.Shape(corners, tets - 1),
        "the mass of body": lambda: he.Body.dynamic("ball", ball, skin, -1.0),
        "needs its mass, or its density": lambda: he.Body.dynamic("ball", ball, skin),
        "the friction of a material is -0.1": lambda: he.Material(1e5, 0.0, -0.1),
        "both were given, mass=1.0 kg and density=3.0 kg/m³": lambda: he.Body.dynamic("ball", ball, skin, 1.0, density=3.0),
        "polygons.vtk holds a surface, not a mesh of tetrahedra: RigidShape.read": lambda: he.Shape.read(FIELD / "polygons.vtk"),
        "no_seam.vtk holds a mesh of tetrahedra, not a surface: Shape.read": lambda: he.Solid.read(FIELD / "no_seam.vtk"),
        "part.stl holds a surface, not a mesh of tetrahedra: RigidShape.read": lambda: he.Shape.read("part.stl"),
        "part.mesh holds a mesh of tetrahedra, not a surface: Shape.read": lambda: he.RigidShape.read("part.mesh"),
        "mujoco.msh holds a surface, not a mesh of tetrahedra: RigidShape.read": lambda: he.Shape.read(
            FIELD.parent / "hostile_files/mujoco.msh"
        ),
        "body \"floor\" has no friction of its own": lambda: he.World(
            [body, he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())]
        ).jacobian(plan, [he.Parameter.friction("floor")]),
        "two bodies are named": lambda: he.World([body, body]),
        'no body is named "floor"; there are ["ball"]': lambda: world.index_of("floor"),
        'no body is named "wall"': lambda: world.jacobian(plan, [he.Parameter.friction("wall")]),
        "interval 0 of the control of body \"ball\" does not exist: the body has no control": lambda: world.jacobian(plan, [he.Parameter.control("ball", 0)]),
        "the parameters have 3 numbers, but got 2 values or changes": lambda: world.perturbed(
            [he.Parameter.gravity()], [0.0, 0.0]
        ),
        "the time step is 0": lambda: he.Plan(0.0, 5),
        "the gravity is NaN": lambda: he.World([body], gravity=[0.0, 0.0, float("nan")]),
        "a state has 2 bodies, but the world has 1": lambda: world.diagnostics(
            he.State(0.0, np.stack([eye, eye]), np.zeros((2, 6)))
        ),
        "the stiffness of a spring is -1": lambda: he.World(
            [body, he.Body.fixed("wall", ball, skin)],
            forces=[he.Spring(("ball", "wall"), ([0.0] * 3, [0.0] * 3), 0.1, -1.0)],
        ),
        "the stiffness of a spring is -2": lambda: driven(force_parameters={"k": -2.0}),
        'no force parameter is named "k"; there are ["c"]': lambda: driven(force_parameters={"c": 1.0}),
        "the stiffness of a spring is -3": lambda: driven(force_parameters={"k": 1.0}).perturbed(
            [he.Parameter.force_parameter("k")], [-4.0]
        ),
        'the world has no force parameter "c"': lambda: driven(force_parameters={"k": 1.0}).jacobian(
            plan, [he.Parameter.force_parameter("c")]
        ),
        "a force parameter needs a name": lambda: he.World([body], force_parameters={"": 1.0}),
        'body "ball" has two controls': lambda: he.World([body], controls=[he.Control("ball", 0.1, np.ones((1, 6)))] * 2),
        'a spring between bodies "wall" and "block" moves nothing': lambda: he.World(
            [he.Body.fixed("wall", ball, skin), he.Body.fixed("block", ball, skin)],
            forces=[he.Spring(("wall", "block"), ([0.0] * 3, [0.0] * 3), 0.1, 1.0)],
        ),
        "the change between two states is inf": lambda: world.difference(
            *(he.State(0.0, he.pose([x, 0.0, 0.0])[None], np.zeros((1, 6))) for x in (-1e308, 1e308))
        ),
        "twists must be finite": lambda: he.State(0.0, eye[None], np.full((1, 6), np.inf)),
        "a trajectory needs at least one state": lambda: he.Trajectory([]),
        "the times of a path must increase": lambda: he.Path([0.0, 0.0], np.stack([eye, eye])),
    }


@pytest.mark.parametrize("reason", refusals())
def test_the_reason_is_told(reason):
    with pytest.raises(he.HydroelasticError) as caught:
        refusals()[reason]()
    assert isinstance(caught.value, ValueError)
    assert reason.lower() in str(caught.value).lower()


def test_a_rollout_that_fails_keeps_its_states():
    stiff = he.Material(1e150)
    falling = he.Body.dynamic("falling", he.Shape.icosphere(0.1, 1), stiff, 1e-200, pose=he.pose([0.0, 0.0, 1.0]))
    floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), stiff)
    world = he.World([falling, floor], gravity=[0.0, 0.0, -9.81])
    with pytest.raises(he.RolloutError, match='took body "falling" to a state that is not finite') as caught:
        world.rollout(he.Plan(0.1, 100)).run()
    assert len(caught.value.trajectory) == 5
    with pytest.raises(he.RolloutError) as caught:
        world.jacobian(he.Plan(0.1, 100), [he.Parameter.gravity()])
    assert caught.value.trajectory is None
    (error,) = he.Batch(he.Plan(0.1, 100)).rollouts([world])
    assert isinstance(error, he.RolloutError) and len(error.trajectory) == 5


def test_classes_without_a_constructor():
    for made in (he.Body, he.Rollout, he.Parameter, he.Integrator, he.StepReport):
        with pytest.raises(TypeError):
            made()
