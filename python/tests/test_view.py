"""Pictures: their content, and their pixels in a browser."""

import base64
import html
import json
import re
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he
from hydroelastic import view

sys.path.insert(0, str(Path(__file__).parent))
import browser as chromium

# Frame of a picture in a notebook.
LARGEST = 1_000_000
# Coordinates are rounded to the 65535th part of a box.
GRID = 0.5001 / 65535


class Content:
    """Content of a page, unpacked like in the viewer."""

    def __init__(self, page):
        packed = base64.b64decode(re.search("const DATA = '(.*?)'", page)[1])
        data = zlib.decompress(packed)
        length = int.from_bytes(data[:4], "little")
        self.head = json.loads(data[4 : 4 + length])
        self._data = data[4 + length :]

    def array(self, reference):
        kind, first, count = reference
        return np.frombuffer(self._data, "<" + kind, count, first)

    def points(self, part):
        return part["low"] + self.array(part["points"]).reshape(-1, 3) / 65535 * part["size"]


@pytest.fixture(scope="module")
def surface():
    pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    return pair.surface(he.pose([0.0, 0.0, 0.18]), he.pose())


@pytest.fixture(scope="module")
def thrown(bounce):
    world, plan = bounce
    return world.rollout(he.Plan(5e-4, 400, record_every=4)).run()


def test_a_surface_has_its_corners_and_pressures(surface):
    content = Content(view.html(surface))
    (patch,) = content.head["patches"]
    size = np.ptp(surface.vertices, axis=0).max()
    assert np.abs(content.points(patch) - surface.vertices).max() <= GRID * size
    pressures = content.array(patch["shares"]) / 65535 * content.head["limit"]
    assert np.abs(pressures - surface.pressures).max() <= GRID * surface.pressures.max()
    assert content.array(patch["sizes"]).tolist() == np.diff(surface.offsets).tolist()
    assert content.head["limit"] == surface.pressures.max() > 0.0 and not content.head["exceeded"]


def test_pressures_above_the_limit_have_its_color(surface):
    limit = surface.pressures.max() / 2
    content = Content(surface.show(pressure_limit=limit).html)
    shares = content.array(content.head["patches"][0]["shares"])
    assert content.head["limit"] == limit and content.head["exceeded"]
    assert (shares == 65535).sum() == (surface.pressures >= limit).sum() > 0


def test_a_world_has_its_bodies_and_contacts(scene):
    pressed = scene.initial_state
    poses = pressed.poses.copy()
    poses[0, 2, 3] = 0.19
    pressed = he.State(0.5, poses, pressed.twists)
    content = Content(scene.show(pressed).html)
    assert [body["name"] for body in content.head["bodies"]] == scene.names
    assert [body["moves"] for body in content.head["bodies"]] == [True, True, False]
    assert len({body["color"] for body in content.head["bodies"]}) == 3
    actual = content.array(content.head["poses"]).reshape(1, 3, 3, 4)
    assert np.abs(actual[0] - poses[:, :3]).max() < 1e-7
    assert len(content.head["patches"]) == len(scene.contacts(pressed)) > 0
    for body, drawn in zip(scene.bodies, content.head["bodies"], strict=True):
        shape = content.head["shapes"][drawn["shape"]]
        corners = content.points(shape)[content.array(shape["triangles"])]
        expected = body.shape.vertices[body.shape.surface_triangles].reshape(-1, 3)
        assert np.abs(corners - expected).max() <= GRID * np.ptp(expected, axis=0).max()
    assert Content(scene.show().html).head["times"] == [scene.initial_state.time]


