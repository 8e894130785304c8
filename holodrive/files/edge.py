"""The file edge: pydantic forms with quantities, and pydantic's errors as faults with a place.

Imported only where a file is read; the forms live in `robots/form.py` and `worlds/form.py`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, TypeAdapter, ValidationError
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from holodrive.files.scan import Path
from holodrive.files.source import Source, meant, section
from holodrive.files.units import DIMENSIONS, QuantityError, parse, shown


class Form(BaseModel):
    """A table of a file: strict, without keys that nobody reads."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, populate_by_name=False)


@dataclass(frozen=True, slots=True)
class Quantity:
    """Annotation of a float that may be written with a unit, and the range in which it makes sense."""

    dimension: str
    low: float
    high: float
    above_low: bool = False

    def read(self, value: object) -> float:
        """The SI number, or the fault in one line."""
        try:
            number = parse(value, self.dimension)
        except QuantityError as error:
            raise custom(str(error), error.hint) from None
        if not self._allows(number):
            raise out_of_range(value, self.range, self._meant(value))
        return number

    def _allows(self, number: float) -> bool:
        return (self.low < number if self.above_low else self.low <= number) and number <= self.high

    def _meant(self, value: object) -> str:
        """A unit that makes a plain number fit: the usual slip is degrees or millimetres without a unit."""
        if isinstance(value, str) or self.dimension not in _SLIPS:
            return ""
        for unit in _SLIPS[self.dimension]:
            text = f"{value} {unit}"
            if self._allows(parse(text, self.dimension)):
                return f'did you mean "{text}"?'
        return ""

    @property
    def range(self) -> str:
        """The allowed values in words."""
        unit = DIMENSIONS[self.dimension].si
        unit = f" {unit}" if unit else ""
        low = f"above {self.low:g}" if self.above_low else f"{self.low:g}"
        return f"{low} to {self.high:g}{unit}"

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        dimension = DIMENSIONS[self.dimension]
        bound = "exclusiveMinimum" if self.above_low else "minimum"
        number = {"type": "number", bound: self.low, "maximum": self.high}
        text = {"type": "string", "pattern": _TEXT, "examples": [dimension.example]}
        return {"anyOf": [number, text]}


