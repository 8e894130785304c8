"""Where Numba keeps compiled kernels: one folder per state of this package's sources.

Numba notices an edited kernel, but not an edited callee in another file (numba issue 6061 and kin), so a cached
caller would go on giving yesterday's numbers. A folder named by a hash of all sources cannot lie.

This runs on every `import holodrive`, so it imports little: no pathlib, no shutil (5 ms of 30).
"""

import hashlib
import os
import sys

KEPT = 4  # folders of earlier sources that stay, newest first


def use_own_folder() -> str | None:
    """Point Numba at this package's folder, unless the user has chosen one; gives the folder."""
    if "NUMBA_CACHE_DIR" in os.environ:
        return None
    folder = os.path.join(cache_root(), sources_hash(os.path.dirname(os.path.abspath(__file__))))
    if not os.path.isdir(folder):  # new sources: their folder is made by Numba, the oldest ones go
        prune()
    os.environ["NUMBA_CACHE_DIR"] = folder
    if "numba" in sys.modules:  # it has read its configuration already
        sys.modules["numba"].config.CACHE_DIR = folder
    return folder


def cache_root() -> str:
    """The user's cache folder for compiled kernels; one in the temporary folder where that cannot be written.

    Numba refuses to compile at all when its cache folder cannot be written, so a read-only home must not be chosen.
    """
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    if not os.path.isabs(base) or not _can_be_made(base):
        import tempfile

        base = os.path.join(tempfile.gettempdir(), f"cache-{os.getuid()}")
    return os.path.join(base, "holodrive", "numba")


def sources_hash(package: str) -> str:
    """Hash of every Python file below `package`, names and contents."""
    digest = hashlib.blake2b(digest_size=8)
    for folder, folders, names in os.walk(package):
        folders.sort()
        for name in sorted(names):
            if name.endswith(".py"):
                path = os.path.join(folder, name)
                digest.update(os.path.relpath(path, package).encode())
                with open(path, "rb") as file:
                    digest.update(file.read())
    return digest.hexdigest()


def prune() -> int:
    """Remove folders of sources that are no more, but for the newest few; gives how many went."""
    import shutil

    root = cache_root()
    folders = [os.path.join(root, name) for name in os.listdir(root)] if os.path.isdir(root) else []
    old = sorted(folders, key=os.path.getmtime, reverse=True)[KEPT:]
    for folder in old:
        shutil.rmtree(folder, ignore_errors=True)
    return len(old)


def _can_be_made(folder: str) -> bool:
    """Whether the folder, or else the nearest folder above it, can be written."""
    while not os.path.exists(folder):
        folder = os.path.dirname(folder)
    return os.access(folder, os.W_OK | os.X_OK)
