"""A controller of your own: straight to the goal, at a speed that falls with the distance.

Writes own_controller.html.
"""

import math

import holodrive as hd
from holodrive.types import Estimate, Observation, Reference


class Straight:
    """Position and heading at the same time, each in proportion to what is left."""

    command_kind = "twist"

    def __init__(self, gain: float = 1.5, tolerance_m: float = 0.02) -> None:
        self.gain, self.tolerance_m = gain, tolerance_m

    def reset(self) -> None:
        """Nothing is remembered."""

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> hd.Decision:
        """The way that is left, seen from the robot, times the gain."""
        dx, dy, turn = hd.geometry.log(hd.geometry.between(estimate.pose, reference.pose))
        twist = hd.Twist(self.gain * dx, self.gain * dy, self.gain * turn)
        return hd.Decision(twist, arrived=reference.last and math.hypot(dx, dy) < self.tolerance_m)


run = hd.drive(hd.simulate("mecanum4", seed=1), controller=Straight(), goal=(0.5, 0.3, 1.57))
print(f"{run.ended} after {run.time[-1]:.1f} s, {1e3 * run.metrics['final_error_m']:.1f} mm off")
hd.report(run).save("own_controller.html")
print("see own_controller.html")
