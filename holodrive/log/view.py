"""A window onto the floor: metres to pixels, with grid and scale bar."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holodrive import svg
from holodrive.types import Array, Pose

Bounds = tuple[float, float, float, float]  # x_min, y_min, x_max, y_max [m]

_MARGIN_LEFT, _MARGIN_BOTTOM, _MARGIN = 40.0, 36.0, 10.0  # px, room for the numbers on the axes


@dataclass(frozen=True)
class View:
    """Where a piece of floor stands on a picture.

    Attributes:
        bounds: the piece of floor [m].
        scale: [px/m].
        left, top, width, height: the plot area on the picture [px].
    """

    bounds: Bounds
    scale: float
    left: float
    top: float
    width: float
    height: float

    @classmethod
    def fit(cls, bounds: Bounds, width: float, height: float, *, margins: bool = True, header: float = 0.0) -> "View":
        """The largest view of `bounds` in a picture of at most `width` x `height` px, below a header of some px."""
        left, bottom, edge = (_MARGIN_LEFT, _MARGIN_BOTTOM, _MARGIN) if margins else (0.0, 0.0, 0.0)
        wide, high = max(bounds[2] - bounds[0], 1e-6), max(bounds[3] - bounds[1], 1e-6)
        scale = min((width - left - edge) / wide, (height - bottom - edge - header) / high)
        return cls(bounds, scale, left, edge + header, wide * scale, high * scale)

    @property
    def picture(self) -> tuple[float, float]:
        """Width and height of the whole picture [px], margins included."""
        margins = self.left > 0.0
        return (
            self.left + self.width + (_MARGIN if margins else 0.0),
            self.top + self.height + (_MARGIN_BOTTOM if margins else 0.0),
        )

    def x(self, x: Any) -> Any:
        """Pixel column of places [m]."""
        return self.left + (x - self.bounds[0]) * self.scale

    def y(self, y: Any) -> Any:
        """Pixel row of places [m]; up is up."""
        return self.top + self.height - (y - self.bounds[1]) * self.scale

    def pixels(self, xy: Array) -> Array:
        """Pixels (..., 2) of places (..., 2 or more)."""
        xy = np.asarray(xy, dtype=np.float64)
        return np.stack([self.x(xy[..., 0]), self.y(xy[..., 1])], axis=-1)

    def path(self, xy: Array, **attributes: object) -> str:
        """A polyline through places (n, 2 or more), thinned to what can be seen."""
        data = svg.path_data(svg.simplify(self.pixels(xy)))
        return svg.element("path", d=data, **({"fill": "none"} | attributes)) if data else ""

    def place(self, pose: Pose, *children: str, **attributes: object) -> str:
        """A group whose children are drawn in metres in the frame of `pose`."""
        return svg.element("g", *children, transform=self.transform(pose), **attributes)

    def transform(self, pose: Pose) -> str:
        """SVG transform from metres in the frame of `pose` to pixels."""
        degrees = float(np.degrees(pose.theta))
        turn = f"rotate({degrees:.2f})" if np.isfinite(degrees) else ""
        return f"translate({self.x(pose.x):.2f} {self.y(pose.y):.2f})scale({self.scale:.4f} {-self.scale:.4f}){turn}"


def around(places: Iterable[Array], margin: float) -> Bounds | None:
    """The box about all finite places (each (n, 2 or more)), wider by `margin` [m]; None without any."""
    stacked = [np.asarray(p, dtype=np.float64).reshape(-1, np.shape(p)[-1])[:, :2] for p in places if np.size(p)]
    points = np.concatenate(stacked) if stacked else np.empty((0, 2))
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return None
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return float(x0 - margin), float(y0 - margin), float(x1 + margin), float(y1 + margin)


def union(*boxes: Bounds | None) -> Bounds:
    """The box about all boxes; 2 m about the origin when there is none."""
    known = [box for box in boxes if box is not None]
    if not known:
        return (-1.0, -1.0, 1.0, 1.0)
    return (
        min(b[0] for b in known),
        min(b[1] for b in known),
        max(b[2] for b in known),
        max(b[3] for b in known),
    )


def grid(view: View) -> str:
    """Lines at round metres, with numbers along the left and lower edge."""
    x0, y0, x1, y1 = view.bounds
    right, bottom = view.left + view.width, view.top + view.height
    # one step for both axes, so that cells are squares
    span, room = (x1 - x0, view.width) if view.width >= view.height else (y1 - y0, view.height)
    steps, decimals = svg.ticks(0.0, span, max(2, int(room // 70)))
    step = steps[1] - steps[0] if len(steps) > 1 else span
    columns = np.arange(np.ceil(x0 / step - 1e-9), np.floor(x1 / step + 1e-9) + 1) * step
    rows = np.arange(np.ceil(y0 / step - 1e-9), np.floor(y1 / step + 1e-9) + 1) * step
    lines = "".join(f"M{view.x(x):.1f} {view.top:.1f}V{bottom:.1f}" for x in columns)
    lines += "".join(f"M{view.left:.1f} {view.y(y):.1f}H{right:.1f}" for y in rows)
    texts = [
        svg.text(view.x(x), bottom + 14, svg.number(x, decimals), text_anchor="middle", **_NUMBER) for x in columns
    ]
    texts += [
        svg.text(view.left - 6, view.y(y) + 4, svg.number(y, decimals), text_anchor="end", **_NUMBER) for y in rows
    ]
    return (
        svg.element("rect", class_="floor", x=view.left, y=view.top, width=view.width, height=view.height, fill="#fff")
        + svg.element("path", class_="grid", d=lines, stroke="#e3e6ea", stroke_width=1, fill="none")
        + svg.element("g", *texts)
    )


def scale_bar_length(view: View) -> tuple[float, str]:
    """A round length [m] of up to a third of the plot's width, and how it is told."""
    lengths, decimals = svg.ticks(0.0, 0.3 * view.width / view.scale, 2)
    length = float(lengths[-1])
    return length, f"{svg.number(length, decimals)} m" if length >= 0.1 else f"{svg.number(1e3 * length, 0)} mm"


def scale_bar(view: View) -> str:
    """A bar of a round length at the lower right, outside the plot area."""
    length, label = scale_bar_length(view)
    right, row = view.left + view.width, view.top + view.height + 26
    left = right - length * view.scale
    bar = f"M{left:.1f} {row - 4:.1f}v8M{left:.1f} {row:.1f}H{right:.1f}M{right:.1f} {row - 4:.1f}v8"
    return svg.element("path", class_="ink-line", d=bar, stroke="#3c4654", stroke_width=1.5, fill="none") + svg.text(
        left - 6, row + 4, label, text_anchor="end", **_NUMBER
    )


def axis_names(view: View) -> str:
    """What the numbers are: x and y in metres."""
    row = view.top + view.height + 30
    return svg.text(view.left, row, "x →, y ↑ in metres", **_NUMBER)


_NUMBER: dict[str, object] = {"class_": "number", "font_size": 11, "fill": "#5b6675", "font_family": "sans-serif"}
