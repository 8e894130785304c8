"""The package as a whole: light to import, complete in its vocabulary, layered."""

import ast
import importlib
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import holodrive as hd

ROOT = Path(__file__).parents[1]
LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-bench.lock")
HEAVY = ("numpy", "numba", "scipy", "pydantic", "PIL", "rich", "click", "pyarrow", "mcap")


def test_importing_holodrive_imports_nothing_heavy() -> None:
    """`import holodrive` in a fresh interpreter loads no third-party package at all."""
    code = f"import holodrive, sys; print([name for name in {HEAVY} if name in sys.modules])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


def test_every_name_of_the_vocabulary_is_there() -> None:
    """All of `__all__` can be had, and `dir` tells it."""
    for name in hd.__all__:
        assert getattr(hd, name) is not None
    assert set(hd.__all__) <= set(dir(hd))


def test_a_wrong_name_is_an_attribute_error() -> None:
    """Lazy import does not swallow typing errors."""
    with pytest.raises(AttributeError, match="simulat"):
        hd.simulat  # type: ignore[attr-defined]


PACKAGES = sorted((ROOT / "holodrive").rglob("__init__.py"))


@pytest.mark.parametrize("path", PACKAGES, ids=lambda path: path.parent.name)
def test_every_package_says_what_it_exports(path: Path) -> None:
    """What an `__init__` defines for others is in its `__all__`, and all of `__all__` is there.

    (A name that is imported, not used and not in `__all__` is what the linter finds.)
    """
    module = importlib.import_module(".".join(path.parent.relative_to(ROOT).parts))
    defined = {
        node.name
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    }
    exported = getattr(module, "__all__", [])
    assert defined <= set(exported)
    assert all(hasattr(module, name) for name in exported)
    assert len(set(exported)) == len(exported)


def test_lock_files_hold_hashes_and_no_address() -> None:
    """Every pinned package has a hash; nothing names a place on the net."""
    for name in LOCKS:
        text = (ROOT / name).read_text()
        assert "://" not in text
        assert "--index" not in text
        blocks = [block for block in text.replace("\\\n", " ").splitlines() if block and block[0].isalnum()]
        assert blocks
        assert all("==" in block and "--hash=sha256:" in block for block in blocks)


def test_the_locks_agree() -> None:
    """What the tests and benchmarks run with is what users run with."""
    core, dev, bench = (
        {line.split(" \\")[0] for line in (ROOT / name).read_text().splitlines() if line and line[0].isalnum()}
        for name in LOCKS
    )
    assert core <= dev <= bench


def test_all_declared_dependencies_are_locked() -> None:
    """A dependency in pyproject.toml that is not in the lock would be missing after `make`."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    locked = {line.split("==")[0] for line in (ROOT / "requirements.lock").read_text().splitlines()}
    assert {dependency.split(">")[0] for dependency in project["dependencies"]} <= locked


def test_versions_agree() -> None:
    """pyproject.toml, the package and the citation say one version."""
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == hd.__version__
    assert f"version: {hd.__version__}\n" in (ROOT / "CITATION.cff").read_text()


def test_an_import_against_the_layers_is_refused(tmp_path: Path) -> None:
    """The linter that keeps the layers does see a back-import, and one that hides in a function."""
    linter = Path(sys.executable).with_name("lint-imports")
    shutil.copytree(ROOT / "holodrive", tmp_path / "holodrive", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    with (tmp_path / "holodrive" / "types.py").open("a") as file:
        file.write("\nfrom holodrive import kinematics\n")
    with (tmp_path / "holodrive" / "log" / "run.py").open("a") as file:
        file.write("\ndef back() -> None:\n    from holodrive import sim\n")
    result = subprocess.run([linter, "--no-cache"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "holodrive.types is not allowed to import holodrive.kinematics" in result.stdout
    assert "holodrive.log is not allowed to import holodrive.sim" in result.stdout
