"""What to simulate, as plain data: a job goes into a file, to another process or to another machine as it is."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from holodrive import control, estimation, planning, robots, worlds
from holodrive.errors import InputError, UnknownName
from holodrive.interfaces import Plug
from holodrive.robots.spec import Robot
from holodrive.sim import period
from holodrive.worlds.spec import World

GENERATORS = ("course", "generate")  # of holodrive.worlds, by the number of the run
NUMBERS = 2**63  # of runs, 0 to this
AFTER_TRAJECTORY_S = 2.0  # for the robot to settle at the end
DEFAULT_S = {"course": 90.0}  # and 60 s for the others


@dataclass(frozen=True)
class Places:
    """Where the runs take place: worlds that a generator makes of a run's number, or a list to go round in.

    Attributes:
        generator: "course" or "generate" of `holodrive.worlds`; "" for the list.
        crossers: moving obstacles of a course.
        texts: worlds as TOML; run number k takes `texts[k % len(texts)]`.
    """

    generator: str = ""
    crossers: int = 0
    texts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if bool(self.generator) == bool(self.texts):
            raise InputError("a job takes place in worlds of a generator or in a list of worlds; give one of them")
        if self.generator and self.generator not in GENERATORS:
            raise UnknownName("generator of worlds", self.generator, GENERATORS)
        if self.crossers < 0 or (self.crossers and self.generator != "course"):
            raise InputError(f"crossers is {self.crossers}; courses have 0 or more of them, other worlds none")

    @classmethod
    def of(cls, *places: World | str) -> "Places":
        """A list of worlds, each a value, a catalog name or a file."""
        found = [place if isinstance(place, World) else worlds.load(place) for place in places]
        return cls(texts=tuple(place.text or worlds.dump(place) for place in found))


@dataclass(frozen=True)
class Job:
    """Runs of every variant of a controller under the same numbers: the same worlds with the same noise for all.

    Run number k takes place in world k (see `Places`) and draws the noise of robot k of `seed`, as
    `holodrive.sim.rollout(first=k)` defines it. So a run's outcome depends on its variant and its number, and on
    nothing that it is run together with.

    Attributes:
        robot: TOML text.
        places: worlds.
        controller: registered name, with a compiled kernel.
        params: its parameters, over its defaults.
        variants: fields over `params`, one mapping for each variant; an empty mapping is `params` as they are.
        reference: recipe for `planning.from_recipe`; None drives to each world's goal.
        first, count: numbers of the runs, first to first + count - 1.
        seed: of the noise.
        t: longest time of a run [s]; dt: physics step [s].
        plant: a name of `sim.period.PLANTS`.
        estimator: registered name, or "auto" (`estimation.default_name`); None lets the controller know the truth.
        start: pose (x, y, theta) [m, m, rad]; None takes each world's.
        stop_on_arrival: end a run when the controller says that it is there.
    """

    robot: str
    places: Places
    controller: str
    params: Mapping[str, Any] = field(default_factory=dict)
    variants: tuple[Mapping[str, Any], ...] = ({},)
    reference: Mapping[str, Any] | None = None
    first: int = 0
    count: int = 1
    seed: int = 0
    t: float = 60.0
    dt: float = 1e-3
    plant: str = "first_order"
    estimator: str | None = "auto"
    start: tuple[float, float, float] | None = None
    stop_on_arrival: bool = True

    def __post_init__(self) -> None:
        if not (self.count >= 1 and self.first >= 0 and self.first + self.count <= NUMBERS):
            raise InputError(f"a job takes 1 or more runs, numbered from 0 on; found {self.count} from {self.first} on")
        if not self.variants:
            raise InputError("a job takes 1 or more variants; an empty mapping is the parameters as they are")
        if not (self.t > 0.0 and math.isfinite(self.t) and 0.0 < self.dt <= self.t):
            raise InputError(f"a job takes t > 0 and 0 < dt <= t; found t={self.t} s, dt={self.dt} s")
        if self.plant not in period.PLANTS:
            raise UnknownName("plant", self.plant, period.PLANTS)

    @property
    def numbers(self) -> range:
        """Of the runs."""
        return range(self.first, self.first + self.count)

    def over(self, numbers: range) -> "Job":
        """The same under other numbers."""
        if len(numbers) < 1 or numbers.step != 1:
            raise InputError(f"runs are numbered without gaps; found {numbers}")
        return replace(self, first=numbers.start, count=len(numbers))

    def check(self) -> None:
        """Everything that a run of it would refuse, refused before anything is sent anywhere.

        Raises:
            InputError, UnknownName, FileFaults: robot, worlds, controller, parameters or reference cannot be.
        """
        robot = robots.parse(self.robot, "the job's robot")
        for variant in self.variants:
            control.compiled(self.controller, {**self.params, **variant})
        self.believer(robot)
        if self.reference is not None:
            planning.from_recipe(dict(self.reference))
        for text in self.places.texts:
            place = worlds.parse(text, "the job's world")
            if self.reference is None and place.goal is None:
                raise InputError(f"world {place.name!r} has no goal; give a goal or a path to follow")

    def believer(self, robot: Robot) -> Plug | None:
        """The estimator's plug for the job's robot; None lets the controller know the truth."""
        if self.estimator is None:
            return None
        return estimation.plug(estimation.default_name(robot) if self.estimator == "auto" else self.estimator)

    def to_json(self) -> str:
        """The whole job as one JSON text; `from_json` gives an equal job back."""
        return json.dumps(asdict(self) | {"params": dict(self.params), "variants": [dict(v) for v in self.variants]})

    @classmethod
    def from_json(cls, text: str) -> "Job":
        """The job that a JSON text holds.

        Raises:
            InputError: it is no job.
        """
        try:
            values = json.loads(text)
            known = {one.name for one in fields(cls)}
            if unknown := set(values) - known:
                raise InputError(f"a job has no {sorted(unknown)[0]!r}; known: {', '.join(sorted(known))}")
            values["places"] = Places(**values["places"] | {"texts": tuple(values["places"].get("texts", ()))})
            values["variants"] = tuple(values.get("variants", ({},)))
            values["start"] = None if values.get("start") is None else tuple(values["start"])
            return cls(**values)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"this is no job: {error}") from error


def job(
    robot: Robot | str,
    places: Places | World | str | Sequence[World | str],
    controller: str,
    *,
    goal: Sequence[float] | None = None,
    reference: Mapping[str, Any] | None = None,
    t: float | None = None,
    params: Mapping[str, Any] | None = None,
    **options: Any,
) -> Job:
    """A job of names, files and values; the whole of it is checked.

    Args:
        robot: value, catalog name or file.
        places: `Places`, "course" or "generate", or worlds as values, catalog names or files.
        controller: registered name.
        goal: pose (x, y, theta) [m, m, rad]; each world's own when neither it nor a reference is given.
        reference: recipe of a table (`table.recipe`).
        t: longest time of a run [s]; a trajectory's length and 2 s, 90 s for courses, else 60 s when None.
        params: of the controller; where it drives to a world's goal, that goal's tolerances are added to them.
        options: the other attributes of `Job`.
    """
    if goal is not None:
        if reference is not None:
            raise InputError("a job has a goal or a reference, not both")
        reference = planning.from_recipe({"kind": "goal", "pose": list(goal)}).recipe
    found = _places(places)
    if t is None:
        length = planning.from_recipe(dict(reference)).duration_s if reference else 0.0
        t = length + AFTER_TRAJECTORY_S if length else DEFAULT_S.get(found.generator, 60.0)
    described = robot if isinstance(robot, Robot) else robots.load(robot)
    made = Job(
        robots.dump(described), found, controller, dict(params or {}), reference=reference, t=float(t), **options
    )
    made.check()
    return made


def _places(places: Places | World | str | Sequence[World | str]) -> Places:
    if isinstance(places, Places):
        return places
    if isinstance(places, str) and places in GENERATORS:
        return Places(generator=places)
    return Places.of(*([places] if isinstance(places, World | str) else places))
