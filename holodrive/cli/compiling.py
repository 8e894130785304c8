"""Tells a user who waits for the first compilation what they wait for."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from holodrive.cli.output import LABEL, Output

EXPECTED_S = 25  # on two cores of 2024
PATIENCE_S = 1.5  # a warm start takes less


@contextmanager
def compiling(out: Output) -> Iterator[None]:
    """Says once, while the body takes long and no compiled kernels are there, that this happens once."""
    if out.quiet or _compiled():
        yield
        return
    timer = threading.Timer(
        PATIENCE_S, out.note, [f"{'compile':<{LABEL}}once for this version, about {EXPECTED_S} s; later starts skip it"]
    )
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _compiled() -> bool:
    folder = os.environ.get("NUMBA_CACHE_DIR")
    return bool(folder) and next(Path(str(folder)).rglob("*.nbc"), None) is not None
