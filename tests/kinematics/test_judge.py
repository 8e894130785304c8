"""Rank and condition: the verdict is that of a 50-digit SVD, and the lost motion is named."""

import math

import mpmath as mp
import numpy as np
import pytest

from holodrive import robots
from holodrive.errors import ChassisError
from holodrive.kinematics import Chassis, Wheel
from holodrive.kinematics.judge import MAX_CONDITION, judge

mp.mp.dps = 50


def exact_values(wheels):
    """Singular values of J diag(1, 1, 1/L_c), largest first, in 50 digits from the wheels' own numbers."""
    rows, levers = [], []
    mixed = len({wheel.steered for wheel in wheels}) == 2
    mean_radius = sum(mp.mpf(w.radius) for w in wheels) / len(wheels)
    for w in wheels:
        x, y, yaw, r = (mp.mpf(value) for value in (w.x, w.y, w.yaw, w.radius))
        if w.steered:
            c, s, k = mp.cos(yaw), mp.sin(yaw), 1 / mean_radius if mixed else mp.mpf(1)
            rows += [[k * c, k * s, k * (x * s - y * c)], [-k * s, k * c, k * (x * c + y * s)]]
            levers.append(mp.hypot(x, y))
        else:
            axis = yaw + mp.mpf(w.roller)
            ax, ay, push = mp.cos(axis), mp.sin(axis), mp.cos(mp.mpf(w.roller))
            rows.append([ax / (r * push), ay / (r * push), (x * ay - y * ax) / (r * push)])
            other = yaw - mp.mpf(w.roller)
            ox, oy = mp.cos(other), mp.sin(other)
            levers.append(max(abs(x * ay - y * ax), abs(x * oy - y * ox)) / abs(push))
    length = max(sum(levers), sum(mp.hypot(w.x, w.y) for w in wheels) / 10) / len(wheels)
    matrix = mp.matrix([[a, b, c / (length or 1)] for a, b, c in rows])
    # square of the values from the 3 x 3 normal matrix: 50 digits leave 25 for the smallest
    values = mp.eigsy(matrix.T * matrix, eigvals_only=True)
    return sorted((mp.sqrt(max(value, 0)) for value in values), reverse=True)


def random_layout(rng):
    """Three to five wheels: at random, parallel, concurrent, or nearly so."""
    count = int(rng.integers(3, 6))
    kind = rng.choice(["random", "parallel", "concurrent", "swerve", "mixed"])
    off = 0.0 if rng.random() < 0.4 else 10.0 ** -rng.uniform(2.0, 9.0)
    meet, common = rng.uniform(-0.5, 0.5, 2), rng.uniform(-math.pi, math.pi)
    wheels = []
    for i in range(count):
        x, y = rng.uniform(-0.5, 0.5, 2)
        roller, radius = rng.uniform(-1.2, 1.2), rng.uniform(0.02, 0.1)
        axis = {"parallel": common, "concurrent": math.atan2(meet[1] - y, meet[0] - x)}.get(
            str(kind), rng.uniform(-math.pi, math.pi)
        )
        axis += off * rng.normal()
        if kind == "swerve" or (kind == "mixed" and i == 0):
            # modules on one point are the singular case of swerve
            wheels.append(
                Wheel.swerve(meet[0] + off * rng.normal(), meet[1] + off * rng.normal(), radius, name=f"w{i}")
            )
        else:
            wheels.append(Wheel.mecanum(x, y, axis - roller, radius, roller, name=f"w{i}"))
    return wheels


@pytest.mark.parametrize("seed", range(8))
def test_the_verdict_equals_a_50_digit_svd(seed):
    """400 layouts, many of them exactly or nearly singular: same rank, same condition, same refusal."""
    rng = np.random.default_rng(seed)
    refused = 0
    for _ in range(50):
        wheels = random_layout(rng)
        values = exact_values(wheels)
        condition = values[0] / values[2] if values[2] > mp.mpf(10) ** -22 * values[0] else mp.inf
        rank = sum(value * MAX_CONDITION >= values[0] for value in values)
        try:
            chassis = Chassis(wheels)
        except ChassisError:
            refused += 1
            assert condition > MAX_CONDITION
            verdict = judge(wheels, np.concatenate([w.rows for w in wheels]))
            if not any(w.steered for w in wheels):
                assert verdict.rank == rank < 3
                assert len(verdict.lost) == 3 - rank
        else:
            assert condition <= MAX_CONDITION
            assert chassis.rank == rank == 3
            assert chassis.condition == pytest.approx(float(condition), rel=1e-9 * max(1.0, float(condition) / 1e3))
    assert refused > 5


def test_parallel_axes_lose_a_direction_and_are_named():
    wheels = {name: Wheel.omni(x, y, 0.0, 0.05) for name, x, y in (("a", 0, 0.2), ("b", 0.1, -0.2), ("c", -0.2, 0.1))}
    with pytest.raises(ChassisError, match=r"cannot move sideways \(along y\): the push axes of a, b, c are parallel"):
        Chassis(wheels)
    turned = {name: Wheel.omni(w.x, w.y, math.pi / 2, 0.05) for name, w in wheels.items()}
    with pytest.raises(ChassisError, match=r"cannot move forwards or back \(along x\)"):
        Chassis(turned)
    slanted = {name: Wheel.omni(w.x, w.y, 0.5, 0.05) for name, w in wheels.items()}
    with pytest.raises(ChassisError, match=r"cannot move along the direction at 118\.6 deg"):
        Chassis(slanted)


