"""A fuzzy system as one C99 file without dependencies, for a microcontroller.

It allocates nothing, keeps no state, and needs no library; with Gaussian or bell inputs it needs exp and pow of the
C library. Its tables are the kernel's own (`control.fuzzy.packing`), its steps the kernel's, so that in double it
gives the same numbers.
"""

import math
import re

from holodrive.control.fuzzy.files import c_export_text as c
from holodrive.control.fuzzy.files.c_export_outputs import Output, output_code
from holodrive.control.fuzzy.files.words import cannot, number, refuse_fuzzylab
from holodrive.control.fuzzy.membership import corners
from holodrive.control.fuzzy.sets import Set
from holodrive.control.fuzzy.system import Rule, System, Variable

MOST_OUTPUTS = 32  # bits of what the function returns


def c_source(system: System, header: bool = False) -> str:
    """C99 text with the function `NAME_evaluate`.

    Args:
        system: the system; NAME is its name in small letters, other characters as _.
        header: for a .h file to include: everything is `static inline`, with a guard.

    Raises:
        InputError: the system behaves as fuzzylab does, or has more than 32 outputs.
    """
    refuse_fuzzylab(system, "c")
    if len(system.outputs) > MOST_OUTPUTS:
        raise cannot(system, "c", f"{len(system.outputs)} outputs", f"it takes {MOST_OUTPUTS}; split the system")
    outputs = [output_code(system, index) for index in range(len(system.outputs))]
    parts = [_opening(system), *_includes(system), c.HEAD, *_pieces(system), *_unique(outputs)]
    text = "\n".join([*parts, _evaluate(system, outputs)])
    name = _identifier(system.name)
    text = text.replace("fz_", f"{name}_").replace("FZ_", f"{name.upper()}_")
    if not header:
        return text
    guard = f"{name.upper()}_H"
    text = re.sub(
        r"^(static |unsigned long )", lambda match: "static inline " + match[1].replace("static ", ""), text, flags=re.M
    )
    return f"#ifndef {guard}\n#define {guard}\n\n{text}\n#endif\n"


def _identifier(name: str) -> str:
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") or "system"
    return plain if plain[0].isalpha() else f"fuzzy_{plain}"


def comment(text: str) -> str:
    """Text that ends no comment early and begins none."""
    text = "".join(character if character.isprintable() else "?" for character in text)
    return text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def _opening(system: System) -> str:
    """What the file is, in a comment."""

    def listed(variables: tuple[Variable, ...]) -> list[str]:
        return [
            f"     {place} {one.name}, {number(one.low)} to {number(one.high)}{' ' * bool(one.unit)}{one.unit}"
            for place, one in enumerate(variables)
        ]

    lines = [
        f"Fuzzy system {system.name}, written by holodrive.",
        "",
        f"     {_signature(system)};",
        "",
        "   evaluates it. clamp: 1 brings inputs into their range first. Bit k of the result is 1 where",
        "   y[k] is its default because no rule fires or an input is not a number; 0 means that all is well.",
        "   Inputs x:",
        *listed(system.inputs),
        "   Outputs y:",
        *(
            f"{line}; default {'not a number' if math.isnan(one.default) else number(one.default)}"
            for line, one in zip(listed(system.outputs), system.outputs, strict=True)
        ),
    ]
    return "/* " + "\n".join(comment(line) for line in lines) + "\n*/"


def _includes(system: System) -> list[str]:
    curved = {one.kind for variable in system.inputs for one in variable.sets} & {"gaussian", "bell"}
    return ["#include <math.h>\n"] if curved else []


def _pieces(system: System) -> list[str]:
    """The functions that inputs and rules need."""
    used = [_set(system, *slot).kind for slot in _slots(system)]
    pieces = [c.CLAMP, c.HEARD]
    for kinds, piece in (
        (("triangle", "trapezoid"), c.TRAPEZOID),
        (("polyline",), c.POLYLINE),
        (("gaussian",), c.GAUSSIAN),
        (("bell",), c.BELL),
    ):
        if any(kind in kinds for kind in used):
            pieces.append(piece)
    joints = {rule.connective for rule in system.rules if sum(map(bool, rule.inputs)) > 1}
    if "and" in joints:
        pieces.append(c.AND[system.conjunction])
    if "or" in joints:
        pieces.append(c.OR[system.disjunction])
    return pieces


def _unique(outputs: list[Output]) -> list[str]:
    pieces: list[str] = []
    for output in outputs:
        pieces += [piece for piece in output.pieces if piece not in pieces]
    return pieces


