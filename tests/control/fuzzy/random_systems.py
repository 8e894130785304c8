"""Fuzzy systems for hypothesis to draw, of every kind, and the same systems evaluated by plain NumPy on samples."""

from typing import get_args

import numpy as np
from hypothesis import strategies as st

from holodrive.control.fuzzy import Rule, Set, System, Variable, system
from holodrive.control.fuzzy.evaluation import membership

# Places are twentieths of the universe, so that no set is too narrow for the samples.
PLACES = st.integers(-4, 24).map(lambda k: k / 20.0)
INSIDE = st.integers(0, 20).map(lambda k: k / 20.0)
HEIGHTS = st.integers(0, 4).map(lambda k: k / 4.0)
STRAIGHT = ("triangle", "trapezoid", "polyline")
CURVED = ("gaussian", "bell")


@st.composite
def fuzzy_set(draw, name, variable, kinds, places=PLACES):
    """A set of one of the kinds, given in shares of the universe (low, high)."""
    low, high = variable
    kind, width = draw(st.sampled_from(kinds)), high - low
    if kind in ("triangle", "trapezoid"):
        n = 3 if kind == "triangle" else 4
        shares = draw(st.lists(places, min_size=n, max_size=n).map(sorted).filter(lambda s: s[0] < s[-1]))
        return Set(name, kind, tuple(low + share * width for share in shares))
    if kind == "polyline":
        shares = draw(st.lists(places, min_size=2, max_size=5).map(sorted))
        return Set(name, kind, tuple(v for share in shares for v in (low + share * width, draw(HEIGHTS))))
    centre, spread = low + draw(places) * width, width * draw(st.integers(1, 6)) / 20.0
    if kind == "gaussian":
        return Set(name, kind, (centre, spread))
    if kind == "bell":
        return Set(name, kind, (spread, draw(st.sampled_from((0.5, 1.0, 2.5))), centre))
    return Set(name, "singleton", (low + draw(INSIDE) * width,))


@st.composite
def variable(draw, name, kinds, places=PLACES):
    low = draw(st.sampled_from((-300.0, 0.0, 5.0)))
    high = low + draw(st.sampled_from((1.0, 40.0, 600.0)))
    count = draw(st.integers(1, 4))
    return Variable(name, low, high, tuple(draw(fuzzy_set(f"s{k}", (low, high), kinds, places)) for k in range(count)))


@st.composite
def rule(draw, inputs, outputs):
    condition = [draw(st.integers(-len(one.sets), len(one.sets))) for one in inputs]
    if not any(condition):
        condition[0] = 1
    return Rule(
        tuple(condition),
        tuple(draw(st.integers(0, len(one.sets))) for one in outputs),
        draw(st.sampled_from((1.0, 1.0, 0.6, 0.0))),
        draw(st.sampled_from(("and", "or"))),
    )


@st.composite
def mamdani(draw, output_kinds=STRAIGHT, methods=("centroid", "bisector", "mom", "som", "lom")):
    """A Mamdani system with any inputs and outputs of these kinds."""
    inputs = tuple(draw(variable(f"x{k}", STRAIGHT + CURVED)) for k in range(draw(st.integers(1, 3))))
    outputs = tuple(draw(variable(f"y{k}", output_kinds)) for k in range(draw(st.integers(1, 2))))
    return System(
        "drawn",
        inputs,
        outputs,
        tuple(draw(st.lists(rule(inputs, outputs), min_size=1, max_size=8))),
        conjunction=draw(st.sampled_from(get_args(system.Conjunction))),
        disjunction=draw(st.sampled_from(get_args(system.Disjunction))),
        implication=draw(st.sampled_from(get_args(system.Implication))),
        aggregation=draw(st.sampled_from(get_args(system.Aggregation))),
        defuzzification=draw(st.sampled_from(methods)),
    )


@st.composite
def with_input(draw, systems):
    """A system and an input x, up to a fifth beyond its universe."""
    drawn = draw(systems)
    shares = [draw(st.floats(-0.2, 1.2)) for _ in drawn.inputs]
    return drawn, [one.low + share * (one.high - one.low) for one, share in zip(drawn.inputs, shares, strict=True)]


# --- the second method ---------------------------------------------------------------------------

_AND = {"min": min, "prod": lambda a, b: a * b, "bounded": lambda a, b: max(0.0, a + b - 1.0)}
_OR = {"max": max, "probor": lambda a, b: a + b - a * b, "bounded": lambda a, b: min(1.0, a + b)}


def plain_strengths(system, x):
    """One rule after the other, by the definition."""
    out = []
    for one in system.rules:
        degrees = []
        for value, variable_, number in zip(x, system.inputs, one.inputs, strict=True):
            if number:
                mu = float(membership(variable_.sets[abs(number) - 1], value))
                degrees.append(mu if number > 0 else 1.0 - mu)
        join = _AND[system.conjunction] if one.connective == "and" else _OR[system.disjunction]
        total = degrees[0]
        for mu in degrees[1:]:
            total = join(total, mu)
        out.append(total * one.weight)
    return np.array(out)


def plain_aggregate(system, strengths, output, u):
    """Heights (n,) of an output's aggregate at places u (n,), rule by rule."""
    total = np.zeros_like(u)
    for one, strength in zip(system.rules, strengths, strict=True):
        if one.outputs[output]:
            mu = membership(system.outputs[output].sets[one.outputs[output] - 1], u)
            mu = np.minimum(mu, strength) if system.implication == "min" else mu * strength
            total = total + mu if system.aggregation == "sum" else np.maximum(total, mu)
    return total


def fires(system, strengths, output):
    """Whether a rule that speaks of this output fires."""
    return any(s > 0.0 and one.outputs[output] for s, one in zip(strengths, system.rules, strict=True))
