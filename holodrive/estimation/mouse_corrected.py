"""The recursion of Keek et al. for two mice as corrected: each mouse by the sign of its own x.

See `estimation.mouse_recursion` for the rule and its faults, `estimation.mouse_pair` for what else it tells.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from holodrive.estimation import mouse_pair
from holodrive.estimation.mouse_odometry import check
from holodrive.estimation.mouse_recursion import CORRECTED
from holodrive.types import Array

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot


@dataclass(frozen=True)
class MouseCorrected:
    """Parameters of the recursion as corrected; also an estimator plug.

    Attributes:
        twist_s: time constant of the filter on the twist [s]; 0 for none.
    """

    twist_s: float = 0.01

    kernel: ClassVar[Any]

    def __post_init__(self) -> None:
        check("mouse_corrected", self, at_least_0=("twist_s",))

    def memory_size(self, robot: "Robot") -> int:
        """How many float64 the kernel keeps between ticks."""
        return mouse_pair.MEMORY

    def pack(self, robot: "Robot") -> Array:
        """The rule and the mice, as one vector.

        Raises:
            InputError: the mice are not two on one forward axis, the first in the robot's centre.
        """
        return mouse_pair.pack(robot, "mouse_corrected", CORRECTED, self.twist_s)


MouseCorrected.kernel = staticmethod(mouse_pair.tick)
