"""What happened, kept: the MCAP recorder and reader, runs in memory, comparison, recordings of real robots."""

from holodrive.log.builder import RunBuilder
from holodrive.log.compare import Difference, compare
from holodrive.log.reader import read
from holodrive.log.recorder import Recorder
from holodrive.log.run import Run, Tick

__all__ = ["Difference", "Recorder", "Run", "RunBuilder", "Tick", "compare", "read"]
