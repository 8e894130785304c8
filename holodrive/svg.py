"""SVG elements as text: the few that robots, worlds and plots are drawn with."""

from html import escape


def element(name: str, *children: str, **attributes: object) -> str:
    """`<name a="b">children</name>`; `_` in attribute names becomes `-`, a trailing `_` is dropped, None is left out."""
    text = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{_value(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{text}>{''.join(children)}</{name}>" if children else f"<{name}{text}/>"


def text(x: float, y: float, content: str, **attributes: object) -> str:
    """A text element with escaped content."""
    return element("text", escape(content), x=x, y=y, **attributes)


def document(width: float, height: float, *children: str, view_box: str | None = None, title: str = "") -> str:
    """A whole SVG picture of `width` x `height` pixels."""
    head = element("title", escape(title)) if title else ""
    return element(
        "svg",
        head,
        *children,
        xmlns="http://www.w3.org/2000/svg",
        width=width,
        height=height,
        viewBox=view_box or f"0 0 {_value(width)} {_value(height)}",
        role="img",
    )


def points(pairs: object) -> str:
    """`x,y x,y ...` for polylines and polygons, from an (n, 2) array or list."""
    return " ".join(f"{x:.5g},{y:.5g}" for x, y in pairs)  # type: ignore[attr-defined]


def _value(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else escape(str(value), quote=True)
