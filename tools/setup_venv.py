#!/usr/bin/env python3
"""Make or mend the `.venv` of this checkout: pinned, hashed packages and holodrive itself, editable.

Usage: python3 tools/setup_venv.py [core|dev|bench]

Standard library only, and readable by Python 3.6, so that an old Python can say that it is too old.
Exit codes: 0 ready, 1 the installation failed, 2 this machine lacks something, 130 interrupted.
"""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

try:
    import fcntl
except ImportError:  # not on Linux; two set-ups at once are then not kept apart
    fcntl = None  # type: ignore[assignment]

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
VENV = os.path.join(ROOT, ".venv")
VENV_PYTHON = os.path.join(VENV, "bin", "python")
STAMP = os.path.join(VENV, "holodrive-setup.json")  # written last: it means "whole"
BUILDING = os.path.join(VENV, "holodrive-setup.building")  # here while we work: it means "half made"
# each holds what the ones before it hold
LOCKS = {"core": "requirements.lock", "dev": "requirements-dev.lock", "bench": "requirements-bench.lock"}
LEVELS = list(LOCKS)
OLDEST = (3, 11)
NEWEST = (3, 13)  # the newest that the locks are tested with
# What a Python must bring, told in one line that this script reads back.
PROBE = (
    "import sys\n"
    "missing = []\n"
    "for name in ('venv', 'ensurepip', 'ctypes', 'zlib', 'ssl'):\n"
    "    try: __import__(name)\n"
    "    except ImportError: missing.append(name)\n"
    "print('%d.%d.%d' % sys.version_info[:3], sys.executable, ','.join(missing) or '-')\n"
)


class SetupError(Exception):
    """Something that one line can say, with the exit code."""

    def __init__(self, message, code=2):
        super().__init__(message)
        self.code = code


