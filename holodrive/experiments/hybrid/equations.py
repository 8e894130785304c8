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
    claims = (*_inverse(chassis.jacobian), *_forward(forward), _pseudo_inverse(), *_roller(), *_quality(chassis))
    return Result(claims, data={"jacobian": chassis.jacobian.tolist(), "forward": forward.tolist()})


def _inverse(jacobian: Array) -> list[Claim]:
    claims = []
    for i in range(3):
        for j in range(3):
            said, ours = printed.EQ_19[i][j], float(jacobian[i, j])
            if said == 0.0:
                continue
            digit = 0.1 if said == 19.6 else 0.01  # one unit of the last printed digit
            note = f"4.52 needs {said * 5.1:.2f} cm from the centre to the wheels; Table VI has 23 cm" if j == 2 else ""
            claims.append(
                claimed("Eq. 19", f"wheel {i + 1} per {_AXES[j]}", said, ours, within=digit / abs(said), note=note)
            )
    radius = float(100.0 / jacobian[0, 1])
    note = (
        f"Eq. 19 needs {radius:.2f} cm, half of Table I's {printed.WHEEL_DIAMETER_CM:g} cm; "
        "with 5 cm its entries were 20, 27.3 and 7.3"
    )
    claims.append(Claim("Table VI", "wheel radius", printed.WHEEL_RADIUS_CM, radius, "contradicts itself", "cm", note))
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


def _pseudo_inverse() -> Claim:
    """Eq. 15 gives the right numbers for a definition that does not exist: T of one wheel is 2 x 3."""
    alpha = beta = -2.0 * math.pi / 3.0
    gamma, distance, radius = math.pi / 4.0, 0.23, 0.051
    turn = beta - gamma
    t = np.array(
        [
            np.array([math.cos(turn), math.sin(turn), distance * math.sin(turn - alpha)]) / (-radius * math.sin(gamma)),
            np.array([math.cos(beta), math.sin(beta), distance * math.sin(beta - alpha)]) / math.sin(gamma),
        ]
    )
    return Claim(
        "Eq. 15",
        "rank of TᵀT of one wheel (wheel 2), which its inverse needs",
        3.0,
        float(np.linalg.matrix_rank(t.T @ t)),
        "cannot be",
        note="T is 2 x 3 (Eq. 14), so (TᵀT)⁻¹ does not exist; the closed form that is printed is Tᵀ(TTᵀ)⁻¹",
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
