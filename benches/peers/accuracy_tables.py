"""Tables and plot of `accuracy.py`: results by scene, then by (program, method)."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot
import numpy

# Errors (m) that a user may allow.
ALLOWED = [1e-3, 1e-4, 1e-5]
NAMES = {"ours": "ours", "drake": "Drake"}
COLORS = {
    "ours": ["#000000", "#c44e00", "#7a3fa0"],
    "drake": ["#8c96a0", "#2ca25f", "#9ecae1", "#4292c6"],
}
MARKERS = {"ours": "o", "drake": "s"}
# The plot ends here: what is further off is no answer (m), what is less is round-off.
LARGEST, SMALLEST = 0.2, 1e-8


def print_all(results):
    print_references(results)
    print_rows(results)
    print_fastest(results)


def label(key, method):
    return f"{NAMES[key]}, {method.replace('_', ' ')}"


def print_references(results):
    """Of the first scene of a group, the last coordinate that is measured."""
    methods = [label(*method) for method in next(iter(results.values()))]
    print("Where a body ends by the reference of each method (m): height of the ball, way of the")
    print("brick from the middle, height of the top cube, height of the ball.\n")
    print_line("scene", methods)
    print_line("---", ["---"] * len(methods))
    for name, found in results.items():
        ends = [of_method["reference"][0] for of_method in found.values()]
        print_line(name, ["–" if end is None else f"{end[-1][-1]:.6f}" for end in ends])


def print_line(first, cells):
    print("| " + " | ".join([first, *cells]) + " |")


def print_rows(results):
    of_methods = [of_method for found in results.values() for of_method in found.values()]
    steps = sorted({step for of_method in of_methods for step in of_method["rows"]})
    print("\nError (m), and simulated seconds per second:\n")
    print_line("scene, method", [f"{1e3 * step:g} ms" for step in steps])
    print_line("---", ["---"] * len(steps))
    for name, found in results.items():
        for method, of_method in found.items():
            cells = [cell(of_method["rows"], step) for step in steps]
            print_line(f"{name}: {label(*method)}", cells)


def cell(rows, step):
    if step not in rows:
        return ""
    row = rows[step]
    return f"{row['error']:.0e}, {speed(row['speed'])}" if row else "failed"


def speed(number):
    return f"{number:,.0f}" if number >= 10 else f"{number:.2g}"


def print_fastest(results):
    """The largest speed whose error, and that of all shorter steps, is within a bound."""
    methods = list(next(iter(results.values())))
    print("\nSimulated seconds per second (step in ms) with no larger error:\n")
    print_line("scene, error", [label(*method) for method in methods])
    print_line("---", ["---"] * len(methods))
    for name, found in results.items():
        for bound in ALLOWED:
            cells = [fastest(found[method]["rows"], bound) for method in methods]
            print_line(f"{name}, {1e3 * bound:g} mm", cells)


def fastest(rows, bound):
    best = None
    for step in sorted(rows):
        if not rows[step] or not rows[step]["error"] <= bound:
            break
        if best is None or rows[step]["speed"] > rows[best]["speed"]:
            best = step
    return "–" if best is None else f"{speed(rows[best]['speed'])} ({1e3 * best:g})"


def plot(results, path):
    """A panel for each scene: error across, speed upwards, a point for each step."""
    pyplot.rcParams.update({"svg.hashsalt": "accuracy", "svg.fonttype": "none", "font.size": 9})
    across = 2 if len(results) > 1 else 1
    down = (len(results) + 1) // 2
    size = (5.2 * across, 4.1 * down)
    figure, panels = pyplot.subplots(down, across, figsize=size, squeeze=False)
    for panel, (name, found) in zip(panels.flat, results.items()):
        draw(panel, name, found)
    lines, labels = panels.flat[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="lower center", ncols=4, frameon=False)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(path, metadata={"Date": None})
    # matplotlib leaves spaces at the ends of lines.
    path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")


def draw(panel, name, found):
    colors = {key: iter(of_program) for key, of_program in COLORS.items()}
    for (key, method), of_method in found.items():
        rows = {step: row for step, row in sorted(of_method["rows"].items()) if row}
        errors = numpy.array([max(row["error"], SMALLEST) for row in rows.values()])
        errors[~(errors <= LARGEST)] = numpy.nan
        speeds = [row["speed"] for row in rows.values()]
        panel.loglog(
            errors, speeds, MARKERS[key] + "-", color=next(colors[key]), label=label(key, method),
            markersize=4, linewidth=1.8 if key == "ours" else 1.2,
        )
        mark_steps(panel, rows, errors)
    panel.set(title=name, xlabel="error (m)", ylabel="simulated seconds per second")
    panel.grid(True, which="major", color="#e1e1e1", linewidth=0.7)


def mark_steps(panel, rows, errors):
    """Writes the step beside the first and last points of a line."""
    shown = [place for place, error in enumerate(errors) if numpy.isfinite(error)]
    for place in {shown[0], shown[-1]} if shown else ():
        step = list(rows)[place]
        at = (errors[place], rows[step]["speed"])
        panel.annotate(f"{1e3 * step:g} ms", at, (4, 4), textcoords="offset points", fontsize=6)
