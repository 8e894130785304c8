"""Figures 25 to 34: sets, rules, surface, scans and what they tell of obstacles."""

import numpy as np

from holodrive import build, worlds
from holodrive.control import fuzzy
from holodrive.experiments.claims import Claim, Verdict
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed, robots
from holodrive.experiments.pictures import Gallery, paths_over
from holodrive.log.run import Run
from holodrive.reports import fuzzy as plots
from holodrive.reports.lidar import LidarSection
from holodrive.types import Array

AT = (700.0, 300.0, 2000.0)  # mm: obstacle near on the left, medium ahead


def figure_25(setting: Setting) -> Result:
    """Sets of DH."""
    system = fuzzy.load("paper_viii")
    claims = (*_parameters("Fig. 25", system, "DH"), _coverage("Fig. 25", system, "DH"), _beyond(system))
    return Result(claims, (_sets("Figure 25", system, ("DH",)),))


def figure_26(setting: Setting) -> Result:
    """Sets of DL and DR, and the hole between those of DL."""
    system = fuzzy.load("paper_viii")
    left, right = (tuple(one.params for one in system.inputs[system.input_index(n)].sets) for n in ("DL", "DR"))
    jump = _jump(system)
    claims = (
        *_parameters("Fig. 26", system, "DL"),
        *_parameters("Fig. 26", system, "DR"),
        Claim("text", "DL and DR use equivalent parameters", "yes", "yes" if left == right else "no",
              "agrees" if left == right else "contradicts itself",
              note="M of DL is 500 750 1000, of DR 250 750 1500; F differs too"),
        _coverage("Fig. 26", system, "DL"),
        _coverage("Fig. 26", system, "DR"),
        Claim("Fig. 26", "rules that fire at DL = 500 mm", None, float(_fired(system, (700.0, 500.0, 700.0))),
              "not printed", "", "no set of DL is active there: 0/0 in Eq. 24"),
        Claim("Fig. 26", "jump of the output across DL = 500 mm, DH = DR = 50 mm", None, jump, "not printed",
              "of 300", "Table VIII"),
    )  # fmt: skip
    return Result(claims, (_sets("Figure 26", system, ("DL", "DR")),))


def figure_27(setting: Setting) -> Result:
    """Sets of L and R: not the same, and none near zero."""
    system = fuzzy.load("paper_viii")
    middles = [
        ", ".join(f"{sum(one.params) / 3.0:.1f}" for one in variable.sets).replace("-", "−")
        for variable in system.outputs
    ]
    claims = (
        *_parameters("Fig. 27", system, "L"),
        *_parameters("Fig. 27", system, "R"),
        Claim("Fig. 27", "centroids of N, NZ, PZ, P", None, f"L {middles[0]}; R {middles[1]}", "not printed",
              note="'PZ PZ' turns right by 16.7 although both say the same"),
        Claim("Fig. 27", "slowest speed ahead, share of the fastest", None, 100.0 * _slowest(system), "not printed",
              "%", "no set covers zero: the controller cannot stop"),
        Claim("text", "unit of -300..300", "angular velocity, unit not told", "share of full speed", "not comparable",
              note="22 rpm are 2.3 rad/s or 132 deg/s; taken here as a share of full speed, with named motor presets"),
    )  # fmt: skip
    return Result(claims, (_sets("Figure 27", system, ("L", "R")),))


def figure_28(setting: Setting) -> Result:
    """The structure of the system."""
    system = fuzzy.load("paper_viii")
    count = f"{len(system.inputs)} in, {len(system.rules)} rules, {len(system.outputs)} out"
    same: Verdict = "agrees" if count == printed.STRUCTURE else "differs"
    words = f"{system.kind}, AND {system.conjunction}, {system.implication} / {system.aggregation}, "
    return Result(
        (
            Claim("Fig. 28", "structure", printed.STRUCTURE, count, same),
            Claim(
                "Fig. 28", "inference", "Mamdani, centre of gravity", words + system.defuzzification, "agrees",
                note="min, max and 101 samples are the defaults of the paper's library; here the centroid is exact",
            ),
        )
    )  # fmt: skip


def figure_29(setting: Setting) -> Result:
    """The rule viewer at one point."""
    system = fuzzy.load("paper_viii")
    section = plots.FuzzySection(system, at=AT)
    return Result(
        (
            Claim(
                "Fig. 29",
                "rules at work",
                None,
                f"{_fired(system, AT)} of {len(system.rules)} at one point",
                "no number",
            ),
        ),
        (section,),
    )


def figure_30(setting: Setting) -> Result:
    """The control surface of both tables and of the repaired profile."""
    systems = {name: fuzzy.load(name) for name in ("paper_vii", "paper_viii", "repaired")}
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 2500.0, 41)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    claims = []
    for name, system in systems.items():
        values = system.evaluate(grid)
        low, high = np.nanmin(values), np.nanmax(values)
        claims.append(
            Claim("Fig. 30", f"{name}: outputs declared, reached", "−300 to 300",
                  f"{low:.1f} to {high:.1f}".replace("-", "−"), "not comparable",
                  note="a centroid never reaches the end of the range")
        )  # fmt: skip
    pictures = tuple(
        (f"{name} at DR = {AT[2]:g} mm", plots.surfaces_svg(system, ("DH", "DL"), AT))
        for name, system in systems.items()
    )
    return Result(tuple(claims), (Gallery("Figure 30: control surfaces", pictures),))


