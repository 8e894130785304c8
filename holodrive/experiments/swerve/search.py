"""How much is the motor and how much the gains: the same grid of controller settings for each set of motors."""

import itertools
import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache

from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.swerve import printed, robots
from holodrive.experiments.swerve.robots import Setup
from holodrive.experiments.swerve.runs import STEADY_DEG, Track, drive, driven
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import table

SOON_S = 8.0  # who arrives later is slow
# gains of the grid: K [1/s]; drive P [V s/rad] and I [V/rad]; steering P [V/rad] and rate [V s/rad]
GRID = ((0.6, 1.0, 1.3), (0.5, 2.0), (0.33, 2.0), (1.0, 3.0, 6.0, 12.0, 24.0), (0.3, 1.0, 2.4))
SEARCHED = (
    robots.AVERAGED,
    robots.DC_MILLI,
    robots.DC_HENRY,
)  # averaged: as six-step on this task, and ten times faster


@dataclass(frozen=True)
class Found:
    """What a grid of settings made of one set of motors; each list in order of arrival.

    Attributes:
        tried: settings.
        arrived: that came within 2 % of the distance to stay.
        soon: of them within 8 s.
        steady: of those without steering that swings by 2 degrees or more.
    """

    tried: int
    arrived: tuple[Track, ...]
    soon: tuple[Track, ...]
    steady: tuple[Track, ...]


def settings(setup: Setup) -> list[Setup]:
    """The grid for one set of motors."""
    return [replace(setup, k=k, kp=kp, ki=ki, ks=ks, kvs=kvs) for k, kp, ki, ks, kvs in itertools.product(*GRID)]


@lru_cache(maxsize=8)
def searched(setup: Setup, workers: int | None = None) -> Found:
    """All settings of the grid, driven to the figures' goal."""
    tried = settings(setup)
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        tracks = list(pool.map(lambda one: driven(one, printed.GOAL_FIGURES), tried))
    arrived = tuple(sorted((track for track in tracks if track.arrived), key=lambda track: track.arrival_s))
    soon = tuple(track for track in arrived if track.arrival_s < SOON_S)
    return Found(len(tried), arrived, soon, tuple(track for track in soon if track.steady))


def search(setting: Setting) -> Result:
    """Counts over the grid, the setting of record, and the motors exchanged under one controller."""
    found = {}
    for setup in SEARCHED:
        setting.tell(f"            {setup.name}: {math.prod(map(len, GRID))} settings")
        found[setup.name] = searched(setup, setting.workers)
    record, henry = drive(robots.DC_MILLI), found[robots.DC_HENRY.name]
    claims = (
        Claim("section 3.2", "DC with 2.7 mH: steering oscillates", "yes", f"no: {record.swing_deg:.1f}°",
              "differs" if record.steady else "agrees",
              note=f"{record.setup.gains}: there in {record.arrival_s:.2f} s, {record.peak_rpm:.0f} rpm, and the "
              f"wheels stand at the end ({record.end_rpm:.2f} rpm)"),
        Claim("section 3.2", "DC with 2.7 H: settings that arrive within 8 s and are steady", None,
              f"{len(henry.steady)} of {henry.tried}", "not printed", note=_best(henry)),
        Claim("section 3.2", "the same, 2.7 mH", None, _share(found[robots.DC_MILLI.name]), "not printed"),
        Claim("section 3.1", "the same, BLDC", None, _share(found[robots.AVERAGED.name]), "not printed",
              note=f"averaged, which drives this task as six-step does. Steady: below {STEADY_DEG:g}° there and back"),
    )  # fmt: skip
    counts, changes = [_row(*one) for one in found.items()], exchanged()
    sections = (
        TableSection("One grid of settings for all motors", table(counts), _GRID),
        TableSection("Motors and controllers exchanged", table(changes), _EXCHANGED),
    )
    return Result(claims, sections, {"counts": counts, "exchanged": changes})


_GRID = (
    "K 0.6, 1, 1.3; drive P 0.5, 2 and I 0.33, 2; steering P 1, 3, 6, 12, 24 and rate 0.3, 1, 2.4 (units as in the "
    "table of gains), each with each. DC limited to 450 rpm, BLDC to 700 rpm."
)
_EXCHANGED = (
    "Rows with dots keep the controller of the robot above them and change its motors. DC motors are limited to 450 "
    "rpm and BLDC motors to 700 rpm unless the row says another."
)


def exchanged() -> list[dict[str, float | str]]:
    """Rows of single changes between the robots of the figures."""
    bldc, henry, milli = robots.BLDC, robots.DC_HENRY, robots.DC_MILLI
    free = milli.robot.wheels[0].motor.no_load_speed_rad_s * 30.0 / math.pi
    changes = (
        ("DC 2.7 H", henry),
        ("… with 2.7 mH", replace(henry, motor=milli.motor)),
        ("… with BLDC motors", _with_controller(bldc, henry)),
        ("DC 2.7 mH, setting of record", milli),
        ("… with 2.7 H", replace(milli, motor=henry.motor)),
        ("… without the limit of 450 rpm", replace(milli, limit_rpm=free)),
        ("… with BLDC motors", _with_controller(bldc, milli)),
        ("BLDC six-step", bldc),
        ("… with DC motors, 2.7 mH, limit 700 rpm", replace(_with_controller(milli, bldc), limit_rpm=bldc.limit_rpm)),
        ("… with DC motors, 2.7 mH", _with_controller(milli, bldc)),
        ("… with DC motors, 2.7 H", _with_controller(henry, bldc)),
        ("BLDC with our own board (feed-forward)", replace(bldc, feed_forward=1.0)),
    )
    return [{"motors and controller": name, **drive(setup).row()} for name, setup in changes]


def _with_controller(motors: Setup, other: Setup) -> Setup:
    return replace(motors, k=other.k, kp=other.kp, ki=other.ki, ks=other.ks, kvs=other.kvs)


def _share(found: Found) -> str:
    return f"{len(found.steady)} of {found.tried}"


def _best(found: Found) -> str:
    if not found.steady:
        return "none is fast and steady"
    best = found.steady[0]
    return f"the best, {best.setup.gains}: {best.arrival_s:.2f} s, {best.swing_deg:.1f}° there and back"


def _row(name: str, found: Found) -> dict[str, float | str]:
    best = found.steady[0] if found.steady else None
    return {
        "motors": name,
        "settings": found.tried,
        "arrive": len(found.arrived),
        "within 8 s": len(found.soon),
        "and steady": len(found.steady),
        "best of these, s": best.arrival_s if best else math.nan,
        "its gains": best.setup.gains if best else "none",
    }
