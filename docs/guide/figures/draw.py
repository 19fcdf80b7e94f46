#!/usr/bin/env python3
"""Draws the figures of the guide from the formulas in its chapters. Needs numpy and matplotlib. Run

    python3 docs/guide/figures/draw.py           # writes the SVG files beside this script
    python3 docs/guide/figures/draw.py FOLDER    # writes them, and PNG previews, to another folder

The output is deterministic for one version of matplotlib.
"""

import pathlib
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot
import numpy

# Colors that color-blind readers can tell apart.
BLUE, ORANGE, GREEN, GRAY, BLACK = "#0072b2", "#d55e00", "#009e73", "#8a8a8a", "#222222"
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "mathtext.fontset": "dejavusans",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": BLACK,
    "axes.titlesize": 10,
    "lines.linewidth": 2,
    "svg.fonttype": "none",
    "svg.hashsalt": "guide",
}


def main():
    pyplot.rcParams.update(STYLE)
    here = pathlib.Path(__file__).resolve().parent
    folder = pathlib.Path(sys.argv[1]) if sys.argv[1:] else here
    folder.mkdir(parents=True, exist_ok=True)
    for draw in (equal_pressure, core_and_plateau, surface_law, leapfrog_step, restitution):
        figure = draw()
        path = folder / f"{draw.__name__}.svg"
        figure.savefig(path, metadata={"Date": None, "Creator": None})
        text = path.read_text().replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
        path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n")
        if folder != here:
            figure.savefig(path.with_suffix(".png"), dpi=100)
        pyplot.close(figure)


def arrow(axes, start, end, color=BLACK, style="-|>", width=1.5, shrink=0.0):
    """An arrow from start to end (data coordinates)."""
    shape = {"arrowstyle": style, "color": color, "lw": width, "shrinkA": shrink, "shrinkB": shrink}
    axes.annotate("", xy=end, xytext=start, arrowprops={**shape, "mutation_scale": 12})


def equal_pressure():
    """Two fields p = κ·depth along a line, and the point at which they are equal."""
    kappa_a, kappa_b, overlap = 1.0, 2.0, 1.0
    depth_a = overlap * kappa_b / (kappa_a + kappa_b)
    pressure = kappa_a * depth_a
    figure, axes = pyplot.subplots(figsize=(6.4, 3.6), layout="constrained")
    x = numpy.linspace(-0.6, 1.6, 2)
    axes.axvspan(-0.6, overlap, ymax=0.09, color=ORANGE, alpha=0.25, lw=0)
    axes.axvspan(0.0, 1.6, ymax=0.09, color=BLUE, alpha=0.25, lw=0)
    axes.plot([overlap, -0.05], [0.0, kappa_b * (overlap + 0.05)], color=ORANGE)
    axes.plot([0.0, x[1]], [0.0, kappa_a * x[1]], color=BLUE)
    axes.plot([depth_a] * 2, [-0.2, pressure], color=GRAY, lw=1, ls=":")
    axes.plot(depth_a, pressure, "o", color=BLACK, ms=7, zorder=3)
    axes.text(-0.02, 1.72, r"$p_B = \kappa_B \cdot$ depth in B", color=ORANGE, ha="right", va="center")
    axes.text(1.6, 1.72, r"$p_A = \kappa_A \cdot$ depth in A", color=BLUE, ha="right", va="center")
    axes.text(0.86, 1.3, "equal pressure:\nthe contact surface", ha="center", va="bottom")
    arrow(axes, (0.80, 1.28), (depth_a + 0.02, pressure + 0.05), GRAY, style="-", width=1)
    axes.text(-0.3, -0.1, "body B", color=BLACK, ha="center", va="center")
    axes.text(1.3, -0.1, "body A", color=BLACK, ha="center", va="center")
    arrow(axes, (depth_a, pressure), (depth_a + 0.34, pressure), BLUE, width=2.5)
    arrow(axes, (depth_a, pressure), (depth_a - 0.34, pressure), ORANGE, width=2.5)
    axes.text(depth_a + 0.37, pressure - 0.02, "force on A", color=BLUE, ha="left", va="center")
    axes.text(depth_a - 0.37, pressure - 0.02, "force on B", color=ORANGE, ha="right", va="center")
    for start, end, label in [(0.0, depth_a, r"$\delta_A$"), (depth_a, overlap, r"$\delta_B$")]:
        arrow(axes, (start, 0.13), (end, 0.13), style="<|-|>", width=1)
        axes.text((start + end) / 2, 0.15, label, ha="center", va="bottom")
    axes.set(xlim=(-0.6, 1.75), ylim=(-0.2, 2.1), xticks=[0.0, overlap], yticks=[0.0, pressure])
    axes.set_xticklabels(["surface of A", "surface of B"])
    axes.set_yticklabels(["0", r"$\kappa\delta$"])
    axes.set_xlabel("position along the line")
    axes.set_ylabel("pressure")
    return figure


