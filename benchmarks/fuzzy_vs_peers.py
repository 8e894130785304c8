"""The fuzzy engine against ferrifuzz and the first paper's fuzzylab: one call, a batch, and how exact they are.

    pip install 'holodrive[bench]'
    python benchmarks/fuzzy_vs_peers.py [--fuzzylab PYTHON] [--rounds 41] [--save]

The paper's controller with Table VIII (and `repaired`): three inputs, 27 rules, two outputs. ferrifuzz runs in this
process, with 1000 samples for each output (its own default of 200 is printed beside it, without a bar) and, for the
batch, on all cores, as ours does. fuzzylab fails with NumPy 2 and runs in a process of its own, in an environment like

    python -m venv FOLDER && FOLDER/bin/pip install fuzzylab matplotlib 'numpy<2'

whose FOLDER/bin/python is given as `--fuzzylab`; without it that line is left out. Sides take turns, so that other
load meets both alike; figures are medians. Exit code 1 when a bar is missed.
"""

import argparse
import json
import math
import platform
import statistics
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

from holodrive.control import fuzzy
from holodrive.control.fuzzy.evaluation import membership, strengths

try:
    import ferrifuzz
except ImportError:
    sys.exit("this benchmark compares with ferrifuzz, which is not installed: pip install 'holodrive[bench]'")

BATCH, CALLS = 10_000, 400
RESOLUTION = 1000
BARS = {"ferrifuzz one": 1 / 5, "ferrifuzz batch": 1 / 15, "fuzzylab one": 1 / 200}
EXACT = 1e-8  # ours against a second method, in the outputs' units


# --- the peers' side ------------------------------------------------------------------------------


def ferri(system, resolution):
    """The same controller in ferrifuzz."""
    other = ferrifuzz.FuzzySystem(resolution=resolution)
    for variables, add in ((system.inputs, other.add_input), (system.outputs, other.add_output)):
        for variable in variables:
            theirs = ferrifuzz.Variable(variable.name, variable.low, variable.high)
            for one in variable.sets:
                theirs[one.name] = getattr(ferrifuzz.mf, one.kind)(*one.params)
            add(theirs)
    for rule in system.rules:
        other.add_rule(f"IF {spoken(system.inputs, rule.inputs)} THEN {spoken(system.outputs, rule.outputs)}")
    return other


def spoken(variables, numbers):
    return " AND ".join(f"{v.name} IS {v.sets[k - 1].name}" for v, k in zip(variables, numbers, strict=True))


def ferri_batch(other, columns):
    out = other.compute_batch(columns)
    return np.stack([out[name] for name in other.output_names()], axis=1)


