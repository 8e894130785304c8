"""A recording of a real robot: wheel odometry against motion capture, and what another wheel radius would give."""

import holodrive as hd
from holodrive.estimation.evaluation import evaluate
from holodrive.log import recordings

name = recordings.shipped()[0]
recording = recordings.read(name)
print(f"{name}: {len(recording.time)} samples of {', '.join(recording.wheels)}")

for percent in (-2, -1, 0, 1, 2):
    nominal = hd.load(recording.robot)
    radius = nominal.wheels[0].radius * (1.0 + percent / 100.0)
    robot = hd.load(recording.robot, {f"wheel.{wheel.name}.radius": radius for wheel in nominal.wheels})
    result = evaluate(recording, robot)
    print(f"radius {percent:+d} %   end error {1e3 * result.end_error_m:5.1f} mm   RMSE {1e3 * result.rmse_m:5.1f} mm")