def _slots(system: System) -> list[tuple[int, int]]:
    """(input, set) of all conditions that occur, each once, counted from 0."""
    found = {(i, abs(k) - 1) for rule in system.rules for i, k in enumerate(rule.inputs) if k}
    return sorted(found)


def _set(system: System, index: int, place: int) -> Set:
    return system.inputs[index].sets[place]


def real(value: float) -> str:
    """A constant."""
    return f"FZ_R({float(value)!r})"


def _degree(one: Set, x: str) -> str:
    """The C expression of a membership; polylines have their points in a table `p`."""
    match one.kind:
        case "triangle" | "trapezoid":
            return f"fz_trapezoid({', '.join(map(real, corners(one)))}, {x})"
        case "polyline":
            return f"fz_polyline(p, {len(one.params) // 2}, {x})"
        case "singleton":
            return f"{x} == {real(one.params[0])} ? FZ_R(1) : FZ_R(0)"
        case _:
            return f"fz_{one.kind}({', '.join(map(real, one.params))}, {x})"


def _signature(system: System) -> str:
    n_in, n_out = len(system.inputs), len(system.outputs)
    return f"unsigned long fz_evaluate(const fz_real x[{n_in}], fz_real y[{n_out}], int clamp)"


def _evaluate(system: System, outputs: list[Output]) -> str:
    n_in, n_out = len(system.inputs), len(system.outputs)
    slots = {slot: place for place, slot in enumerate(_slots(system))}
    lines = [
        _signature(system),
        "{",
        f"    fz_real in[{n_in}], m[{len(slots)}], s[{len(system.rules)}];",
        *(f"    {line}" for output in outputs for line in output.declarations),
        "    unsigned long silent = 0;",
        "",
    ]
    lines += [f"    y[{k}] = {_default(one)};" for k, one in enumerate(system.outputs)]
    everything = (1 << n_out) - 1
    missing = " || ".join(f"x[{i}] != x[{i}]" for i in range(n_in))
    lines += [f"    if ({missing})", f"        return {everything}UL;", ""]
    lines += [
        f"    in[{i}] = fz_clamped(x[{i}], {real(one.low)}, {real(one.high)}, clamp);"
        for i, one in enumerate(system.inputs)
    ]
    for (index, place), slot in slots.items():
        lines += _condition(system, index, place, slot)
    lines.append("")
    for count, rule in enumerate(system.rules):
        lines += [
            f"    /* {count + 1}: {comment(_sentence(system, rule))} */",
            f"    s[{count}] = {_strength(rule, slots)};",
        ]
    for output in outputs:
        lines += ["", *(f"    {line}" for line in output.statements)]
    return "\n".join([*lines, "    (void)in, (void)s; /* where nothing is concluded */", "    return silent;", "}", ""])


def _condition(system: System, index: int, place: int, slot: int) -> list[str]:
    one = _set(system, index, place)
    line = (
        f"m[{slot}] = {_degree(one, f'in[{index}]')}; /* {comment(system.inputs[index].name)} IS {comment(one.name)} */"
    )
    if one.kind != "polyline":
        return [f"    {line}"]
    points = ", ".join(map(real, one.params))
    return ["    {", f"        static const fz_real p[] = {{{points}}};", f"        {line}", "    }"]


def _default(variable: Variable) -> str:
    return "FZ_NONE" if math.isnan(variable.default) else real(variable.default)


def _strength(rule: Rule, slots: dict[tuple[int, int], int]) -> str:
    joined = ""
    for index, number_ in enumerate(rule.inputs):
        if number_:
            degree = f"m[{slots[index, abs(number_) - 1]}]"
            degree = f"1 - {degree}" if number_ < 0 else degree
            joined = f"fz_{rule.connective}({joined}, {degree})" if joined else degree
    weighted = f"({joined}) * {real(rule.weight)}" if rule.weight != 1.0 else joined
    return f"fz_heard({weighted})"


def _sentence(system: System, rule: Rule) -> str:
    conditions = [
        f"{one.name} IS {'NOT ' * (k < 0)}{one.sets[abs(k) - 1].name}"
        for k, one in zip(rule.inputs, system.inputs, strict=True)
        if k
    ]
    conclusions = [
        f"{one.name} IS {one.sets[k - 1].name}" for k, one in zip(rule.outputs, system.outputs, strict=True) if k
    ]
    return f"IF {f' {rule.connective.upper()} '.join(conditions)} THEN {', '.join(conclusions) or 'nothing'}"
