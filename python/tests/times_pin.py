"""Prints times of accelerations of a robot in contact and of their derivatives: python tests/times_pin.py."""

import time

from test_pin import pressed_arm

from hydroelastic.pin import Robot


def least(functions, count=2000):
    """Returns the minimum time of each function over ``count`` calls (µs). The functions alternate, so that other
    programs slow all of them."""
    times = [float("inf")] * len(functions)
    for _ in range(count):
        for index, function in enumerate(functions):
            start = time.perf_counter()
            function()
            times[index] = min(times[index], 1e6 * (time.perf_counter() - start))
    return times


for order in range(1, 5):
    robot, (q, v, tau) = pressed_arm(order=order)
    robot.linearized(q, v, tau)
    contact = robot._contacts[0]
    material = robot._by_contact[0]
    loose = Robot(robot.model, robot.contacts, check_stability=False)
    states = {"checked": (q, v), "unchecked": (q, v)}

    def go_on(name, of):
        # Each step continues from the last step, because the first step of a rollout costs more.
        states[name] = of.step(*states[name], tau, 1e-7)

    moved = (*contact.poses, *contact.twists)
    wrench, linearized, plain, whole, step, checked, unchecked = least(
        [
            lambda: contact.pair.wrench(*moved, moduli=material[0], law=material[1]),
            lambda: contact.pair.linearized(*moved, moduli=material[0], law=material[1]),
            lambda: robot.acceleration(q, v, tau),
            lambda: robot.linearized(q, v, tau),
            lambda: loose.linearized_step(q, v, tau, 1e-3),
            lambda: go_on("checked", robot),
            lambda: go_on("unchecked", loose),
        ]
    )
    print(
        f"order {order}: contact {wrench:.1f}, with Jacobian {linearized:.1f} ({linearized / wrench:.2f}); "
        f"acceleration {plain:.1f}, with derivatives {whole:.1f} ({whole / plain:.2f}); step with derivatives {step:.1f}; "
        f"step {unchecked:.1f}, with the stability check {checked:.1f} ({checked / unchecked:.2f})"
    )
