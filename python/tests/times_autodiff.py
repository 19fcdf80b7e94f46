"""Prints times of calls through JAX and PyTorch, if they are installed: python tests/times_autodiff.py."""

import importlib.util
import time

import numpy as np

import hydroelastic as he


def least(function, count=3000):
    """Returns the minimum time of a function over ``count`` calls (µs), after 20 warm-up calls."""
    times = []
    for _ in range(count + 20):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times[20:])


# A ball of order 3 on a box: 66 polygons.
law = he.SurfaceLaw(0.2, 0.4, 1e-2)
pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6, law)
pose_a = he.pose([0.013, 0.021, 0.1921], [0.3, -0.2, 0.5])
pose_b = he.pose([0.0, 0.0, 0.0], [0.02, -0.03, 0.01])
twist = np.array([0.1, 0.2, -0.3, 0.5, 0.1, -0.05])
many = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-6 * index]) for index in range(1000)])

skin = he.Material(1e5, 0.2, 0.4)
ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0, 0, 0.4]), velocity=[0.5, 0, 0])
floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
plan = he.Plan(2e-4, 2500, record_every=2500)
by = [he.Parameter.initial_velocity("ball")]

print("least times, µs")
print(
    f"library: wrench {least(lambda: pair.wrench(pose_a, pose_b)):.0f}, with Jacobian "
    f"{least(lambda: pair.wrench_and_jacobian(pose_a, pose_b)):.0f}, in motion "
    f"{least(lambda: pair.wrench(pose_a, pose_b, twist, twist)):.0f}, with Jacobian "
    f"{least(lambda: pair.linearized(pose_a, pose_b, twist, twist)):.0f}; 1000 with Jacobians, each "
    f"{least(lambda: pair.wrench_and_jacobian(many, pose_b), 20) / 1000:.1f}; rollout "
    f"{least(lambda: world.rollout(plan).run(), 10):.0f}, with Jacobian {least(lambda: world.jacobian(plan, by), 10):.0f}"
)


def jax_times():
    import jax
    import jax.numpy as jnp

    import hydroelastic.jax as hj

    jax.config.update("jax_enable_x64", True)

    def time_of(function, *arguments, count=3000):
        arguments, jitted = jax.device_put(arguments), jax.jit(function)
        return least(lambda: jax.block_until_ready(jitted(*arguments)), count)

    def rest(a, b):
        return jnp.sum(hj.wrench(pair, a, b) ** 2)

    def motion(a, b, t):
        return jnp.sum(hj.wrench(pair, a, b, t, t) ** 2)

    def end(change):
        return jnp.sum(hj.final_state(world, plan, by, change).poses[0, :3, 3] ** 2)

    def nothing(a):
        out = jax.ShapeDtypeStruct((12,), jnp.float64)
        return jax.pure_callback(lambda a: np.zeros(12), out, a, vmap_method="broadcast_all")

    both, batch = jax.value_and_grad(rest, (0, 1)), jax.vmap(jax.value_and_grad(rest), (0, None))
    print(
        f"JAX {jax.__version__}, jitted: empty callback {time_of(nothing, pose_a):.0f}, wrench {time_of(rest, pose_a, pose_b):.0f}, "
        f"value and gradient {time_of(both, pose_a, pose_b):.0f}, in motion {time_of(motion, pose_a, pose_b, twist):.0f}, value "
        f"and gradient {time_of(jax.value_and_grad(motion, (0, 1, 2)), pose_a, pose_b, twist):.0f}; vmap of 1000, each "
        f"{time_of(batch, many, pose_b, count=20) / 1000:.1f}; rollout {time_of(end, np.zeros(3), count=10):.0f}, value and "
        f"gradient {time_of(jax.value_and_grad(end), np.zeros(3), count=10):.0f}"
    )


def times_by_controls():
    """Times 1,000 steps of a ball that is pushed over a half-space, and the gradient with respect to its 6,000 control
    numbers."""
    import jax
    import jax.numpy as jnp

    import hydroelastic.jax as hj

    steps = 1000
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0, 0, 0.095]), velocity=[0.5, 0, 0])
    ground = he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid(0.4))
    world = he.World([ball, ground], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
    world = world.replace(controls=[he.Control("ball", 5e-4, np.zeros((steps, 6)))])
    plan, by = he.Plan(5e-4, steps, record_every=50), he.Parameter.controls(["ball"], steps)

    def effort_and_miss(controls):
        states = hj.rollout(world, plan, by, controls.reshape(-1))
        return jnp.sum((states.poses[:, 0, 0, 3] - 0.1) ** 2) + 1e-6 * jnp.sum(controls**2)

    at = np.zeros((steps, 1, 6))
    plain = least(lambda: world.rollout(plan).run(), 10)
    gradient = jax.jit(jax.value_and_grad(effort_and_miss))
    both = least(lambda: jax.block_until_ready(gradient(at)), 10)
    print(f"1,000 steps of contact: {1e-3 * plain:.1f} ms, value and gradient (6,000 numbers) {1e-3 * both:.1f} ms")


def torch_times():
    import torch

    import hydroelastic.torch as ht

    def gradient(function, *arrays):
        tensors = [torch.tensor(array, requires_grad=True) for array in arrays]
        return lambda: torch.autograd.grad(function(*tensors), tensors)

    def rest(a, b):
        return (ht.wrench(pair, a, b) ** 2).sum()

    def motion(a, b, t):
        return (ht.wrench(pair, a, b, t, t) ** 2).sum()

    def end(change):
        return (ht.final_state(world, plan, by, change).poses[0, :3, 3] ** 2).sum()

    a, b, t = (torch.from_numpy(array) for array in (pose_a, pose_b, twist))
    print(
        f"PyTorch {torch.__version__}: wrench {least(lambda: rest(a, b)):.0f}, value and gradient "
        f"{least(gradient(rest, pose_a, pose_b)):.0f}, in motion {least(lambda: motion(a, b, t)):.0f}, value and gradient "
        f"{least(gradient(motion, pose_a, pose_b, twist)):.0f}; batch of 1000, each "
        f"{least(gradient(lambda a: rest(a, b), many), 20) / 1000:.1f}; rollout "
        f"{least(lambda: end(torch.zeros(3, dtype=torch.float64)), 10):.0f}, value and gradient "
        f"{least(gradient(end, np.zeros(3)), 10):.0f}"
    )


if importlib.util.find_spec("jax"):
    jax_times()
    times_by_controls()
if importlib.util.find_spec("torch"):
    torch_times()
