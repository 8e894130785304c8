"""Wheels on a body: the one wheel equation, the matrices of a chassis, and what its wheels can do."""

from holodrive.kinematics.chassis import Chassis
from holodrive.kinematics.wheel import Wheel

__all__ = ["Chassis", "Wheel"]
