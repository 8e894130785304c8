"""Pictures of a base: the chassis from above with its push axes, and the speeds that its wheels allow."""

import math
from typing import TYPE_CHECKING

import numpy as np

from holodrive import svg
from holodrive.kinematics.chassis import Chassis
from holodrive.kinematics.wheel import Wheel

if TYPE_CHECKING:
    from holodrive.robots.spec import Robot

_BODY, _WHEEL, _AXIS, _DRIVE, _INK, _FAINT = "#eef1f5", "#3b4252", "#d08770", "#2e7d4f", "#2e3440", "#b9c0cc"
_FONT = "font-family:system-ui,sans-serif"


def chassis_svg(robot: "Robot | Chassis", width: float = 480.0) -> str:
    """The base from above, x up and y left: wheels with names, rolling directions (green), roller axes (orange)."""
    chassis = robot if isinstance(robot, Chassis) else Chassis.of(robot)
    title = "chassis" if isinstance(robot, Chassis) else (robot.title or robot.name)
    reach = max(math.hypot(wheel.x, wheel.y) + 2.2 * wheel.radius + abs(wheel.caster) for wheel in chassis.wheels)
    footprint = 0.0 if isinstance(robot, Chassis) else robot.footprint_radius_m
    reach = 1.08 * max(reach, footprint)
    canvas = _Canvas(width, reach)
    parts = [_body(chassis, canvas)]
    if footprint:
        parts.append(canvas.circle(0.0, 0.0, footprint, fill="none", stroke=_FAINT, stroke_dasharray="4 4"))
    widths = [0.6 * wheel.radius for wheel in chassis.wheels]
    if not isinstance(robot, Chassis):
        widths = [spec.width for spec in robot.wheels]
    parts += [_wheel(wheel, wide, canvas) for wheel, wide in zip(chassis.wheels, widths, strict=True)]
    parts += [
        _axes(canvas),
        *(_name(wheel, canvas) for wheel in chassis.wheels),
        _scale_bar(canvas),
        _legend(chassis, width),
    ]
    return svg.document(width, width, *parts, title=title)


def polytope_svg(robot: "Robot | Chassis", omegas: tuple[float, ...] | None = None, width: float = 480.0) -> str:
    """Speeds (vx up, vy left) [m/s] that the wheels allow, one outline for each yaw rate [rad/s].

    Without `omegas`: 0, a third and two thirds of the fastest turn in place.
    """
    chassis = robot if isinstance(robot, Chassis) else Chassis.of(robot)
    turn = chassis.polytope.turn_in_place
    rates = omegas if omegas is not None else (0.0, turn / 3.0, 2.0 * turn / 3.0)
    sections = [chassis.polytope.section(rate) for rate in rates]
    reach = 1.25 * max((float(np.abs(section).max()) for section in sections if len(section)), default=1.0)
    canvas = _Canvas(width, reach)
    parts = [_grid(canvas)]
    shades = ("#2e7d4f", "#5e81ac", "#b48ead", "#d08770", "#bf616a")
    for i, (rate, section) in enumerate(zip(rates, sections, strict=True)):
        colour = shades[i % len(shades)]
        pairs = [canvas.at(x, y) for x, y in section]
        if pairs:
            parts.append(
                svg.element(
                    "polygon", points=svg.points(pairs), fill=colour, fill_opacity="0.12", stroke=colour, stroke_width=2
                )
            )
        parts.append(
            svg.text(12.0, 22.0 + 17.0 * i, f"omega = {rate:.3g} rad/s", fill=colour, font_size=13, style=_FONT)
        )
    return svg.document(width, width, *parts, title="speeds that the wheels allow")


class _Canvas:
    """Metres in robot axes (x up, y left) to pixels."""

    def __init__(self, width: float, reach: float) -> None:
        self.width, self.reach = width, reach
        self.scale = 0.5 * width / reach

    def at(self, x: float, y: float) -> tuple[float, float]:
        return 0.5 * self.width - y * self.scale, 0.5 * self.width - x * self.scale

    def circle(self, x: float, y: float, radius: float, **style: object) -> str:
        px, py = self.at(x, y)
        return svg.element("circle", cx=px, cy=py, r=radius * self.scale, **style)

    def line(self, a: tuple[float, float], b: tuple[float, float], **style: object) -> str:
        (x1, y1), (x2, y2) = self.at(*a), self.at(*b)
        return svg.element("line", x1=x1, y1=y1, x2=x2, y2=y2, **style)

    def arrow(self, start: tuple[float, float], angle: float, length: float, colour: str, width: float = 2.0) -> str:
        """An arrow in robot axes; `length` [m]."""
        end = (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))
        size = min(max(5.0, 0.22 * length * self.scale), 11.0) / self.scale
        barbs = [
            (end[0] - size * math.cos(angle + turn), end[1] - size * math.sin(angle + turn)) for turn in (0.45, -0.45)
        ]
        head = svg.element(
            "polygon", points=svg.points([self.at(*point) for point in (end, *barbs)]), fill=colour, stroke="none"
        )
        stop = (end[0] - 0.7 * size * math.cos(angle), end[1] - 0.7 * size * math.sin(angle))
        return self.line(start, stop, stroke=colour, stroke_width=width) + head


def _body(chassis: Chassis, canvas: _Canvas) -> str:
    """The hull of the wheel centres, in the order of their angle."""
    wheels = sorted(chassis.wheels, key=lambda wheel: math.atan2(wheel.y, wheel.x))
    pairs = svg.points([canvas.at(wheel.x, wheel.y) for wheel in wheels])
    return svg.element("polygon", points=pairs, fill=_BODY, stroke=_FAINT, stroke_width=1.5, stroke_linejoin="round")


