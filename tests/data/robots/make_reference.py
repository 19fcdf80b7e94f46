"""Writes poses and inertias of the links of URDF files, at position zero of all joints, by Pinocchio.

All joints become continuous first. Otherwise Pinocchio would add the inertias of welded links.

python make_reference.py OUTPUT.json FOLDER
"""

import json
import pathlib
import sys
import xml.etree.ElementTree as tree

import pinocchio


def links_of(path):
    robot = tree.parse(path).getroot()
    for joint in robot.findall("joint"):
        joint.set("type", "continuous")
        for axis in joint.findall("axis"):
            axis.set("xyz", "1 0 0")
    model = pinocchio.buildModelFromXML(tree.tostring(robot, encoding="unicode"))
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    links = {}
    for frame, pose in zip(model.frames, data.oMf):
        if frame.type == pinocchio.FrameType.BODY:
            is_root = frame.parentJoint == 0
            inertia = frame.inertia if is_root else model.inertias[frame.parentJoint]
            links[frame.name] = {
                "rotation": pose.rotation.tolist(),
                "translation": pose.translation.tolist(),
                "mass": inertia.mass,
                "center_of_mass": inertia.lever.tolist(),
                "inertia": inertia.inertia.tolist(),
            }
    return links


def main(output, folder):
    folder = pathlib.Path(folder)
    robots = {}
    for path in sorted(folder.rglob("*.urdf")):
        try:
            robots[path.relative_to(folder).as_posix()] = links_of(path)
        except Exception as error:
            print(f"{path}: {error}", file=sys.stderr)
    pathlib.Path(output).write_text(json.dumps(robots) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
