"""Mounts and scales of mice come back from runs, as well as stated, and what runs cannot tell is said."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_runs import FOOTPRINT_M, MICE, MOUNTS, SCALES, counts_of, end_of, runs, steps_of

from holodrive import geometry
from holodrive.calibration import mice, mouse_fit, mouse_runs
from holodrive.calibration.mice import MiceCalibration, calibrate
from holodrive.calibration.mouse_runs import Accuracy, MouseRun
from holodrive.errors import InputError
from holodrive.types import Array, Pose

EXACT = Accuracy(tape_m=1e-6, turn_rad=1e-6)


def found(of: list[MouseRun], **options: object) -> MiceCalibration:
    """The calibration of the two mice."""
    return calibrate(of, MICE, FOOTPRINT_M, **options)  # type: ignore[arg-type]


def errors(result: MiceCalibration, mounts: tuple[Pose, ...] = MOUNTS, scales: Array = SCALES) -> Array:
    """(4k,) found minus true, scales relative."""
    true = [(m.theta, math.log(s[0]), m.x, m.y) for m, s in zip(mounts, scales, strict=True)]
    each = [math.log(p.value) if p.name == "scale" else p.value for p in result.parameters]
    return np.array(each) - np.ravel(true)


def test_the_end_of_a_run_is_its_arcs_one_after_the_other() -> None:
    """The closed sum agrees with composing poses."""
    steps = steps_of("ahead", np.random.default_rng(0)) * (1.0, 1.0, 300.0)
    np.testing.assert_allclose(mouse_fit.end_of(steps), end_of(steps), atol=1e-12)


@settings(max_examples=25)
@given(
    yaw=st.tuples(*[st.floats(-5.0, 5.0)] * 2),
    scale=st.tuples(*[st.floats(0.9, 1.1)] * 2),
    off=st.tuples(*[st.floats(-0.01, 0.01)] * 4),
    seed=st.integers(0, 1000),
)
def test_perturbed_mounts_come_back(
    yaw: tuple[float, ...], scale: tuple[float, ...], off: tuple[float, ...], seed: int
) -> None:
    """Angles to 5 deg, scales to 10 %, lever arms to 10 mm: found within five standard deviations, which are small."""
    mounts = (
        Pose(off[0], off[1], math.radians(yaw[0])),
        Pose(0.1 + off[2], off[3], math.radians(yaw[1])),
    )
    scales = 1e-5 * np.repeat(np.array(scale)[:, None], 2, axis=1)
    result = found(runs(seed, mounts=mounts, scales=scales))
    sigma = np.sqrt(np.diag(result.covariance))
    assert np.all(np.abs(errors(result, mounts, scales)) < 5.0 * sigma)
    assert np.all(sigma < np.tile([math.radians(0.05), 8e-4, 6e-4, 6e-4], 2))
    assert result.complete
    assert result.notes == ()


def test_exact_measuring_leaves_only_the_counts() -> None:
    result = found(runs(1, accuracy=EXACT))
    assert np.all(np.abs(errors(result)) < np.tile([1e-4, 1e-4, 2e-5, 2e-5], 2))


def test_standard_deviations_are_true() -> None:
    """Over 40 seeds the errors are as large as the covariance says, and so is the sum of squares of the fit."""
    off, fit = [], []
    for seed in range(40):
        result = found(runs(seed))
        error = errors(result)
        off.append(error @ np.linalg.solve(result.covariance, error))
        fit.append(result.chi2)
        assert result.freedom == 4
        assert result.widened == 1.0
    assert abs(np.mean(off) - 8.0) < 3.0 * math.sqrt(16.0 / 40.0)  # chi2 of 8 numbers: mean 8, variance 16
    assert abs(np.mean(fit) - 4.0) < 3.0 * math.sqrt(8.0 / 40.0)


def test_noise_of_the_mice_is_counted_in() -> None:
    """1 % of noise on every reading: still as large as the covariance says."""
    off = []
    for seed in range(20):
        result = found(runs(seed, noise=0.01), noise_relative=0.01)
        error = errors(result)
        off.append(error @ np.linalg.solve(result.covariance, error))
    assert abs(np.mean(off) - 8.0) < 3.0 * math.sqrt(16.0 / 20.0)


def test_each_run_tells_what_it_should() -> None:
    """The spin tells lever arms, both straight runs tell scale and angle, and either of them would do alone."""
    result = found(runs(2))
    for mouse in MICE:
        for axis in "xy":
            first = result.parameter(mouse, axis).excited_by[0]
            assert (first.run, first.needed) == ("spin", True)
            assert first.share > 0.9
        for name in ("yaw", "scale"):
            shares = {each.run: each.share for each in result.parameter(mouse, name).excited_by}
            assert abs(shares["ahead"] - shares["left"]) < 0.05
            assert shares["ahead"] + shares["left"] > 0.95
            assert not any(each.needed for each in result.parameter(mouse, name).excited_by)


def test_axes_of_different_scale_are_told_apart() -> None:
    scales = SCALES * [[1.0, 1.03], [1.0, 1.0]]
    result = found(runs(3, scales=scales), per_axis=True)
    for i, mouse in enumerate(MICE):
        for j, name in enumerate(("scale x", "scale y")):
            each = result.parameter(mouse, name)
            assert abs(each.value - scales[i, j]) < 4.0 * each.sigma
    assert any("axes of mouse one differ by -2.8 %" in note for note in result.notes)
    assert not any("mouse two" in note for note in result.notes)


def test_one_mouse_alone_is_calibrated_too() -> None:
    """It cannot tell turns, which are then taken as measured."""
    both = runs(4)
    for run in both:
        object.__setattr__(run, "counts", run.counts[:, 1:])
        object.__setattr__(run, "way", run.way[1:])
        object.__setattr__(run, "squares", run.squares[:, 1:])
    result = calibrate(both, ("two",), FOOTPRINT_M)
    assert np.all(np.abs(errors(result, MOUNTS[1:], SCALES[1:])) < 4.0 * np.sqrt(np.diag(result.covariance)))
    assert "alone" in result.notes[0]


def test_a_known_track_needs_no_tape() -> None:
    """Any motion that turns will do; what is found is as good as the track."""
    generator = np.random.default_rng(5)
    time = np.linspace(0.0, 60.0, 4000)[:, None]
    twist = np.sin(time * [0.3, 0.37, 0.23] + [0.0, 1.0, 2.0]) * [0.04, 0.04, 0.3]
    steps = twist[:-1] * np.diff(time, axis=0)
    track = np.zeros((len(time), 3))
    for i, step in enumerate(geometry.exp(steps)):
        track[i + 1] = geometry.compose(track[i], step)
    counts = np.concatenate([np.zeros((1, 2, 2)), counts_of(steps, MOUNTS, SCALES, generator)])
    result = found(mouse_runs.tracked("drive", counts, track, Accuracy()))
    assert np.all(np.abs(errors(result)) < 4.0 * np.sqrt(np.diag(result.covariance)))
    assert np.all(np.abs(errors(result)) < np.tile([2e-3, 2e-3, 1e-3, 1e-3], 2))


def names_not_told(result: MiceCalibration) -> set[tuple[str, str]]:
    return {(each.mouse, each.name) for each in result.parameters if not each.told}


def test_without_a_spin_no_lever_arm_is_told() -> None:
    result = found(runs(6, ("ahead", "left")))
    assert names_not_told(result) == {(mouse, axis) for mouse in MICE for axis in "xy"}
    assert result.condition > 1e4
    assert "without a spin nothing tells the lever arm" in result.notes[0]


def test_a_spin_alone_tells_the_lever_arm_only_against_the_scale() -> None:
    result = found(runs(7, ("spin",)))
    assert {("two", name) for name in mice.PARAMETERS} <= names_not_told(result)
    assert math.isinf(result.condition)
    assert "only against the scale" in result.notes[0]


def test_one_straight_run_says_what_nothing_checks() -> None:
    """Scale and angle stand on one length and one direction; scales of two axes cannot be told apart."""
    both = runs(8, ("spin", "ahead"))
    result = found(both)
    assert result.complete
    assert "one way only" in result.notes[0]
    apart = found(both, per_axis=True)
    assert ("two", "scale y") in names_not_told(apart)


def test_whole_turns_do_not_tell_the_point_that_was_turned_about() -> None:
    """Lever arms are then as uncertain as the robot's centre is, and a half turn more tells it."""
    whole, half = found(runs(9, turns=5.0)), found(runs(9, turns=5.5))
    assert whole.parameter("two", "x").sigma == pytest.approx(Accuracy().centre_m, rel=0.05)
    assert half.parameter("two", "x").sigma < 0.15 * whole.parameter("two", "x").sigma
    assert any("half turn" in note for note in whole.notes)


