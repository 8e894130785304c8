"""Robots as files: the shipped catalog, files of your own, and the libraries of motors and sensors."""

from holodrive.robots import motors, sensors
from holodrive.robots.files import dump, load, names, parse, schema, template
from holodrive.robots.spec import Robot

__all__ = ["Robot", "dump", "load", "motors", "names", "parse", "schema", "sensors", "template"]