def test_axes_through_one_point_lose_the_rotation_about_it():
    def towards(x, y, px, py):
        return Wheel.omni(x, y, math.atan2(py - y, px - x), 0.05)

    places = ((0.2, 0.0), (-0.1, 0.2), (-0.1, -0.2))
    with pytest.raises(ChassisError, match="it cannot turn in place"):
        Chassis([towards(x, y, 0.0, 0.0) for x, y in places])
    with pytest.raises(
        ChassisError, match=r"rotation about \(0\.3, 0\.1\) m turns no wheel.*all meet in \(0\.3, 0\.1\) m"
    ):
        Chassis([towards(x, y, 0.3, 0.1) for x, y in places])


def test_mecanum_wheels_with_crossed_rollers_cannot_turn_on_a_square_base():
    places = (("fl", 0.2, 0.2, 1), ("fr", 0.2, -0.2, -1), ("rl", -0.2, 0.2, -1), ("rr", -0.2, -0.2, 1))
    with pytest.raises(
        ChassisError, match=r"cannot turn in place: the push axes of fl, fr, rl, rr all meet in \(0, 0\)"
    ):
        Chassis({name: Wheel.mecanum(x, y, 0.0, 0.03, side * math.pi / 4) for name, x, y, side in places})


def mecanum_base(lx, ly, mounted=1):
    places = (("fl", lx, ly, -1), ("fr", lx, -ly, 1), ("rl", -lx, ly, 1), ("rr", -lx, -ly, -1))
    return {name: Wheel.mecanum(x, y, 0.0, 0.03, mounted * side * math.pi / 4) for name, x, y, side in places}


@pytest.mark.parametrize(("lx", "ly"), [(0.2, 0.15), (0.15, 0.2), (0.3, 0.1)])
def test_rollers_mounted_the_other_way_round_show_in_the_condition(lx, ly):
    """The lever falls from lx + ly to |lx - ly|: condition 7 on 0.20 x 0.15 m (the papers' specification, part D)."""
    right, wrong = Chassis(mecanum_base(lx, ly)), Chassis(mecanum_base(lx, ly, -1))
    assert right.characteristic_length == wrong.characteristic_length == pytest.approx(lx + ly)
    assert right.condition == pytest.approx(1.0)
    assert wrong.condition == pytest.approx((lx + ly) / abs(lx - ly))


def test_nearly_square_bases_with_crossed_rollers_warn():
    chassis = Chassis(mecanum_base(0.2, 0.18, -1))
    assert chassis.condition == pytest.approx(19.0)
    assert "is above 10" in chassis.warnings[0]


@pytest.mark.parametrize(
    ("name", "condition"),
    [("hybrid3", 4.540015197), ("mecanum4", 1.0), ("polimi_mecanum4", 1.0), ("omni3", math.sqrt(2)),
     ("optiodom_omni3", math.sqrt(2)), ("omni4", math.sqrt(2)), ("swerve3", 1.0), ("swerve4", 1.0)],
)  # fmt: skip
def test_the_catalogs_conditions_are_the_specifications(name, condition):
    assert Chassis.of(robots.load(name)).condition == pytest.approx(condition, rel=1e-9)


def test_three_wheels_on_one_line_are_told_so():
    """Three identical wheels push along one line: no point of it is where they meet."""
    wheel = Wheel.omni(0.2, 0.1, math.pi / 2, 0.05)
    said = (
        r"cannot move forwards or back \(along x\); it cannot turn about any point of one line: "
        r"the push axes of wheel1, wheel2, wheel3 lie on one line, at 90 deg through \(0\.2, 0\) m"
    )
    with pytest.raises(ChassisError, match=said):
        Chassis([wheel] * 3)
    along = [Wheel.omni(0.1 * k, 0.1 * k, math.pi / 4, 0.05) for k in (-1, 0.5, 1)]
    with pytest.raises(
        ChassisError, match=r"at 135\.0 deg; it cannot turn about any point of one line.*at 45 deg through \(0, 0\) m"
    ):
        Chassis(along)
    fixed_on_module = [Wheel.swerve(0.1, 0.0, 0.05), Wheel.omni(0.1, 0.0, 0.3, 0.05), Wheel.omni(0.1, 0.0, 0.3, 0.05)]
    with pytest.raises(ChassisError, match=r"all meet in \(0\.1, 0\)"):
        Chassis(fixed_on_module)


def test_rollers_at_30_degrees_make_the_hybrid_singular():
    third, gamma = 2.0 * math.pi / 3.0, math.pi / 6
    with pytest.raises(ChassisError, match=r"rotation about \(.*\) m turns no wheel"):
        Chassis(
            [
                Wheel.from_paper(0.0, 0.0, -math.pi / 2, 0.23, 0.051),
                Wheel.from_paper(-third, -third, gamma, 0.23, 0.051),
                Wheel.from_paper(third, third, -gamma, 0.23, 0.051),
            ]
        )


def test_too_few_wheels_are_counted():
    with pytest.raises(ChassisError, match=r"2 fixed wheels .* cannot drive three motions"):
        Chassis([Wheel.omni(0.1, 0.0, 1.0, 0.05), Wheel.omni(-0.1, 0.0, 2.0, 0.05)])
    with pytest.raises(ChassisError, match="cannot turn in place: the steered wheels wheel1 stand on one point"):
        Chassis([Wheel.swerve(0.0, 0.0, 0.05)])
    assert Chassis([Wheel.swerve(0.2, 0.0, 0.05), Wheel.swerve(-0.2, 0.0, 0.05)]).rank == 3
