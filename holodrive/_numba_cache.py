"""Where Numba keeps compiled kernels: one folder per state of this package's sources.

Numba notices an edited kernel, but not an edited callee in another file (numba issue 6061 and kin), so a cached
caller would go on giving yesterday's numbers. A folder named by a hash of all sources cannot lie.
"""

import hashlib
import os
import shutil
import sys
from pathlib import Path

KEPT = 4  # folders of earlier sources that stay, newest first


def use_own_folder() -> Path | None:
    """Point Numba at this package's folder, unless the user has chosen one; gives the folder."""
    if "NUMBA_CACHE_DIR" in os.environ:
        return None
    folder = cache_root() / sources_hash(Path(__file__).parent)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:  # it has read its configuration already
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    return folder


def cache_root() -> Path:
    """The user's cache folder for compiled kernels."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "holodrive" / "numba"


def sources_hash(package: Path) -> str:
    """Hash of every Python file below `package`, names and contents."""
    digest = hashlib.blake2b(digest_size=8)
    for path in sorted(package.rglob("*.py")):
        digest.update(path.relative_to(package).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def prune() -> int:
    """Remove folders of sources that are no more, but for the newest few; gives how many went."""
    folders = sorted(cache_root().glob("*"), key=lambda path: path.stat().st_mtime, reverse=True)
    for old in folders[KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
    return len(folders[KEPT:])
