"""Worlds as files: the shipped catalog, files of your own, and a seeded generator."""

from holodrive.worlds.courses import course
from holodrive.worlds.distances import clearance
from holodrive.worlds.files import dump, load, names, parse, schema, template
from holodrive.worlds.generator import generate
from holodrive.worlds.spec import World

__all__ = ["World", "clearance", "course", "dump", "generate", "load", "names", "parse", "schema", "template"]
