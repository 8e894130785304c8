"""The C of one output: what it declares, what it does, and the functions that it needs."""

from dataclasses import dataclass, field

from holodrive.control.fuzzy import packing as pk
from holodrive.control.fuzzy.files import c_export_text as c
from holodrive.control.fuzzy.system import System
from holodrive.types import Array


@dataclass(slots=True)
class Output:
    """Lines of C inside the function, and pieces before it."""

    declarations: list[str] = field(default_factory=list)
    statements: list[str] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)


def output_code(system: System, index: int) -> Output:
    """The C of an output in the kernel's form for it."""
    rules = [(r, rule.outputs[index] - 1) for r, rule in enumerate(system.rules) if rule.outputs[index]]
    if not rules:
        return Output(statements=[f"silent |= {1 << index}UL; /* no rule concludes y[{index}] */"])
    packed = system.packed
    at = int(packed[int(packed[pk.AT_OUTPUTS]) + index])
    form, n_sets, n_table = (int(packed[at + place]) for place in (pk.FORM, pk.N_SETS, pk.N_TABLE))
    table = packed[at + pk.TABLE :]
    if form == pk.SUGENO:
        return _sugeno(system, index, rules, table[: n_sets * (len(system.inputs) + 1)].reshape(n_sets, -1))
    heights = _heights(system, index, rules, n_sets)
    if form == pk.SINGLETONS:
        return _singletons(system, index, heights, table[:n_sets])
    n_cells = n_table * (2 + 2 * n_sets)
    cells = table[:n_cells].reshape(n_table, -1)
    if form == pk.ORDERED:
        return _ordered(system, index, heights, table[n_cells : n_cells + 5 * n_sets].reshape(n_sets, 5))
    return _cells(system, index, heights, rules, cells)


def _real(value: float) -> str:
    return f"FZ_R({float(value)!r})"


def _heights(system: System, index: int, rules: list[tuple[int, int]], n_sets: int) -> Output:
    output = Output([f"fz_real h{index}[{n_sets}] = {{0}};"], pieces=[c.RAISE[system.aggregation]])
    output.statements = [f"fz_raise(&h{index}[{number}], s[{r}]);" for r, number in rules]
    return output


def _concluded(index: int, condition: str, value: str) -> list[str]:
    return [
        f"if ({condition})",
        f"    y[{index}] = {value};",
        "else",
        f"    silent |= {1 << index}UL;",
    ]


def _sugeno(system: System, index: int, rules: list[tuple[int, int]], table: Array) -> Output:
    total, weights = f"t{index}", f"w{index}"
    output = Output([f"fz_real {total} = 0, {weights} = 0;"])
    for r, number in rules:
        *slopes, constant = table[number].tolist()
        terms = [_real(constant), *(f"{_real(k)} * in[{i}]" for i, k in enumerate(slopes) if k != 0.0)]
        output.statements += [
            f"if (s[{r}] > 0) {{",
            f"    {total} += s[{r}] * ({' + '.join(terms)});",
            f"    {weights} += s[{r}];",
            "}",
        ]
    value = f"{total} / {weights}" if system.defuzzification == "wtaver" else total
    output.statements += _concluded(index, f"{weights} > 0", value)
    return output


def _singletons(system: System, index: int, output: Output, places: Array) -> Output:
    n, method = len(places), system.defuzzification
    highest = method not in ("centroid", "bisector")
    piece = c.SINGLETONS["maxima" if highest else method]
    output.pieces += [c.LEVEL] * highest
    output.pieces.append(piece.replace("@PICK@", c.PICK.get(method, "")))
    output.declarations.append(f"static const fz_real u{index}[{n}] = {{{', '.join(map(_real, places.tolist()))}}};")
    fires = " || ".join(f"h{index}[{k}] > 0" for k in range(n))
    output.statements += _concluded(index, fires, f"fz_of_singletons(u{index}, h{index}, {n})")
    return output


def _ordered(system: System, index: int, output: Output, rows: Array) -> Output:
    piece = c.ORDERED
    for mark, value in (c.SCALED if system.implication == "prod" else c.CUT).items():
        piece = piece.replace(mark, value)
    output.pieces.append(piece)
    output.declarations.append(f"struct fz_union c{index} = {{0, 0, 0, 0, 0}};")
    for number, *corners in rows.tolist():
        shape = ", ".join(map(_real, corners))
        output.statements.append(f"fz_next(&c{index}, {shape}, h{index}[{int(number)}]);")
    output.statements += _concluded(index, f"c{index}.area > 0", f"c{index}.moment / c{index}.area")
    return output