def test_half_spaces_are_plates_below_their_outlines(rigid_world):
    trajectory = rigid_world.rollout(he.Plan(1e-3, 100, record_every=10)).run()
    bodies = list(rigid_world.bodies)
    tilt = he.pose([5.0, 3.0, 0.0], [0.0, 0.0, 0.5])
    bodies[2] = he.Body.fixed("ground", he.HalfSpace(0.05), he.Material(1e6), pose=tilt)
    layered = he.World(bodies[:1] + bodies[2:], gravity=[0.0, 0.0, -9.81])
    for picture, world, states, thickness in (
        (trajectory.show(rigid_world), rigid_world, list(trajectory), None),
        (rigid_world.show(), rigid_world, [rigid_world.initial_state], None),
        (layered.show(), layered, [layered.initial_state], 0.05),
    ):
        content = Content(picture.html)
        shape_indices = {body["name"]: body["shape"] for body in content.head["bodies"]}
        plate = content.head["shapes"][shape_indices["ground"]]
        corners, triangles = content.points(plate), content.array(plate["triangles"]).reshape(-1, 3)
        solid = he.RigidShape(corners, triangles)  # The surface is closed and oriented outwards.
        outline = world.half_space_outlines(states)[world.names.index("ground")]
        width = np.ptp(outline, axis=0)[:2]
        assert np.allclose(corners[: len(outline)], outline, atol=1e-4 * width.max())
        size = np.ptp(corners, axis=0)
        assert np.allclose(size[:2], width, rtol=1e-4) and abs(corners[:, 2].max()) < 1e-5
        assert abs(solid.volume - size.prod()) < 1e-6 * size.prod()
        assert size[2] < 0.02 * width.max() if thickness is None else abs(size[2] - thickness) < 1e-4 * thickness
        if "block" in shape_indices:
            block = content.head["shapes"][shape_indices["block"]]
            shape = rigid_world.bodies[1].shape
            assert np.allclose(content.points(block), shape.vertices, atol=1e-5)
            assert np.array_equal(content.array(block["triangles"]).reshape(-1, 3), shape.triangles)
    alone = he.World([he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid())])
    assert len(Content(alone.show().html).head["shapes"]) == 1


def test_a_floor_and_four_walls_are_a_tray():
    block = he.Body.dynamic("block", he.Shape.cuboid([0.2, 0.2, 0.1]), he.Material(1e5), 1.0, pose=he.pose([0.0, 0.0, 0.1]))
    poses = {"floor": he.pose()}
    for name, angle, distance in (("east", 0.0, 0.12), ("north", 0.5, 0.15), ("west", 1.0, 0.12), ("south", 1.5, 0.15)):
        c, s = np.cos(angle * np.pi), np.sin(angle * np.pi)
        poses[name] = he.pose([distance * c, distance * s, 0.0], np.array([s, -c, 0.0]) * np.pi / 2)
    walls = [he.Body.fixed(name, he.HalfSpace(), he.Material.rigid(), pose=pose) for name, pose in poses.items()]
    hidden = he.Body.fixed("hidden", he.HalfSpace(), he.Material.rigid(), pose=he.pose([0.0, 0.0, -0.1]))
    content = Content(he.World([block, *walls, hidden]).show().html)
    corners = []
    for body, pose in zip(content.head["bodies"][1:6], poses.values(), strict=True):
        points = content.points(content.head["shapes"][body["shape"]])
        corners.append(points[:4] @ pose[:3, :3].T + pose[:3, 3])
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    # The walls end a quarter of the diagonal of the block above the block.
    assert np.allclose([low, high], [[-0.12, -0.15, 0.0], [0.12, 0.15, 0.225]], atol=1e-4)
    assert np.allclose(np.ptp(corners[0], axis=0), [0.24, 0.3, 0.0], atol=1e-4)
    assert "shape" not in content.head["bodies"][6]


def test_bodies_of_the_same_shape_share_it():
    skin, shape = he.Material(1e5), he.Shape.icosphere(0.1, 1)
    bodies = [he.Body.dynamic(str(index), shape, skin, 1.0, pose=he.pose([index, 0.0, 0.0])) for index in range(3)]
    head = Content(he.World(bodies).show().html).head
    assert len(head["shapes"]) == 1 and [body["shape"] for body in head["bodies"]] == [0, 0, 0]


