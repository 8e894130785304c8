"""Equations 2, 15, 19 and 23 of the paper beside the one wheel equation."""

import math

import numpy as np

from holodrive.experiments.claims import Claim, claimed
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed, robots
from holodrive.kinematics import Chassis, Wheel
from holodrive.types import Array

_AXES = ("vx", "vy", "omega")


def equations(setting: Setting) -> Result:
    """Claims about the kinematics."""
    chassis = Chassis.of(robots.printed())
    forward = np.asarray(np.linalg.inv(chassis.jacobian), dtype=np.float64)
    claims = (*_inverse(chassis.jacobian), *_forward(forward), _pseudo_inverse(chassis), *_roller(), *_quality(chassis))
    return Result(claims, data={"jacobian": chassis.jacobian.tolist(), "forward": forward.tolist()})


def _inverse(jacobian: Array) -> list[Claim]:
    claims = [
        claimed("Eq. 19", f"wheel {i + 1} per {_AXES[j]}", printed.EQ_19[i][j], float(jacobian[i, j]), within=0.003)
        for i, j in ((0, 1), (0, 2), (1, 0), (1, 1))
    ]
    radius = float(100.0 / jacobian[0, 1])
    claims.append(
        Claim(
            "Table VI",
            "wheel radius",
            printed.WHEEL_RADIUS_CM,
            radius,
            "contradicts itself",
            "cm",
            f"Eq. 19 needs {radius:.2f} cm, half of Table I's {printed.WHEEL_DIAMETER_CM:g} cm; "
            f"with 5 cm its entries were 20, 27.3 and 7.3",
        )
    )
    return claims


def _forward(forward: Array) -> list[Claim]:
    claims = []
    for i in range(3):
        for j in range(3):
            said, found = printed.EQ_23[i][j], float(forward[i, j])
            if abs(found) < 1e-12:
                continue
            wrong = said * found < 0.0
            note = "wrong sign: Eq. 23 is not the inverse of Eq. 19" if wrong else ""
            claim = claimed("Eq. 23", f"{_AXES[i]} per wheel {j + 1}", said, found, within=0.01, note=note)
            claims.append(
                Claim(claim.where, claim.what, said, found, "contradicts itself", note=note) if wrong else claim
            )
    return claims


def _pseudo_inverse(chassis: Chassis) -> Claim:
    """Eq. 15 gives the right numbers for a definition that does not exist for one wheel."""
    jacobian = chassis.jacobian[:1]
    return Claim(
        "Eq. 15",
        "inverse of one wheel's 1 x 3 row: rank of TᵀT",
        "(TᵀT)⁻¹Tᵀ",
        f"rank {np.linalg.matrix_rank(jacobian.T @ jacobian)} of 3",
        "cannot be",
        note="TᵀT is singular for one wheel; the closed form that is printed is Tᵀ(TTᵀ)⁻¹. "
        "Three wheels together have an inverse: that is Eq. 18.",
    )


def _roller() -> list[Claim]:
    """Eq. 2 at vx = 0.1 m/s for a Mecanum wheel: speed of the roller on the ground."""
    wheel = Wheel.mecanum(*_polar(0.23, -2.0 * math.pi / 3.0), math.radians(-30.0), 0.051, math.pi / 4.0)
    vx = 0.1
    speed = float(Chassis([wheel, *_others()]).jacobian[0] @ np.array([vx, 0.0, 0.0]))
    simple = 0.051 * speed / math.cos(math.pi / 4.0)
    gamma, beta = math.pi / 4.0, -2.0 * math.pi / 3.0
    exact = math.cos(beta) * vx / math.sin(gamma)  # second row of Eq. 14
    return [
        Claim(
            "Eq. 2",
            "roller speed of wheel 2 at vx = 0.1 m/s",
            simple,
            exact,
            "contradicts itself",
            "m/s",
            "Eq. 14, second row, gives ours; Eq. 2 holds only where the wheel's centre does not move along its plane",
        )
    ]


def _quality(chassis: Chassis) -> list[Claim]:
    omni = [
        Wheel.omni(*_polar(0.23, a), a + math.pi / 2.0, 0.051) for a in (0.0, *np.radians([-120.0, 120.0]).tolist())
    ]
    three = Chassis(omni)
    note = "of J diag(1, 1, 1/l): three omni wheels are better placed, and faster ahead with the same motors"
    limit = printed.MOTOR_RPM * math.pi / 30.0
    ahead = [limit / float(np.max(np.abs(c.jacobian @ [1.0, 0.0, 0.0]))) for c in (chassis, three)]
    needed = printed.FLC[0] / printed.FLC[1]
    return [
        Claim("text", "condition: hybrid, three omni", "—", f"{chassis.condition:.2f}, {three.condition:.2f}",
              "not comparable", note=note),
        Claim("Tables II, X", "speed ahead at 22 rpm", needed, 100.0 * ahead[0], "cannot be", "cm/s",
              "the path of Table X in its time needs the printed speed; the printed motor gives ours"),
        Claim("text", "time of three omni wheels over time of hybrid", printed.THREE_OMNI_S / printed.FLC[1],
              ahead[0] / ahead[1], "not comparable", "",
              "with the same motors three omni wheels are faster ahead, not slower; their set-up is not described"),
    ]  # fmt: skip


def _others() -> list[Wheel]:
    return [
        Wheel.omni(*_polar(0.23, 0.0), math.pi / 2.0, 0.051),
        Wheel.mecanum(*_polar(0.23, 2.0 * math.pi / 3.0), math.radians(-150.0), 0.051, -math.pi / 4.0),
    ]


def _polar(distance: float, bearing: float) -> tuple[float, float]:
    return distance * math.cos(bearing), distance * math.sin(bearing)
