"""How long one waits: `import holodrive`, `holodrive --help`, and the demo from an empty and a warm compile cache.

    python benchmarks/startup.py            imports and help (seconds)
    python benchmarks/startup.py --demo     the demo as well (minutes)

Each figure is the median of interleaved whole processes, given beside its peer and as a ratio.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROUNDS = 15
PYTHON = sys.executable
HOLODRIVE = str(Path(PYTHON).with_name("holodrive"))


def seconds(command: list[str], **environment: str) -> float:
    begin = time.perf_counter()
    subprocess.run(
        command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=os.environ | environment
    )
    return time.perf_counter() - begin


def ratio(ours: list[str], peer: list[str]) -> tuple[float, float, float]:
    """Median seconds of both, taken in turn, and the median of the pairs' ratios."""
    seconds(ours), seconds(peer)
    pairs = [(seconds(ours), seconds(peer)) for _ in range(ROUNDS)]
    a, b = ([pair[i] for pair in pairs] for i in (0, 1))
    return statistics.median(a), statistics.median(b), statistics.median([x / y for x, y in pairs])


def main() -> None:
    rows = [
        ("import holodrive", "import numpy", [PYTHON, "-c", "import holodrive"], [PYTHON, "-c", "import numpy"], 2.0),
        ("holodrive --help", "python -c pass", [HOLODRIVE, "--help"], [PYTHON, "-c", "pass"], 5.0),
    ]
    for ours, peer, a, b, bar in rows:
        x, y, r = ratio(a, b)
        print(f"{ours:20} {1e3 * x:7.1f} ms   {peer:16} {1e3 * y:7.1f} ms   ratio {r:5.2f}   (bar: at most {bar:g})")
    if "--demo" in sys.argv[1:]:
        demo()


def demo() -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [HOLODRIVE, "demo", "-o", str(Path(folder) / "demo.html")]
        cache = str(Path(folder) / "cache")
        cold = seconds(command, NUMBA_CACHE_DIR=cache)
        warm = statistics.median(seconds(command, NUMBA_CACHE_DIR=cache) for _ in range(3))
    print(f"holodrive demo       {cold:7.1f} s    from an empty compile cache   (aim: 40 s)")
    print(f"holodrive demo       {warm:7.1f} s    from a warm compile cache     (aim: 8 s)")


if __name__ == "__main__":
    main()
