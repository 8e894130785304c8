"""A compiled estimator in the ordinary loop: the same kernel, one tick at a time."""

import numpy as np

from holodrive import layout
from holodrive.interfaces import Plug
from holodrive.observation_array import empty_observation, fill_observation
from holodrive.robots.spec import Robot
from holodrive.types import Array, Estimate, Observation, Pose, Twist


class KernelEstimator:
    """An `interfaces.Estimator` around a plug's kernel."""

    def __init__(self, plug: Plug, robot: Robot) -> None:
        self.plug = plug
        self._observation = empty_observation(robot.lidar.beams if robot.lidar else 0)
        self._memory = np.zeros(max(3, plug.memory_size(robot)))
        self._params = plug.pack(robot)
        self._estimate = np.zeros(layout.ESTIMATE_SIZE)

    def reset(self, pose: Pose) -> None:
        """Start from a known pose."""
        self._memory[:] = 0.0
        self._memory[layout.START_POSE : layout.START_POSE + 3] = pose

    def step(self, observation: Observation) -> Estimate:
        """One tick."""
        fill_observation(self._observation, observation)
        self.plug.kernel(self._observation, self._memory, self._params, self._estimate)
        return estimate_of_array(self._estimate)


def estimate_of_array(values: Array) -> Estimate:
    """An `Estimate` from its vector in `holodrive.layout`."""
    covariance = values[layout.EST_COVARIANCE : layout.EST_COVARIANCE + 9].reshape(3, 3).copy()
    numbers = values.tolist()
    return Estimate(
        Pose(*numbers[layout.EST_POSE : layout.EST_POSE + 3]),
        Twist(*numbers[layout.EST_TWIST : layout.EST_TWIST + 3]),
        covariance,
        numbers[layout.EST_SLIP],
        int(numbers[layout.EST_SUSPECT]),
    )