@dataclass(frozen=True, slots=True)
class Whole:
    """Annotation of an int between two bounds."""

    low: int
    high: int

    def read(self, value: object) -> int:
        """The number, or the fault in one line."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise custom(f"{shown(value)} is not a whole number")
        if not self.low <= value <= self.high:
            raise out_of_range(value, f"{self.low} to {self.high}")
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


_SLIPS = {"angle": ("deg",), "length": ("mm", "cm"), "time": ("ms",)}
_TEXT = "^\\s*[-+\u2212]?\\s?(\\d+\\.?\\d*|\\.\\d+)([eE][-+]?\\d+)?\\s*[^\\s\\d.,].*$"

F = TypeVar("F", bound=Form)

# positions in files, up to the size of a large hall; radii and so on have their own ranges in the forms
Coordinate = Annotated[float, Quantity("length", -1e4, 1e4)]
Distance = Annotated[float, Quantity("length", 0.0, 1e4)]
Angle = Annotated[float, Quantity("angle", -12.6, 12.6)]  # two turns: catches degrees written without a unit
Ratio = Annotated[float, Quantity("number", 0.0, 1.0)]


def custom(message: str, hint: str = "") -> PydanticCustomError:
    """An error of our own words inside a validator."""
    return PydanticCustomError("holodrive", "{message}", {"message": message, "hint": hint})


def out_of_range(value: object, allowed: str, hint: str = "") -> PydanticCustomError:
    """A number that makes no sense there; its key is put before it."""
    message = f"{shown(value)} is out of range; allowed: {allowed}"
    return PydanticCustomError("out_of_range", "{message}", {"message": message, "hint": hint})


def check(
    form: type[F], table: object, path: Path, source: Source, *, also: Mapping[str, str] | None = None
) -> tuple[F | None, dict[str, Any]]:
    """Check one table against its form and note all its faults.

    Args:
        form: what the table must be.
        table: what was found there.
        path: where in the file.
        source: takes the faults.
        also: keys that must be there besides those without default, with what they are for.

    Returns:
        The form (None when it has faults) and the fields that are right by themselves, by attribute name,
        so that checks across fields can still be made and all faults come at once.
    """
    if not isinstance(table, dict):
        source.fault(path, f"{shown(table)} stands where a table {section(path)} should be")
        return None, {}
    before = len(source.faults) + source.unlisted
    for key, why in (also or {}).items():
        if key not in table:
            source.fault(path, f"{section(path)} needs '{key}': {why}", at_key=True)
    try:
        filled = form.model_validate(table)
    except ValidationError as error:
        for detail in error.errors(include_url=False, include_input=True):
            if source.full:
                source.unlisted += 1
            else:
                _note(form, path, dict(detail), source)
        return None, _right_fields(form, table)
    fields = {name: getattr(filled, name) for name in filled.model_fields_set}
    return (filled if len(source.faults) + source.unlisted == before else None), fields


def _right_fields(form: type[Form], table: dict[str, Any]) -> dict[str, Any]:
    right = {}
    for name, info in form.model_fields.items():
        key = info.alias or name
        if key in table:
            annotated: Any = Annotated[(info.annotation, *info.metadata)] if info.metadata else info.annotation
            try:
                right[name] = TypeAdapter(annotated).validate_python(table[key], strict=True)
            except ValidationError:
                continue
    return right


def _note(form: type[Form], path: Path, detail: dict[str, Any], source: Source) -> None:
    location, kind, found = tuple(detail["loc"]), detail["type"], detail.get("input")
    place = path + location
    key = location[-1] if location else ""
    if kind == "holodrive":
        source.fault(place, detail["ctx"]["message"], detail["ctx"]["hint"])
    elif kind == "out_of_range":
        source.fault(place, f"{key} {detail['ctx']['message']}", detail["ctx"]["hint"])
    elif kind == "extra_forbidden":
        known = known_keys(form, location[:-1])
        source.fault(place, f"unknown key '{key}' in {section(place[:-1])}", meant(str(key), known), at_key=True)
    elif kind == "missing":
        source.fault(place[:-1], f"{section(place[:-1])} needs '{key}': {_purpose(form, location)}", at_key=True)
    elif kind == "literal_error":
        words = [word.strip().strip("'") for word in detail["ctx"]["expected"].replace(" or ", ",").split(",")]
        hint = meant(found, words) if isinstance(found, str) else ""
        what = f"{key} {shown(found)} is not known; choose {_choice(words)}"
        source.fault(place, what, hint if hint.startswith("did") else "")
    else:
        source.fault(place, f"{shown(found)} is not {_EXPECTED.get(kind, detail['msg'])}")


_EXPECTED = {
    "string_type": "text",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "model_type": "a table { key = value, ... }",
    "model_attributes_type": "a table { key = value, ... }",
    "dict_type": "a table { key = value, ... }",
}


def known_keys(form: type[Form], location: Path) -> list[str]:
    """The keys of the form, or of the form nested in it at `location`."""
    nested = _nested(form, location)
    return [info.alias or name for name, info in nested.model_fields.items()]


def _purpose(form: type[Form], location: Path) -> str:
    nested = _nested(form, location[:-1])
    for name, info in nested.model_fields.items():
        if (info.alias or name) == location[-1]:
            return info.description or ""
    return ""


def _nested(form: type[Form], location: Path) -> type[Form]:
    for part in location:
        for name, info in form.model_fields.items():
            if (info.alias or name) == part:
                inner = _form_of(info.annotation)
                form = inner or form
    return form


def _form_of(annotation: Any) -> type[Form] | None:
    if isinstance(annotation, type):
        return annotation if issubclass(annotation, Form) else None
    for argument in getattr(annotation, "__args__", ()):
        found = _form_of(argument)
        if found is not None:
            return found
    return None


def _choice(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
