"""A world as canonical TOML."""

from holodrive.files.write import table
from holodrive.worlds.distances import GOAL_IN_OBSTACLE, covering
from holodrive.worlds.spec import World


def text(world: World) -> str:
    """The whole file; a goal that lies in an obstacle is accepted by name."""
    accept = [GOAL_IN_OBSTACLE] if any(True for _ in covering(world)) else None
    blocks = [
        "#:schema world.schema.json\nschema = 1\n",
        table(
            ("world",),
            {"name": world.name, "title": world.title or None, "source": world.source or None, "accept": accept},
        ),
        _arena(world),
        table(("start",), {"x": world.start.x, "y": world.start.y, "heading": world.start.theta}),
    ]
    if world.goal is not None:
        blocks.append(_goal(world))
    return "\n".join([*blocks, *_obstacles(world)])


def _arena(world: World) -> str:
    width, height = world.size or (None, None)
    corner = {"x": world.corner[0], "y": world.corner[1]}
    return table(("arena",), {"width": width, "height": height, "corner": corner, "walls": world.walls})


def _goal(world: World) -> str:
    if world.goal is None:
        return ""
    goal = world.goal
    return table(
        ("goal",),
        {
            "x": goal.pose.x,
            "y": goal.pose.y,
            "heading": goal.pose.theta,
            "tolerance": goal.tolerance_m,
            "heading_tolerance": goal.tolerance_rad,
            "heading_matters": goal.heading_matters,
        },
    )


def _obstacles(world: World) -> list[str]:
    blocks = []
    for c in world.circles:
        blocks.append(_entry("circle", c.name, {"x": c.x, "y": c.y, "radius": c.radius}))
    for s in world.segments:
        ends: dict[str, object] = {"from": {"x": s.x1, "y": s.y1}, "to": {"x": s.x2, "y": s.y2}}
        blocks.append(_entry("wall", s.name, ends))
    for b in world.boxes:
        blocks.append(_entry("box", b.name, {"x": b.x, "y": b.y, "length": b.length, "width": b.width, "yaw": b.theta}))
    for m in world.movers:
        path = [{"time": k.time, "x": k.x, "y": k.y} for k in m.path]
        blocks.append(_entry("mover", m.name, {"radius": m.radius, "path": path, "loop": m.loop}))
    return blocks


def _entry(kind: str, name: str, values: dict[str, object]) -> str:
    return table((kind,), {"name": name or None, **values}, entry=True)