def test_bodies_without_a_shape_are_not_drawn():
    arm = he.Body.dynamic("arm", None, mass=1.0, inertia=np.eye(3), pose=he.pose([0.0, 0.0, 0.5]))
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), he.Material(1e5), 1.0)
    for bodies, count in (([arm, ball], 1), ([arm], 0)):
        world = he.World(bodies)
        content = Content(world.show().html)
        assert len(content.head["shapes"]) == count
        assert ["shape" in body for body in content.head["bodies"]] == [body.shape is not None for body in bodies]
        # The box includes the position of the arm.
        assert content.head["high"][2] >= 0.5
        world.rollout(he.Plan(1e-3, 5)).run().show(world)


def test_creases_of_a_cuboid_are_its_edges_and_a_ball_has_none():
    def of(shape):
        used, triangles = np.unique(shape.surface_triangles, return_inverse=True)
        vertices = shape.vertices[used]
        return vertices[view.creases(vertices, triangles.reshape(-1, 3))]

    edges = of(he.Shape.cuboid([1.0, 2.0, 3.0]))
    assert sorted(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).tolist()) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4
    assert len(of(he.Shape.icosphere(0.1, 3))) == 0


def test_a_trajectory_has_frames_from_the_first_to_the_last(bounce, thrown):
    world, _ = bounce
    assert len(thrown) == 101
    content = Content(thrown.show(world, frames=21).html)
    assert content.head["times"] == thrown.times[::5].tolist()
    touching = [index for index in range(21) if world.contacts(thrown[5 * index])]
    assert [patch["frame"] for patch in content.head["patches"]] == touching != []
    greatest = max(
        contact.surface.pressures.max() for index in touching for contact in world.contacts(thrown[5 * index])
    )
    assert content.head["limit"] == greatest
    assert Content(thrown.show().html).head["bodies"] == []


def test_pictures_stay_below_one_megabyte(bounce, scene, surface, thrown):
    world, _ = bounce
    long = scene.rollout(he.Plan(2e-4, 6000, record_every=3)).run()
    assert len(long) == 2001
    for picture in (surface.show(), scene.show(), thrown.show(world), long.show(), long.show(scene, frames=2001)):
        assert len(picture._repr_html_()) < LARGEST
    times = Content(long.show(scene, frames=2001).html).head["times"]
    assert 100 < len(times) < 2001 and (times[0], times[-1]) == (long.times[0], long.times[-1])


def test_meshes_that_take_more_are_told_of():
    rng = np.random.default_rng(0)
    shape = he.Shape.icosphere(0.1, 5)
    noisy = he.Shape(shape.vertices + 1e-4 * rng.normal(size=shape.vertices.shape), shape.tets, shape.extents)
    others = [he.Shape(noisy.vertices * (1.0 + 1e-3 * index), noisy.tets, noisy.extents) for index in range(9)]
    world = he.World([he.Body.fixed(str(index), other, he.Material(1e5)) for index, other in enumerate(others)])
    with pytest.warns(UserWarning, match="MB"):
        world.show()


def test_a_saved_page_is_the_picture(surface, scene, tmp_path):
    view.save(tmp_path / "a.html", surface)
    surface.show().save(tmp_path / "b.html")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page == (tmp_path / "b.html").read_text(encoding="utf-8") == view.html(surface)
    for thing in (surface, scene, scene.rollout(he.Plan(1e-3, 3)).run()):
        shown = re.search('srcdoc="(.*?)"', thing._repr_html_(), flags=re.S)[1]
        assert html.unescape(shown) == thing.show().html
    assert f"{len(surface)} polygons" in repr(surface.show())


def test_a_page_names_no_other_place(surface):
    assert re.findall(r"https?://\S*|src=\S*|href=\S*|@import\S*", view.html(surface)) == []
    assert "default-src 'none'" in view.html(surface)


