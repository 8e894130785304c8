"""Sweeps: simulated runs per second, what a second core gives, and what the way over a Dask cluster costs.

    python benchmarks/tuning.py [--rounds 7] [--runs 120] [--save]

Workload: two variants of go_to_pose for hybrid3_table_x in random courses (four obstacles, 360-beam lidar, 1 ms
physics), 30 s each. The worlds are generated before the clock runs. The cluster is a local one of two worker processes
with one thread each, so what it costs is the way of tasks and results over a socket. All kinds take turns, so that
other load meets all alike; figures are medians. Exit code 1 when a bar is missed, or the numbers differ at all.
"""

import argparse
import platform
import statistics
import sys
import time
from pathlib import Path

import numba
import numpy as np

from holodrive import tuning
from holodrive.tuning.backends import Threads, cores
from holodrive.tuning.cluster import Cluster

TWO_CORES = 1.7  # times one thread
CLUSTER_COST = 0.15  # of the time of two threads, at most on top


def timed(job, backend):
    begin = time.perf_counter()
    out = tuning.sweep(job, backend)
    return time.perf_counter() - begin, out.values


def measure(job, rounds):
    import distributed

    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(**options, host="127.0.0.1") as local:
        address = local.scheduler_address
        with Cluster(address) as runner:
            kept = tuning.Open(runner)
            backends = {"1 thread": Threads(1), "2 threads": Threads(2), "2 workers, connected": kept,
                        "2 workers, with connecting": address}  # fmt: skip
            times = {name: [] for name in backends}
            values = {}
            for number in range(rounds + 1):
                for name, backend in backends.items():
                    seconds, values[name] = timed(job, backend)
                    if number:  # the first round compiles and generates worlds, in every process
                        times[name].append(seconds)
    equal = all(np.array_equal(values["1 thread"], other, equal_nan=True) for other in values.values())
    return {name: statistics.median(found) for name, found in times.items()}, equal


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--runs", type=int, default=120)
    parser.add_argument("--save", action="store_true")
    chosen = parser.parse_args()
    job = tuning.job(
        "hybrid3_table_x", "course", "go_to_pose", variants=({}, {"k_xy": 2.0}), first=10_000, count=chosen.runs, t=30.0
    )
    total = 2 * chosen.runs
    times, equal = measure(job, chosen.rounds)
    lines = [
        f"Python {platform.python_version()}, Numba {numba.__version__}, {cores()} cores, {chosen.rounds} rounds "
        f"of {total} runs of 30 s, medians"
    ]
    lines += [f"{name:<28}{total / seconds:7.0f} runs/s" for name, seconds in times.items()]
    speed_up = times["1 thread"] / times["2 threads"]
    cost = times["2 workers, connected"] / times["2 threads"] - 1.0
    join = times["2 workers, with connecting"] - times["2 workers, connected"]
    lines.append(f"two threads against one      {speed_up:7.2f} x        (bar {TWO_CORES})")
    lines.append(f"cluster against two threads  {100.0 * cost:+7.1f} %        (bar +{100.0 * CLUSTER_COST:.0f} %)")
    lines.append(f"connecting                   {join:7.2f} s")
    lines.append(f"numbers equal bit for bit: {'yes' if equal else 'NO'}")
    met = equal and cost <= CLUSTER_COST and (speed_up >= TWO_CORES or cores() < 2)
    lines.append("all bars met" if met else "a bar is missed")
    print("\n".join(lines))
    if chosen.save:
        Path(__file__).with_name("results").joinpath("tuning.txt").write_text("\n".join(lines) + "\n")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
