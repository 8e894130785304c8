"""Tables VII and VIII: the two rule tables of one controller, and what the linter says of them."""

from holodrive.control import fuzzy
from holodrive.experiments.claims import Claim
from holodrive.experiments.experiment import Result, Setting
from holodrive.experiments.hybrid import printed
from holodrive.reports.fuzzy import finding_table
from holodrive.reports.sections import TableSection
from holodrive.reports.tables import Table, table

REMARKS = {  # findings of the linter about single rules
    "F-TOWARD": "turns to the near side",
    "F-TOWARD-BACK": "reverses, nose to the near side",
    "F-BACK": "reverses straight although a side is open",
    "F-STRAIGHT": "goes straight past a near side",
    "F-BLIND": "reverses blindly",
}


def table_vii(setting: Setting) -> Result:
    """Claims about Table VII."""
    vii = fuzzy.load("paper_vii")
    claims = (
        _same(),
        Claim("Table VII", "numbers of the rules", "1 to 9, three times", "1 to 27", "not comparable",
              note="each of the columns (A), (B), (C) begins with 'Rule 1'"),
        Claim("abstract", "states", printed.STATES, str(len(vii.rules)), "contradicts itself",
              note=f"three sets on three inputs are 27 states; the table has {_pairs(vii)} different output pairs"),
        Claim("Table VII", "rules that reverse", None, _listed(concerned("paper_vii", "F-BLIND")), "not printed",
              note="all nine with the head near: driven by Table VII alone a robot backs off and comes again"),
        Claim("Table VII", "of these, nose turned to the nearer side", None,
              _listed(concerned("paper_vii", "F-TOWARD-BACK")), "not printed",
              note="right only if L and R are exchanged, as the paper's library does"),
        Claim("Table VII", "rules that go straight past a near side", None,
              _listed(concerned("paper_vii", "F-STRAIGHT")), "not printed"),
    )  # fmt: skip
    return Result(claims, (_side_by_side(), _findings("paper_vii")), _data("paper_vii"))


def table_viii(setting: Setting) -> Result:
    """Claims about Table VIII."""
    viii = fuzzy.load("paper_viii")
    claims = (
        _same(),
        Claim("Table VIII", "rules that turn ahead into the near side", None,
              _listed(concerned("paper_viii", "F-TOWARD")), "not printed",
              note="far, far, near: an obstacle on the right, and the robot turns right; Table VII has it left"),
        Claim("Table VIII", "rules that go straight past one near side", None,
              _listed(concerned("paper_viii", "F-STRAIGHT")), "not printed",
              note="Table VII turns away from the near side in all of them"),
        Claim("Table VIII", "different output pairs", None, str(_pairs(viii)), "not printed"),
    )  # fmt: skip
    return Result(claims, (_side_by_side(), _findings("paper_viii")), _data("paper_viii"))


def concerned(profile: str, code: str) -> list[int]:
    """Numbers of the rules that the linter names under a code."""
    found = fuzzy.load(profile).lint(sensor_range=printed.SENSOR_MM)
    return sorted({number for one in found if one.code == code for number in one.rules})


def _findings(profile: str) -> TableSection:
    found = fuzzy.load(profile).lint(sensor_range=printed.SENSOR_MM)
    return TableSection(f"What the linter finds in {profile}", finding_table(found))


def _data(profile: str) -> dict[str, list[int]]:
    return {code: concerned(profile, code) for code in REMARKS}


def _same() -> Claim:
    vii, viii = fuzzy.load("paper_vii"), fuzzy.load("paper_viii")
    differ = [i for i, (a, b) in enumerate(zip(vii.rules, viii.rules, strict=True), 1) if a.outputs != b.outputs]
    note = f"one controller, two tables; they differ in rules {_listed(differ)}"
    count = len(vii.rules)
    return Claim("Tables VII, VIII", "rules that are the same", str(count), f"{count - len(differ)} of {count}",
                 "contradicts itself", note=note)  # fmt: skip


def _pairs(system: fuzzy.System) -> int:
    return len({rule.outputs for rule in system.rules})


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers)) or "none"


def _side_by_side() -> TableSection:
    return TableSection(
        "The 27 rules",
        rule_table(),
        "N near or negative big, M medium, F far; NZ negative, PZ positive, P positive big. The repaired profile is "
        "Table VIII with rules 11, 13, 20, 21, 22 and 25 taken from Table VII.",
    )


def rule_table() -> Table:
    """All rules of both tables and of the repaired profile, with what the linter says of each."""
    systems = {name: fuzzy.load(name) for name in ("paper_vii", "paper_viii", "repaired")}
    remarks = {name: {code: concerned(name, code) for code in REMARKS} for name in ("paper_vii", "paper_viii")}
    rows = []
    for number, rule in enumerate(systems["paper_vii"].rules, 1):
        row: dict[str, object] = {"rule": number}
        row |= {v.name: v.sets[i - 1].name for v, i in zip(systems["paper_vii"].inputs, rule.inputs, strict=True)}
        for name, system in systems.items():
            outputs = system.rules[number - 1].outputs
            row[name] = " ".join(v.sets[i - 1].name for v, i in zip(system.outputs, outputs, strict=True))
        row["remark"] = "; ".join(
            f"{name.removeprefix('paper_').upper()} {REMARKS[code]}"
            for name, codes in remarks.items()
            for code, numbers in codes.items()
            if number in numbers and code != "F-BLIND"
        )
        rows.append(row)
    return table(rows)
