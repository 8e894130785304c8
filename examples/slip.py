"""The same drive with quick physics and with motors, battery and wheel slip. Writes slip.html."""

import holodrive as hd

runs = [
    hd.drive(hd.simulate("mecanum4", plant=plant, seed=2), goal=(0.4, 0.3, 0.8)) for plant in ("first_order", "slip")
]
for run in runs:
    off = 1e3 * run.metrics["final_error_m"]
    print(f"{run.settings['plant']:<12} {run.ended} after {run.time[-1]:5.2f} s, {off:4.1f} mm off by the truth")
hd.report(runs).save("slip.html")
print("see slip.html")
