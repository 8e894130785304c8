"""What a world file may say in right form and still be wrong: a goal in an obstacle, a path back in time."""

from collections.abc import Sequence

from holodrive.files.scan import Path
from holodrive.files.source import Source, section
from holodrive.types import Pose
from holodrive.worlds.distances import GOAL_IN_OBSTACLE, covering, distance, obstacles
from holodrive.worlds.form import MoverForm, WallForm
from holodrive.worlds.spec import Segment, World

ACCEPTABLE = (GOAL_IN_OBSTACLE,)


def names(source: Source) -> None:
    """A name stands for one thing: --set and events use it."""
    first: dict[str, Path] = {}
    for kind in ("circle", "wall", "box", "mover"):
        entries = source.table.get(kind, [])
        for number, entry in enumerate(entries if isinstance(entries, list) else []):
            name = entry.get("name") if isinstance(entry, dict) else None
            if not isinstance(name, str) or not name:
                continue
            path: Path = (kind, number)
            if name in first:
                source.fault((*path, "name"), f"the name {name!r} is taken by {section(first[name])}")
            else:
                first[name] = path


def walls(found: Sequence[WallForm | None], source: Source) -> None:
    """A wall has a length."""
    for number, wall in enumerate(found):
        if wall is not None and (wall.start.x, wall.start.y) == (wall.end.x, wall.end.y):
            source.fault(("wall", number), f"[[wall]] {number + 1} begins and ends in the same point", at_key=True)


def paths(found: Sequence[MoverForm | None], source: Source) -> bool:
    """A mover's times grow; whether all paths can be used."""
    good = True
    for number, mover in enumerate(found):
        if mover is None:
            continue
        if not mover.path:
            source.fault(("mover", number, "path"), "a path needs at least one key frame")
            good = False
        for k in range(1, len(mover.path)):
            before, now = mover.path[k - 1].time, mover.path[k].time
            if now <= before:
                place = ("mover", number, "path", k, "time")
                source.fault(place, f"key frame {k + 1} is at {now:g} s, not after key frame {k} at {before:g} s")
                good = False
    return good


def start(world: World | None, source: Source) -> None:
    """The robot does not start in or on something, nor outside."""
    if world is None:
        return
    place, path = world.start, _place("start", source)
    if _outside(world, place):
        source.fault(path, f"start {_shown(place)} is outside the arena, {_arena(world)}", at_key=True)
        return
    for name, obstacle in obstacles(world):
        gap = float(distance(obstacle, place.x, place.y))
        if gap <= 0.0:
            word = "touches" if isinstance(obstacle, Segment) else "is inside"
            hint = "" if "start" in source.table else "write a [start] table with x and y"
            source.fault(path, f"start {_shown(place)} {word} {name}", hint, at_key=True)


def goal(world: World, accepted: Sequence[str], source: Source) -> None:
    """The goal can be reached, unless the file says that it knows."""
    accepts = GOAL_IN_OBSTACLE in accepted
    if world.goal is None:
        if accepts:
            source.fault(("world", "accept"), "there is no goal that could be in an obstacle; leave 'accept' out")
        return
    place, path = world.goal.pose, _place("goal", source)
    if _outside(world, place):
        source.fault(path, f"goal {_shown(place)} is outside the arena, {_arena(world)}", at_key=True)
    inside = list(covering(world))
    if accepts and not inside:
        source.fault(("world", "accept"), "the goal is in no obstacle; leave 'accept' out")
    for name, depth in inside:
        if not accepts:
            source.fault(
                path,
                f"goal {_shown(place)} is inside {name}",
                f'if that is meant, write accept = ["{GOAL_IN_OBSTACLE}"] under [world]',
                at_key=True,
            )
        elif world.goal.tolerance_m <= depth:
            source.fault(
                path,
                f"goal {_shown(place)} is {depth:.3g} m deep in {name}, more than its tolerance of "
                f"{world.goal.tolerance_m:.3g} m; nothing can reach it",
                at_key=True,
            )


def _place(table: str, source: Source) -> Path:
    """Where to point: at the table, or at the coordinate that `--set` gave it."""
    return next(((table, key) for key in ("x", "y") if (table, key) in source.settings), (table,))


def _outside(world: World, place: Pose) -> bool:
    if world.size is None:
        return False
    (x, y), (width, height) = world.corner, world.size
    return not (x <= place.x <= x + width and y <= place.y <= y + height)


def _arena(world: World) -> str:
    (x, y), (width, height) = world.corner, world.size or (0.0, 0.0)
    return f"x {x:g} to {x + width:g} m, y {y:g} to {y + height:g} m"


def _shown(place: Pose) -> str:
    return f"({place.x:g}, {place.y:g})"
