"""Terms of FML: shapes of fuzzy terms, values of TSK terms."""

from holodrive.control.fuzzy.files.draft import Draft, DraftVariable
from holodrive.control.fuzzy.files.fml_tree import ELEMENTS, Element
from holodrive.control.fuzzy.sets import SetKind

_PLAIN: dict[str, SetKind] = {
    "triangularShape": "triangle",
    "trapezoidShape": "trapezoid",
    "gaussianShape": "gaussian",
    "singletonShape": "singleton",
}


def number(draft: Draft, element: Element, name: str, default: str | None = None) -> float:
    """An attribute that is a finite number, NaN after a fault."""
    text = element.attributes.get(name.lower(), default)
    if text is None:
        draft.fault(element.line, f"the <{element.tag}> has no {name}")
        return float("nan")
    return draft.number(text, element.line, f"{name} of <{element.tag}>")


def fuzzy_term(draft: Draft, element: Element, variable: DraftVariable) -> tuple[SetKind, list[float]] | None:
    """Kind and parameters of a <fuzzyTerm>; None after a fault."""
    if "name" not in element.attributes:
        draft.fault(element.line, f"a <fuzzyTerm> of {variable.name!r} has no name")
    if len(element.children) != 1:
        draft.fault(element.line, f"the <fuzzyTerm> has {len(element.children)} shapes; it takes one")
        return None
    shape = element.children[0]
    if shape.tag == "pointSetShape":
        return _points(draft, shape)
    if shape.tag == "customShape":
        return _custom(draft, shape)
    values = [number(draft, shape, name) for name in ELEMENTS[shape.tag][0]]
    if shape.tag in _PLAIN:
        return _PLAIN[shape.tag], values
    a, b = values
    if shape.tag == "rectangularShape":
        return "trapezoid", [a, a, b, b]
    heights = (0.0, 1.0) if shape.tag == "rightLinearShape" else (1.0, 0.0)
    return "polyline", [a, heights[0], b, heights[1]]


def _points(draft: Draft, shape: Element) -> tuple[SetKind, list[float]] | None:
    method = shape.get("interpolationMethod", "linear")
    if method != "linear":
        draft.unknown(shape.line, "interpolationMethod that is read", method, ["linear"])
        return None
    pairs = [(number(draft, one, "x"), number(draft, one, "y")) for one in shape.children]
    return "polyline", [value for pair in pairs for value in pair]


def _custom(draft: Draft, shape: Element) -> tuple[SetKind, list[float]] | None:
    if shape.get("name") != "custom_gbell":
        draft.unknown(shape.line, "custom shape", shape.get("name"), ["custom_gbell"])
        return None
    return "bell", [number(draft, one, "value") for one in shape.children]


def tsk_term(draft: Draft, element: Element, variable: DraftVariable) -> tuple[SetKind, list[float]] | None:
    """A <tskTerm>: order 0 is one value; order 1 is the constant and then one coefficient for each input."""
    values = [draft.number(one.text, one.line, f"a <tskValue> of {variable.name!r}") for one in element.children]
    order = element.get("order", "0" if len(values) == 1 else "1")
    if order not in ("0", "1"):
        draft.fault(element.line, f"order {order!r} of the <tskTerm> is not known", "known: 0, 1")
        return None
    wanted = 1 if order == "0" else len(draft.inputs) + 1
    if len(values) != wanted:
        draft.fault(
            element.line,
            f"the <tskTerm> of order {order} has {len(values)} values; it takes {wanted}",
            "the constant first, then one for each input; inputs stand before the outputs" if order == "1" else "",
        )
        return None
    return ("constant", values) if order == "0" else ("linear", [*values[1:], values[0]])


def settled_domains(draft: Draft) -> None:
    """The universe of a TSK output without one: all that its conclusions reach while inputs are in their universes."""
    if draft.options.get("kind") != "sugeno":
        return
    for output in draft.outputs:
        if output.low == output.low:  # it has one
            continue
        ends: list[float] = []
        for one in output.sets.values():
            *slopes, constant = one.params if one is not None else (0.0,)
            spans = [(k * each.low, k * each.high) for k, each in zip(slopes, draft.inputs, strict=False)]
            ends += [constant + sum(map(min, spans)), constant + sum(map(max, spans))]
        low, high = min(ends, default=0.0), max(ends, default=0.0)
        output.low, output.high = (low, high) if low < high else (low - 1.0, high + 1.0)
