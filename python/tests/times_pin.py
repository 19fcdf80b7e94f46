"""Prints what accelerations of a robot in contact and their derivatives take: python tests/times_pin.py."""

import time

from test_pin import pressed_arm


def least(functions, count=2000):
    """The least of so many times (µs) of each, in turn: what else runs here slows all of them."""
    found = [float("inf")] * len(functions)
    for _ in range(count):
        for place, function in enumerate(functions):
            start = time.perf_counter()
            function()
            found[place] = min(found[place], 1e6 * (time.perf_counter() - start))
    return found


for order in range(1, 5):
    robot, (q, v, tau) = pressed_arm(order=order)
    robot.linearised(q, v, tau)
    contact = robot._contacts[0]
    material = robot._by_contact[0]
    moved = (*contact.poses, *contact.twists)
    wrench, linearised, plain, whole, step = least(
        [
            lambda: contact.pair.wrench(*moved, moduli=material[0], law=material[1]),
            lambda: contact.pair.linearised(*moved, moduli=material[0], law=material[1]),
            lambda: robot.acceleration(q, v, tau),
            lambda: robot.linearised(q, v, tau),
            lambda: robot.linearised_step(q, v, tau, 1e-3),
        ]
    )
    print(
        f"order {order}: contact {wrench:.1f}, with Jacobian {linearised:.1f} ({linearised / wrench:.2f}); "
        f"acceleration {plain:.1f}, with derivatives {whole:.1f} ({whole / plain:.2f}); step with derivatives {step:.1f}"
    )
