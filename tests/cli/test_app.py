"""What all verbs have in common: help, hints, exit codes, streams, and never a traceback."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import pytest

from holodrive.cli.app import app
from holodrive.cli.faults import report_fault
from holodrive.cli.options import pose_of, split_settings
from holodrive.cli.output import Output, plain, table
from holodrive.cli.verbs import VERBS
from holodrive.errors import HardwareFault, InputError

Cli = Callable[..., Any]  # see conftest.py


def test_help_imports_nothing_that_a_verb_needs() -> None:
    """Help comes at once: neither NumPy, Numba, rich nor any verb's module is loaded."""
    code = (
        "import sys; from holodrive.cli import main; main(['--help'])\n"
        "heavy = [name for name in ('click', 'numpy', 'numba', 'rich', 'pydantic', 'scipy') if name in sys.modules]\n"
        "print('LOADED', heavy + [name for name in sys.modules if 'cli.commands' in name])"
    )
    assert "LOADED []" in subprocess.check_output([sys.executable, "-c", code], text=True)


def test_no_word_is_help(cli: Cli) -> None:
    """`holodrive` alone says what there is."""
    answer = cli()
    assert answer.code == 0
    assert all(verb in answer.out for verb in VERBS)


def test_help_is_the_same_by_the_short_way_and_by_click(cli: Cli) -> None:
    """One text, whether it is asked for alone or with another option."""
    assert cli("--help").out == cli("-h").out == cli("-v", "--help").out == cli("-q").out


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help_with_two_examples_or_more(cli: Cli, verb: str) -> None:
    """And each example begins with the verb itself."""
    answer = cli(verb, "--help")
    assert answer.code == 0
    examples = answer.out.partition("Examples:")[2].strip().splitlines()
    assert len(examples) >= 2
    assert all(line.strip().startswith(f"holodrive {verb}") for line in examples)
    for option in ("--quiet", "--verbose", "--json"):
        assert option in answer.out


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_in_the_table_is_a_command_of_that_name(verb: str) -> None:
    """The table and the modules agree."""
    assert import_module(f"holodrive.cli.commands.{verb}").command.name == verb


def test_all_modules_are_in_the_table() -> None:
    """No verb is forgotten."""
    folder = Path(import_module("holodrive.cli.commands").__file__ or "").parent
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == set(VERBS)


def test_an_unknown_verb_is_told_the_nearest(cli: Cli) -> None:
    """Exit code 2, one error, a hint, nothing on standard output."""
    answer = cli("doctr")
    assert answer.code == 2
    assert answer.err.startswith("error: no verb called 'doctr'. Did you mean 'doctor'?")
    assert not answer.out


def test_an_unknown_option_is_told_the_nearest(cli: Cli) -> None:
    """The same for options."""
    answer = cli("version", "--jsn")
    assert answer.code == 2
    assert "Did you mean '--json'?" in answer.err


def test_results_go_out_and_hints_go_err(cli: Cli) -> None:
    """A pipe gets the result only; the last line for people says what to do next."""
    answer = cli("version")
    assert answer.out.startswith("holodrive ")
    assert "next" not in answer.out
    assert answer.err.splitlines()[-1].startswith("next ")


def test_quiet_says_the_result_only(cli: Cli) -> None:
    """-q may stand before or after the verb."""
    assert cli("-q", "version").err == ""
    assert cli("version", "-q").err == ""


def test_json_is_json(cli: Cli) -> None:
    """One document, and NaN is null."""
    assert json.loads(cli("version", "--json").out)["holodrive"]
    assert plain({"a": float("nan"), "b": (1, 2.5, None, True)}) == {"a": None, "b": [1, 2.5, None, True]}


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (InputError("no such thing"), 2, "error: no such thing"),
        (HardwareFault("no answer"), 3, "error: no answer"),
        (FileNotFoundError(2, "No such file or directory", "x.mcap"), 2, "error: x.mcap: No such file or directory"),
        (ZeroDivisionError("oops"), 1, "a fault of holodrive"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (click.Abort(), 130, "interrupted"),
    ],
)
def test_errors_become_words_and_exit_codes(
    error: BaseException, code: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Never a traceback without -v."""
    assert report_fault(error, Output()) == code
    err = capsys.readouterr().err
    assert words in err
    assert "Traceback" not in err


def test_verbose_shows_the_trace(capsys: pytest.CaptureFixture[str]) -> None:
    """-v is for those who look for the cause."""
    out = Output()
    out.set(verbose=True)
    report_fault(ZeroDivisionError("oops"), out)
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_a_reader_that_leaves_is_no_error() -> None:
    """`holodrive ... | head -1` ends without a word of complaint."""
    command = f"{sys.executable} -c 'from holodrive.cli import main; import sys; sys.exit(main())' version -v | head -1"
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)
    assert result.stdout.startswith("holodrive")
    assert "Error" not in result.stderr


def test_no_colour_in_a_pipe_nor_with_no_color() -> None:
    """Escape codes are for terminals."""
    environment = {**os.environ, "NO_COLOR": "1"}
    code = "from holodrive.cli import main; import sys; sys.exit(main(['nothing']))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)
    assert result.returncode == 2
    assert "\033" not in result.stderr


def test_settings_are_for_the_robot_or_the_controller() -> None:
    """`controller.` goes to the controller as a number, all else to the robot as it stands."""
    robot, controller = split_settings(["wheel.front.radius=50mm", "controller.kp=2"])
    assert robot == {"wheel.front.radius": "50mm"}
    assert controller == {"kp": 2}


@pytest.mark.parametrize("setting", ["mass", "=3", "mass="])
def test_a_setting_without_key_or_value_is_refused(setting: str) -> None:
    """With an example of a right one."""
    with pytest.raises(InputError, match="KEY=VALUE"):
        split_settings([setting])


def test_poses_take_units() -> None:
    """Plain numbers are SI."""
    assert pose_of("50cm, 2, 180deg", "--goal") == pytest.approx((0.5, 2.0, 3.141592653589793))
    assert pose_of("-1e-1,.5", "--goal") == (-0.1, 0.5)


@pytest.mark.parametrize("text", ["", "1", "1,2,3,4", "1,x", "1,2deg", "1,2,3m", "nan,1"])
def test_wrong_poses_say_what_is_wanted(text: str) -> None:
    """Never a traceback for a slip of the hand."""
    with pytest.raises(InputError, match="--goal"):
        pose_of(text, "--goal")


def test_tables_align() -> None:
    """First column left, the others right."""
    assert table(("a", "bb"), [("long", 1), ("x", 22)]) == "a     bb\nlong   1\nx     22"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_a_script_for_the_shell(cli: Cli, shell: str) -> None:
    """It calls holodrive back."""
    answer = cli("completion", shell)
    assert answer.code == 0
    assert "_HOLODRIVE_COMPLETE" in answer.out


def test_completion_knows_the_verbs() -> None:
    """The group lists what the table lists."""
    assert app.list_commands(click.Context(app)) == list(VERBS)


def test_doctor_answers_each_question(cli: Cli) -> None:
    """One line a check; JSON has a verdict for each."""
    checks = json.loads(cli("doctor", "--json").out)
    assert {check["name"] for check in checks} >= {"python", "packages", "catalog", "cache", "serial", "disk", "clock"}
    assert {check["verdict"] for check in checks} <= {"ok", "note", "bad"}
