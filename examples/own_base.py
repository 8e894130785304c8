"""A base from wheels in code: one omni wheel in front, two Mecanum wheels behind, and what it can do."""

from math import cos, radians, sin

import numpy as np

import holodrive as hd

ARM_M, RADIUS_M = 0.23, 0.051


def at(bearing_deg: float) -> tuple[float, float]:
    """A place on the circle of the wheels."""
    return ARM_M * cos(radians(bearing_deg)), ARM_M * sin(radians(bearing_deg))


chassis = hd.Chassis(
    {
        "front": hd.Wheel.omni(*at(0), yaw=radians(90), radius=RADIUS_M),
        "right": hd.Wheel.mecanum(*at(-120), yaw=radians(-30), radius=RADIUS_M, roller=radians(45)),
        "left": hd.Wheel.mecanum(*at(120), yaw=radians(-150), radius=RADIUS_M, roller=radians(-45)),
    }
)
with np.printoptions(precision=3, suppress=True):
    print("wheel speeds per (vx, vy, omega):", chassis.jacobian, sep="\n")
print(f"rank {chassis.rank}, condition {chassis.condition:.2f}")

speeds = chassis.inverse((0.1, 0.0, 0.0)).speeds
print("0.1 m/s ahead needs", dict(zip(chassis.names, np.round(speeds, 3).tolist(), strict=True)), "rad/s")
print("and back:", np.round(chassis.forward(speeds), 6).tolist())

try:  # two omni wheels that roll the same way cannot push sideways
    hd.Chassis([hd.Wheel.omni(0.0, side, yaw=0.0, radius=RADIUS_M) for side in (0.2, -0.2)])
except hd.HolodriveError as error:
    print("refused:", error)
