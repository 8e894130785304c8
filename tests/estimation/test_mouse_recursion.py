"""Claims about the recursion of Keek et al., eq. 1 to 7: as printed, as corrected, as closed form, as estimators."""

import json
import math
from pathlib import Path
from typing import Any

import ground
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_mouse_odometry import with_mice

from holodrive import estimation, geometry, robots
from holodrive.errors import InputError
from holodrive.estimation import mouse_recursion
from holodrive.types import Array, Observation, Pose, WheelState

START = Pose(0.4, -1.2, 2.5)


@pytest.fixture
def vectors(shared_data: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((shared_data / "paper_vectors.json").read_text())["seed002"]
    return data


def in_degrees(poses: Array) -> Array:
    return np.column_stack([poses[1:, :2], np.degrees(poses[1:, 2])])


@pytest.mark.parametrize(
    ("form", "key"), [("printed", "literal_as_printed"), ("corrected", "corrected"), ("closed_form", "closed_form")]
)
def test_free_increments_of_the_reference(vectors: dict[str, Any], form: str, key: str) -> None:
    case = vectors["localisation_eq1_7_free_increments"]
    poses = getattr(mouse_recursion, form)(case["increments_x1y1x2y2"], case["D"])
    np.testing.assert_allclose(in_degrees(poses), case[key], atol=1e-9)


@pytest.mark.parametrize(("form", "key"), [("corrected", "paper_corrected"), ("rigid", "exact")])
def test_rigid_motions_of_the_reference(vectors: dict[str, Any], form: str, key: str) -> None:
    case = vectors["localisation_rigid_motion"]
    poses = getattr(mouse_recursion, form)(case["increments"], case["D"])
    np.testing.assert_allclose(in_degrees(poses), case[key], atol=1e-9)


def test_the_four_branches_of_the_heading(vectors: dict[str, Any]) -> None:
    """Eq. 7 is atan2(x, y), clockwise from +Y, with -180 degrees where both are possible."""
    for case in vectors["eq7_heading_deg"]:
        found = mouse_recursion.heading(float(case["xdiff"]), float(case["ydiff"]))
        assert math.degrees(found) == pytest.approx(case["alpha"], abs=1e-12)
    assert math.isnan(mouse_recursion.heading(0.0, 0.0))


def test_the_corrected_recursion_is_its_closed_form() -> None:
    """To 1e-10 mm and rad over 200 runs of 300 samples, a fifth of the numbers zero."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        steps = rng.normal(size=(300, 4)) * rng.choice([0.0, 1.0], p=[0.2, 0.8], size=(300, 4))
        difference = mouse_recursion.corrected(steps, 100.0) - mouse_recursion.closed_form(steps, 100.0)
        difference[:, 2] = geometry.wrap(difference[:, 2])
        assert np.abs(difference).max() < 1e-10


@given(angle=st.floats(-20.0, 20.0))
def test_headings_are_wrapped_as_the_paper_measures_them(angle: float) -> None:
    wrapped = mouse_recursion.wrap(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.remainder(wrapped - angle, math.tau) == pytest.approx(0.0, abs=1e-12)


def test_what_each_form_costs_on_rigid_motions() -> None:
    """The printed sign is lost, the corrected recursion strays by tenths, the rigid form by counts alone."""
    rng, errors = np.random.default_rng(1), {"printed": [], "corrected": [], "rigid": []}
    for _ in range(8):
        moves = ground.motion(rng, 30.0, 0.015)
        told = ground.counts(ground.ways(moves, ground.PAIR), rng)
        steps = np.stack([-told[:, 0, 1], told[:, 0, 0], -told[:, 1, 1], told[:, 1, 0]], axis=-1)
        end = ground.path(moves)[-1]
        for form, errs in errors.items():
            x, y, alpha = getattr(mouse_recursion, form)(steps, 0.1)[-1]
            errs.append((math.hypot(y - end[0], -x - end[1]), abs(math.remainder(-alpha - end[2], math.tau))))
    distance = {form: np.median(errs, axis=0)[0] for form, errs in errors.items()}
    turn = {form: np.median(errs, axis=0)[1] for form, errs in errors.items()}
    assert distance["rigid"] < 0.02e-3 < 0.05e-3 < distance["corrected"] < 1e-3 < 10e-3 < distance["printed"]
    assert turn["rigid"] < math.radians(0.01) < math.radians(0.02) < turn["corrected"] < math.radians(1.0)
    assert turn["printed"] > math.radians(10.0)


# --- as estimators ----------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["printed", "corrected"])
def test_the_estimator_is_the_recursion_from_the_start_pose_on(form: str) -> None:
    robot, rng = robots.load("mecanum4_mice"), np.random.default_rng(4)
    told = ground.counts(ground.ways(0.3 * ground.motion(rng, 6.0, 0.015), ground.PAIR), rng)
    steps = np.stack([-told[:, 0, 1], told[:, 0, 0], -told[:, 1, 1], told[:, 1, 0]], axis=-1)
    right, ahead, alpha = getattr(mouse_recursion, form)(steps, 0.1).T
    wanted = geometry.compose(START, np.stack([ahead, -right, -np.unwrap(alpha)], axis=-1))
    loop = estimation.estimator(f"mouse_{form}", robot)
    loop.reset(START)
    blind = WheelState(np.full(4, np.nan), np.full(4, np.nan), np.zeros(0))
    mice = np.concatenate([np.zeros((1, 2, 2)), told])
    found = [loop.step(Observation(0.015 * k, 0.015, blind, mice=seen)).pose for k, seen in enumerate(mice)]
    np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.mark.parametrize(
    "mounts",
    [
        (Pose(0.0, 0.05, 0.0), Pose(0.1, 0.05, 0.0)),
        (Pose(0.1, 0.0, 0.0), Pose(0.0, 0.0, 0.0)),
        (Pose(0.0, 0.0, 0.0), Pose(0.0, 0.1, 0.0)),
        (Pose(0.0, 0.0, 0.0), Pose(0.1, 0.0, math.pi / 2)),
        (Pose(0.0, 0.0, 0.0), Pose(0.1, 0.0, 0.0), Pose(-0.1, 0.0, 0.0)),
    ],
)
@pytest.mark.parametrize("form", ["printed", "corrected"])
def test_another_mounting_is_refused_in_one_line(form: str, mounts: tuple[Pose, ...]) -> None:
    with pytest.raises(InputError, match="two mice on one forward axis") as refused:
        estimation.plug(f"mouse_{form}").pack(with_mice(mounts))
    assert "\n" not in str(refused.value)


def test_increments_and_distances_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match=r"\(3, 2\), expected \(N, 4\)"):
        mouse_recursion.printed(np.zeros((3, 2)), 0.1)
    with pytest.raises(InputError, match="must be above 0"):
        mouse_recursion.corrected(np.zeros((3, 4)), 0.0)
