"""The robot of the paper's section 3 with its motors, and the gains that the paper does not print."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from holodrive import build
from holodrive.experiments.swerve import printed
from holodrive.robots.spec import Motor, Robot, SpeedLoop, WheelSpec

NO_MASS_KG = 0.01  # the paper's model is kinematic: "no consideration given to the mass"
MASS_KG = 20.0  # of the variant with a mass; assumed
STEERING_RAD_S = 60.0  # beyond what any of these motors reaches: steering is limited by its motor alone
_RPM = math.pi / 30.0


@dataclass(frozen=True)
class Setup:
    """A robot and its controller; gains of the loops are those at the output shaft.

    Attributes:
        name: in tables and pictures.
        motor: of all drives and steerings, a name of the motor library.
        k: gain of position and heading [1/s].
        kp, ki: of the drives' speed loop [V s/rad, V/rad].
        ks, kvs: of the steerings: voltage per error and per rate [V/rad, V s/rad].
        limit_rpm: of the wheels.
        mass_kg: of the robot.
        feed_forward: share of the commanded wheel speed that becomes voltage at once; our own boards have 1.
        drive: how BLDC motors are fed; "" leaves what the library says.
    """

    name: str
    motor: str
    k: float
    kp: float
    ki: float
    ks: float
    kvs: float
    limit_rpm: float
    mass_kg: float = NO_MASS_KG
    feed_forward: float = 0.0
    drive: Literal["", "averaged", "six_step", "foc"] = ""

    @property
    def robot(self) -> Robot:
        """The robot with these motors and loops."""
        bare = _bare(self.motor, self.mass_kg)
        motor = bare.wheels[0].motor
        if self.drive:
            motor = replace(motor, drive=self.drive)
        per_unit = motor.no_load_speed_rad_s / motor.voltage_v  # rad/s per volt
        loop = SpeedLoop(self.kp * per_unit, self.ki * per_unit, filter_s=0.0, feed_forward=self.feed_forward)
        return replace(bare, wheels=tuple(self._wheel(wheel, motor) for wheel in bare.wheels), speed_loop=loop, text="")

    def _wheel(self, wheel: WheelSpec, motor: Motor) -> WheelSpec:
        assert wheel.steering is not None
        steering = replace(wheel.steering, motor=motor, kp_v_rad=self.ks, kd_v_s_rad=self.kvs)
        return replace(wheel, motor=motor, steering=steering, max_speed_rad_s=self.limit_rpm * _RPM)

    @property
    def gains(self) -> str:
        """All of them in one line."""
        return f"K {self.k:g}, drive {self.kp:g} and {self.ki:g}, steering {self.ks:g} and {self.kvs:g}"


@lru_cache(maxsize=16)
def _bare(motor: str, mass_kg: float) -> Robot:
    base = "swerve3_dc" if motor.startswith("dc") else "swerve3_motors"
    overrides = {
        "defaults.wheel.motor": motor,
        "defaults.wheel.steering.motor": motor,
        "defaults.wheel.steering.rate": f"{STEERING_RAD_S} rad/s",
        "robot.mass": f"{mass_kg} kg",
    }
    return build.load(base, overrides)


# Found with `search`: gains that show the paper's picture. Section 3 prints none.
BLDC = Setup("BLDC six-step", "bldc-16pole-9to1", 0.6, 0.45, 4.5, 6.0, 0.3, printed.BLDC_PEAK_RPM)
FOC = replace(BLDC, name="BLDC FOC", motor="bldc-sine-16pole-9to1")
AVERAGED = replace(BLDC, name="BLDC averaged", drive="averaged")
DC_HENRY = Setup("DC 2.7 H", "dc-hekimoglu-2.7h", 1.3, 2.0, 0.33, 12.0, 2.4, printed.DC_PEAK_RPM)
DC_MILLI = Setup("DC 2.7 mH", "dc-hekimoglu-2.7mh", 1.3, 0.5, 2.0, 12.0, 1.0, printed.DC_PEAK_RPM)
PAPER = (BLDC, FOC, AVERAGED, DC_HENRY, DC_MILLI)
