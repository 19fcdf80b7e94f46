#!/usr/bin/env python3
"""Draws the diagrams of chapters 4 and 6 of the guide.

    python3 docs/guide/figures/draw_steps.py           # writes the SVG files beside this script
    python3 docs/guide/figures/draw_steps.py --png     # writes PNG files too, for a look at them

Needs matplotlib. The output is deterministic for one version of matplotlib.
"""

import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

HERE = pathlib.Path(__file__).resolve().parent
INK, GRAY, BLUE, RED, GREEN = "#222222", "#8a8a8a", "#1f6fb4", "#c0392b", "#2e7d4f"
LIGHT = {INK: "#f3f3f3", GRAY: "#f7f7f7", BLUE: "#e4eff8", RED: "#fae7e4", GREEN: "#e5f3ea"}


NAMES = ["x_0", "x_1", "x_2", "x_3", r"\cdots", "x_n"]


def main():
    plt.rcParams.update({"svg.hashsalt": "hydroelastic", "svg.fonttype": "path", "font.family": "DejaVu Sans", "font.size": 10})
    for name, draw in {"step_and_gradient": draw_gradient, "implicit_step": draw_implicit_step}.items():
        figure = draw()
        figure.savefig(HERE / f"{name}.svg", metadata={"Date": None}, facecolor="white")
        if "--png" in sys.argv[1:]:
            figure.savefig(HERE / f"{name}.png", dpi=110, facecolor="white")
        plt.close(figure)


def canvas(width, height):
    """Returns a figure whose axes have the units of 1/10 inch, with the origin at the lower left corner."""
    figure = plt.figure(figsize=(width / 10, height / 10))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    axes.axis("off")
    return figure, axes


def box(axes, center, size, text, color=INK, fontsize=10):
    (x, y), (width, height) = center, size
    corner = (x - width / 2, y - height / 2)
    style = "round,pad=0,rounding_size=0.8"
    axes.add_patch(FancyBboxPatch(corner, width, height, boxstyle=style, facecolor=LIGHT[color], edgecolor=color, linewidth=1.3))
    axes.text(x, y, text, ha="center", va="center", color=INK, fontsize=fontsize, linespacing=1.35)


def arrow(axes, start, end, color=INK, bend=0.0, dashed=False, width=1.4):
    style = "dashed" if dashed else "solid"
    axes.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle="-|>",
            mutation_scale=12,
            shrinkA=0,
            shrinkB=0,
            color=color,
            linewidth=width,
            linestyle=style,
            connectionstyle=f"arc3,rad={bend}",
        )
    )


def label(axes, place, text, color=INK, fontsize=9, ha="center", va="center", weight="normal"):
    axes.text(*place, text, ha=ha, va=va, color=color, fontsize=fontsize, fontweight=weight, linespacing=1.35)


def states(axes, places, y, kept=()):
    """Draws the states of a rollout; checkpoints are filled."""
    for index, x in enumerate(places):
        face = RED if index in kept else "white"
        axes.add_patch(Circle((x, y), 1.55, facecolor=face, edgecolor=RED if index in kept else INK, linewidth=1.3))
        label(axes, (x, y - 0.1), f"${NAMES[index]}$", "white" if index in kept else INK, 10)


def draw_gradient():
    figure, axes = canvas(96, 55)
    places = [27 + 8.5 * index for index in range(6)]
    first, last, radius = places[0], places[-1], 1.55

    # Forward mode.
    y = 40
    label(axes, (2, 52), "Forward mode: one rollout for up to 96 numbers", BLUE, 11, "left", weight="bold")
    box(axes, (10, y), (16, 6.5), "parameters p\n≤ 96 numbers", BLUE)
    box(axes, (86, y), (16, 6.5), "outcome\nand Jacobian", BLUE)
    states(axes, places, y)
    ends = [18, *places]
    for index, x in enumerate(places):
        arrow(axes, (ends[index] + (radius if index else 0), y), (x - radius, y))
        if index != 4:
            label(axes, (x, y + 4.6), rf"$\partial {NAMES[index]}/\partial p$", BLUE, 9)
    arrow(axes, (last + radius, y), (78, y))
    arrow(axes, (18, y + 7.4), (78, y + 7.4), BLUE)
    label(axes, (48, y + 9.2), "dual numbers carry the derivatives through every step", BLUE)
    label(axes, (48, y - 4.4), "steps", INK, 9)

    # Reverse mode.
    y = 17
    label(axes, (2, 29.5), "Reverse mode: one sweep for any number of parameters", RED, 11, "left", weight="bold")
    box(axes, (10, y), (16, 6.5), "parameters p\nthousands", RED)
    box(axes, (86, y), (16, 6.5), "loss\none number", RED)
    states(axes, places, y, kept=(0, 3))
    for index, x in enumerate(places):
        arrow(axes, (ends[index] + (radius if index else 0), y), (x - radius, y))
    arrow(axes, (last + radius, y), (78, y))
    for right, left in zip([78, *places[::-1]], [*places[::-1], 18]):
        start = (right, y - 3.2) if right == 78 else (right, y - 2.6)
        end = (left, y - 3.2) if left == 18 else (left, y - 2.6)
        arrow(axes, start, end, RED, bend=-0.28)
    label(axes, (48, y - 6.2), "adjoint sweep: derivatives of the loss, from the last step to the first", RED)
    for from_, to in [(0, 1), (1, 2), (3, 4), (4, 5)]:
        arrow(axes, (places[from_] + 0.6, y + 2.2), (places[to] - 0.6, y + 2.2), GRAY, bend=-0.42, dashed=True, width=1.1)
    label(axes, (48, y + 6.6), "steps between checkpoints are recomputed, with the same bits", GRAY)
    label(axes, (2, 5.2), "gradient with respect to every\nparameter, vertex and extent", RED, 9, "left")
    axes.add_patch(Circle((64, 5.2), 1.1, facecolor=RED, edgecolor=RED))
    label(axes, (66, 5.1), "checkpoint: a step kept in memory", INK, 9, "left")
    return figure


