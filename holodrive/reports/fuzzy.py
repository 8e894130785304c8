"""A fuzzy system on a page: sets, rules, findings; what comes out at one input and why; the control surface."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from holodrive.control.fuzzy.evaluation import aggregated
from holodrive.control.fuzzy.lint import Finding, lint
from holodrive.control.fuzzy.shape import Shape, shapes
from holodrive.control.fuzzy.system import System, Variable
from holodrive.errors import InputError
from holodrive.reports import parts
from holodrive.reports.plots import Chart, Line
from holodrive.reports.surface import side_by_side, surface
from holodrive.reports.tables import Table
from holodrive.svg import number
from holodrive.types import Array


@dataclass(frozen=True)
class FuzzySection:
    """One fuzzy system.

    Attributes:
        system: to show.
        at: (n_in,) one input to explain, in the system's units; None shows the system only.
        across: names of the two inputs of the control surface; by default the first two, where there are two.
        sensor_range: for the linter, see `lint`.
        clamp: as for `evaluate`.
        name: heading, by default the system's name.
    """

    system: System
    at: Sequence[float] | None = None
    across: tuple[str, str] | None = None
    sensor_range: tuple[float, float] | None = None
    clamp: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.system, System):
            raise InputError(f"a FuzzySection shows a system, such as fuzzy.load('repaired'); found {self.system!r}")
        names = [v.name for v in self.system.inputs]
        if self.at is not None and np.shape(self.at) != (len(names),):
            raise InputError(f"at is one number for each of {', '.join(names)}; found {self.at!r}")

    @property
    def title(self) -> str:
        """The heading."""
        return self.name or f"Fuzzy system {self.system.name}"

    def html(self) -> str:
        """What stands under the heading."""
        system = self.system
        found = lint(system, self.sensor_range)
        text = parts.note(system.source) + parts.fact_list(facts(system, found))
        text += _charts(
            "Sets of the inputs", [membership_chart(v, self._value(i)) for i, v in enumerate(system.inputs)]
        )
        if system.kind == "mamdani":
            text += _charts("Sets of the outputs", [membership_chart(v) for v in system.outputs])
        if self.at is not None:
            text += self._explained(self.at)
        text += self._surfaces()
        text += parts.heading("Findings", "Of the linter, which looks at break points and rules.")
        text += findings_html(found) if found else "<p>Nothing was found.</p>"
        rules = rule_table(system).html()
        return f"{text}<details><summary>All {len(system.rules)} rules</summary>{rules}</details>"

    def _repr_html_(self) -> str:
        """For notebooks: the page of this section alone."""
        from holodrive.reports.page import report

        return report(self)._repr_html_()

    def _value(self, index: int) -> float | None:
        return None if self.at is None else float(self.at[index])

    def _explained(self, at: Sequence[float]) -> str:
        told = self.system.explain(at, self.clamp)
        charts = [aggregated_chart(self.system, at, k, self.clamp) for k in range(len(self.system.outputs))]
        where = ", ".join(f"{v.name} = {float(x):g}" for v, x in zip(self.system.inputs, at, strict=True))
        text = parts.heading(f"At {where}", "Share: area of the aggregated set that the rule won.") + told.html()
        return text + _figures(charts)

    def _surfaces(self) -> str:
        names = self.across or tuple(v.name for v in self.system.inputs[:2])
        if len(names) != 2:
            return ""
        across = (names[0], names[1])
        shown = [surface(self.system, across, k, self.at, self.clamp) for k in range(len(self.system.outputs))]
        pictures = "".join(f"<figure>{one.svg()}</figure>" for one in shown)
        return parts.heading("Control surface") + f'<div class="charts two">{pictures}</div>'


def facts(system: System, found: Sequence[Finding] = ()) -> dict[str, str]:
    """What kind of system it is, in pairs of words."""
    counts = {s: sum(one.severity == s for one in found) for s in ("error", "warning", "info")}
    told = [f"{n} {s}{'s' * (n != 1 and s != 'info')}" for s, n in counts.items() if n]
    return {
        "kind": system.kind,
        "inputs": ", ".join(v.name for v in system.inputs),
        "outputs": ", ".join(v.name for v in system.outputs),
        "rules": str(len(system.rules)),
        "and, or": f"{system.conjunction}, {system.disjunction}",
        "implication": system.implication,
        "aggregation": system.aggregation,
        "defuzzification": system.defuzzification,
        "lint": ", ".join(told) or "clean",
    }


def membership_chart(variable: Variable, value: float | None = None) -> Chart:
    """The sets of a variable over its universe; `value` is marked."""
    lines = [
        Line(one.name, *_within(curve, variable), colour=i)
        for i, (one, curve) in enumerate(zip(variable.sets, shapes(variable), strict=True))
    ]
    marks = () if value is None or not variable.low <= value <= variable.high else (value,)
    return Chart(
        variable.name, "", tuple(lines), variable.name, variable.unit, low=0.0, high=1.0, least=1.0, marks=marks,
        width=360.0, height=180.0,
    )  # fmt: skip


def aggregated_chart(system: System, x: Sequence[float], output: int, clamp: bool = True) -> Chart:
    """What all rules together say of one output at x, over the sets it is made of, with the result marked."""
    variable = system.outputs[output]
    places, heights = aggregated(system, x, output, clamp)
    value = float(system.evaluate(x, clamp)[output])
    stems = system.kind == "sugeno" or any(one.kind == "singleton" for one in variable.sets)
    if stems:
        lines = [
            Line("rules" * (i == 0), np.array([u, u]), np.array([0.0, h]))
            for i, (u, h) in enumerate(zip(places, heights, strict=True))
        ]
    else:
        lines = [Line("", *_within(c, variable), colour=7, dash="2 3") for c in shapes(variable)]
        lines.append(Line("aggregated", *_ended(places, heights, variable), area=True))
    ends = Line("", np.array([variable.low, variable.high]), np.zeros(2), colour=7)
    known = np.isfinite(value)
    title = f"{variable.name} = {number(value, 1)}" if known else f"{variable.name}: no rule fires"
    return Chart(
        f"{title} ({system.defuzzification})", "", (ends, *lines), variable.name, variable.unit, low=0.0, high=1.0,
        least=1.0, marks=(value,) if known else (), height=200.0,
    )  # fmt: skip


def rule_table(system: System) -> Table:
    """All rules, one a row."""
    variables = (*system.inputs, *system.outputs)
    weighted = any(rule.weight != 1.0 for rule in system.rules)
    joined = any(rule.connective == "or" for rule in system.rules)
    header = ("rule", *(v.name for v in variables), *("joined by",) * joined, *("weight",) * weighted)
    cells = []
    for count, rule in enumerate(system.rules, 1):
        literals = (*rule.inputs, *rule.outputs)
        names = [_literal(v, i) for v, i in zip(variables, literals, strict=True)]
        cells.append((str(count), *names, *(rule.connective,) * joined, *(f"{rule.weight:g}",) * weighted))
    data = tuple(dict(zip(header, row, strict=True)) for row in cells)
    return Table("", header, tuple(cells), data, (True, *(False,) * (len(header) - 1)))


def finding_table(found: Sequence[Finding]) -> Table:
    """What the linter found, errors first."""
    header = ("code", "severity", "what")
    cells = tuple((one.code, one.severity, one.text) for one in found)
    return Table("", header, cells, tuple(dict(zip(header, row, strict=True)) for row in cells), (False,) * 3)


def findings_html(found: Sequence[Finding]) -> str:
    """The same with lines that break, for a page."""
    rows = "".join(
        f"<tr><td>{one.code}</td><td>{one.severity}</td><td class='wrap'>{escape(one.text)}</td></tr>" for one in found
    )
    head = "".join(f'<th scope="col">{name}</th>' for name in ("code", "severity", "what"))
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def surfaces_svg(system: System, across: tuple[str, str], at: Sequence[float] | None = None, clamp: bool = True) -> str:
    """The control surfaces of all outputs as one SVG document.

    Raises:
        UnknownName, InputError: as `surface`.
    """
    if len(system.inputs) < 2:
        raise InputError(f"{system.name!r} has one input; a control surface needs two")
    return side_by_side([surface(system, across, k, at, clamp) for k in range(len(system.outputs))])


def _literal(variable: Variable, index: int) -> str:
    if not index:
        return "—"
    return ("not " if index < 0 else "") + variable.sets[abs(index) - 1].name


def _within(curve: Shape, variable: Variable) -> tuple[Array, Array]:
    """A set from one end of the universe to the other."""
    ends = np.array([variable.low, variable.high])
    inside = (curve.x > ends[0]) & (curve.x < ends[1])
    x = np.concatenate([ends[:1], curve.x[inside], ends[1:]])
    return x, np.concatenate([curve.after(ends[:1]), curve.m[inside], curve.before(ends[1:])])


def _ended(x: Array, m: Array, variable: Variable) -> tuple[Array, Array]:
    """Down to zero at both ends of the universe, so that its area closes there."""
    if not len(x):
        return np.array([variable.low, variable.high]), np.zeros(2)
    return np.concatenate([x[:1], x, x[-1:]]), np.concatenate([[0.0], m, [0.0]])


def _charts(title: str, charts: Sequence[Chart]) -> str:
    return parts.heading(title) + _figures(charts)


def _figures(charts: Sequence[Chart]) -> str:
    return f'<div class="charts">{"".join(f"<figure>{chart.svg()}</figure>" for chart in charts)}</div>'