def main(arguments):
    """Set up what `arguments` ask for; give the exit code."""
    level = arguments[0] if arguments else "core"
    if level not in LOCKS or len(arguments) > 1:
        print("usage: setup_venv.py [core|dev|bench]", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, _as_interrupt)
    try:
        if not is_ready(level):
            set_up(level)
    except SetupError as error:
        print("set-up: " + str(error), file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        print("\nset-up: interrupted; the next `make` mends it", file=sys.stderr)
        return 130
    except OSError as error:
        print("set-up: {}: {}".format(error.filename or VENV, error.strerror or error), file=sys.stderr)
        return 1
    return 0


def is_ready(level):
    """Whether `.venv` is whole, made for this place, this Python and these locks."""
    stamp = read_stamp()
    return (
        stamp.get("level") in LEVELS
        and stamp.get("key") == key(stamp["level"])
        and LEVELS.index(stamp["level"]) >= LEVELS.index(level)
        and not os.path.exists(BUILDING)
        and os.path.realpath(VENV_PYTHON) == stamp.get("python")
        and os.path.exists(VENV_PYTHON)
    )


def read_stamp():
    """What the last whole set-up left, or nothing."""
    try:
        with open(STAMP) as file:
            stamp = json.load(file)
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def key(level):
    """Hash of all that decides what is installed; it holds the folder, because a .venv cannot be moved."""
    digest = hashlib.sha256(ROOT.encode() + level.encode())
    for name in (LOCKS.get(level, ""), "pyproject.toml", os.path.join("tools", "setup_venv.py")):
        path = os.path.join(ROOT, name)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                digest.update(file.read())
    return digest.hexdigest()


def set_up(level):
    """Make `.venv`, or bring it up to date, under a lock of its own."""
    start = time.time()
    with open(os.path.join(ROOT, ".venv.lock"), "w") as lock:
        if fcntl is not None:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                say(start, "another set-up is running here; waiting for it")
                fcntl.flock(lock, fcntl.LOCK_EX)
                if is_ready(level):
                    return
        had = read_stamp().get("level")
        if had in LEVELS and LEVELS.index(had) > LEVELS.index(level):
            level = had  # once set up for tests, keep it so
        make_venv(start)
        install(level, start)
    say(start, "ready")


def make_venv(start):
    """Keep a working `.venv`; make a new one in place of one that is half made, moved or broken."""
    if os.path.isdir(VENV):
        ours = os.path.exists(STAMP) or os.path.exists(BUILDING)
        moved = os.path.exists(STAMP) and read_stamp().get("root") != ROOT
        if works() and not os.path.exists(BUILDING) and not moved:
            return
        if not ours and os.listdir(VENV) and not os.path.exists(os.path.join(VENV, "pyvenv.cfg")):
            raise SetupError(".venv is there but is no virtual environment: move it away, then try again")
        say(start, "the old .venv is half made, moved or broken: making a new one")
        shutil.rmtree(VENV)
    elif os.path.lexists(VENV):
        raise SetupError(".venv is there but is no folder: move it away, then try again")
    python, version = find_python()
    say(start, "making .venv with Python " + version)
    os.mkdir(VENV)
    open(BUILDING, "w").close()
    run([python, "-m", "venv", VENV], "could not make .venv", start)


def works():
    """Whether the Python in `.venv` is new enough and has pip."""
    code = "import sys, pip; sys.exit(sys.version_info < {!r})".format(OLDEST)
    try:
        return subprocess.call([VENV_PYTHON, "-c", code], env=clean_environment(), stderr=subprocess.DEVNULL) == 0
    except OSError:
        return False


def find_python():
    """The Python to build on: the one that runs this script when it is fit, else the newest fit one on PATH."""
    names = [sys.executable or "python3", "python3"]
    names += ["python3.%d" % minor for minor in range(NEWEST[1], OLDEST[1] - 1, -1)]
    names += ["python3.%d" % minor for minor in range(NEWEST[1] + 1, NEWEST[1] + 4)]
    found = [answer for answer in map(probe, names) if answer]
    fit = [answer for answer in found if answer[0] >= OLDEST and answer[2] == "-"]
    if fit:
        supported = [answer for answer in fit if answer[0][:2] <= NEWEST]
        version, path, _ = (supported or fit)[0]
        return path, ".".join(map(str, version))
    for version, path, missing in found:
        if version >= OLDEST:
            raise SetupError(explain_missing(path, version, missing.split(",")))
    versions = ", ".join(sorted({".".join(map(str, answer[0])) for answer in found})) or "none"
    raise SetupError(
        "holodrive needs Python {}.{} or newer; found {}: {}".format(
            OLDEST[0], OLDEST[1], versions, install_line("python3.11 python3.11-venv", "python3.12", "python")
        )
    )


def probe(name):
    """(version, path, missing modules) of an interpreter, or None when it does not run (such as a pyenv shim)."""
    path = name if os.path.isabs(name) else shutil.which(name)
    if not path:
        return None
    try:
        answer = subprocess.run(
            [path, "-c", PROBE],
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            env=clean_environment(),
            timeout=60,
        )
        version, rest = answer.stdout.decode().strip().split(" ", 1)
        path, missing = rest.rsplit(" ", 1)
        return tuple(map(int, version.split("."))), path, missing
    except (OSError, ValueError, subprocess.SubprocessError):
        return None


def explain_missing(path, version, missing):
    """One line about a Python that is new enough but not whole."""
    name = "Python {}.{} ({})".format(version[0], version[1], path)
    if set(missing) <= {"venv", "ensurepip"}:
        return name + " cannot make a virtual environment: " + install_line("python3-venv", "python3", "python")
    return "{} was built without {}: {}".format(
        name, ", ".join(missing), install_line("python3 python3-venv", "python3", "python")
    )


def install_line(apt, dnf, pacman):
    """What to type to get a package, for the package manager of this machine."""
    lines = {"apt-get": "apt install " + apt, "dnf": "dnf install " + dnf, "pacman": "pacman -S " + pacman}
    for tool in ("apt-get", "dnf", "pacman"):
        if shutil.which(tool):
            return "sudo " + lines[tool]
    return "install it with your package manager (on Debian and Ubuntu: sudo apt install {})".format(apt)


def install(level, start):
    """Pinned packages by hash, then this checkout, editable, with the pinned build tool and no download."""
    open(BUILDING, "w").close()
    pip = [VENV_PYTHON, "-m", "pip", "--disable-pip-version-check", "--no-input", "install", "--no-user"]
    with open(os.path.join(ROOT, LOCKS[level])) as file:
        count = sum(1 for line in file if re.match(r"\w", line))
    say(start, "installing {} pinned packages ({})".format(count, LOCKS[level]))
    pinned = ["--no-deps", "--require-hashes", "--only-binary", ":all:", "-r", os.path.join(ROOT, LOCKS[level])]
    if not os.environ.get("PYTHONDONTWRITEBYTECODE"):
        pinned.append("--no-compile")  # saves 8 s; Python compiles what it imports, unless told not to keep it
    run([*pip, "--retries", "2", *pinned], "pip could not install the pinned packages", start)
    say(start, "installing holodrive itself, editable")
    editable = ["--config-settings", "editable_mode=compat"]  # a plain path: quick to start, and editors follow it
    run(
        [*pip, "--no-deps", "--no-build-isolation", "--no-index", *editable, "-e", ROOT],
        "pip could not install holodrive",
        start,
    )
    stamp = {"level": level, "key": key(level), "python": os.path.realpath(VENV_PYTHON), "root": ROOT}
    with open(STAMP + ".new", "w") as file:
        json.dump(stamp, file)
    os.replace(STAMP + ".new", STAMP)
    os.remove(BUILDING)


def run(command, failure, start):
    """Run quietly, showing on a terminal what is being worked on; on failure raise its last line."""
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        env=clean_environment(),
        cwd=ROOT,
    )
    lines = []
    assert process.stdout is not None
    try:
        for raw in process.stdout:
            line = raw.decode(errors="replace").strip()
            if line:
                lines.append(line)
                show(start, line)
        code = process.wait()
    except BaseException:
        process.terminate()
        process.wait()
        raise
    finally:
        show(start, "")
    if code:
        raise SetupError("{}: {}".format(failure, reason(lines)), 1)


