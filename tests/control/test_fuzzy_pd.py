"""Laws of the fuzzy-PD tracker."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import holodrive as hd
from holodrive import control, planning, references
from holodrive.control import fuzzy_pd, pid
from holodrive.control.fuzzy_pd import FuzzyPd
from holodrive.errors import InputError

GRID = np.stack(np.meshgrid(np.linspace(-1.3, 1.3, 53), np.linspace(-1.3, 1.3, 53), indexing="ij"), axis=-1)
SYSTEMS = [fuzzy_pd.system(), fuzzy_pd.system(0.3, 0.6), fuzzy_pd.system(0.7, 0.2)]


@pytest.mark.parametrize("system", SYSTEMS)
def test_the_fuzzy_system_is_odd_and_zero_at_zero(system):
    u = system.evaluate(GRID)[..., 0]
    assert_allclose(u[::-1, ::-1], -u, atol=1e-15)
    assert system.evaluate((0.0, 0.0))[0] == 0.0
    assert_allclose(np.abs(u).max(), 1.0)


@pytest.mark.parametrize("system", SYSTEMS)
def test_more_error_never_gives_less_action(system):
    u = system.evaluate(GRID)[..., 0]
    assert np.min(np.diff(u, axis=0)) >= -1e-15
    assert np.min(np.diff(u, axis=1)) >= -1e-15
    assert_allclose(u, np.swapaxes(u, 0, 1), atol=1e-15)  # error and rate weigh the same


def test_the_sets_are_a_ruspini_partition():
    """At any error the memberships sum to 1, so there is always a rule and no weighting of weights."""
    from holodrive.control.fuzzy.evaluation import membership

    x = np.linspace(-1.0, 1.0, 401)
    for system in SYSTEMS:
        assert_allclose(sum(membership(one, x) for one in system.inputs[0].sets), 1.0, atol=1e-15)


def test_near_zero_it_is_a_pd():
    """u = e + de inside the first sets when both smalls are alike."""
    inside = GRID[np.sum(np.abs(GRID), axis=-1) <= 0.5]
    assert_allclose(fuzzy_pd.system().evaluate(inside)[:, 0], np.sum(inside, axis=1), atol=1e-15)


def test_a_small_error_is_answered_as_the_pid_without_integral_answers_it():
    """Same gains, feed-forward, limits and arrival: the same run."""
    robot = hd.load("hybrid3_table_x")
    plug = FuzzyPd()
    params = {
        "kp": plug.gain_m_s / plug.span_m, "kd": plug.gain_m_s / plug.span_m_s, "ki": 0.0, "ki_theta": 0.0,
        "kp_theta": plug.gain_rad_s / plug.span_rad, "kd_theta": plug.gain_rad_s / plug.span_rad_s,
    }  # fmt: skip
    table = planning.follow(planning.circle(0.5), 0.05, 0.05)
    runs = [
        hd.rollout(robot, None, name, params=given, t=5.0, reference=table, starts=(0.52, 0.01, 0.02), log_every=10)
        for name, given in (("fuzzy_pd", {}), ("pid", params))
    ]
    assert_allclose(runs[0].log, runs[1].log, atol=1e-9)


def test_it_goes_no_faster_than_the_pid_may():
    robot = hd.load("hybrid3_table_x")
    far = references.fixed_goal((10.0, 5.0, 3.0))
    plugs = [control.compiled(name) for name in ("fuzzy_pd", "pid")]
    limits = [plug.pack(robot)[[7, 8]] for plug in plugs]
    assert_allclose(*limits)
    run = hd.rollout(robot, None, "fuzzy_pd", params={"gain_m_s": 5.0}, t=2.0, reference=far, log_every=1)
    assert np.nanmax(np.hypot(run.column("vx"), run.column("vy"))) <= limits[0][0] * (1 + 1e-6)


@pytest.mark.parametrize("module", [fuzzy_pd, pid])
def test_the_bounds_for_tuning_are_fields_around_their_defaults(module):
    plug = {fuzzy_pd: FuzzyPd, pid: pid.Pid}[module]()
    for name, (low, high) in module.BOUNDS.items():
        assert low <= getattr(plug, name) <= high
        assert type(plug)(**{name: low}) != type(plug)(**{name: high})


@pytest.mark.parametrize(
    ("params", "word"),
    [
        ({"small_in": 1.0}, "between 0 and 1"),
        ({"small_out": 0.0}, "above 0"),
        ({"span_m": -1.0}, "above 0"),
        ({"gain_rad_s": math.nan}, "NaN"),
        ({"span": 1.0}, "Did you mean 'span_m'"),
    ],
)
def test_parameters_that_cannot_be_are_refused(params, word):
    with pytest.raises(InputError, match=word):
        control.plug("fuzzy_pd", params)
