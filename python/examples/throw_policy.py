"""Can a network learn to throw a rolling ball so that it is at its target in time, after a bounce?

    pip install "hydroelastic[jax]"
    python throw_policy.py

A ball rolls over the ground, each time in another way. For 0.2 s a network of 1,027 weights sees its state and the target
every 10 ms and pushes it; then it flies for 0.7 s, and bounces and rubs on its way. Adam follows the gradient of the mean
squared miss through 20 looks of the network and all 1,800 steps, contacts included, which are taken back from the end.
"""

import jax
import jax.numpy as jnp
import numpy as np

import hydroelastic as he
import hydroelastic.jax as hj

jax.config.update("jax_enable_x64", True)

LOOKS, STEP, BATCH, ITERATIONS, RATE = 20, 5e-4, 8, 300, 0.01

skin = he.Material(modulus=1e5, dissipation=0.1, friction=0.5)
ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, mass=1.0, pose=he.pose([0.0, 0.0, 0.1]))
ground = he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid(friction=0.5))
push = he.Control("ball", 1e-2, np.zeros((1, 6)))
world = he.World([ball, ground], gravity=[0.0, 0.0, -9.81], controls=[push], slip_tolerance=1e-2)
by = [he.Parameter.control("ball", 0)]
pushed, flight = he.Plan(STEP, round(1e-2 / STEP)), he.Plan(STEP, 1400, record_every=20)


def episodes(random, count):
    """Rolling balls and targets: states of both bodies, (count, 3)."""
    velocity = random.uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 0.0], (count, 3))
    spin = np.cross([0.0, 0.0, 1.0], velocity) / 0.1
    twists = np.zeros((count, 2, 6))
    twists[:, 0] = np.concatenate([spin, velocity], 1)
    poses = np.broadcast_to(world.initial_state.poses, (count, 2, 4, 4))
    return hj.State(poses, twists), random.uniform([0.6, -0.3, 0.15], [1.2, 0.3, 0.3], (count, 3))


def network(random):
    sizes = [13, 32, 16, 3]
    return [(random.normal(size=(m, n)) / np.sqrt(m), np.zeros(n)) for m, n in zip(sizes, sizes[1:])]


def policy(weights, state, target, time):
    """The force (N) on the ball."""
    twist, position = state.twists[:, 0], state.poses[:, 0, :3, 3]
    times = jnp.broadcast_to(time, (len(target), 1))
    layer = jnp.concatenate([position, 0.1 * twist[:, :3], twist[:, 3:], target, times], 1)
    for weight, bias in weights[:-1]:
        layer = jnp.tanh(layer @ weight + bias)
    weight, bias = weights[-1]
    return jnp.array([0.0, 0.0, 20.0]) + 5.0 * (layer @ weight + bias)


def thrown(weights, start, target):
    """The states in which the balls are let go."""

    def look(state, time):
        force = policy(weights, state, target, time)
        wrench = jnp.concatenate([jnp.zeros_like(force), force], 1)
        return hj.final_state(world, pushed, by, wrench, start=state), None

    return jax.lax.scan(look, start, jnp.linspace(-1.0, 1.0, LOOKS))[0]


def loss(weights, start, target):
    """The mean squared miss (m²)."""
    last = hj.final_state(world, flight, start=thrown(weights, start, target))
    return jnp.mean(jnp.sum((last.poses[:, 0, :3, 3] - target) ** 2, 1))


@jax.jit
def improved(weights, moments, iteration, start, target):
    """A step of Adam."""
    value, slopes = jax.value_and_grad(loss)(weights, start, target)
    means, squares = moments
    means = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, means, slopes)
    squares = jax.tree.map(lambda s, g: 0.99 * s + 0.01 * g * g, squares, slopes)
    unbiased = jnp.sqrt(1.0 - 0.99**iteration) / (1.0 - 0.9**iteration)
    rate = RATE * (1.0 - (iteration - 1) / ITERATIONS) * unbiased
    weights = jax.tree.map(lambda w, m, s: w - rate * m / (jnp.sqrt(s) + 1e-8), weights, means, squares)
    return value, weights, (means, squares)


random = np.random.default_rng(1)
weights = jax.tree.map(jnp.asarray, network(random))
moments = (jax.tree.map(jnp.zeros_like, weights),) * 2
unseen = episodes(np.random.default_rng(2), 32)
judged = jax.jit(loss)
before = float(judged(weights, *unseen))
for iteration in range(1, ITERATIONS + 1):
    value, weights, moments = improved(weights, moments, float(iteration), *episodes(random, BATCH))
    if iteration % 50 == 0:
        print(f"iteration {iteration}: misses by {1e3 * float(value) ** 0.5:.0f} mm")
after = float(judged(weights, *unseen))
count = sum(it.size for it in jax.tree.leaves(weights))
heights = hj.rollout(world, flight, start=thrown(weights, *unseen)).poses[:, :, 0, 2, 3]
bounced = int(np.sum((heights[:, 0] > 0.1) & (heights.min(1) < 0.1)))
print(f"{count} weights; throws not seen before miss by {1e3 * before**0.5:.0f} mm before, {1e3 * after**0.5:.0f} mm after")
print(f"{bounced} of {len(heights)} are in the air when they are let go, and bounce")
assert after < before / 50 and bounced > 0.9 * len(heights)
