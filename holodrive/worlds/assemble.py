"""From the tables of a world file to a `World`, with every fault of the file noted on the way."""

from collections.abc import Iterable
from typing import Any, TypeVar

from holodrive.files.edge import Form, check
from holodrive.files.source import Source, meant
from holodrive.files.units import shown
from holodrive.types import Pose
from holodrive.worlds import checks
from holodrive.worlds.form import (
    ArenaForm,
    BoxForm,
    CircleForm,
    GoalForm,
    MoverForm,
    StartForm,
    WallForm,
    WorldForm,
)
from holodrive.worlds.spec import Box, Circle, Goal, KeyFrame, Mover, Segment, World

F = TypeVar("F", bound=Form)

SECTIONS = ("schema", "world", "arena", "start", "goal", "circle", "wall", "box", "mover")


def world(source: Source) -> World:
    """The world of a file; raises FileFaults with all its faults."""
    for key, value in source.table.items():
        if key not in SECTIONS:
            what = f"unknown table [{key}]" if isinstance(value, dict | list) else f"unknown key '{key}'"
            source.fault((key,), what, meant(key, SECTIONS), at_key=True)
    base, fields = _base(source)
    arena, _ = check(ArenaForm, source.table.get("arena", {}), ("arena",), source)
    start, _ = check(StartForm, source.table.get("start", {}), ("start",), source)
    goal = _goal(source) if "goal" in source.table else None
    circles = _entries(CircleForm, "circle", source)
    walls = _entries(WallForm, "wall", source)
    boxes = _entries(BoxForm, "box", source)
    movers = _entries(MoverForm, "mover", source)
    found = World(
        name=base.name if base else "",
        title=base.title if base else "",
        source=base.source if base else "",
        size=_size(arena, source),
        corner=(arena.corner.x, arena.corner.y) if arena else (0.0, 0.0),
        walls=arena.walls if arena else False,
        start=Pose(start.x, start.y, start.heading) if start else Pose(0.0, 0.0, 0.0),
        goal=goal,
        circles=tuple(Circle(c.x, c.y, c.radius, c.name) for c in _good(circles)),
        segments=tuple(Segment(w.start.x, w.start.y, w.end.x, w.end.y, w.name) for w in _good(walls)),
        boxes=tuple(Box(b.x, b.y, b.length, b.width, b.yaw, b.name) for b in _good(boxes)),
        movers=tuple(
            Mover(m.radius, tuple(KeyFrame(k.time, k.x, k.y) for k in m.path), m.loop, m.name) for m in _good(movers)
        ),
        text=source.text,
    )
    checks.names(source)
    checks.walls(walls, source)
    if checks.paths(movers, source):
        checks.start(found if start else None, source)
        checks.goal(found, fields.get("accept", []), source)
    source.refuse()
    return found


def _base(source: Source) -> tuple[WorldForm | None, dict[str, Any]]:
    if "world" not in source.table:
        source.fault((), "the file has no [world] table; it needs name")
        return None, {}
    base, fields = check(WorldForm, source.table["world"], ("world",), source)
    for number, name in enumerate(fields.get("accept", [])):
        if name not in checks.ACCEPTABLE:
            place = ("world", "accept", number)
            source.fault(place, f"{shown(name)} cannot be accepted", meant(name, checks.ACCEPTABLE))
    return base, fields


def _size(arena: ArenaForm | None, source: Source) -> tuple[float, float] | None:
    if arena is None or (arena.width is None and arena.height is None):
        return None
    if arena.width is None or arena.height is None:
        missing = "height" if arena.height is None else "width"
        source.fault(
            ("arena",), f"[arena] needs '{missing}' too; without width and height the floor is open", at_key=True
        )
        return None
    return arena.width, arena.height


def _goal(source: Source) -> Goal | None:
    form, _ = check(GoalForm, source.table["goal"], ("goal",), source)
    if form is None:
        return None
    if form.heading_matters and form.heading is None:
        source.fault(("goal", "heading_matters"), "[goal] has no 'heading' that could matter")
    return Goal(
        pose=Pose(form.x, form.y, 0.0 if form.heading is None else form.heading),
        tolerance_m=form.tolerance,
        tolerance_rad=form.heading_tolerance,
        heading_matters=form.heading is not None if form.heading_matters is None else form.heading_matters,
    )


def _entries(form: type[F], kind: str, source: Source) -> list[F | None]:
    table = source.table.get(kind, [])
    if not isinstance(table, list):
        source.fault(
            (kind,), f"{shown(table)} stands where a list should be; write [[{kind}]] in double brackets", at_key=True
        )
        return []
    return [check(form, entry, (kind, number), source)[0] for number, entry in enumerate(table)]


def _good(forms: Iterable[F | None]) -> list[F]:
    return [form for form in forms if form is not None]