def figure_31(setting: Setting) -> Result:
    """A photograph."""
    return Result((Claim("Fig. 31", "lidar on the robot", "photograph", None, "no number"),))


def figure_32(setting: Setting) -> Result:
    """A polar scan from the start of the printed course."""
    claim = Claim("Fig. 32", "points of one scan", None, float(_standing().scans[-1].ranges.size), "not printed",
                  note="scan from the start of the printed course")  # fmt: skip
    return Result((claim,), (LidarSection(_standing()),))


def figure_33(setting: Setting) -> Result:
    """The window with the four obstacles."""
    world = worlds.load("paper_course_printed")
    picture = Gallery("Figure 33: the four obstacles", ((world.title, paths_over(world, [])),))
    count = len(world.circles)
    claim = Claim("Fig. 33", "obstacles", 4.0, float(count), "agrees" if count == 4 else "differs")
    return Result((claim,), (picture,))


def figure_34(setting: Setting) -> Result:
    """Clusters of one scan, fitted by circles, beside the true obstacles."""
    from holodrive import perception

    run = _standing()
    found = perception.clusters(perception.points(run.scans[-1]))
    world = worlds.load("paper_course_printed")
    claims = []
    for number, circle in enumerate(world.circles, 1):
        near = [(np.hypot(*(_in_world(run, c.x, c.y) - (circle.x, circle.y))), c) for c in found]
        away, cluster = min(near, key=lambda pair: pair[0])
        if away < circle.radius:
            claims.append(
                Claim("Fig. 34", f"obstacle {number}: radius from one scan", 100.0 * circle.radius,
                      100.0 * cluster.radius, "agrees" if abs(cluster.radius - circle.radius) < 0.03 else "differs",
                      "cm", f"centre off by {1e3 * away:.0f} mm; the method is not in the paper")
            )  # fmt: skip
        else:
            claims.append(Claim("Fig. 34", f"obstacle {number}", 100.0 * circle.radius, None, "no number", "cm",
                                "hidden behind another, or not told apart from the wall, in this scan"))  # fmt: skip
    return Result(tuple(claims), (LidarSection(run),))


def _standing() -> Run:
    """A robot that stands at the start of the printed course for two scans."""
    base = build.simulate(robots.table_x(), worlds.load("paper_course_printed"), seed=1)
    return build.drive(base, "go_to_pose", goal=tuple(base.truth), duration_s=0.6, stop_on_arrival=False)


def _in_world(run: Run, x: float, y: float) -> Array:
    px, py, theta = run.pose[-1]
    c, s = np.cos(theta), np.sin(theta)
    return np.array([px + c * x - s * y, py + s * x + c * y])


def _sets(title: str, system: fuzzy.System, names: tuple[str, ...]) -> Gallery:
    variables = {v.name: v for v in (*system.inputs, *system.outputs)}
    return Gallery(title, tuple((name, plots.membership_chart(variables[name]).svg()) for name in names))


def _parameters(where: str, system: fuzzy.System, name: str) -> list[Claim]:
    variable = {v.name: v for v in (*system.inputs, *system.outputs)}[name]
    claims = []
    for one in variable.sets:
        said, found = (" ".join(f"{p:g}" for p in numbers) for numbers in (printed.SETS[name][one.name], one.params))
        verdict: Verdict = "agrees" if said == found else "differs"
        claims.append(Claim(where, f"set {one.name} of {name}", said, found, verdict))
    return claims


def _coverage(where: str, system: fuzzy.System, name: str) -> Claim:
    """Least membership of the best set over the universe, as the linter finds it at break points."""
    found = {one.code: one for one in system.lint() if one.variable == name}
    worst = found.get("F-GAP") or found.get("F-COVER")
    if worst is None:
        return Claim(where, f"{name}: least coverage", None, "0.5 or more", "not printed")
    note = worst.text
    return Claim(where, f"{name}: least coverage", None, worst.value, "not printed", "", note)


def _beyond(system: fuzzy.System) -> Claim:
    low, high = printed.SENSOR_MM
    share = 1.0 - ((printed.UNIVERSE_MM[1] - low) / (high - low)) ** 3
    return Claim("text", "sensor readings outside the inputs' universe", f"{low:g} to {high:g} mm",
                 f"{100.0 * share:.1f} % of the cube", "contradicts itself",
                 note="inputs end at 2500 mm; beyond it no rule fires unless they are clamped, as here")  # fmt: skip


def _fired(system: fuzzy.System, at: tuple[float, ...]) -> int:
    return len(system.explain(at).rules)


def _jump(system: fuzzy.System) -> float:
    below, above = system.evaluate([[50.0, 500.0 - 1e-6, 50.0], [50.0, 500.0 + 1e-6, 50.0]])
    return float(np.max(np.abs(above - below)))


def _slowest(system: fuzzy.System) -> float:
    values = [system.outputs[0].sets[i].params for i in (2, 3)]
    return float(sum(values[0]) / sum(values[1]))