def test_a_surface_without_polygons_is_shown_as_such(surface):
    pair = he.Pair(he.Shape.icosphere(0.1, 1), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    apart = pair.surface(he.pose([0.0, 0.0, 5.0]), he.pose())
    assert len(apart) == 0 and Content(apart.show().html).head["patches"] == []


def test_bad_arguments_are_refused(bounce, scene, surface, thrown):
    world, _ = bounce
    for refused in (
        lambda: surface.show(pressure_limit=0.0),
        lambda: surface.show(pressure_limit=float("nan")),
        lambda: surface.show(height=0),
        lambda: thrown.show(world, frames=0),
        lambda: thrown.show(scene),
        lambda: scene.show(world.initial_state),
    ):
        with pytest.raises(he.HydroelasticError):
            refused()
    for refused in (lambda: view.picture(3), lambda: view.html(surface, frames=3), lambda: surface.show(1.0)):
        with pytest.raises(TypeError):
            refused()


def lab(colors):
    """Converts sRGB colors (n, 3) between 0 and 1 to CIELAB coordinates (n, 3), in daylight of 6500 K."""
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
    )
    xyz = linear @ to_xyz.T / to_xyz.sum(axis=1)
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def test_the_color_map_is_perceptually_uniform():
    colors = np.array([[int(color[i : i + 2], 16) / 255 for i in (0, 2, 4)] for color in view.PRESSURE_COLORS])
    positions = np.linspace(0, len(colors) - 1, 256)
    between = np.stack([np.interp(positions, range(len(colors)), colors[:, i]) for i in range(3)], axis=1)
    lightness = lab(between)[:, 0]
    assert (np.diff(lightness) > 0.0).all() and lightness[0] < 20.0 and lightness[-1] > 85.0
    # Lightness alone shows the pressure, because it deviates from a straight line by at most 5 of 100.
    assert np.abs(lightness - np.linspace(lightness[0], lightness[-1], 256)).max() < 5.0


@pytest.fixture(scope="module")
def page():
    if not chromium.is_there():
        pytest.skip("Chromium and chromedriver are not installed")
    page = chromium.Browser()
    yield page
    page.close()


def colored(pixels):
    """Counts the pixels that are not white, gray or black."""
    return int((np.ptp(pixels.astype(int), axis=2) > 40).sum())


def wait_for(condition):
    """Waits until a condition is true."""
    for _ in range(50):
        if condition():
            return
        time.sleep(0.2)
    raise AssertionError("the condition was not true within 10 s")


DRAWN = "document.body.dataset.drawn === 'true'"


@pytest.mark.browser
def test_a_surface_is_seen_in_the_colors_of_its_pressures(page, surface, tmp_path):
    view.save(tmp_path / "surface.html", surface)
    page.open(tmp_path / "surface.html")
    page.wait_until(DRAWN)
    pixels = page.pixels()
    # This region is left of the color bar.
    seen = pixels[:, : pixels.shape[1] - 150].reshape(-1, 3).astype(int)
    for color in (view.PRESSURE_COLORS[0], view.PRESSURE_COLORS[8], view.PRESSURE_COLORS[-1]):
        rgb = [int(color[i : i + 2], 16) for i in (0, 2, 4)]
        assert (np.abs(seen - rgb).max(axis=1) < 25).sum() > 20, color
    assert colored(pixels) > 5000
    assert f"{surface.pressures.max() / 1e3:.3g} kPa" in page.run("return document.body.innerText")


@pytest.mark.browser
def test_a_world_is_seen_in_the_frame_of_a_notebook_and_can_be_turned(page, scene, tmp_path):
    (tmp_path / "notebook.html").write_text(f"<meta charset=utf-8>{scene._repr_html_()}", encoding="utf-8")
    page.open(tmp_path / "notebook.html")
    page.enter_frame()
    page.wait_until(DRAWN)
    before = page.pixels()
    assert colored(before) > 3000
    assert page.run("return document.querySelector('#names').innerText").split() == scene.names
    page.leave_frame()
    page.drag(120, 40)
    assert (page.pixels() != before).any(axis=2).sum() > 3000


