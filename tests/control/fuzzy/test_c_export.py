"""The exported C, compiled with all warnings as errors, gives what the kernel gives."""

import ctypes
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from random_systems import STRAIGHT, mamdani
from test_files_round_trip import SYSTEMS

from holodrive.control import fuzzy
from holodrive.control.fuzzy import files
from holodrive.control.fuzzy.files.c_export import c_source
from holodrive.errors import InputError

CC = shutil.which("cc")
AVR = shutil.which("avr-gcc")
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler (cc) on this machine")
STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-std=c99")


def compiled(folder: Path, *systems, real="double"):
    """The C functions of systems, as Python functions from inputs and clamp to outputs and result."""
    source, library = folder / "x.c", folder / f"x{len(list(folder.iterdir()))}.so"  # dlopen knows a path by its name
    source.write_text("\n".join(map(c_source, systems)))
    command = [CC, *STRICT, "-O1", "-shared", "-fPIC", f"-DFUZZY_REAL={real}", str(source), "-o", str(library)]
    libraries = ["-lm"] if "math.h" in source.read_text() else ["-nostdlib"]
    done = subprocess.run([*command, *libraries], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [_function(ctypes.CDLL(str(library)), system, real) for system in systems]


def _function(library, system, real):
    function = getattr(library, f"{system.name}_evaluate")
    function.restype = ctypes.c_ulong
    kind = ctypes.c_double if real == "double" else ctypes.c_float

    def call(x, clamp):
        out = (kind * len(system.outputs))()
        silent = function((kind * len(x))(*x), out, ctypes.c_int(clamp))
        return np.array(out), silent

    return call


def compare(system, call, rows, tolerance=1e-9):
    defaults = np.array([one.default for one in system.outputs])
    for clamp in (True, False):
        expected = system.evaluate(rows, clamp)
        answers = [call(x, clamp) for x in rows]
        silent = np.array([[answer >> k & 1 for k in range(len(defaults))] for _, answer in answers], dtype=bool)
        assert np.array_equal(silent, np.isnan(expected))
        found = np.array([out for out, _ in answers])
        wanted = np.where(np.isnan(expected), defaults, expected)
        assert np.allclose(found, wanted, rtol=tolerance, atol=tolerance, equal_nan=True)


@needs_cc
@pytest.mark.parametrize("name", ["paper_vii", "paper_viii"])
def test_the_reference_vectors(name, shared_data, tmp_path):
    """Those of the shared data, clamped and not."""
    system = fuzzy.load(name)
    vectors = json.loads((shared_data / "flc_vectors.json").read_text())
    compare(system, *compiled(tmp_path, system), np.array(vectors["inputs"]))


@needs_cc
@pytest.mark.parametrize("name", fuzzy.names())
def test_every_profile(name, tmp_path):
    system = fuzzy.load(name)
    rows = np.random.default_rng(3).uniform(-200.0, 3000.0, (500, len(system.inputs)))
    compare(system, *compiled(tmp_path, system), rows)


@needs_cc
@given(st.lists(st.one_of(SYSTEMS, mamdani(STRAIGHT, ("bisector", "mom", "som", "lom"))), min_size=8, max_size=8))
@settings(
    max_examples=4, phases=[Phase.generate], suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
def test_any_system(tmp_path_factory, drawn):
    """Eight at a time: that the names of several in one file differ is tested too."""
    systems = [replace(system, name=f"drawn{k}") for k, system in enumerate(drawn)]
    rng = np.random.default_rng(7)
    for system, call in zip(systems, compiled(tmp_path_factory.mktemp("c"), *systems), strict=True):
        columns = [rng.uniform(1.2 * v.low - 0.2 * v.high, 1.2 * v.high - 0.2 * v.low, 40) for v in system.inputs]
        rows = np.stack(columns, axis=1)
        rows[0, 0] = np.nan
        compare(system, call, rows)


@needs_cc
def test_single_precision_is_near(tmp_path):
    """The same file with FUZZY_REAL=float."""
    system = fuzzy.load("repaired")
    rows = np.random.default_rng(4).uniform(0.0, 2500.0, (300, 3))
    compare(system, *compiled(tmp_path, system, real="float"), rows, tolerance=2e-3)


@needs_cc
@pytest.mark.parametrize("method", ["bisector", "mom"])
def test_faint_rules_count_as_they_do_in_the_kernel(method, tmp_path):
    system = fuzzy.load("repaired")
    rules = tuple(replace(rule, weight=1e-250) for rule in system.rules)
    faint = replace(system, rules=rules, implication="prod", defuzzification=method)
    compare(faint, *compiled(tmp_path, faint), np.random.default_rng(6).uniform(0.0, 2500.0, (100, 3)))


@needs_cc
def test_the_default_is_given_where_no_rule_fires(tmp_path):
    system = fuzzy.load("paper_viii")
    outputs = (replace(system.outputs[0], default=-7.5), system.outputs[1])
    (call,) = compiled(tmp_path, replace(system, outputs=outputs))
    found, silent = call((100.0, 500.0, 100.0), True)  # the hole of DL
    assert silent == 0b11
    assert found[0] == -7.5
    assert np.isnan(found[1])
    assert call((100.0, 400.0, 100.0), True)[1] == 0
    assert call((float("nan"), 400.0, 100.0), True)[1] == 0b11


@needs_cc
def test_two_headers_fit_into_one_program(tmp_path):
    """Every name carries the system's; `.h` files may be included twice."""
    for name in ("paper_vii", "repaired"):
        files.write(fuzzy.load(name), tmp_path / f"{name}.h")
    includes = '#include "paper_vii.h"\n#include "repaired.h"\n#include "repaired.h"\n'
    (tmp_path / "main.c").write_text(includes + "int main(void) { return 0; }\n")
    done = subprocess.run([CC, *STRICT, str(tmp_path / "main.c"), "-o", str(tmp_path / "main")], capture_output=True, text=True, check=False)  # fmt: skip  # noqa: E501
    assert done.returncode == 0, done.stderr


@needs_cc
def test_hostile_names_stay_comments(tmp_path):
    """Names reach comments only, and end none."""
    system = fuzzy.load("paper_viii")
    inputs = tuple(replace(one, name=f"{one.name}*/ int x; /* \\ ??/\n\u202e") for one in system.inputs)
    wrong = replace(system, name="3 w*/\n \u202e", inputs=inputs)
    assert "fuzzy_3_w_evaluate" in c_source(wrong)
    (tmp_path / "x.c").write_text(c_source(wrong), encoding="utf-8")
    done = subprocess.run([CC, *STRICT, "-c", str(tmp_path / "x.c"), "-o", str(tmp_path / "x.o")], capture_output=True, text=True, check=False)  # fmt: skip  # noqa: E501
    assert done.returncode == 0, done.stderr


def test_what_cannot_be_exported_is_refused_by_name():
    system = fuzzy.load("paper_viii")
    with pytest.raises(InputError, match="fuzzylab"):
        c_source(replace(system, fuzzylab=True))
    many = tuple(replace(system.outputs[0], name=f"y{k}") for k in range(33))
    rules = (replace(system.rules[0], outputs=(1,) * 33),)
    with pytest.raises(InputError, match="33 outputs"):
        c_source(replace(system, outputs=many, rules=rules))


@pytest.mark.skipif(AVR is None, reason="no avr-gcc on this machine")
def test_it_fits_an_arduino_mega(tmp_path, capsys):
    """Flash and RAM of the repaired profile on an ATmega2560, with the C library's floats linked in."""
    source = c_source(fuzzy.load("repaired"))
    main = "\nvolatile float in[3], out[2];\nint main(void) { float x[3] = {in[0], in[1], in[2]}, y[2];"
    main += " repaired_evaluate(x, y, 1); out[0] = y[0]; out[1] = y[1]; return 0; }\n"
    (tmp_path / "x.c").write_text("#define FUZZY_REAL float\n" + source + main)
    command = [AVR, "-mmcu=atmega2560", "-Os", *STRICT, str(tmp_path / "x.c"), "-o", str(tmp_path / "x.elf")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    size = subprocess.run([AVR.replace("avr-gcc", "avr-size"), str(tmp_path / "x.elf")], capture_output=True, text=True, check=True)  # fmt: skip  # noqa: E501
    text, data, bss = map(int, size.stdout.splitlines()[1].split()[:3])
    with capsys.disabled():
        print(f"\nrepaired on an atmega2560: {text + data} bytes of flash, {data + bss - 20} of static RAM")
    assert text + data < 64 * 1024
    assert data + bss == 20  # in and out of this program
