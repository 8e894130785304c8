"""What all tests share: seeded property tests, the catalog's robots, and the recorded data where it is there."""

import signal
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("seeded", derandomize=True, deadline=None, database=None)
settings.register_profile("campaign", max_examples=2000, deadline=None)
settings.load_profile("seeded")

# Shells start background jobs deaf to Ctrl-C, and children inherit that: tests that interrupt one would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

SHARED_DATA = Path(__file__).parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of recordings and test vectors that lies beside the checkout and is not part of it."""
    if not SHARED_DATA.is_dir():
        pytest.skip(f"no recorded data at {SHARED_DATA}")
    return SHARED_DATA
