"""The verbs in one table, and the help that follows from it; imports nothing, so that help comes at once."""

# verb -> what it does; the module is holodrive.cli.commands.<verb>
VERBS = {
    "demo": "drive three robots, replay a recorded one, write a page",
    "run": "drive one robot in one world",
    "compare": "controllers or recorded runs side by side",
    "reproduce": "a paper's tables and figures: printed value, ours, verdict",
    "tune": "better parameters for a controller, by simulation",
    "calibrate": "measure motors or ball mice, and write what was found into the robot's file",
    "replay": "look at a log or a recording of a real robot again",
    "render": "a run as GIF, PNG, SVG or HTML",
    "export": "a run as CSV or Parquet",
    "kinematics": "Jacobian, rank, condition and top speeds of a base",
    "explain": "what a fuzzy system does and why, and what is wrong with it",
    "list": "robots, worlds, controllers, motors, sensors that there are",
    "new": "a commented start for a robot, world or controller",
    "check": "look for faults in robot, world and fuzzy files",
    "bench": "how fast it is on this machine",
    "doctor": "whether this machine has all it takes",
    "completion": "tab completion for your shell",
    "version": "the version, and those of what it stands on",
}

_WIDTH = max(map(len, VERBS)) + 2

HELP = f"""\
Usage: holodrive [OPTIONS] VERB ...

  Describe, simulate, drive, record and replay omnidirectional robots.

Verbs:
{chr(10).join(f"  {verb:<{_WIDTH}}{text}" for verb, text in VERBS.items())}

Options:
  -q, --quiet    no progress and no hints
  -v, --verbose  say more; show the trace of an error
  --version      say the version
  -h, --help     say this

  Results go to standard output, progress and hints to standard error.
  Exit codes: 0 ok, 1 failed check, 2 wrong input, 3 hardware fault, 130 Ctrl-C.

Start with:
  holodrive demo
  holodrive run hybrid3 -w paper_course --via 0.5,0.5 --via 1,1.5 --via 0.5,4.5 -o run.mcap
  holodrive VERB --help
"""
