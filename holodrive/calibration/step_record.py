"""One open-loop step as it was measured: time and displacement after a PWM value was commanded out of standstill."""

import math
from dataclasses import dataclass

import numpy as np

from holodrive.types import Array


@dataclass(frozen=True, eq=False)
class StepRecord:
    """One step.

    Attributes:
        group: "W1W4", "W2W3", or a wheel's name.
        direction: "forward" or "backward".
        pwm: counts, above 0 in both directions.
        time: (N,) [s], rising; the PWM is held from `command_time` to the last of them.
        x, y: (N,) displacement [m] since the command in the robot's frame at that moment (x ahead, y left);
            of a single wheel the travel of its rim, and 0.
        command_time: when the PWM was commanded, on the same clock [s].
        diagonal: the displacement is that of a Mecanum base on one of its diagonal pairs.
        line: of the file it was read from; 0 for none.
    """

    group: str
    direction: str
    pwm: float
    time: Array
    x: Array
    y: Array
    command_time: float = 0.0
    diagonal: bool = True
    line: int = 0

    @property
    def name(self) -> str:
        """For people: group, direction and PWM."""
        return f"{self.group} {self.direction} at PWM {self.pwm:g}"

    def travel(self) -> Array:
        """(N,) displacement [m] along the direction in which the step went.

        For a pair (sign(x_f) x + sign(y_f) y) / sqrt 2, which ends in (|x_f| + |y_f|) / sqrt 2, the path of
        Keek et al., eq. 8, in closed form.
        """
        if not self.diagonal:
            return np.asarray(self.x * _sign(self.x[-1]))
        return np.asarray((_sign(self.x[-1]) * self.x + _sign(self.y[-1]) * self.y) / math.sqrt(2.0))


def _sign(value: float) -> float:
    return -1.0 if value < 0.0 else 1.0
