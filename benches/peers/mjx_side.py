"""A block pushed over a floor in MuJoCo MJX, and the gradient with respect to its pushes, in double precision."""

import contextlib
import sys
import time

import jax
import mujoco
import numpy
from jax import numpy as jnp

# On import, MJX prints which optional packages it searched for.
with contextlib.redirect_stdout(sys.stderr):
    from mujoco import mjx
    from mujoco.mjx._src import solver

jax.config.update("jax_enable_x64", True)

# Iterations of the solver, and of its line search in each iteration. With these numbers, the block ends within 1 mm of its final position
# with 100 and 50 iterations.
ITERATIONS, LINE_SEARCH = 4, 10

MODEL = """
<mujoco>
  <option timestep="{time_step}" gravity="0 0 -{gravity}" cone="{cone}"
    iterations="{iterations}" ls_iterations="{ls_iterations}"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1" friction="{friction} 0 0"/>
    <body pos="0 0 {half[2]}">
      <freejoint/>
      <geom type="box" size="{half[0]} {half[1]} {half[2]}" mass="{mass}" friction="{friction} 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


class Rollout:
    """A compiled rollout as a function of the pushes, and its gradient by reverse mode."""

    def __init__(self, scene, cone, iterations, line_search, loops=contextlib.nullcontext):
        self.name = f"MJX, {cone}, {iterations} iteration" + "s" * (iterations > 1)
        self.scene, self.loops = scene, loops
        model = mujoco.MjModel.from_xml_string(
            MODEL.format(
                half=[length / 2 for length in scene["size"]],
                cone=cone,
                iterations=iterations,
                ls_iterations=line_search,
                **{name: scene[name] for name in ("time_step", "gravity", "friction", "mass")},
            )
        )
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, nstep=scene["settling_steps"])
        self.in_mujoco = model, data
        self.model, self.start = mjx.put_model(model), mjx.put_data(model, data)
        self.compiled_value = jax.jit(self.loss)
        self.compiled_gradient = jax.jit(jax.value_and_grad(self.loss, has_aux=True))
        self.compilation = 0.0

    def loss(self, pushes):
        """Returns the squared final horizontal distance (m²) from the goal, and the final position (m)."""
        steps = self.scene["steps"] // self.scene["intervals"]

        def step(data, push):
            data = data.replace(qfrc_applied=jnp.zeros(6).at[:2].set(push))
            after = mjx.step(self.model, data)
            # In double precision, the step returns some indices in a wider type than it received.
            return jax.tree.map(lambda new, old: new.astype(old.dtype), after, data), None

        @jax.checkpoint
        def interval(data, push):
            return jax.lax.scan(lambda data, _: step(data, push), data, None, length=steps)

        with self.loops():
            data, _ = jax.lax.scan(interval, self.start, pushes)
        miss = data.qpos[:2] - jnp.array(self.scene["goal"])
        return miss @ miss, data.qpos[:3]

    def end_in_mujoco(self, pushes):
        """Returns the final position (m) in MuJoCo itself, from which MJX is ported. Must be called only once, because the call changes the
        simulation data."""
        model, data = self.in_mujoco
        for push in pushes:
            data.qfrc_applied[:2] = push
            mujoco.mj_step(model, data, nstep=self.scene["steps"] // self.scene["intervals"])
        return data.qpos[:3]

    def value(self, pushes):
        seconds, (loss, end) = self.timed("value", self.compiled_value, pushes)
        return {"seconds": seconds, "loss": float(loss), "end": end.tolist()}

    def gradient(self, pushes):
        seconds, found = self.timed("gradient", self.compiled_gradient, pushes)
        (loss, end), slope = found
        return {"seconds": seconds, "loss": float(loss), "gradient": numpy.asarray(slope)}

    def timed(self, what, function, pushes):
        """Returns the processor time (s) and the result of a call. The first call compiles; its time is recorded as compilation, and the
        call is repeated."""
        pushes = jnp.asarray(pushes)
        if not hasattr(self, what + "_is_warm"):
            start = time.process_time()
            jax.block_until_ready(function(pushes))
            if what == "gradient":
                self.compilation = time.process_time() - start
            setattr(self, what + "_is_warm", True)
        start = time.process_time()
        result = jax.block_until_ready(function(pushes))
        return time.process_time() - start, result


def ways(scene):
    """Returns rollouts with one solver iteration, for which MJX has no loop, and with several, whose loop is replaced by a scan."""
    return [
        Rollout(scene, "pyramidal", 1, LINE_SEARCH),
        Rollout(scene, "pyramidal", ITERATIONS, LINE_SEARCH, scanned_loops),
        Rollout(scene, "elliptic", ITERATIONS, LINE_SEARCH, scanned_loops),
    ]


@contextlib.contextmanager
def scanned_loops():
    """Context in which JAX traces `while_loop` as a scan of ITERATIONS iterations, which has reverse mode."""
    loop = jax.lax.while_loop
    jax.lax.while_loop = lambda condition, body, start: solver._while_loop_scan(
        condition, body, start, ITERATIONS
    )
    try:
        yield
    finally:
        jax.lax.while_loop = loop


def print_default(scene, pushes):
    """Prints the block's final position in MuJoCo with 100 iterations, and JAX's error for reverse mode through MJX with as many."""
    for cone in ("pyramidal", "elliptic"):
        rollout = Rollout(scene, cone, iterations=100, line_search=50)
        x, y, _ = rollout.end_in_mujoco(pushes)
        print(f"In MuJoCo itself, {cone} cone, 100 iterations, the block ends at {x:.4f}, {y:.4f} m.")
    try:
        jax.eval_shape(jax.grad(rollout.loss, has_aux=True), jnp.asarray(pushes))
    except ValueError as error:
        print(f"MJX, 100 iterations: {str(error).splitlines()[0]}")
    else:
        print("MJX has reverse mode by 100 iterations too.")