def test_contradicting_runs_widen_the_standard_deviations() -> None:
    """Lengths that are wrong by some millimetres with a tape said to be good to 0.1 mm."""
    good = Accuracy(tape_m=1e-4)
    wrong = runs(10, accuracy=good)
    wrong[1].measured[0].value[0] += 0.005
    result = found(wrong)
    assert result.widened > 5.0
    assert any("contradict" in note for note in result.notes)


def broken(change: object) -> list[MouseRun]:
    """Runs of which one is changed by a function of the runs."""
    out = runs(11)
    change(out)  # type: ignore[operator]
    return out


def dead(each: list[MouseRun]) -> None:
    for run in each:
        run.counts[:, 1] = 0.0
        run.way[1] = 0.0


def dead_half_way(each: list[MouseRun]) -> None:
    each[2].counts[len(each[2].counts) // 2 :, 1] = 0.0


def mirrored(each: list[MouseRun]) -> None:
    for run in each:
        run.counts[:, 1, 1] *= -1.0


def far_apart(each: list[MouseRun]) -> None:
    each[0].measured[0].value[2] /= 11.0


def empty(each: list[MouseRun]) -> None:
    object.__setattr__(each[1], "counts", np.empty((0, 2, 2)))


def not_finite(each: list[MouseRun]) -> None:
    each[1].counts[5, 0, 0] = math.nan


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (dead, "mouse two counted 0 in run 'ahead' where one counted"),
        (dead_half_way, "contradict each other"),
        (mirrored, "mouse two sees runs 'ahead' and 'left' mirrored"),
        (far_apart, "outside its footprint of 0.29 m"),
        (empty, "run 'ahead' is empty"),
        (not_finite, "not finite"),
        (lambda each: each.clear(), "found none"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(change: object, words: str) -> None:
    with pytest.raises(InputError) as caught:
        found(broken(change))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mouse_runs.spin("s", np.zeros((5, 1, 2)), 0.0, None, Accuracy()), "turns by a known angle"),
        (lambda: mouse_runs.straight("a", "ahead", np.zeros((5, 1, 2)), (0.0, 0.0), None, Accuracy()), "known length"),
        (lambda: mouse_runs.tracked("t", np.zeros((5, 1, 2)), np.full((5, 3), np.nan), Accuracy()), "no two poses"),
        (lambda: Accuracy(tape_m=0.0), "above 0"),
    ],
)
def test_a_run_of_which_nothing_is_known_is_none(make: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()  # type: ignore[operator]
