"""Tells a user who waits for the first compilation what they wait for."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from holodrive.cli.output import LABEL, Output

EXPECTED_S = 20  # all kernels of a first run, on two cores of 2024
PATIENCE_S = 2.0  # a warm start takes less


@contextmanager
def compiling(out: Output) -> Iterator[Callable[[], None]]:
    """Says why it takes long when it does; the function that it gives ends the waiting (as does leaving)."""
    text = f"{'compile':<{LABEL}}once for this version, about {EXPECTED_S} s in all; later starts skip it"
    timer = threading.Timer(PATIENCE_S, out.note, [text])
    timer.daemon = True
    if not out.quiet:
        timer.start()
    try:
        yield timer.cancel
    finally:
        timer.cancel()
