"""MuJoCo's side of `accuracy.py`: answers questions on stdin, one JSON line each, until stdin closes.

The time is processor time of `mj_step`. Bodies are spheres, boxes and a plane, which have contact points. A body on a path is heavy and
has slide joints. Before each step, outside the measured time, the script puts the body on the path with the mean velocity of the step.
"""

import json
import sys
import time

import mujoco
import numpy
from rollout_scenes import displacement

HEAVY = 1e6  # kg


class Rollout:
    """A scene in its initial state, with a method that advances it."""

    def __init__(self, scene, time_step):
        self.bodies = scene["bodies"]
        spec = mujoco.MjSpec()
        spec.option.timestep, spec.option.gravity = time_step, [0, 0, -scene["gravity"]]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        for body in self.bodies:
            add(spec.worldbody, body, scene)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        for body in self.bodies:
            if body.get("mass"):
                joint = self.data.joint(body["name"])
                joint.qvel[:3] = body["velocity"]

    def answer(self, steps):
        """Returns the processor time (s) of the steps and the final positions of the bodies."""
        seconds, is_prescribed = 0.0, any(body.get("moves") for body in self.bodies)
        at_once = 1 if is_prescribed else steps
        for done in range(0, steps, at_once):
            if is_prescribed:
                self.prescribe(done * self.model.opt.timestep)
            start = time.process_time()
            mujoco.mj_step(self.model, self.data, nstep=at_once)
            seconds += time.process_time() - start
        # After `mj_step`, the poses are those before its last step.
        mujoco.mj_kinematics(self.model, self.data)
        positions = numpy.concatenate([self.data.body(body["name"]).xpos for body in self.bodies])
        # MuJoCo resets a simulation that diverges.
        warnings = [mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC]
        if any(self.data.warning[warning].number for warning in warnings):
            return {"seconds": seconds, "positions": None, "failure": "diverged"}
        return {"seconds": seconds, "positions": positions.tolist(), "failure": None}

    def prescribe(self, now):
        step = self.model.opt.timestep
        for body in self.bodies:
            if body.get("moves"):
                here, there = (displacement(body["moves"], at) for at in (now, now + step))
                for axis in range(3):
                    joint = self.data.joint(f"{body['name']}, {axis}")
                    joint.qpos, joint.qvel = here[axis], (there - here)[axis] / step


def add(world, body, scene):
    """Adds the body with its joints, if any, and its geometry."""
    quaternion = numpy.zeros(4)
    mujoco.mju_mat2Quat(quaternion, numpy.array(body["pose"][:9]))
    link = world.add_body(name=body["name"], pos=body["pose"][9:], quat=quaternion)
    mass, moments = body.get("mass"), body.get("moments")
    if mass:
        link.add_freejoint(name=body["name"])
    elif body.get("moves"):
        mass, moments, link.gravcomp = HEAVY, [HEAVY] * 3, 1.0
        for axis in range(3):
            name, slide = f"{body['name']}, {axis}", mujoco.mjtJoint.mjJNT_SLIDE
            link.add_joint(name=name, type=slide, axis=numpy.eye(3)[axis])
    if mass:
        link.mass, link.inertia, link.explicitinertial = mass, moments, True
        link.ipos, link.iquat = [0.0] * 3, [1.0, 0.0, 0.0, 0.0]
    shapes = {0: mujoco.mjtGeom.mjGEOM_PLANE, 1: mujoco.mjtGeom.mjGEOM_SPHERE}
    size = body.get("size", [])
    half = [5.0, 5.0, 0.1] if not size else size if len(size) == 1 else [x / 2 for x in size]
    link.add_geom(
        type=shapes.get(len(size), mujoco.mjtGeom.mjGEOM_BOX),
        size=numpy.resize([*half, 0.0, 0.0], 3),
        friction=[friction(body, scene), 0.0, 0.0],
        # MuJoCo uses the friction of the geometry with the higher priority.
        priority=1 if body.get("mass") else 0,
        solref=scene["solref"],
    )


def friction(body, scene):
    """Returns the friction between the body and the last, fixed body: the harmonic mean, as in Drake and in this library."""
    both = body["friction"], scene["bodies"][-1]["friction"]
    return 2 * both[0] * both[1] / sum(both) if sum(both) else 0.0


if __name__ == "__main__":
    for line in sys.stdin:
        question = json.loads(line)
        rollout = Rollout(question["scene"], question["time_step"])
        print(json.dumps(rollout.answer(question["steps"])), flush=True)