def _wheel(wheel: Wheel, wide: float, canvas: _Canvas) -> str:
    """Tyre, rollers and arrows of one wheel, drawn in its own axes and turned into place."""
    px, py = canvas.at(wheel.x, wheel.y)
    long, short = 2.0 * wheel.radius * canvas.scale, max(wide * canvas.scale, 3.0)
    tyre = svg.element(
        "rect",
        x=-short / 2,
        y=wheel.caster * canvas.scale - long / 2,
        width=short,
        height=long,
        rx=short / 5,
        fill=_WHEEL,
        fill_opacity="0.85",
    )
    turned = svg.element("g", tyre, transform=f"translate({px:.2f} {py:.2f}) rotate({-math.degrees(wheel.yaw):.3f})")
    parts = [turned]
    here = (wheel.x, wheel.y)
    if wheel.steered:
        parts.append(
            canvas.circle(
                *here,
                1.25 * wheel.radius + abs(wheel.caster),
                fill="none",
                stroke=_AXIS,
                stroke_width=1.5,
                stroke_dasharray="5 3",
            )
        )
    else:
        # the roller axis is the direction in which the ground can push
        axis, half = wheel.push_axis, 1.6 * wheel.radius
        dx, dy = half * math.cos(axis), half * math.sin(axis)
        a, b = (wheel.x - dx, wheel.y - dy), (wheel.x + dx, wheel.y + dy)
        parts.append(canvas.line(a, b, stroke=_AXIS, stroke_width=2.5, stroke_linecap="round"))
    parts.append(canvas.arrow(here, wheel.yaw, 1.9 * wheel.radius, _DRIVE))
    return svg.element("g", *parts)


def _name(wheel: Wheel, canvas: _Canvas) -> str:
    """The wheel's name and kind, beside it on the side of the middle."""
    px, py = canvas.at(wheel.x, wheel.y)
    gap = 1.45 * wheel.radius * canvas.scale + 4.0
    if abs(wheel.y) > 0.25 * canvas.reach:
        px, anchor = (px + gap, "start") if wheel.y > 0.0 else (px - gap, "end")
    else:
        py, anchor = py + (gap + 6.0 if wheel.x >= 0.0 else -gap), "middle"
    halo: dict[str, object] = {"text_anchor": anchor, "style": _FONT, "stroke": "white", "paint_order": "stroke"}
    return svg.text(px, py - 1.0, wheel.name, fill=_INK, font_size=13, stroke_width=3, **halo) + svg.text(
        px, py + 12.0, wheel.kind, fill="#7b8494", font_size=11, stroke_width=3, **halo
    )


def _legend(chassis: Chassis, width: float) -> str:
    """What the colours mean."""
    entries = [("rolling direction", _DRIVE)]
    if len(chassis.steered) < len(chassis.wheels):
        entries.append(("roller axis", _AXIS))
    if chassis.steered:
        entries.append(("steered", _AXIS))
    return "".join(
        svg.text(width - 10.0, width - 12.0 - 15.0 * i, text, fill=colour, font_size=12, text_anchor="end", style=_FONT)
        for i, (text, colour) in enumerate(entries)
    )


def _axes(canvas: _Canvas) -> str:
    length = 0.22 * canvas.reach
    x, y = canvas.arrow((0, 0), 0.0, length, "#bf616a", 1.5), canvas.arrow((0, 0), math.pi / 2, length, "#5e81ac", 1.5)
    (ax, ay), (bx, by) = canvas.at(1.15 * length, 0.0), canvas.at(0.0, 1.15 * length)
    return (
        x + y
        + svg.text(ax + 6.0, ay + 4.0, "x", fill="#bf616a", font_size=12, style=_FONT)
        + svg.text(bx - 4.0, by - 6.0, "y", fill="#5e81ac", font_size=12, style=_FONT)
    )  # fmt: skip


def _scale_bar(canvas: _Canvas) -> str:
    length = _nice(0.5 * canvas.reach)
    x, y = 16.0, canvas.width - 16.0
    label = f"{length * 100:g} cm" if length < 1.0 else f"{length:g} m"
    return svg.element("line", x1=x, y1=y, x2=x + length * canvas.scale, y2=y, stroke=_INK, stroke_width=2) + svg.text(
        x, y - 6.0, label, fill=_INK, font_size=12, style=_FONT
    )


def _grid(canvas: _Canvas) -> str:
    """Circles of equal speed and the two axes."""
    step = _nice(0.4 * canvas.reach)
    parts = []
    for i in range(1, int(canvas.reach / step) + 1):
        parts.append(
            canvas.circle(0.0, 0.0, i * step, fill="none", stroke=_FAINT, stroke_width=1, stroke_dasharray="2 4")
        )
        px, py = canvas.at(-i * step * 0.7071, -i * step * 0.7071)
        parts.append(svg.text(px + 3.0, py, f"{i * step:g} m/s", fill="#7b8494", font_size=11, style=_FONT))
    for angle, label in ((0.0, "vx"), (math.pi / 2, "vy")):
        parts.append(canvas.arrow((0.0, 0.0), angle, 0.9 * canvas.reach, "#7b8494", 1.0))
        px, py = canvas.at(0.94 * canvas.reach * math.cos(angle), 0.94 * canvas.reach * math.sin(angle))
        parts.append(svg.text(px + 4.0, py - 6.0, label, fill="#7b8494", font_size=12, style=_FONT))
    return "".join(parts)


def _nice(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is at most `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-9))
