"""NumPy archives, with every way in which they can be broken told in one line."""

import zipfile
import zlib
from pathlib import Path

import numpy as np

from holodrive.errors import LogError
from holodrive.types import Array

_BROKEN = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError)


def is_npz(head: bytes) -> bool:
    """Whether a file that begins with `head` is a zip archive."""
    return head.startswith(b"PK")


def arrays(path: Path) -> dict[str, tuple[int, ...]]:
    """Shape of each array in the archive, without reading the arrays."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {name.removesuffix(".npy"): _shape(archive, name) for name in archive.namelist()}
    except _BROKEN as error:
        raise LogError(f"{path}: not a readable NumPy archive: {error}") from None


def one_array(path: Path, key: str) -> Array:
    """One array of the archive as float64."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            return np.asarray(archive[key], dtype=np.float64)
    except _BROKEN as error:
        raise LogError(f"{path}: array {key!r} cannot be read: {error}") from None


def _shape(archive: zipfile.ZipFile, name: str) -> tuple[int, ...]:
    with archive.open(name) as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        return tuple(int(size) for size in read(file)[0])