@pytest.mark.browser
def test_a_trajectory_is_stepped_by_its_slider_and_plays_to_its_end(page, bounce, thrown, tmp_path):
    world, _ = bounce
    view.save(tmp_path / "throw.html", thrown, world=world)
    page.open(tmp_path / "throw.html")
    page.wait_until(DRAWN)
    first = page.pixels()
    move = "const s = document.querySelector('input'); s.value = %d; s.dispatchEvent(new Event('input'));"
    page.run(move % 50)
    middle = page.pixels()
    assert (first != middle).any(axis=2).sum() > 1000
    drawn = np.linspace(0, len(thrown) - 1, 100).round().astype(int)
    output = "return document.querySelector('output').textContent"
    assert page.run(output) == f"t = {thrown.times[drawn[50]]:.4f} s"
    page.run("document.querySelector('select').value = 1; document.querySelector('button').click()")
    start = time.perf_counter()
    page.wait_until("document.querySelector('input').value === document.querySelector('input').max")
    assert time.perf_counter() - start < 10.0
    assert page.run("return document.querySelector('button').textContent") == "▶"
    assert page.run(output) == f"t = {thrown.times[-1]:.4f} s"


@pytest.mark.browser
def test_a_picture_out_of_sight_gives_its_context_back_and_takes_it_again(page, scene, tmp_path):
    frames = "".join(scene._repr_html_() for _ in range(24))
    (tmp_path / "many.html").write_text(f"<meta charset=utf-8>{frames}", encoding="utf-8")
    page.open(tmp_path / "many.html")
    for index in (0, 23, 0):
        page.run(f"document.querySelectorAll('iframe')[{index}].scrollIntoView()")
        page.enter_frame(index)
        page.wait_until(DRAWN)
        page.wait_until("!document.querySelector('canvas').getContext('webgl2').isContextLost()")
        page.leave_frame()
        # The bodies are visible. Without them, the legend and the axes have fewer than a thousand colored pixels.
        wait_for(lambda: colored(page.pixels()) > 10_000)
    page.enter_frame(23)
    page.wait_until("document.querySelector('canvas').getContext('webgl2').isContextLost()")
    page.leave_frame()


@pytest.mark.browser
def test_no_request_leaves_the_page(page, scene, thrown, bounce, tmp_path):
    world, _ = bounce
    leak = "<script>fetch('http://%s.invalid/'); new Image().src = 'http://%s.invalid/';</script></body>"
    pages = {
        "free": "<body>" + leak % ("free", "free"),
        "world": scene.show().html.replace("</body>", leak % ("world", "world")),
        "throw": thrown.show(world).html.replace("</body>", leak % ("throw", "throw")),
    }
    for name, content in pages.items():
        (tmp_path / f"{name}.html").write_text(content, encoding="utf-8")
    page.requests()
    for name in pages:
        page.open(tmp_path / f"{name}.html")
        if name != "free":
            page.wait_until(DRAWN)
        time.sleep(1.0)
    # The browser itself sends some requests. Requests of a page have the name of the page.
    asked = " ".join(page.listener.asked)
    assert "free.invalid" in asked
    assert "world.invalid" not in asked and "throw.invalid" not in asked
    requests = page.requests()
    assert any("free.invalid" in request for request in requests)
    view.save(tmp_path / "plain.html", thrown, world=world)
    page.open(tmp_path / "plain.html")
    page.wait_until(DRAWN)
    page.run("document.querySelector('button').click()")
    time.sleep(1.0)
    assert page.requests() == [(tmp_path / "plain.html").as_uri()]