def draw_implicit_step():
    figure, axes = canvas(100, 73)

    # The time step and its substeps.
    label(axes, (2, 70), "One time step of an island", INK, 11, "left", weight="bold")
    edges = [4, 22, 33, 39, 42.5, 45, 50, 60, 78, 96]
    y, height = 61.5, 3.6
    for index, (left, right) in enumerate(zip(edges, edges[1:])):
        color = BLUE if index == 6 else GRAY
        axes.add_patch(plt.Rectangle((left, y), right - left, height, facecolor=LIGHT[color], edgecolor=color, linewidth=1.2))
    axes.add_patch(plt.Rectangle((50, y), 10, height, facecolor=LIGHT[BLUE], edgecolor=BLUE, linewidth=2.0))
    label(axes, (40, y + 5.4), "impact: short substeps", GRAY)
    label(axes, (13, y + 5.4), "flight: long substeps", GRAY)
    label(axes, (60, y + 5.4), "trial of a substep", BLUE)
    for x in (50, 60):
        axes.plot([x, 2 + (x - 50) * 9.6], [y, 53.5], color=BLUE, linewidth=1.0, linestyle="dotted")

    # The trial: three stages, and inside each the two loops.
    axes.add_patch(FancyBboxPatch((2, 22), 96, 31.5, boxstyle="round,pad=0,rounding_size=1", facecolor="white", edgecolor=BLUE, linewidth=1.3))
    label(axes, (4, 51), "Substep: three stages (Sdirk3) or one (ImplicitEuler), one after another", BLUE, 10, "left", weight="bold")
    size = (19.5, 9)
    box(axes, (14.5, 40), size, "Predict\nvelocities at the\nend of the stage", GRAY, 9)
    box(axes, (38.5, 40), size, "Search contacts\npolygons, wrenches,\nderivatives", GREEN, 9)
    box(axes, (62.5, 40), size, "Newton's method\non frozen polygons\n(no search)", GREEN, 9)
    box(axes, (86, 40), (17.5, 9), "Stage solved\ncorrection below\nsolver tolerance", GRAY, 9)
    arrow(axes, (24.25, 40), (28.75, 40))
    arrow(axes, (48.25, 40), (52.75, 40))
    arrow(axes, (72.25, 40), (77.25, 40))
    arrow(axes, (62.5, 44.5), (38.5, 44.5), GREEN, bend=0.22)
    label(axes, (50.5, 48.6), "search again", GREEN)
    axes.plot([86, 86, 14.5], [35.5, 30.2, 30.2], color=INK, linewidth=1.4)
    arrow(axes, (14.5, 30.2), (14.5, 35.5))
    label(axes, (50.5, 31.8), "next stage", INK)
    label(axes, (46, 25.8), "Sdirk3 only. Error of values: difference from an embedded formula.\nError of slopes: error of the derivative along the motion.", BLUE)
    arrow(axes, (50.5, 22), (50.5, 18.2))

    # The decision.
    box(axes, (50.5, 14.2), (31, 8), "Are both errors below their tolerances,\nand could no body pass through another?", INK, 9)
    box(axes, (13, 14.2), (19, 8), "Accept\nnext duration\nfrom the errors", BLUE, 9)
    box(axes, (87, 14.2), (19, 8), "Divide\ntry a shorter\nsubstep", RED, 9)
    arrow(axes, (35, 14.2), (22.5, 14.2), BLUE)
    arrow(axes, (66, 14.2), (77.5, 14.2), RED)
    label(axes, (28.7, 15.7), "yes", BLUE)
    label(axes, (71.7, 15.7), "no", RED)
    arrow(axes, (93, 35.5), (93, 18.2), RED, dashed=True)
    label(axes, (91.8, 26.0), "not solved:\na quarter of\nthe duration", RED, ha="right")
    label(axes, (50.5, 6.2), "Near the end of the budget of trials, substeps grow and are accepted whatever their errors. The report counts them as missed.", GRAY)
    return figure


if __name__ == "__main__":
    main()
