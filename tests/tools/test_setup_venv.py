"""The set-up script: what it says when a machine lacks something, and when it has nothing to do.

Whole installations are tried in CI by `.ci/run`, which begins with one; here nothing is downloaded.
"""

import ast
import importlib.util
import json
import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "setup_venv.py"


@pytest.fixture
def setup(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script as a module that works in an empty checkout, with an empty PATH and no Python."""
    (tmp_path / "tools").mkdir()
    for name in (*(path.name for path in SCRIPT.parents[1].glob("*.lock")), "pyproject.toml", "tools/setup_venv.py"):
        (tmp_path / name).write_text((SCRIPT.parents[1] / name).read_text())
    spec = importlib.util.spec_from_file_location("setup_venv", tmp_path / "tools" / "setup_venv.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(module.sys, "executable", "")
    return module


def fake_python(setup: ModuleType, name: str, version: str, missing: str = "-") -> Path:
    """An interpreter on PATH that answers the probe."""
    path = Path(setup.ROOT) / "bin" / name
    path.write_text(f"#!/bin/sh\necho '{version} {path} {missing}'\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def test_python_3_6_can_read_it() -> None:
    """So that an old Python can say that it is too old."""
    ast.parse(SCRIPT.read_text(), feature_version=(3, 6))


def test_too_old_a_python_is_named(setup: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    """One line: what was found, what is needed, what to install."""
    fake_python(setup, "python3", "3.9.2")
    fake_python(setup, "apt-get", "")
    assert setup.main([]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "set-up: holodrive needs Python 3.11 or newer; found 3.9.2: sudo apt install python3.11 python3.11-venv"
    ]


def test_no_venv_module_says_what_to_install(setup: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    """Debian ships `venv` apart."""
    fake_python(setup, "python3", "3.11.2", "ensurepip")
    fake_python(setup, "apt-get", "")
    assert setup.main([]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.endswith("cannot make a virtual environment: sudo apt install python3-venv\n")


def test_the_newest_fit_python_is_found(setup: ModuleType) -> None:
    """Neither too old, nor newer than tried, nor without venv, nor one that does not run."""
    fake_python(setup, "python3", "3.9.2")
    fake_python(setup, "python3.11", "3.11.9")
    right = fake_python(setup, "python3.12", "3.12.4")
    fake_python(setup, "python3.13", "3.13.1", "ensurepip")
    fake_python(setup, "python3.14", "3.14.0")
    assert setup.find_python() == (str(right), "3.12.4")
    right.write_text("#!/bin/sh\nexit 127\n")  # such as a pyenv shim without its version
    assert setup.find_python()[1] == "3.11.9"


def test_a_newer_python_than_tried_is_better_than_none(setup: ModuleType) -> None:
    """It may work; pip will tell."""
    fake_python(setup, "python3", "3.14.0")
    assert setup.find_python()[1] == "3.14.0"


def test_a_whole_venv_needs_nothing(setup: ModuleType) -> None:
    """The stamp says for which locks, which Python and which folder; a dev set-up serves core as well."""
    python = Path(setup.VENV_PYTHON)
    python.parent.mkdir(parents=True)
    python.symlink_to(sys.base_prefix + "/bin/python3")
    stamp = {"level": "dev", "key": setup.key("dev"), "python": os.path.realpath(python), "root": setup.ROOT}
    Path(setup.STAMP).write_text(json.dumps(stamp))
    assert setup.is_ready("core")
    assert setup.is_ready("dev")
    Path(setup.BUILDING).touch()
    assert not setup.is_ready("core")
    Path(setup.BUILDING).unlink()
    (Path(setup.ROOT) / "requirements-dev.lock").write_text("changed")
    assert not setup.is_ready("core")


def test_a_core_venv_is_not_enough_for_tests(setup: ModuleType) -> None:
    """`make test` after `make demo` installs more."""
    python = Path(setup.VENV_PYTHON)
    python.parent.mkdir(parents=True)
    python.symlink_to(sys.base_prefix + "/bin/python3")
    stamp = {"level": "core", "key": setup.key("core"), "python": os.path.realpath(python), "root": setup.ROOT}
    Path(setup.STAMP).write_text(json.dumps(stamp))
    assert setup.is_ready("core")
    assert not setup.is_ready("dev")


def test_a_folder_that_is_no_venv_is_left_alone(setup: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing of the user's is deleted."""
    Path(setup.VENV).mkdir()
    mine = Path(setup.VENV) / "mine.txt"
    mine.write_text("precious")
    fake_python(setup, "python3", "3.12.4")
    assert setup.main([]) == 2
    assert "move it away" in capsys.readouterr().err
    assert mine.exists()


def test_pip_faults_become_one_line(setup: ModuleType) -> None:
    """The last error, or the network when that is the cause."""
    assert setup.reason(["Collecting x", "ERROR: no space left", "tail"]) == "ERROR: no space left"
    lines = ["WARNING: Retrying after NewConnectionError(...)", "ERROR: No matching distribution found for x"]
    assert setup.reason(lines).startswith("no connection to the package index")


def test_an_interrupt_is_said_and_mended_next_time(setup: ModuleType) -> None:
    """Ctrl-C gives 130 and leaves the mark of a half-made .venv."""
    slow = Path(setup.ROOT) / "bin" / "python3"
    slow.write_text(f'#!/bin/sh\ncase "$*" in *venv*) exec /bin/sleep 60;; *) echo "3.12.4 {slow} -";; esac\n')
    slow.chmod(0o755)
    code = (
        f"import sys; sys.path.insert(0, {str(Path(setup.ROOT) / 'tools')!r}); import setup_venv\n"
        f"sys.executable = ''; sys.exit(setup_venv.main([]))"
    )
    slow.write_text(slow.read_text().replace("*venv*)", "*-m\\ venv*)"))
    process = subprocess.Popen([sys._base_executable, "-c", code], stderr=subprocess.PIPE, text=True)
    for _ in range(200):
        if Path(setup.BUILDING).exists():
            break
        time.sleep(0.05)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert "interrupted" in process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert Path(setup.BUILDING).exists()
    assert not setup.is_ready("core")
