"""Robots and folders for the tests of the log."""

import sys
from pathlib import Path

import pytest

from holodrive import robots
from holodrive.robots.spec import Robot

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def hybrid3() -> Robot:
    return robots.load("hybrid3")
