"""How hard must two soft fingers squeeze to lift a cube? MuJoCo moves them, and this library computes their contact.

    pip install "hydroelastic[mujoco]"; python gripper_lifts.py

Friction carries the cube if 2 μ F exceeds its weight. If a hand squeezes with less force, it rises without the cube.
MuJoCo computes the contact between the table and the cube.
"""

import mujoco
import numpy as np

import hydroelastic as he
from hydroelastic import mujoco as soft

XML = """
<mujoco>
  <option timestep="1e-4"/>
  <worldbody>
    <geom name="table" type="box" size=".3 .3 .05" pos="0 0 -.05"/>
    <body name="cube" pos="0 0 .03"><freejoint/><geom name="cube" type="box" size=".03 .03 .03" mass=".5"/></body>
    <body name="hand" pos="0 0 .035">
      <joint name="lift" type="slide" axis="0 0 1"/><geom type="box" size=".02 .06 .01" pos="0 0 .1" mass=".5"/>
      <body name="left" pos="0 -.05 0">
        <joint name="left" type="slide" axis="0 1 0" damping="20"/><geom type="box" size=".02 .01 .02" mass=".2"/>
      </body>
      <body name="right" pos="0 .05 0">
        <joint name="right" type="slide" axis="0 -1 0" damping="20"/><geom type="box" size=".02 .01 .02" mass=".2"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="lift" kp="5000" kv="300"/>
    <motor name="left" joint="left"/><motor name="right" joint="right"/>
  </actuator>
</mujoco>
"""
FRICTION, WEIGHT = 0.6, 0.5 * 9.81
CLOSE, LIFT, HOLD = 0.15, 0.4, 0.25  # duration of each phase (s)
HEIGHT = 0.1  # height of the lift (m)


def scene():
    """The model and its soft contacts between two finger pads and the cube."""
    pad, cube = he.Shape.cuboid([0.04, 0.02, 0.04]), he.Shape.cuboid([0.06, 0.06, 0.06])
    pair = he.Pair(pad, cube, 2e5, 1e7, he.SurfaceLaw(dissipation=0.5, friction=FRICTION, slip_tolerance=3e-3))
    contacts = [soft.ContactPair(pair, soft.body(finger), soft.geom("cube")) for finger in ("left", "right")]
    spec = mujoco.MjSpec.from_string(XML)
    soft.exclude(spec, contacts)
    model = spec.compile()
    return model, soft.PassiveContacts(model, contacts)


def lift(squeeze):
    """Squeezes with a force (N), lifts and holds. Returns the rise of the cube (m), and its slip in the fingers (m)."""
    model, contacts = scene()
    data = mujoco.MjData(model)
    weight_of_hand = 0.9 * 9.81
    grip_height = None
    with contacts:
        while data.time < CLOSE + LIFT + HOLD:
            # A smooth ramp is 0 at the end of closing and 1 at the end of the lift.
            part = np.clip((data.time - CLOSE) / LIFT, 0.0, 1.0)
            rise = HEIGHT * part**2 * (3.0 - 2.0 * part)
            data.ctrl[:] = [rise + weight_of_hand / 5000.0, squeeze, squeeze]
            mujoco.mj_step(model, data)
            if grip_height is None and data.time >= CLOSE:
                grip_height = data.body("cube").xpos[2] - data.body("hand").xpos[2]
        forces = contacts.wrenches(data)[:, 3:6]
    height = data.body("cube").xpos[2]
    rise = height - 0.03
    print(f"squeezed with {squeeze:.1f} N: cube rose by {rise:.4f} m, normal forces {np.abs(forces[:, 1]).round(2)} N")
    return rise, grip_height - (height - data.body("hand").xpos[2])


if __name__ == "__main__":
    least = WEIGHT / (2.0 * FRICTION)
    print(f"the weight needs {least:.2f} N on each finger")
    rise, slip = lift(2.0 * least)
    print(f"  slipped by {1e3 * slip:.2f} mm")
    assert rise > 0.95 * HEIGHT and slip < 2e-3
    rise, _ = lift(0.7 * least)
    assert rise < 0.05 * HEIGHT
