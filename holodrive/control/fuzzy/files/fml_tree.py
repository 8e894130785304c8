"""XML as a tree of elements with their lines. Nothing outside the text is read, and nothing in it is multiplied.

A document type with its entities is how small XML texts grow large ("billion laughs") or reach for other files; FML
needs none, so that one is refused where it begins.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from xml.parsers import expat

from holodrive.control.fuzzy.files.draft import Draft
from holodrive.errors import did_you_mean

DEEPEST = 20  # elements within each other; FML has seven

# element -> its attributes, its children
ELEMENTS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "fuzzySystem": (("name",), ("knowledgeBase", "mamdaniRuleBase", "tskRuleBase")),
    "fuzzyController": (("name",), ("knowledgeBase", "mamdaniRuleBase", "tskRuleBase")),
    "knowledgeBase": ((), ("fuzzyVariable", "tskVariable")),
    "fuzzyVariable": (
        ("name", "scale", "domainleft", "domainright", "type", "accumulation", "defuzzifier", "defaultValue"),
        ("fuzzyTerm",),
    ),
    "fuzzyTerm": (
        ("name", "complement"),
        (
            *("triangularShape", "trapezoidShape", "gaussianShape", "singletonShape", "rectangularShape"),
            *("rightLinearShape", "leftLinearShape", "pointSetShape", "customShape"),
        ),
    ),
    "triangularShape": (("param1", "param2", "param3"), ()),
    "trapezoidShape": (("param1", "param2", "param3", "param4"), ()),
    "gaussianShape": (("param1", "param2"), ()),
    "singletonShape": (("param1",), ()),
    "rectangularShape": (("param1", "param2"), ()),
    "rightLinearShape": (("param1", "param2"), ()),
    "leftLinearShape": (("param1", "param2"), ()),
    "pointSetShape": (("interpolationMethod", "degree"), ("point",)),
    "point": (("x", "y"), ()),
    "customShape": (("name",), ("parameter",)),
    "parameter": (("value",), ()),
    "tskVariable": (
        ("name", "scale", "type", "combination", "defaultValue", "domainleft", "domainright"),
        ("tskTerm",),
    ),
    "tskTerm": (("name", "order"), ("tskValue",)),
    "tskValue": ((), ()),
    "mamdaniRuleBase": (("name", "activationMethod", "andMethod", "orMethod"), ("rule",)),
    "tskRuleBase": (("name", "activationMethod", "andMethod", "orMethod"), ("tskRule",)),
    "rule": (("name", "andMethod", "orMethod", "connector", "weight"), ("antecedent", "consequent")),
    "tskRule": (("name", "andMethod", "orMethod", "connector", "weight"), ("antecedent", "tskConsequent")),
    "antecedent": ((), ("clause",)),
    "consequent": ((), ("then",)),
    "tskConsequent": ((), ("tskThen",)),
    "then": ((), ("clause",)),
    "tskThen": ((), ("tskClause",)),
    "clause": (("modifier",), ("variable", "term")),
    "tskClause": ((), ("variable", "term")),
    "variable": ((), ()),
    "term": ((), ()),
}


STRANGERS = {  # elements of the standard that are not read; none of them is a misspelling
    *("tsukamotoVariable", "aggregatedFuzzyVariable", "anYaDataCloud", "tsukamotoRuleBase", "anYaRuleBase", "else"),
    *("piShape", "zShape", "sShape", "leftGaussianShape", "rightGaussianShape", "circularDefinition", "tskElse"),
}


@dataclass(slots=True)
class Element:
    """An element: its name without prefix, attributes in small letters, text between its tags, children, comments."""

    tag: str
    line: int
    attributes: dict[str, str]
    children: list["Element"] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """What stands between the tags, without the spaces around it."""
        return "".join(self.texts).strip()

    def get(self, name: str, default: str = "") -> str:
        """An attribute."""
        return self.attributes.get(name.lower(), default)

    def all(self, tag: str) -> list["Element"]:
        """The children of a name."""
        return [child for child in self.children if child.tag == tag]


class _RefusedError(Exception):
    """Leaves the XML parser early; the fault is noted already."""


def tree(draft: Draft) -> Element:
    """The root of the text.

    Raises:
        FileFaults: it is not XML, has a document type, or an element or attribute that FML does not have there.
    """
    parser = expat.ParserCreate()
    stack = [Element("", 0, {})]

    def refuse(message: str, hint: str = "") -> None:
        draft.fault(parser.CurrentLineNumber, message, hint, parser.CurrentColumnNumber + 1)
        raise _RefusedError

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            refuse(f"more than {DEEPEST} elements stand within each other")
        given = {name.lower(): value for name, value in attributes.items()}
        element = Element(tag.rpartition(":")[2], parser.CurrentLineNumber, given)
        stack[-1].children.append(element)
        stack.append(element)

    def doctype(*_: object) -> None:
        refuse("the file has a document type (<!DOCTYPE ...>)", "remove it; FML needs none and entities are not read")

    def text(text: str) -> None:
        stack[-1].texts.append(text)

    def comment(text: str) -> None:
        stack[-1].comments.append(text)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: stack.pop()
    parser.CharacterDataHandler = text
    parser.CommentHandler = comment
    parser.StartDoctypeDeclHandler = doctype
    parser.EntityDeclHandler = doctype
    _run(parser, draft)
    draft.source.refuse()
    root = stack[0].children[0]
    if root.tag not in ("fuzzySystem", "fuzzyController"):
        draft.unknown(root.line, "root element", root.tag, ["fuzzySystem", "fuzzyController"])
    else:
        _check(draft, root)
    draft.source.refuse()
    return root


def _run(parser: expat.XMLParserType, draft: Draft) -> None:
    parse: Callable[[str, bool], object] = parser.Parse
    try:
        parse(draft.source.text, True)
    except expat.ExpatError as error:
        words = expat.ErrorString(error.code)
        draft.fault(error.lineno, f"not valid XML: {words}", "is the file cut off?" if error.code == 3 else "")
    except (UnicodeEncodeError, ValueError):
        draft.fault(0, "not valid XML: it holds characters that no text has")
    except _RefusedError:
        pass  # the fault was noted where it was found; reading only had to end


def _check(draft: Draft, element: Element) -> None:
    """That FML has the attributes and children here; a stranger's children are not looked at."""
    attributes, children = ELEMENTS[element.tag]
    known = {name.lower() for name in attributes}
    for name in element.attributes:
        if name not in known and name != "networkaddress" and not name.startswith(("xmlns", "xml:", "xsi:")):
            draft.unknown(element.line, f"attribute of <{element.tag}>", name, list(attributes))
    for child in element.children:
        if child.tag in children:
            _check(draft, child)
        else:
            near = did_you_mean(child.tag, children) if child.tag not in STRANGERS else ""
            read = f"read are: {', '.join(f'<{tag}>' for tag in children)}" if children else "it has no elements"
            draft.fault(child.line, f"<{child.tag}> is not read in <{element.tag}>{near}", read)