def core_and_plateau():
    """Pressure on a line through a thick body and a thin one, for two kinds of field."""
    thick, thin, skin = 1.0, 0.3, 0.2
    figure, both = pyplot.subplots(1, 2, figsize=(7.2, 3.3), sharey=True, layout="constrained")

    def distance(thickness):
        x = numpy.array([0.0, min(skin, thickness / 2), thickness / 2, thickness - skin, thickness])
        x = numpy.unique(x[(x >= 0.0) & (x <= thickness)])
        return x, numpy.minimum(x, thickness - x)

    for axes in both:
        axes.set(xlim=(0.0, 1.08), ylim=(0.0, 1.28), xticks=[0.0, thick], yticks=[0.0, 1.0])
        axes.set_xticklabels(["surface", "other side"])
        axes.set_yticklabels(["0", "E"])
        axes.axhline(1.0, color=GRAY, lw=1, ls=":")
        axes.set_xlabel("position on a line through the body")
    for thickness, color in [(thick, BLUE), (thin, ORANGE)]:
        x, depth = distance(thickness)
        both[0].plot(x, depth / (thickness / 2), color=color)
        both[1].plot(x, numpy.minimum(depth / skin, 1.0), color=color)
    left, right = both
    left.set_title("from_distance: κ = E / depth of the core")
    left.set_ylabel("pressure")
    left.text(0.5, 1.03, "core", color=BLUE, ha="center", va="bottom")
    left.text(0.15, 1.03, "core", color=ORANGE, ha="center", va="bottom")
    left.text(0.80, 0.55, "thick body:\nsofter", color=BLUE, ha="left", va="center")
    left.text(0.29, 0.18, "thin body:\nstiffer", color=ORANGE, ha="left", va="center")
    right.set_title("from_distance_up_to: κ = E / skin depth")
    right.text(0.5, 1.03, "plateau", color=BLUE, ha="center", va="bottom")
    right.text(0.32, 0.35, "thin body:\nsame κ, no plateau", color=ORANGE, ha="left", va="center")
    arrow(right, (0.0, 1.13), (skin, 1.13), style="<|-|>", width=1)
    right.text(skin / 2, 1.15, "skin", ha="center", va="bottom")
    return figure


