"""The one loop and the gate that every command for the motors passes."""

from holodrive.runtime.gate import GateLimits, GateState, Verdict, gate, rearm
from holodrive.runtime.loop import Ending, Loop, Sink
from holodrive.runtime.pace import RealTime
from holodrive.runtime.teleop import KeyTeleop, TeleopSettings, TerminalKeys

__all__ = [
    "Ending",
    "GateLimits",
    "GateState",
    "KeyTeleop",
    "Loop",
    "RealTime",
    "Sink",
    "TeleopSettings",
    "TerminalKeys",
    "Verdict",
    "gate",
    "rearm",
]
