"""`holodrive doctor`: one line a check, and what to do where one fails."""

import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

import click

from holodrive import _numba_cache
from holodrive.cli.commands.version import STANDS_ON
from holodrive.cli.options import verb
from holodrive.cli.output import Output, colour

GIB = 2.0**30


class Check(NamedTuple):
    """One answer: `verdict` is "ok", "note" (something will not work, most things will) or "bad"."""

    name: str
    verdict: str
    text: str


@verb("doctor", ["", "--json"])
def command(out: Output) -> int:
    """Check whether this machine has all that it takes; exit code 1 when something is bad."""
    checks = [check() for check in CHECKS]
    if out.json:
        out.data([check._asdict() for check in checks])
    else:
        for name, verdict, text in checks:
            mark = click.style(f"{verdict:<5}", fg={"ok": "green", "note": "yellow", "bad": "red"}[verdict])
            click.echo(f"{mark}{name:<12}{text}", color=colour())
    bad = [check.name for check in checks if check.verdict == "bad"]
    out.next(f"mend {', '.join(bad)}, then holodrive doctor" if bad else "holodrive demo")
    return 1 if bad else 0


def python() -> Check:
    """64 bit (an older Python than 3.11 cannot read this file)."""
    text = f"{platform.python_version()} on {platform.system()} {platform.machine()} ({sys.executable})"
    if sys.maxsize < 2**32:
        return Check("python", "bad", f"{text}: Numba has no 32-bit build")
    return Check("python", "ok", text)


def packages() -> Check:
    """All that holodrive stands on is there."""
    found, missing = [], []
    for name in STANDS_ON:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    if missing:
        return Check("packages", "bad", f"missing: {', '.join(missing)}; pip install {' '.join(missing)}")
    return Check("packages", "ok", ", ".join(found))


def catalog() -> Check:
    """Every shipped robot and world can be read."""
    from holodrive import robots, worlds
    from holodrive.errors import HolodriveError

    try:
        count = [len([library.load(name) for name in library.names()]) for library in (robots, worlds)]
    except (HolodriveError, OSError) as error:
        return Check("catalog", "bad", f"{error}; install holodrive again")
    return Check("catalog", "ok", f"{count[0]} robots, {count[1]} worlds")


def cache() -> Check:
    """Compiled kernels can be kept."""
    folder = Path(os.environ.get("NUMBA_CACHE_DIR") or _numba_cache.cache_root())
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        text = f"cannot write {folder} ({error.strerror}): every start compiles anew; set NUMBA_CACHE_DIR to a folder"
        return Check("cache", "note", text)
    return Check("cache", "ok", f"{folder} is writable, {len(list(folder.rglob('*.nbc')))} compiled kernels")


def processors() -> Check:
    """How many threads a roll-out may use."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Check("processors", "ok", f"{count} usable")


def terminal() -> Check:
    """What the terminal can show."""
    encoding = sys.stdout.encoding or "unknown"
    size = shutil.get_terminal_size()
    where = f"terminal {size.columns} x {size.lines}" if sys.stdout.isatty() else "not a terminal: plain output"
    if "utf" not in encoding.lower():
        return Check("terminal", "note", f"{where}, {encoding}: some signs will not print; export LANG=C.UTF-8")
    return Check("terminal", "ok", f"{where}, {encoding}")


def serial() -> Check:
    """Serial ports, and the right to open them; needed for real robots only."""
    ports = sorted(str(path) for pattern in ("ttyACM*", "ttyUSB*") for path in Path("/dev").glob(pattern))
    closed = [port for port in ports if not os.access(port, os.R_OK | os.W_OK)]
    if closed:
        return Check(
            "serial", "note", f"no right to open {', '.join(closed)}: sudo usermod -aG dialout $USER, log in again"
        )
    return Check("serial", "ok", ", ".join(ports) if ports else "no port in sight; only a real robot needs one")


def disk() -> Check:
    """Room for logs here."""
    free = shutil.disk_usage(Path.cwd()).free / GIB
    return Check("disk", "ok" if free > 1.0 else "note", f"{free:.1f} GiB free here; an hour of log is 0.2 to 0.4 GB")


def clock() -> Check:
    """A monotonic clock that is fine enough for the control loop, and a date that can be true."""
    resolution = time.get_clock_info("monotonic").resolution
    if resolution > 1e-3:
        return Check("clock", "bad", f"ticks each {resolution:.3g} s; the control loop needs 1 ms")
    if time.gmtime().tm_year < 2025:
        return Check("clock", "note", f"the date is {time.strftime('%Y-%m-%d')}: logs will carry it; set the clock")
    return Check("clock", "ok", f"{time.strftime('%Y-%m-%d %H:%M')}, ticks each {resolution * 1e9:.0f} ns")


CHECKS: tuple[Callable[[], Check], ...] = (
    python, packages, catalog, cache, processors, terminal, serial, disk, clock,
)  # fmt: skip
