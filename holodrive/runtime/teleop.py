"""Drive by keyboard in a terminal: keys by place, a dead man's switch, and always a way to stop.

A terminal tells presses, not releases, so a key counts as held until `hold_s` after its last repeat;
the first repeat comes late (commonly 0.25 to 0.5 s), hence the default.
"""

import os
import select
import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from holodrive.errors import InputError
from holodrive.interfaces import CommandKind
from holodrive.types import Decision, Estimate, Observation, Reference, Twist

HELP = """\
  q  w  e      turn left, forward, turn right
  a  s  d      left, back, right           arrow keys work as well
  +  -         faster, slower
  space        stop          x, Esc        end"""

# key -> direction of (vx, vy, omega)
KEYS: dict[str, tuple[float, float, float]] = {
    "w": (1, 0, 0),
    "s": (-1, 0, 0),
    "a": (0, 1, 0),
    "d": (0, -1, 0),
    "q": (0, 0, 1),
    "e": (0, 0, -1),
    "\x1b[A": (1, 0, 0),
    "\x1b[B": (-1, 0, 0),
    "\x1b[D": (0, 1, 0),
    "\x1b[C": (0, -1, 0),
}
END = {"x", "\x1b", "\x03"}


@dataclass(frozen=True)
class TeleopSettings:
    """How fast keys drive, and for how long a press counts."""

    speed_m_s: float = 0.1
    yaw_rate_rad_s: float = 0.5
    hold_s: float = 0.6
    factor: float = 1.25  # of + and -


class KeyTeleop:
    """An `interfaces.Controller` that follows the keys which `read` gives.

    Args:
        read: the keys pressed since the last call, each as one string.
        settings: see TeleopSettings.
    """

    command_kind: CommandKind = "twist"

    def __init__(self, read: Callable[[], list[str]], settings: TeleopSettings | None = None) -> None:
        self._read, self.settings = read, settings or TeleopSettings()
        self.reset()

    def reset(self) -> None:
        """All keys up, first speed."""
        self._until: dict[tuple[float, float, float], float] = {}
        self.scale, self.ended = 1.0, False

    def step(self, reference: Reference, estimate: Estimate, observation: Observation) -> Decision:
        """The twist of all keys that count as held; says arrived when the user ends."""
        for key in self._read():
            self._press(key, observation.time)
        held = [direction for direction, until in self._until.items() if observation.time < until]
        vx, vy, omega = (max(-1.0, min(1.0, sum(direction[i] for direction in held))) for i in range(3))
        v, w = self.scale * self.settings.speed_m_s, self.scale * self.settings.yaw_rate_rad_s
        return Decision(Twist(v * vx, v * vy, w * omega), arrived=self.ended)

    def _press(self, key: str, time: float) -> None:
        key = key.lower() if len(key) == 1 else key
        if key in KEYS:
            direction = KEYS[key]
            self._until.pop((-direction[0], -direction[1], -direction[2]), None)  # the newer of two opposites counts
            self._until[direction] = time + self.settings.hold_s
            return
        self._until.clear()  # any other key stops: space, a slip of the hand, the end
        if key in END:
            self.ended = True
        elif key in "+=":
            self.scale *= self.settings.factor
        elif key in "-_":
            self.scale /= self.settings.factor


class TerminalKeys:
    """The keys of the terminal, one by one, without waiting for a line's end; restores the terminal on leaving.

    Raises:
        InputError: when standard input is no terminal.
    """

    def __init__(self) -> None:
        self._saved: Any = None

    def __enter__(self) -> "TerminalKeys":
        if not sys.stdin.isatty():
            raise InputError("driving by keys needs a terminal as standard input; run this command in one")
        import termios
        import tty

        self._saved = termios.tcgetattr(sys.stdin)
        tty.setcbreak(sys.stdin)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        import termios

        if self._saved is not None:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._saved)
            self._saved = None

    def __call__(self) -> list[str]:
        """What was pressed since the last call."""
        data = b""
        while select.select([sys.stdin], [], [], 0.0)[0]:
            chunk = os.read(sys.stdin.fileno(), 1024)
            if not chunk:
                return ["x"]  # the terminal has gone: end
            data += chunk
        return split_keys(data.decode("utf-8", "replace"))


def split_keys(text: str) -> list[str]:
    """Single keys out of what a terminal sent: arrow keys are three characters."""
    keys, i = [], 0
    while i < len(text):
        step = 3 if text[i : i + 3] in KEYS else 1
        keys.append(text[i : i + step])
        i += step
    return keys