def surface_law():
    """Friction −μp'·v/√(v² + v_s²), and the factor max(0, 1 − d·v_n) of dissipation."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(7.2, 3.3), layout="constrained")
    slip = numpy.linspace(-5.0, 5.0, 81)
    left.plot([-5.0, 0.0, 0.0, 5.0], [1.0, 1.0, -1.0, -1.0], color=GRAY, lw=1.2, ls="--")
    left.plot(slip, -slip / numpy.sqrt(slip**2 + 1.0), color=BLUE)
    at_tolerance = 1.0 / numpy.sqrt(2.0)
    left.plot([1.0, 1.0, 0.0], [0.0, -at_tolerance, -at_tolerance], color=BLACK, lw=1, ls=":")
    left.plot(1.0, -at_tolerance, "o", color=BLACK, ms=5, zorder=3)
    left.text(1.3, -at_tolerance, "71 % at $v_s$", ha="left", va="center")
    left.text(-4.9, 1.07, "Coulomb's law (dashed)", color=GRAY, ha="left", va="bottom")
    left.text(0.35, 0.35, "viscous below $v_s$", color=BLUE, ha="left", va="center")
    left.set(xlim=(-5.0, 5.0), ylim=(-1.3, 1.3), xticks=[0.0, 1.0], yticks=[-1.0, 0.0, 1.0])
    left.set_xticklabels(["0", "$v_s$"])
    left.set_yticklabels(["−μp′", "0", "μp′"])
    left.set_xlabel("slip speed of A")
    left.set_title("friction on A")
    speed = numpy.array([-1.0, 0.0, 1.0, 1.8])
    right.plot(speed, numpy.maximum(0.0, 1.0 - speed), color=ORANGE)
    right.plot([-1.0, 0.0], [1.0, 1.0], color=BLACK, lw=1, ls=":")
    right.plot([0.0, 0.0], [0.0, 1.0], color=BLACK, lw=1, ls=":")
    right.set(xlim=(-1.0, 1.8), ylim=(0.0, 2.1), xticks=[0.0, 1.0], yticks=[0.0, 1.0])
    right.set_xticklabels(["0", "1/d"])
    right.set_yticklabels(["0", "p"])
    right.text(-0.45, 1.75, "approaching:\nmore pressure", color=ORANGE, ha="left", va="center")
    right.text(0.72, 0.62, "separating:\nless pressure,\nnever negative", color=ORANGE, ha="left", va="center")
    right.set_xlabel("normal speed $v_n$ (positive: separating)")
    right.set_title("dissipation: pressure p′ = p·max(0, 1 − d·$v_n$)")
    return figure


def leapfrog_step():
    """Anatomy of one step of length h: drift, kick, drift. Momenta change only in the kick."""
    figure, axes = pyplot.subplots(figsize=(6.4, 3.0), layout="constrained")
    axes.set_axis_off()
    axes.set(xlim=(-0.36, 1.1), ylim=(-0.58, 1.2))
    for x, label in [(0.0, "t"), (0.5, "t + h/2"), (1.0, "t + h")]:
        axes.plot([x, x], [-0.3, 1.0], color=GRAY, lw=1, ls=":")
        axes.text(x, 1.05, label, ha="center", va="bottom")
    poses, momenta = 0.72, 0.0
    axes.text(-0.33, poses, "poses", ha="left", va="center", fontweight="bold")
    axes.text(-0.33, momenta, "momenta", ha="left", va="center", fontweight="bold")
    for start, name in [(0.0, "drift h/2"), (0.5, "drift h/2")]:
        arrow(axes, (start, poses), (start + 0.5, poses), BLUE, width=2.5, shrink=5)
        axes.text(start + 0.25, poses + 0.06, name, color=BLUE, ha="center", va="bottom")
    for x in (0.0, 0.5, 1.0):
        axes.plot(x, poses, "o", color=BLUE, ms=8)
    axes.plot([0.0, 0.5], [momenta] * 2, color=ORANGE, lw=2.5)
    axes.plot([0.5, 1.0], [momenta - 0.22] * 2, color=ORANGE, lw=2.5)
    arrow(axes, (0.5, momenta), (0.5, momenta - 0.22), ORANGE, width=2.5)
    axes.plot(0.0, momenta, "o", color=ORANGE, ms=8)
    axes.plot(1.0, momenta - 0.22, "o", color=ORANGE, ms=8)
    axes.text(0.25, momenta + 0.05, "constant", color=ORANGE, ha="center", va="bottom")
    axes.text(0.75, momenta - 0.17, "constant", color=ORANGE, ha="center", va="bottom")
    axes.text(0.47, momenta - 0.13, "kick h", color=ORANGE, ha="right", va="center")
    arrow(axes, (0.5, poses), (0.5, momenta), BLACK, width=1.2, shrink=7)
    axes.text(0.52, (poses + momenta) / 2, "contact, forces and gravity,\nevaluated once", ha="left", va="center")
    axes.text(0.5, -0.46, "Dissipation, friction and drag use the velocities before the kick.", ha="center", va="center")
    return figure


def rebound_share(product):
    """Coefficient of restitution e for the product d·v: d·v − ln(1 + d·v) = −e·d·v − ln(1 − e·d·v)."""
    target = product - numpy.log1p(product)
    low, high = numpy.zeros_like(product), numpy.minimum(1.0, 1.0 / product)
    for _ in range(60):
        middle = (low + high) / 2
        scaled = middle * product
        with numpy.errstate(divide="ignore"):
            is_below = -scaled - numpy.log1p(-scaled) < target
        low, high = numpy.where(is_below, middle, low), numpy.where(is_below, high, middle)
    return (low + high) / 2


def restitution():
    """Coefficient of restitution of a Hunt–Crossley contact against d·v, and its leading terms."""
    figure, axes = pyplot.subplots(figsize=(5.2, 3.3), layout="constrained")
    product = numpy.linspace(1e-3, 4.0, 161)
    axes.plot([0.0, 1.5], [1.0, 0.0], color=GRAY, lw=1.2, ls="--")
    axes.plot(product, rebound_share(product), color=BLUE)
    tested = numpy.array([0.1, 0.5, 1.0])
    axes.plot(tested, rebound_share(tested), "o", color=BLACK, ms=5, zorder=3)
    axes.text(1.02, 0.22, "1 − (2/3)·d·v", color=GRAY, ha="right", va="center")
    axes.text(2.1, 0.46, "Hunt–Crossley law", color=BLUE, ha="left", va="center")
    axes.set(xlim=(0.0, 4.0), ylim=(0.0, 1.05), xticks=range(5), yticks=numpy.linspace(0.0, 1.0, 6))
    axes.set_xlabel("d·v  (dissipation × approach speed)")
    axes.set_ylabel("coefficient of restitution e")
    return figure


if __name__ == "__main__":
    main()