class Fuzzylab:
    """The other process; says why when it is not there."""

    def __init__(self, python):
        script = Path(__file__).parent / "_fuzzylab.py"
        self.process = subprocess.Popen([python, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        told = json.loads(self.process.stdout.readline() or '{"error": "it does not run"}')
        if "error" in told:
            sys.exit(f"no fuzzylab at {python}: {told['error']}; see the head of this script")
        self.version = told["version"]

    def ask(self, request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def build(self, system):
        sides = {
            side: [
                {"name": v.name, "low": v.low, "high": v.high, "sets": [(s.name, s.kind, s.params) for s in v.sets]}
                for v in variables
            ]
            for side, variables in (("inputs", system.inputs), ("outputs", system.outputs))
        }
        rules = [[*rule.inputs, *rule.outputs, 1, 1] for rule in system.rules]
        self.ask({"system": {**sides, "rules": rules}})

    def evaluate(self, rows):
        """Seconds per call, outputs as returned."""
        told = self.ask({"inputs": rows})
        return told["seconds"], np.array([[math.nan if v is None else v for v in row] for row in told["outputs"]])

    def close(self):
        self.process.stdin.close()
        self.process.wait(10)


# --- how exact ------------------------------------------------------------------------------------


def second_method(system, rows):
    """Centroids by the definition: the aggregate at all break points and crossings, integrated by Simpson's rule.

    Slow, and another way than either of ours: every pair of pieces is crossed, no set is left out.
    """
    out = np.full((len(rows), len(system.outputs)), math.nan)
    for i, fired in enumerate(strengths(system, rows)):
        for k, variable in enumerate(system.outputs):
            heights = [
                max((s for s, rule in zip(fired, system.rules, strict=True) if rule.outputs[k] == number), default=0.0)
                for number in range(1, len(variable.sets) + 1)
            ]
            if max(heights) > 0.0:
                out[i, k] = centroid(variable, heights)
    return out


def centroid(variable, heights):
    corners = {variable.low, variable.high}
    lines = []  # slope, offset
    for one, height in zip(variable.sets, heights, strict=True):
        a, b, c = one.params
        lines += [(1.0 / (b - a), -a / (b - a)), (-1.0 / (c - b), c / (c - b)), (0.0, height)]
        corners |= set(one.params)
    for i, (m, p) in enumerate(lines):
        corners |= {(q - p) / (m - n) for n, q in lines[:i] if m != n}
    u = np.array(sorted(place for place in corners if variable.low <= place <= variable.high))
    points = np.stack([u[:-1], 0.5 * (u[:-1] + u[1:]), u[1:]])
    cut = [np.minimum(membership(one, points), h) for one, h in zip(variable.sets, heights, strict=True)]
    mu = np.max(cut, axis=0)
    weights = np.array([1.0, 4.0, 1.0])[:, None] * np.diff(u) / 6.0
    return np.sum(weights * mu * points) / np.sum(weights * mu)


def error_line(name, theirs, ours):
    both = np.isfinite(theirs).all(axis=1) & np.isfinite(ours).all(axis=1)
    error = np.abs(theirs - ours)[both]
    silent = int(np.sum(np.isnan(theirs).any(axis=1) != np.isnan(ours).any(axis=1)))
    return f"  {name:<44}{error.max():>12.3g}{error.mean():>12.3g}{silent:>12}"


# --- measuring ------------------------------------------------------------------------------------


def seconds(function, times=1):
    begin = time.perf_counter()
    for _ in range(times):
        function()
    return (time.perf_counter() - begin) / times


def measure(system, rounds, lab):
    """Median seconds per evaluation of each line, all in turn in every round."""
    rows = np.random.default_rng(1).uniform(0.0, 2500.0, (BATCH, len(system.inputs)))
    singles = rows[:CALLS].tolist()
    columns = {one.name: rows[:, k].copy() for k, one in enumerate(system.inputs)}
    peer, coarse = ferri(system, RESOLUTION), ferri(system, 200)
    lines = {
        "ours, a list": lambda: seconds(lambda: [system.evaluate(x) for x in singles]) / CALLS,
        "ours, an array": lambda: seconds(lambda: [system.evaluate(x) for x in rows[:CALLS]]) / CALLS,
        "ours, batch": lambda: seconds(lambda: system.evaluate(rows), 5) / BATCH,
        "ferrifuzz": lambda: seconds(lambda: [peer.evaluate(x) for x in singles]) / CALLS,
        "ferrifuzz, 200 samples": lambda: seconds(lambda: [coarse.evaluate(x) for x in singles]) / CALLS,
        "ferrifuzz, batch": lambda: seconds(lambda: ferri_batch(peer, columns)) / BATCH,
        "ferrifuzz, batch, 200 samples": lambda: seconds(lambda: ferri_batch(coarse, columns)) / BATCH,
    }
    if lab:
        lab.build(system)
        lines["fuzzylab"] = lambda: lab.evaluate(singles[:20])[0]
    for line in lines.values():
        line()  # compiled, loaded
    found = {name: [] for name in lines}
    for _ in range(rounds):
        for name, line in lines.items():
            found[name].append(line())
    return {name: statistics.median(times) for name, times in found.items()}


def timing(system, rounds, lab):
    """The table, and whether all bars are met."""
    us = measure(system, rounds, lab)
    text, good = [f"{system.name}: {'':<33}{'ours':>10}{'peer':>11}{'ratio':>9}{'bar':>9}{'speed-up':>10}"], True
    lines = [
        ("one call, a list, ferrifuzz", "ours, a list", "ferrifuzz", "ferrifuzz one"),
        ("one call, an array, ferrifuzz", "ours, an array", "ferrifuzz", "ferrifuzz one"),
        ("one call, a list, ferrifuzz with 200 samples", "ours, a list", "ferrifuzz, 200 samples", ""),
        (f"batch of {BATCH}, ferrifuzz", "ours, batch", "ferrifuzz, batch", "ferrifuzz batch"),
        (f"batch of {BATCH}, ferrifuzz with 200 samples", "ours, batch", "ferrifuzz, batch, 200 samples", ""),
        ("one call, a list, fuzzylab", "ours, a list", "fuzzylab", "fuzzylab one"),
    ]
    for name, ours, theirs, bar in lines:
        if theirs not in us:
            text.append(f"  {name:<44}not measured: give --fuzzylab PYTHON")
            continue
        ratio, limit = us[ours] / us[theirs], BARS.get(bar, math.inf)
        good &= ratio <= limit
        shown = f"{limit:>9.4f}" if bar else f"{'-':>9}"
        times = f"{us[ours] * 1e6:>7.2f} us{us[theirs] * 1e6:>8.1f} us{ratio:>9.4f}{shown}{1 / ratio:>9.0f}x"
        text.append(f"  {name:<44}{times}{'' if ratio <= limit else '  MISSED'}")
    return text, good


def exactness(system, lab):
    """The table of errors, and whether ours is exact."""
    rows = np.random.default_rng(2).uniform(0.0, 2500.0, (2000, len(system.inputs)))
    ours, truth = system.evaluate(rows), second_method(system, rows)
    text = [
        f"{system.name}, errors in output units (range 600) over {len(rows)} inputs",
        f"{'max':>58}{'mean':>12}{'NaN differs':>14}",
    ]
    text.append(error_line("ours, to a second method", ours, truth))
    columns = {one.name: rows[:, k].copy() for k, one in enumerate(system.inputs)}
    for resolution in (RESOLUTION, 200):
        theirs = ferri_batch(ferri(system, resolution), columns)
        text.append(error_line(f"ferrifuzz, {resolution} samples, to ours", theirs, ours))
    if lab:
        lab.build(system)
        theirs = lab.evaluate(rows.tolist())[1]
        text.append(error_line("fuzzylab, to ours", theirs, ours))
        text.append(error_line("fuzzylab with its outputs exchanged, to ours", theirs[:, ::-1], ours))
        as_theirs = fuzzy.load(system.name, fuzzylab_compat=True).evaluate(rows)
        text.append(error_line("fuzzylab, to ours with fuzzylab_compat", theirs, as_theirs))
    good = bool(np.nanmax(np.abs(ours - truth)) <= EXACT) and bool(np.all(np.isnan(ours) == np.isnan(truth)))
    return [*text, *([] if good else ["  ours is not exact: MISSED"])], good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fuzzylab", metavar="PYTHON", help="of an environment with fuzzylab and numpy < 2")
    parser.add_argument("--rounds", type=int, default=41)
    parser.add_argument("--save", action="store_true", help="keep the result beside this script")
    options = parser.parse_args()
    lab = Fuzzylab(options.fuzzylab) if options.fuzzylab else None
    text = [
        f"holodrive {version('holodrive')}, ferrifuzz {version('ferrifuzz')}"
        + (f", fuzzylab {lab.version} there" if lab else ""),
        f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}; "
        f"medians of {options.rounds} interleaved rounds",
    ]
    good = True
    for name in ("paper_viii", "repaired"):
        system = fuzzy.load(name)
        for lines, met in (timing(system, options.rounds, lab), exactness(system, lab)):
            text += ["", *lines]
            good &= met
    if lab:
        lab.close()
    text += ["", "all bars met" if good else "a bar is missed"]
    print("\n".join(text))
    if options.save:
        folder = Path(__file__).parent / "results"
        folder.mkdir(exist_ok=True)
        (folder / "fuzzy_vs_peers.txt").write_text("\n".join(text) + "\n", encoding="utf-8")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
