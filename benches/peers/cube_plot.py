#!/usr/bin/env python3
"""Draws the errors of predictions that `cube.py` wrote with `--output`. Needs matplotlib. Run

    python3 benches/peers/cube_plot.py docs/figures/cube_tosses.svg hydroelastic.json mujoco.json drake-hydroelastic.json
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot

PANELS = {"position errors (%)": "mean position error (% of the edge)", "rotation errors (°)": "mean rotation error (°)"}


def main():
    target, *sources = map(pathlib.Path, sys.argv[1:])
    pyplot.rcParams.update({"svg.hashsalt": "cube", "svg.fonttype": "none", "font.size": 9})
    figure, axes = pyplot.subplots(1, 2, figsize=(9.0, 3.4), sharey=True)
    for source in sources:
        found = json.loads(source.read_text())
        for panel, name in zip(axes, PANELS):
            errors = sorted(found[name])
            panel.step(errors, [(index + 1) / len(errors) for index in range(len(errors))], where="post", label=source.stem)
    for panel, label in zip(axes, PANELS.values()):
        panel.set(xlabel=label, ylim=(0, 1), xlim=(0, None))
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("share of the held-out tosses")
    axes[1].legend(frameon=False)
    figure.tight_layout()
    figure.savefig(target, metadata={"Date": None})
    # matplotlib leaves spaces at the ends of lines.
    target.write_text("\n".join(line.rstrip() for line in target.read_text().splitlines()) + "\n")


if __name__ == "__main__":
    main()
