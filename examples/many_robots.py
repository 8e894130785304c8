"""Compiled batches of 250 robots: a disturbed start, four gains of a controller, what is lost and won."""

import numpy as np

import holodrive as hd

N, SECONDS = 250, 20.0
random = np.random.default_rng(1)
starts = np.column_stack([random.normal(0.0, 0.3, N), random.normal(0.0, 0.3, N), random.uniform(-3.0, 3.0, N)])

print(f"{N} robots for each gain: share that arrived, and the median way and time of those")
for gain in (0.5, 1.0, 2.0, 4.0):
    batch = hd.rollout(
        "swerve4", "open", "go_to_pose", n=N, params={"k_xy": gain}, starts=starts, goals=(2.0, 1.0, 0.0),
        t=SECONDS, seed=1, stop_on_arrival=True,
    )  # fmt: skip
    arrived = batch.metrics["arrived"] > 0.0
    way, time = (np.median(batch.metrics[name][arrived]) for name in ("path_length_m", "time_s"))
    print(f"gain {gain:3.1f} 1/s   {100.0 * arrived.mean():5.1f} %   {way:.2f} m   {time:.2f} s")