def _cells(system: System, index: int, heights: Output, rules: list[tuple[int, int]], cells: Array) -> Output:
    """The general way: a function that walks over the cells, once or twice."""
    by_rule = system.aggregation == "sum" and system.implication == "min"  # cut, then added: each rule is a part
    n_sets = (cells.shape[1] - 2) // 2
    parts = [(f"v[{r}]", number) for r, number in rules] if by_rule else [(f"v[{k}]", k) for k in range(n_sets)]
    walk = [f"static void fz_walk{index}(struct fz_fold *f, const fz_real *v)", "{", "    @LINES@", "    int n;"]
    most = 0
    for row in cells.tolist():
        left, right = row[2 : 2 + n_sets], row[2 + n_sets :]
        lines = [(of, left[k], right[k]) for of, k in parts if left[k] > 0.0 or right[k] > 0.0]
        if lines:
            most = max(most, len(lines))
            walk.append("    n = 0;")
            walk += [f"    n = fz_line(l, n, {_real(y0)}, {_real(y1)}, {of});" for of, y0, y1 in lines]
            walk.append(f"    fz_cell(f, {_real(row[0])}, {_real(row[1])}, l, n);")
    if most == 0:
        return Output(statements=[f"silent |= {1 << index}UL; /* no set of y[{index}] reaches into its range */"])
    walk = [line.replace("@LINES@", f"struct fz_line l[{most}] = {{{{0, 0, 0}}}};") for line in walk]
    output = Output() if by_rule else heights
    output.pieces += [*_area(system), "\n".join([*walk, "}", ""])]
    output.declarations.append(f"struct fz_fold f{index} = {{0}};")
    output.statements += _folded(system, index, "s" if by_rule else f"h{index}")
    return output


def most_lines(system: System) -> int:
    """The most lines in one cell of all outputs: the size of the arrays that `fz_cell` has."""
    most = 1
    for index in range(len(system.outputs)):
        at = int(system.packed[int(system.packed[pk.AT_OUTPUTS]) + index])
        form, n_sets, n_table = (int(system.packed[at + place]) for place in (pk.FORM, pk.N_SETS, pk.N_TABLE))
        if form != pk.CELLS:
            continue
        rows = system.packed[at + pk.TABLE :][: n_table * (2 + 2 * n_sets)].reshape(n_table, -1)
        raised = (rows[:, 2 : 2 + n_sets] > 0.0) | (rows[:, 2 + n_sets :] > 0.0)  # (cells, sets)
        if system.aggregation == "sum" and system.implication == "min":
            weights = [sum(rule.outputs[index] == k + 1 for rule in system.rules) for k in range(n_sets)]
        else:
            weights = [1] * n_sets
        most = max(most, int((raised * weights).sum(axis=1).max(initial=0)))
    return most


def _area(system: System) -> list[str]:
    """The pieces for the aggregate in a cell, without the crossings that cannot be."""
    scales, adds = system.implication == "prod", system.aggregation == "sum"
    n = most_lines(system)
    crossings = "" if scales else c.LIDS_CROSS
    if not adds:
        crossings += c.LINES_CROSS if scales else c.LINES_CROSS + c.OTHER_LIDS_CROSS
    pairs = 0 if adds else n * (n - 1) // 2
    points = 2 + pairs + (0 if scales else n + 2 * pairs)
    loop = f"    for (i = 0; i < n; ++i) {{\n{crossings}    }}\n" if crossings else ""
    lines = (
        c.LINES.replace("@SCALE@", "height * " if scales else "")
        .replace("@LID@", "" if scales else c.LID)
        .replace("@JOIN@", "total += y;" if adds else "total = y > total ? y : total;")
    )
    if not crossings:  # scaled and added: straight in each cell
        start, end = lines.index("/* The place"), lines.index("static fz_real fz_height")
        lines = lines[:start] + lines[end:]
    fields, second, before = _second_pass(system.defuzzification)
    fold = (
        c.FOLD.replace("@FIELDS@", fields)
        .replace("@SECOND@", second)
        .replace("@POINTS@", str(points))
        .replace("@CROSSINGS@", loop)
        .replace("@DECLARE@", "" if adds else "    int j;\n")
    )
    return [lines, *before, fold]


def _second_pass(method: str) -> tuple[str, str, list[str]]:
    if method == "centroid":
        return "", "", []
    if method == "bisector":
        return c.BISECTOR_FIELDS, c.BISECTOR, [c.ROOT]
    return c.MAXIMA_FIELDS, c.MAXIMA, [c.LEVEL]


def _folded(system: System, index: int, values: str) -> list[str]:
    f, method = f"f{index}", system.defuzzification
    lines = [f"fz_walk{index}(&{f}, {values});"]
    if method == "centroid":
        return [*lines, *_concluded(index, f"{f}.total > 0", f"{f}.moment / {f}.total")]
    if method == "bisector":
        again, value = f"{f}.half = {f}.total / 2;", f"{f}.at"
    else:
        again = f"{f}.level = {f}.peak * FZ_LEVEL;"
        mean = f"{f}.length > 0 ? {f}.turn / {f}.length : {f}.sum / {f}.count"
        value = {"som": f"{f}.low", "lom": f"{f}.high", "mom": mean}[method]
    lines += [f"{f}.again = 1;", again, f"fz_walk{index}(&{f}, {values});"]
    return [*lines, *_concluded(index, f"{f}.total > 0", value)]
