"""Pictures of many worlds side by side, for reports of experiments."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from holodrive.log.drawing import Trace, drawn, extent, framed
from holodrive.log.shapes import goal_shape, world_shapes
from holodrive.log.view import View
from holodrive.reports import parts
from holodrive.reports.plots import COLOURS, DASHES
from holodrive.types import Array
from holodrive.worlds.spec import World


@dataclass(frozen=True)
class Gallery:
    """A report section of small pictures, each with a caption."""

    title: str
    pictures: tuple[tuple[str, str], ...]
    note: str = ""

    def html(self) -> str:
        """What stands under the heading."""
        figures = "".join(
            f"<figure><figcaption>{escape(name)}</figcaption>{picture}</figure>" for name, picture in self.pictures
        )
        return parts.note(self.note) + f'<div class="worlds">{figures}</div>'


def paths_over(
    world: World, paths: Sequence[tuple[str, Array]], width: float = 300.0, height: float = 420.0, time_s: float = 0.0
) -> str:
    """Paths (T, 2 or more) [m] by name over a world as it stands at `time_s`, as one SVG document."""
    bounds = extent(world) or (-1.0, -1.0, 1.0, 1.0)
    view = View.fit(bounds, width, height, header=26.0)
    lines = [
        Trace(name, np.asarray(poses), f"c{i % len(COLOURS)}", COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)], 2.0)
        for i, (name, poses) in enumerate(paths)
    ]
    title = f"Paths over {world.name}: {', '.join(line.name for line in lines)}."
    return framed(
        view,
        [line for line in lines if line.name],
        title,
        goal_shape(world, view),
        world_shapes(world, view, time_s),
        *(drawn(line, view) for line in lines),
    )
