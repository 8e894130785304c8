"""The kernel against a second method: the definition, evaluated rule by rule with NumPy on samples."""

import numpy as np
from hypothesis import given, settings
from random_systems import CURVED, STRAIGHT, fires, mamdani, plain_aggregate, plain_strengths, with_input

from holodrive.control.fuzzy.evaluation import aggregated, evaluate, strengths
from holodrive.control.fuzzy.membership import POLYLINE_ERROR

SAMPLES = 20_001


@given(with_input(mamdani()))
def test_strengths_are_those_of_the_definition(case):
    """All kinds of sets, AND, OR, NOT, don't care, weights."""
    system, x = case
    np.testing.assert_allclose(strengths(system, x, clamp=False), plain_strengths(system, x), atol=1e-12)


@settings(max_examples=200)
@given(with_input(mamdani()))
def test_the_aggregate_is_exact_for_straight_sets(case):
    """Cut or scaled, greatest or sum: the polyline of break points meets the definition between all of them."""
    system, x = case
    fired = strengths(system, x, clamp=False)
    for k in range(len(system.outputs)):
        u, mu = aggregated(system, x, k, clamp=False)
        if not fires(system, fired, k):
            assert len(u) == 0
            continue
        inner = np.concatenate([u[:-1] + share * np.diff(u) for share in (0.03, 0.41, 0.97)])
        found = np.concatenate([mu[:-1] + share * np.diff(mu) for share in (0.03, 0.41, 0.97)])
        between = np.repeat(np.diff(u)[None, :], 3, axis=0).ravel() > 1e-9
        expected = plain_aggregate(system, fired, k, inner)
        np.testing.assert_allclose(found[between], expected[between], atol=1e-9)


@settings(max_examples=200)
@given(with_input(mamdani(methods=("centroid", "bisector"))))
def test_centroid_and_bisector_are_those_of_fine_samples(case):
    check_against_samples(*case, 2e-3)


@settings(max_examples=40)
@given(with_input(mamdani(STRAIGHT + CURVED, methods=("centroid", "bisector"))))
def test_curved_outputs_are_those_of_fine_samples(case):
    check_against_samples(*case, 2e-3)


def check_against_samples(system, x, tolerance):
    """Within a share of the universe; NaN exactly where nothing fires or what fires lies outside the universe."""
    out, fired = evaluate(system, x, clamp=False), plain_strengths(system, x)
    for k, variable in enumerate(system.outputs):
        width = variable.high - variable.low
        u = variable.low + (np.arange(SAMPLES) + 0.5) * width / SAMPLES
        mu = plain_aggregate(system, fired, k, u)
        if mu.max() <= 0.0:
            assert np.isnan(out[k])
            continue
        if mu.max() < 1e-6:
            continue  # curved sets this low are within the error of their polylines
        mu = mu / mu.max()
        if system.defuzzification == "centroid":
            expected = np.sum(u * mu) / np.sum(mu)
            assert abs(out[k] - expected) <= tolerance * width
        else:
            # the areas on both sides differ by less than the samples can tell
            left, right = mu[u <= out[k]].sum(), mu[u > out[k]].sum()
            assert abs(left - right) <= 2.0 + tolerance * SAMPLES * mu.mean()


@settings(max_examples=200)
@given(with_input(mamdani()))
def test_defuzzified_is_what_the_aggregate_gives(case):
    """Every method, from the polyline by other formulas; this also checks the closed form against the cells."""
    system, x = case
    out = evaluate(system, x, clamp=False)
    for k in range(len(system.outputs)):
        u, mu = aggregated(system, x, k, clamp=False)
        if len(u) == 0 or not np.any(mu > 0.0):
            assert np.isnan(out[k])
            continue
        np.testing.assert_allclose(out[k], by_polyline(system.defuzzification, u, mu), atol=1e-8 * np.ptp(u), rtol=0)


def by_polyline(method, u, mu):
    """Simpson's rule is exact for a line times a line; maxima by looking at all points."""
    width, middle = np.diff(u), 0.5 * (u[1:] + u[:-1])
    areas = 0.5 * width * (mu[1:] + mu[:-1])
    if method == "centroid":
        moments = width / 6.0 * (u[:-1] * mu[:-1] + 2.0 * middle * (mu[1:] + mu[:-1]) + u[1:] * mu[1:])
        return moments.sum() / areas.sum()
    if method == "bisector":
        done = np.concatenate([[0.0], np.cumsum(areas)])
        i = min(np.searchsorted(done, 0.5 * done[-1]), len(areas)) - 1
        rest, slope = 0.5 * done[-1] - done[i], (mu[i + 1] - mu[i]) / width[i]
        low, high = 0.0, width[i]
        for _ in range(80):  # by halving
            at = 0.5 * (low + high)
            low, high = (at, high) if mu[i] * at + 0.5 * slope * at * at < rest else (low, at)
        return u[i] + low
    top = mu >= mu.max() * (1.0 - 1e-11)
    if method in ("som", "lom"):
        return u[top].min() if method == "som" else u[top].max()
    level = top[1:] & top[:-1] & (width > 0.0)
    return (width * middle)[level].sum() / width[level].sum() if level.any() else np.mean(np.unique(u[top]))


def test_a_curved_output_stays_within_the_stated_error():
    """Of membership, over the whole universe."""
    from holodrive.control.fuzzy import Set
    from holodrive.control.fuzzy.membership import membership, polyline

    u = np.linspace(-1.0, 3.0, 40_001)
    for one in (Set("g", "gaussian", (0.7, 0.01)), Set("w", "gaussian", (9.0, 4.0)), Set("b", "bell", (0.5, 4.0, 1.0))):
        line = np.interp(u, *polyline(one, -1.0, 3.0))
        assert np.max(np.abs(line - membership(one, u))) <= 1.01 * POLYLINE_ERROR
