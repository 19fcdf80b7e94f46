"""Rigid bodies and half-spaces as partners of compliant bodies. Closed forms are the oracles."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

# Relative round-off of volumes, forces and moments.
ROUND_OFF = 1e-13
EDGE, MODULUS, DEPTH = 0.2, 1e6, 0.01
HARD = he.Material.rigid(0.5)
SKIN = he.Material(MODULUS, 1.0, 0.4)
GRAVITY = [0.0, 0.0, -9.81]


def cube():
    return he.Shape.cuboid([EDGE] * 3)


def slab():
    return he.RigidShape.around(he.Shape.cuboid([1.0, 1.0, 0.2]))


def force_of_cube(depth):
    """Force on a face that is pressed into a rigid body by a depth. The pressure decreases towards the edges."""
    return 2.0 * MODULUS / EDGE * (EDGE**2 * depth - 2.0 * EDGE * depth**2 + 4.0 * depth**3 / 3.0)


def grounds():
    """Shapes, moduli and poses of bodies below z = 0."""
    return [(he.HalfSpace(), None, he.pose()), (slab(), None, he.pose([0.0, 0.0, -0.1]))]


def again(value):
    return pickle.loads(pickle.dumps(value))


def test_a_cube_feels_the_force_of_the_closed_form_and_no_modulus_of_what_is_rigid():
    pose_a = he.pose([0.0, 0.0, EDGE / 2 - DEPTH])
    expected = force_of_cube(DEPTH)
    for ground, modulus, pose_b in grounds():
        pair = he.Pair(cube(), ground, MODULUS, modulus)
        assert pair.moduli == (MODULUS, None) and type(pair.shapes[1]) is type(ground)
        wrench, jacobian = pair.wrench_and_jacobian(pose_a, pose_b)
        assert abs(wrench[5] - expected) < ROUND_OFF * expected * 10
        assert not jacobian[:, 13].any()
        assert abs(jacobian[5, 12] - expected / MODULUS) < 10 * ROUND_OFF * expected / MODULUS
        _, jacobian = pair.linearized(pose_a, pose_b, [0.0] * 6, [0.0, 0.0, 0.0, 0.1, 0.0, 0.1])
        assert jacobian.shape == (12, 28) and not jacobian[:, 25].any()
        for ignored in (1.0, -1.0, np.nan, np.inf):
            assert np.array_equal(pair.wrench(pose_a, pose_b, moduli=np.array([MODULUS, ignored])), wrench)
        surface = pair.surface(pose_a, pose_b)
        assert len(surface) > 0 and abs(surface.area - EDGE**2) < ROUND_OFF


def test_a_soft_layer_has_a_modulus():
    layer, modulus, thickness = he.HalfSpace(0.05), 3e5, 0.05
    pair = he.Pair(cube(), layer, MODULUS, modulus)
    # Layer and cube act as springs in series, so the cube has a part of the depth.
    of_layer, of_cube = modulus / thickness, 2.0 * MODULUS / EDGE
    expected = force_of_cube(of_layer * DEPTH / (of_cube + of_layer))
    wrench, jacobian = pair.wrench_and_jacobian(he.pose([0.0, 0.0, EDGE / 2 - DEPTH]), he.pose())
    assert abs(wrench[5] - expected) < 10 * ROUND_OFF * expected
    assert jacobian[5, 13] > 0.0


def test_batches_have_the_bits_of_single_calls():
    heights = np.stack([he.pose([0.0, 0.0, z]) for z in np.linspace(0.08, 0.11, 9)])
    for ground, modulus, pose_b in grounds():
        pair = he.Pair(he.Shape.icosphere(0.1, 2), ground, MODULUS, modulus, he.SurfaceLaw(0.1, 0.3))
        wrenches, jacobians = pair.linearized(heights, pose_b, [0.0, 0.0, 1.0, 0.5, 0.0, 0.0])
        for height, wrench, jacobian in zip(heights, wrenches, jacobians, strict=True):
            single = pair.linearized(height, pose_b, [0.0, 0.0, 1.0, 0.5, 0.0, 0.0])
            assert np.array_equal(single[0], wrench) and np.array_equal(single[1], jacobian)


def test_a_ball_sinks_through_and_is_reported():
    pair = he.Pair(he.Shape.icosphere(0.1, 2), he.HalfSpace(), 1e2)
    assert [pair.has_sunk_through(he.pose([0.0, 0.0, z]), he.pose()) for z in (0.2, 0.05, -0.5)] == [False, False, True]
    heavy = he.Body.dynamic("brick", cube(), he.Material(1e2), 50.0, pose=he.pose([0.0, 0.0, 0.15]))
    world = he.World([heavy, he.Body.fixed("floor", he.HalfSpace(), HARD)], gravity=GRAVITY)
    end = world.rollout(he.Plan(1e-3, 600, record_every=600)).run()[-1]
    assert world.contacts(end) == [] and world.fully_submerged(end) == [("brick", "floor")]
    assert world.fully_submerged(world.initial_state) == []


def test_a_soft_box_that_passes_through_a_rigid_one_is_reported():
    box, skin = he.Shape.cuboid([1.0, 1.0, 1.0]), he.Material(2e4, 1.0, 0.5)
    soft, hard = (box, skin), (he.RigidShape.around(box), he.Material.rigid())
    for upper, lower in ((soft, hard), (hard, soft)):
        body = he.Body.dynamic("body", *upper, 1000.0, pose=he.pose([0.1, 0.05, 1.5]))
        world = he.World([body, he.Body.fixed("below", *lower)], gravity=GRAVITY)
        states = world.rollout(he.Plan(1e-2, 150, "sdirk3")).run()
        assert any(world.fully_submerged(state) for state in states)


def test_a_rigid_shape_has_what_its_surface_encloses():
    solid = he.Shape.distance_cuboid([0.2, 0.3, 0.5])
    shape = he.RigidShape.around(solid)
    assert shape.vertices.shape[1] == 3 and shape.triangles.dtype == np.int64
    assert shape.triangles.shape == solid.surface_triangles.shape
    assert abs(shape.volume - 0.03) < 0.03 * ROUND_OFF
    mass, center, inertia = shape.mass_properties(500.0)
    assert abs(mass - 15.0) < 15.0 * ROUND_OFF and np.abs(center).max() < ROUND_OFF
    expected = np.diag([0.3**2 + 0.5**2, 0.2**2 + 0.5**2, 0.2**2 + 0.3**2]) * 15.0 / 12.0
    assert np.abs(inertia - expected).max() < ROUND_OFF
    same = he.RigidShape(shape.vertices, shape.triangles)
    assert np.array_equal(same.vertices, shape.vertices) and repr(same) == repr(shape)
    assert repr(shape) == "RigidShape(8 vertices, 12 triangles, 3.0000e-2 m³)"


def written(path, shape, unit):
    """Writes the surface as Wavefront or ASCII STL, in a unit (m)."""
    corners = shape.vertices / unit
    if path.suffix == ".obj":
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in shape.triangles.tolist()]
    else:
        lines = ["solid it"]
        for triangle in corners[shape.triangles].tolist():
            points = [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle]
            lines += ["facet normal 0 0 0", "outer loop", *points, "endloop", "endfacet"]
        lines += ["endsolid it"]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("name", ["ball.obj", "ball.STL"])
def test_surfaces_come_from_files(tmp_path, name):
    shape = he.RigidShape.around(he.Shape.icosphere(0.1, 2))
    path = written(tmp_path / name, shape, 1e-3)
    for read in (he.RigidShape.read(path, 1e-3), he.RigidShape.read(str(path), unit=1e-3)):
        assert read.triangles.shape == shape.triangles.shape and read.vertices.shape == shape.vertices.shape
        assert abs(read.volume - shape.volume) < 1e-12 * shape.volume
    assert he.RigidShape.read(path).volume > 1e8 * shape.volume


FIELD_FILES = Path(__file__).parents[2] / "tests" / "data" / "field_files"


def test_surface_files_are_repaired_with_warnings_and_on_request(recwarn):
    for name, volume in [("no_area.obj", 1.0), ("u_prism.obj", 7.0), ("tetrahedron.ply", 1 / 6), ("touch_in_an_edge.stl", 2.0)]:
        assert he.RigidShape.read(FIELD_FILES / name).volume == pytest.approx(volume)
    assert he.RigidShape.read(FIELD_FILES / "inwards.obj", flip=True).volume == pytest.approx(1.0)
    for name in ("open_box.obj", "points.obj"):
        assert he.RigidShape.read(FIELD_FILES / name, hull=True).volume == pytest.approx(1.0)
    mirrored = he.RigidShape.read(FIELD_FILES / "tetrahedron.off", 0.1, scale=[-1, 2, 1], pose=he.pose([1.0, 0.0, 0.0]))
    assert mirrored.volume == pytest.approx(1e-3 / 3) and mirrored.vertices[:, 0].min() == pytest.approx(0.9)
    # The contents of .vtk and .msh files decide.
    for name in ("polygons.vtk", "../hostile_files/mujoco.msh"):
        assert he.RigidShape.read(FIELD_FILES / name).volume == pytest.approx(1 / 6)
    with pytest.raises(FileNotFoundError, match="nothing.vtk"):
        he.RigidShape.read("nothing.vtk")
    assert not recwarn
    with pytest.warns(UserWarning, match="ulp_apart.stl: .* vertices were moved by up to .* m"):
        close = he.RigidShape.read(FIELD_FILES / "ulp_apart.stl")
    assert len(close.vertices) == 8
    with pytest.warns(UserWarning, match="overlap"):
        parts = he.RigidShape.read(FIELD_FILES / "overlap.stl")
    with pytest.warns(UserWarning, match="the surface: 1 pairs of components overlap"):
        he.RigidShape(parts.vertices, parts.triangles)


def test_hulls_of_points_are_rigid_or_compliant():
    corners = np.array(np.meshgrid([0, 1], [0, 2], [0, 3])).reshape(3, 8).T.astype(float)
    points = np.vstack([corners, [[0.5, 1.0, 1.5]]])
    assert he.RigidShape.convex_hull(points).volume == pytest.approx(6.0)
    assert he.Shape.convex_hull(points).volume == pytest.approx(6.0)
    with pytest.raises(he.HydroelasticError, match="the convex hull of 4 points has no volume"):
        he.Shape.convex_hull(corners[corners[:, 2] == 0.0])


def test_what_is_refused(tmp_path):
    shape = slab()
    inward = shape.triangles[:, ::-1]
    open_file = written(tmp_path / "open.obj", shape, 1.0)
    open_file.write_text("\n".join(open_file.read_text().splitlines()[:-1]))
    tool = he.Body.dynamic("tool", shape, HARD, 1.0)
    floor = he.Body.fixed("floor", he.HalfSpace(), HARD)
    ball = he.Body.dynamic("ball", cube(), SKIN, 1.0)
    world = he.World([ball, floor])
    refusals = {
        "turned inwards": lambda: he.RigidShape(shape.vertices, inward),
        "the surface is not closed": lambda: he.RigidShape(shape.vertices, shape.triangles[1:]),
        "not closed": lambda: he.RigidShape.read(open_file),
        "indices count from 0": lambda: he.RigidShape(shape.vertices, shape.triangles - 1),
        "unit": lambda: he.RigidShape.read(open_file, 0.0),
        "a positive and finite thickness": lambda: he.HalfSpace(0.0),
        "HalfSpace() is rigid and has no modulus": lambda: he.Pair(cube(), he.HalfSpace(), 1e5, 1e5),
        "HalfSpace(thickness=0.1) is not rigid: modulus_b is missing": lambda: he.Pair(cube(), he.HalfSpace(0.1), 1e5),
        "modulus_b is missing": lambda: he.Pair(cube(), cube(), 1e5),
        "modulus must be positive": lambda: he.Pair(cube(), he.HalfSpace(), -1e5),
        "its material is rigid: it needs a hydroelastic modulus": lambda: he.Body.fixed("it", cube(), HARD),
        'body "it" is rigid, but its material has a hydroelastic modulus': lambda: he.Body.fixed("it", he.HalfSpace(), SKIN),
        'body "it" is a half-space, which has no mass': lambda: he.Body.dynamic("it", he.HalfSpace(), HARD, 1.0),
        'bodies "tool" and "floor" cannot have a contact': lambda: he.World([tool, floor]),
        'body "floor" is rigid: it has no modulus': lambda: world.jacobian(he.Plan(1e-3, 2), [he.Parameter.modulus("floor")]),
    }
    for reason, refused in refusals.items():
        with pytest.raises(he.HydroelasticError) as caught:
            refused()
        assert reason in str(caught.value), (reason, str(caught.value))
    for a, b in ((shape, cube()), (he.HalfSpace(), cube()), (cube(), "floor"), (cube(), None)):
        with pytest.raises(TypeError):
            he.Pair(a, b, 1e5, 1e5)
    with pytest.raises(TypeError):
        he.Body.fixed("it", 3.0, HARD)
    # Two bodies need no contact if neither is dynamic.
    assert he.World([floor, he.Body.fixed("wall", shape, HARD)]).ignored == []


def test_materials():
    assert HARD == he.Material(None, friction=0.5) != SKIN
    assert HARD.modulus is None and SKIN.modulus == MODULUS
    assert repr(HARD) == "Material(modulus=None, dissipation=0.0, friction=0.5)"
    # A rigid body dissipates nothing, whatever the dissipation of its material.
    law = SKIN.combined_with(he.Material(None, 7.0, 0.4))
    assert law == he.Material(None, 7.0, 0.4).combined_with(SKIN)
    assert law.dissipation == SKIN.dissipation and abs(law.friction - 0.4) < ROUND_OFF


def test_bodies_give_their_shapes_back():
    path = he.Path.steady(he.pose(), [0.0, 0.0, 0.0, 0.1, 0.0, 0.0])
    kinds = {he.HalfSpace(): HARD, he.HalfSpace(0.3): SKIN, slab(): HARD, cube(): SKIN}
    for shape, material in kinds.items():
        for body in (he.Body.fixed("it", shape, material), he.Body.kinematic("it", shape, material, path)):
            for each in (body, again(body), he.World([body]).bodies[0], again(he.World([body])).bodies[0]):
                assert type(each.shape) is type(shape) and repr(each.shape) == repr(shape) and each.material == material
    tool = he.Body.dynamic("tool", slab(), HARD, density=10.0)
    assert abs(tool.mass - 2.0) < 2.0 * ROUND_OFF and again(tool).mass == tool.mass


def test_what_was_pickled_has_the_bits_of_what_it_was(rigid_world):
    for shape in (slab(), he.HalfSpace(), he.HalfSpace(0.1 / 3)):
        for loaded in (again(shape), copy.deepcopy(shape)):
            assert repr(loaded) == repr(shape)
    ball = he.RigidShape.around(he.Shape.icosphere(0.1, 2))
    assert np.array_equal(again(ball).vertices, ball.vertices) and np.array_equal(again(ball).triangles, ball.triangles)
    assert again(HARD) == HARD and again(he.HalfSpace(0.1 / 3)).thickness == 0.1 / 3
    for ground, modulus, pose_b in grounds():
        pair = he.Pair(he.Shape.icosphere(0.1, 2), ground, 1e5, modulus, he.SurfaceLaw(0.1, 0.2))
        pose_a = he.pose([0.0, 0.0, 0.09])
        assert np.array_equal(again(pair).wrench(pose_a, pose_b), pair.wrench(pose_a, pose_b)) and repr(again(pair)) == repr(pair)
    plan = he.Plan(5e-3, 40, he.Integrator.SDIRK3, record_every=20)
    expected, actual = (world.rollout(plan).run() for world in (rigid_world, again(rigid_world)))
    assert np.array_equal(expected.poses, actual.poses) and np.array_equal(expected.twists, actual.twists)
    assert again(rigid_world).ignored == [("block", "ground")]


def test_a_rigid_world_moves_and_has_derivatives(rigid_world):
    plan = he.Plan(1e-3, 300, he.Integrator.SDIRK3, record_every=300)
    by = [he.Parameter.initial_velocity("block"), he.Parameter.friction("ground"), he.Parameter.modulus("ball")]
    trajectory, jacobian = rigid_world.jacobian(plan, by)
    # The block, which the ground does not slow down, has pushed the ball.
    assert trajectory.poses[-1, 0, 0, 3] > 0.01
    state = trajectory[-1]
    touching = {tuple(sorted(contact.bodies)) for contact in rigid_world.contacts(state)}
    assert touching <= {("ball", "block"), ("ball", "ground")}
    assert rigid_world.topology(state).polygon_count > 0 and rigid_world.largest_stable_step(state) > 0.0
    assert np.isfinite(jacobian.poses).all() and jacobian.poses[-1, 0, 0, 3].any()
    batch = he.Batch(plan).jacobians([rigid_world] * 2, by)
    for states, derivatives in batch:
        assert np.array_equal(states.poses, trajectory.poses) and np.array_equal(derivatives.poses, jacobian.poses)
    (recorded,) = he.Batch(plan).rollouts([rigid_world])
    alone = rigid_world.rollout(plan).run()
    assert np.array_equal(recorded.poses, alone.poses)


def test_a_recording_and_tables_are_written(rigid_world, tmp_path):
    trajectory = rigid_world.rollout(he.Plan(1e-3, 200, record_every=20)).run()
    rigid_world.write_recording(tmp_path / "it.glb", trajectory)
    rigid_world.write_trajectory(tmp_path / "it.csv", trajectory)
    assert (tmp_path / "it.glb").stat().st_size > 1000 and len(Path(tmp_path / "it.csv").read_text().splitlines()) == 34
    pair = he.Pair(cube(), he.HalfSpace(), MODULUS)
    pair.write_surface(tmp_path / "it.vtp", he.pose([0.0, 0.0, 0.09]), he.pose())
    assert (tmp_path / "it.vtp").stat().st_size > 100