def reason(lines):
    """The one line of pip's output that tells what went wrong."""
    text = "\n".join(lines)
    errors = [line for line in lines if line.startswith(("ERROR", "Error", "error"))]
    last = (errors or lines or ["no output"])[-1]
    if re.search(r"NewConnectionError|NameResolution|name resolution|ConnectTimeout|ProxyError|unreachable", text):
        return "no connection to the package index; check the network or proxy, then try again"
    return last


def clean_environment():
    """The environment without what would make pip or venv write or look elsewhere."""
    unwanted = (
        "PYTHONHOME",
        "PYTHONPATH",
        "PIP_TARGET",
        "PIP_PREFIX",
        "PIP_ROOT",
        "PIP_USER",
        "PIP_REQUIRE_VIRTUALENV",
    )
    environment = {name: value for name, value in os.environ.items() if name not in unwanted}
    environment["PYTHONUNBUFFERED"] = "1"
    return environment


def say(start, text):
    """One line of progress with the seconds since start."""
    print("set-up [{:5.1f} s] {}".format(time.time() - start, text), file=sys.stderr)
    sys.stderr.flush()


def show(start, text):
    """The line that is being worked on, overwritten by the next; on a terminal only."""
    if sys.stderr.isatty():
        line = "set-up [{:5.1f} s]   {}".format(time.time() - start, text) if text else ""
        sys.stderr.write("\r\033[K" + line[: shutil.get_terminal_size().columns - 1])
        sys.stderr.flush()


def _as_interrupt(signum, frame):
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
