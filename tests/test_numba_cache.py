"""The folder of compiled kernels: another one for other sources, and always one that can be written."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from holodrive import _numba_cache as cache


def test_any_edit_gives_another_folder(tmp_path: Path) -> None:
    """Content, name and place of each file count; other files do not."""
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "x.py").write_text("one")
    (tmp_path / "y.py").write_text("two")
    seen = {cache.sources_hash(str(tmp_path))}
    (tmp_path / "notes.txt").write_text("not a source")
    assert cache.sources_hash(str(tmp_path)) in seen
    (tmp_path / "a" / "x.py").write_text("ones")
    seen.add(cache.sources_hash(str(tmp_path)))
    (tmp_path / "a" / "x.py").rename(tmp_path / "a" / "z.py")
    seen.add(cache.sources_hash(str(tmp_path)))
    assert len(seen) == 3


def test_the_users_choice_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """NUMBA_CACHE_DIR wins."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/somewhere")
    assert cache.use_own_folder() is None
    assert os.environ["NUMBA_CACHE_DIR"] == "/somewhere"


@pytest.mark.parametrize("home", ["/dev/null/nowhere", "relative"])
def test_a_home_that_cannot_be_written_is_not_chosen(home: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a container without a home: a folder among the temporary ones, and the kernels compile."""
    monkeypatch.setenv("XDG_CACHE_HOME", home)
    root = cache.cache_root()
    assert not root.startswith(home)
    Path(root).mkdir(parents=True, exist_ok=True)


def test_old_folders_go_and_the_newest_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a developer's disk does not fill up."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.prune() == 0
    for age in range(7):
        folder = Path(cache.cache_root()) / f"{age}"
        folder.mkdir(parents=True)
        os.utime(folder, (time.time() - age, time.time() - age))
    assert cache.prune() == 3
    assert {path.name for path in Path(cache.cache_root()).iterdir()} == {"0", "1", "2", "3"}


def test_a_kernel_runs_without_a_home(tmp_path: Path) -> None:
    """End to end: no home, no cache folder, and still a compiled kernel."""
    code = "from holodrive import references; print(references.fixed_goal((1, 2, 3)).rows[0, 1])"
    environment = {"PATH": os.environ["PATH"], "HOME": "/dev/null", "TMPDIR": str(tmp_path)}
    assert subprocess.check_output([sys.executable, "-c", code], env=environment, text=True).strip() == "1.0"
