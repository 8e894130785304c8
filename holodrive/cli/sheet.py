"""Several SVG pictures side by side in one, each under its title."""

import re
from collections.abc import Sequence

from holodrive import svg

HEIGHT = 380.0  # px of every picture
GAP = 28.0
HEAD = 34.0
INK = "#1b2530"


def sheet(pictures: Sequence[tuple[str, str]], title: str) -> str:
    """One picture from (title, whole SVG) pairs; each is scaled to the same height."""
    parts, x = [], GAP
    for name, picture in pictures:
        width, height = _size(picture)
        scaled = max(width * HEIGHT / height, 150.0)
        frame = f'<svg x="{x:.1f}" y="{HEAD:.1f}" width="{scaled:.1f}" height="{HEIGHT:.1f}"'
        parts.append(re.sub(r'^<svg (.*?)width="[^"]*" height="[^"]*"', rf"{frame} \1", picture, count=1))
        style = {"font_size": 15, "font_family": "sans-serif", "font_weight": 600, "fill": INK}
        parts.append(svg.text(x + 0.5 * scaled, 22.0, name, text_anchor="middle", **style))
        x += scaled + GAP
    white = svg.element("rect", width=x, height=HEAD + HEIGHT + 8.0, fill="#fff")
    return svg.document(x, HEAD + HEIGHT + 8.0, white, *parts, title=title)


def _size(picture: str) -> tuple[float, float]:
    match = re.match(r'<svg [^>]*?width="([\d.]+)" height="([\d.]+)"', picture)
    if match is None:
        raise ValueError("an SVG picture begins with its width and height")
    return float(match[1]), float(match[2])
