"""A fuzzy controller drives past obstacles; an answer of its rules is explained, and the linter has a word on them."""

import holodrive as hd
from holodrive.control import fuzzy

base = hd.simulate("hybrid3_table_x", world="paper_course", seed=1)
run = hd.drive(base, controller="fuzzy")
print(f"{run.ended} after {run.metrics['time_s']:.1f} s and {run.metrics['path_length_m']:.2f} m")
print(f"nearest obstacle {100.0 * run.metrics['min_clearance_m']:.1f} cm\n")

system = fuzzy.load("repaired")
print(system.explain([700.0, 300.0, 2000.0]).text())

print("\nwhat is wrong with the rules as printed:")
for finding in fuzzy.load("paper_viii").lint():
    if finding.severity == "error":
        print(" ", finding)
