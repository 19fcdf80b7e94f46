"""Tables and plot of `accuracy.py`, from results by scene and method."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot
import numpy

ALLOWED_SLOPES = [0.1, 0.01, 0.001]  # relative errors
NAMES = {"ours": "ours", "drake": "Drake", "mujoco": "MuJoCo"}
COLORS = {
    "ours": ["#c44e00", "#7a3fa0", "#000000"],
    "drake": ["#2ca25f", "#4292c6"],
    "mujoco": ["#8c96a0"],
}
MARKERS = {"ours": "o", "drake": "s", "mujoco": "^"}
# Limits of the axes, of values (m) and of slopes. Errors outside are drawn at the limit.
LIMITS = [(1e-8, 1.0), (1e-6, 100.0)]


def print_all(results, scenes):
    print_references(results)
    print_rows(results)
    print_fastest(results, scenes)


def label(method):
    return f"{NAMES[method.program]}, {method.name.replace('_', ' ')}"


def print_references(results):
    """Prints the last measured coordinate and its slope with respect to each parameter."""
    print("Converged motions: last measured coordinate (m), in parentheses the change from a coarser")
    print("setting (m); its slopes, in parentheses the relative change between two widths.\n")
    print_line("scene", ["program", "coordinate", "slopes"])
    print_line("---", ["---"] * 3)
    for name, found in results.items():
        for method, of_method in found.items():
            # All methods of this library share a reference.
            if method.program != "ours" or method.name == "sdirk3":
                program = "ours" if method.program == "ours" else label(method)
                print_line(name, [program, *reference_cells(of_method["reference"])])


def reference_cells(reference):
    if reference is None:
        return ["–", "–"]
    slopes = ", ".join(f"{slope:.4g}" for slope in reference["slopes"][-1])
    value = f"{reference['values'][-1]:.6f} ({reference['drift']:.0e})"
    return [value, f"{slopes} ({reference['spread']:.0e})"]


def print_line(first, cells):
    print("| " + " | ".join([first, *cells]) + " |")


def print_rows(results):
    print("\nAll settings:\n")
    headings = ["accuracy or step (ms)", "error (m)", "ms", "error of slopes", "ms"]
    print_line("scene, method", headings)
    print_line("---", ["---"] * len(headings))
    for name, found in results.items():
        for method, of_method in found.items():
            for setting, row in of_method["rows"].items():
                cells = [setting_name(method, setting)]
                for error, seconds in zip(row["errors"], row["seconds"]):
                    cells += ["–" if error is None else f"{error:.1e}", milliseconds(seconds)]
                print_line(f"{name}: {label(method)}", cells)


def setting_name(method, setting):
    return f"{setting if method.has_error_control else 1e3 * setting:g}"


def milliseconds(seconds):
    return f"{1e3 * seconds:,.0f}" if seconds >= 0.01 else f"{1e3 * seconds:.2g}"


def print_fastest(results, scenes):
    """Prints the shortest time at which the error of a setting and of all finer settings is within a bound."""
    methods = list(next(iter(results.values())))
    print("\nProcessor time (ms) with no larger error, and the accuracy or step (ms):\n")
    print_line("scene, error", [label(method) for method in methods])
    print_line("---", ["---"] * len(methods))
    for name, found in results.items():
        bounds = [(0, bound, f"{1e3 * bound:g} mm") for bound in scenes[name]["allowed"]]
        bounds += [(1, bound, f"slopes {100 * bound:g} %") for bound in ALLOWED_SLOPES]
        for which, bound, text in bounds:
            cells = [fastest(method, found[method], which, bound) for method in methods]
            print_line(f"{name}, {text}", cells)


def fastest(method, of_method, which, bound):
    """Formats the shortest time and its setting. Returns a dash if the reference is less accurate than the bound."""
    reference, rows, best = of_method["reference"], of_method["rows"], None
    if reference is None or reference["drift" if which == 0 else "spread"] > bound:
        return "–"
    for setting in sorted(rows):
        error, seconds = rows[setting]["errors"][which], rows[setting]["seconds"][which]
        if error is None or not error <= bound:
            break
        if best is None or seconds < best[0]:
            best = seconds, setting
    return "–" if best is None else f"{milliseconds(best[0])} ({setting_name(method, best[1])})"


def plot(results, path):
    """Plots a row of panels for each scene: errors of values and of slopes against processor time."""
    pyplot.rcParams.update({"svg.hashsalt": "accuracy", "svg.fonttype": "none", "font.size": 9})
    size = (10.0, 3.3 * len(results) + 0.5)
    figure, panels = pyplot.subplots(len(results), 2, figsize=size, squeeze=False)
    for row, (name, found) in zip(panels, results.items()):
        for which, panel in enumerate(row):
            draw(panel, found, which)
        row[0].set(title=f"{name}: values", ylabel="error of values (m)")
        row[1].set(title=f"{name}: slopes", ylabel="relative error of slopes")
    lines, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="lower center", ncols=len(labels) // 2, frameon=False)
    figure.tight_layout(rect=(0, 0.6 / size[1], 1, 1))
    figure.savefig(path, metadata={"Date": None})
    # matplotlib leaves spaces at the ends of lines.
    path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")


def draw(panel, found, which):
    """Draws the lines of one panel. A large marker is the default accuracy of the program."""
    colors = {program: iter(of_program) for program, of_program in COLORS.items()}
    for method, of_method in found.items():
        color = next(colors[method.program])
        points = [
            (1e3 * row["seconds"][which], row["errors"][which], setting)
            for setting, row in of_method["rows"].items()
            if row["errors"][which] is not None and numpy.isfinite(row["errors"][which])
        ]
        times, errors, settings = (list(column) for column in zip(*points)) if points else ([], [], [])
        errors = numpy.clip(errors, *LIMITS[which])
        style = {"color": color, "marker": MARKERS[method.program]}
        panel.loglog(times, errors, label=label(method), markersize=4, linewidth=1.4, **style)
        for time, error, setting in zip(times, errors, settings):
            if setting == method.default:
                panel.loglog([time], [error], markersize=9, **style)
    panel.set(xlabel="processor time (ms)")
    panel.grid(True, which="major", color="#e1e1e1", linewidth=0.7)
