"""What tuning found, as a value and as a file that `--params` takes."""

import json
import math
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from holodrive.errors import InputError
from holodrive.tuning.judgement import Judgement
from holodrive.tuning.space import Range

SCHEMA = 1


@dataclass(frozen=True)
class Generation:
    """One step of the search.

    Attributes:
        runs: simulated so far.
        best, median: cost of its candidates.
        spread: of the next candidates, as a share of the ranges.
        values: field -> value of its best candidate.
    """

    runs: int
    best: float
    median: float
    spread: float
    values: dict[str, float]


@dataclass(frozen=True)
class Tuned:
    """The result of `tune`.

    Attributes:
        robot, controller, objective: by name, and the metric's text.
        base: parameters that stayed as they are.
        ranges: what was tuned, and how far it could go.
        start: field -> value, before. best: the same after; empty when nothing better was found.
        history: of the search.
        ended: "budget", "interrupted" or why the search had converged.
        before, after: over the held-out runs; None when it was interrupted before.
        gain: mean change of the cost over the held-out runs, and its 95 % interval.
        settings: what it takes to do it again.
    """

    robot: str
    controller: str
    objective: str
    base: Mapping[str, Any]
    ranges: tuple[Range, ...]
    start: Mapping[str, float]
    best: Mapping[str, float]
    history: tuple[Generation, ...]
    ended: str
    before: Judgement | None = None
    after: Judgement | None = None
    gain: tuple[float, float, float] | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def params(self) -> dict[str, Any]:
        """All parameters to give to the controller."""
        return {**self.base, **self.best}

    @property
    def options(self) -> str:
        """The parameters as options of the command line."""
        return shlex.join(
            word for key, value in self.params.items() for word in ("--set", f"controller.{key}={_text(value)}")
        )

    def to_json(self) -> str:
        """One JSON document; `from_json` gives an equal value back."""
        return json.dumps(_plain({"tuned": SCHEMA, **asdict(self), "params": self.params}), indent=2)

    @classmethod
    def from_json(cls, text: str, file: str = "tuned.json") -> "Tuned":
        """The result that a JSON text holds.

        Raises:
            InputError: it holds none.
        """
        try:
            values = json.loads(text, parse_constant=float)
            if values.pop("tuned") != SCHEMA:
                raise ValueError("of another version")
            values.pop("params")
            values["ranges"] = tuple(Range(**one) for one in values["ranges"])
            values["history"] = tuple(Generation(**one) for one in values["history"])
            for name in ("before", "after"):
                values[name] = Judgement.from_dict(_numbers(values[name])) if values[name] else None
            values["gain"] = tuple(values["gain"]) if values["gain"] else None
            return cls(**values)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"{file} is no result of holodrive tune: {error}") from error

    def save(self, path: str | Path) -> Path:
        """Write the JSON document; gives the path.

        Raises:
            InputError: it cannot be written.
        """
        try:
            Path(path).write_text(self.to_json() + "\n", encoding="utf-8")
        except OSError as error:
            raise InputError(f"the result cannot be written to {path}: {error.strerror}") from error
        return Path(path)


def read(path: str | Path) -> Tuned:
    """What `save` wrote.

    Raises:
        InputError: no such file, or no result in it.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    return Tuned.from_json(text, str(path))


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:
    """As strict JSON knows it: infinite numbers as words, NaN as null."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def _numbers(value: Any) -> Any:
    """Back from `_plain` where only numbers stand."""
    if isinstance(value, dict):
        return {key: _numbers(item) for key, item in value.items()}
    return math.nan if value is None else float(value) if isinstance(value, str) else value
