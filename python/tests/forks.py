"""Runs calls that use threads in a process and in forked children: python tests/forks.py WAY, with a name from WAYS.

Prints "same" if the children returned the bits of the parent. A child that waits for threads of its parent would hang.
"""

import hashlib
import multiprocessing
import os
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import hydroelastic as he

FORK = multiprocessing.get_context("fork")

SKIN = he.Material(1e5, 0.2, 0.4)
BALL = he.Shape.icosphere(0.1, 1)
BLOCK = he.Shape.cuboid([0.4, 0.4, 0.2])
PAIR = he.Pair(he.Shape.icosphere(0.1, 2), BLOCK, 1e5, 1e6)
# A contact with enough polygons to use several threads.
LARGE = he.Pair(he.Shape.icosphere(0.1, 5), BLOCK, 1e5, 1e6, he.SurfaceLaw(0.2, 0.4, 1e-2))
# A layer of balls that touch the floor and each other, with enough contacts to use several threads.
POSITIONS = [[0.19 * (index % 4), 0.19 * (index // 4), 0.095] for index in range(16)]
BALLS = [he.Body.dynamic(f"ball {index}", BALL, SKIN, 1.0, pose=he.pose(at)) for index, at in enumerate(POSITIONS)]
FLOOR = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid(0.5))
HEAP = he.World([*BALLS, FLOOR], gravity=[0.0, 0.0, -9.81])
ONE = he.World([BALLS[0], FLOOR], gravity=[0.0, 0.0, -9.81])
EXPLICIT, IMPLICIT = he.Plan(2e-4, 5), he.Plan(5e-3, 3, he.Integrator.SDIRK3)
BY = [he.Parameter.gravity(), he.Parameter.friction("ball 0")]


def digest(_=None):
    """Returns a digest of the results of calls that use threads."""
    heights = np.stack([he.pose([0.0, 0.0, z]) for z in np.linspace(0.185, 0.195, 100)])
    twist = np.array([0.1, 0.2, 0.3, 0.5, 0.0, -0.1])
    explicit, implicit = (HEAP.rollout(plan).run() for plan in (EXPLICIT, IMPLICIT))
    step = HEAP.step(HEAP.initial_state, IMPLICIT)
    results = [
        *PAIR.linearized(heights, he.pose(), twist, np.zeros(6)),
        LARGE.wrench(he.pose([0.0, 0.0, 0.17]), he.pose(), twist, np.zeros(6)),
        he.Shape.icosphere(0.1, 3).vertices,
        explicit.twists,
        implicit.twists,
        step.twists,
        HEAP.jacobian(IMPLICIT, BY)[1].poses,
        HEAP.vjp(IMPLICIT, BY)[1](np.ones_like(implicit.poses), np.ones_like(implicit.twists)),
        *(trajectory.poses for trajectory in he.Batch(IMPLICIT).rollouts([ONE] * 20)),
    ]
    sha = hashlib.sha256()
    for result in results:
        sha.update(np.ascontiguousarray(result).tobytes())
    return sha.hexdigest()


def put(queue):
    queue.put(digest())


def in_process(target=put):
    queue = FORK.Queue()
    child = FORK.Process(target=target, args=(queue,))
    child.start()
    result = queue.get()
    child.join()
    return result


def put_of_child(queue):
    queue.put(digest() + in_process())


def process():
    return [in_process(), in_process()]


def grandchild():
    both = in_process(put_of_child)
    return [both[: len(both) // 2], both[len(both) // 2 :]]


def pool():
    with FORK.Pool(2) as children:
        return children.map(digest, range(4))


def executor():
    with ProcessPoolExecutor(2, mp_context=FORK) as children:
        return list(children.map(digest, range(4)))


def while_a_thread_works():
    """Forks a child in the middle of a batch."""
    children = []

    def fork(done, total):
        if not children:
            children.append(in_process())

    he.Batch(IMPLICIT, progress=fork).rollouts([HEAP] * 10)
    return children


def data_loader():
    from torch.utils.data import DataLoader, Dataset

    class Digests(Dataset):
        def __len__(self):
            return 4

        def __getitem__(self, index):
            return digest()

    loader = DataLoader(Digests(), batch_size=None, num_workers=2, multiprocessing_context="fork")
    return list(loader)


WAYS = {way.__name__: way for way in (process, grandchild, pool, executor, while_a_thread_works, data_loader)}

if __name__ == "__main__":
    expected = digest()
    children = WAYS[sys.argv[1]]()
    assert children and all(child == expected for child in children), (expected, children)
    print("same", os.environ.get("RAYON_NUM_THREADS"), expected)
