"""PID and fuzzy-PD tuned with the same budget on T1 and T3: the gains of tables XI and XII of the reproduction.

    python benchmarks/trackers.py [--budget 1600] [--seed 1] [--save]

hybrid3_table_x on first_order, wheel odometry; CMA-ES with the same search, runs and seeds for both; judged on runs
that the search did not meet. What it prints is what stands in holodrive/experiments/hybrid/tracks.py (GAINS).
"""

import argparse
import sys
from pathlib import Path

from holodrive import tuning
from holodrive.experiments.hybrid import robots, tracks

# metric that is made small: the first is a moving reference, the second a step
TASKS = {"t1": (tracks.t1_track, "rms_error_m"), "t3": (tracks.t3_track, "iae_m_s")}
# gains of the position; a metric of the position says nothing of the heading's, which stay as they are
FIELDS = {"pid": ("kp", "ki", "kd"), "fuzzy_pd": ("span_m", "span_m_s", "gain_m_s", "small_in", "small_out")}


def tuned(controller, task, budget, seed):
    make, metric = TASKS[task]
    track = make()
    job = tuning.job(
        robots.table_x(),
        "open",
        controller,
        reference=track.reference.recipe,
        start=tuple(track.start),
        t=track.duration_s,
        stop_on_arrival=False,
    )
    problem = tuning.Problem(job, tuning.space(controller, FIELDS[controller]), tuning.Objective.parse(metric))
    return tuning.tune(
        problem,
        budget=budget,
        seed=seed,
        runs=4,
        train_seeds=range(1000, 2000),
        validation_seeds=range(2000, 2040),
        heldout_seeds=range(3000, 3040),
    )


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--budget", type=int, default=1600, help="runs to simulate for each search")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--save", action="store_true", help="keep the output in benchmarks/results/")
    options = parser.parse_args(arguments)
    lines = [f"budget {options.budget} runs each, seed {options.seed}"]
    for task, (_, metric) in TASKS.items():
        for controller in FIELDS:
            found = tuned(controller, task, options.budget, options.seed)
            before, after = found.before.cost.mean, found.after.cost.mean
            lines.append(f"{task} {controller:9s} {metric} {before:.4f} before, {after:.4f} after")
            lines.append(f"    {{{', '.join(f'{k!r}: {v:.4g}' for k, v in found.params.items())}}}")
            print("\n".join(lines[-2:]), flush=True)
    if options.save:
        (Path(__file__).parent / "results" / "trackers.txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
