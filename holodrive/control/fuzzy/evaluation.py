"""Evaluating fuzzy systems from Python: one input or arrays of them."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from holodrive.control.fuzzy import area, kernel
from holodrive.control.fuzzy import packing as pk
from holodrive.control.fuzzy.membership import membership
from holodrive.control.fuzzy.system import System
from holodrive.errors import InputError
from holodrive.types import Array

__all__ = ["aggregated", "evaluate", "membership", "strengths"]

_ROWS_PER_THREAD = 2000  # fewer are not worth a thread


def evaluate(system: System, x: ArrayLike, clamp: bool = True) -> Array:
    """Outputs (..., n_out) for inputs x (..., n_in); NaN where no rule fires or an input is NaN.

    Args:
        system: the fuzzy system.
        x: in the system's units.
        clamp: bring inputs into their universe first; a fuzzylab-compatible system never does.

    Raises:
        InputError: x is not numeric or its last axis is not n_in.
    """
    rows, limit = _inputs(system, x), 1.0 if clamp else 0.0
    if rows.ndim == 1:
        out = np.empty(len(system.outputs))  # made here: giving an array back from a kernel takes twice as long
        _one(system.packed, rows, limit, out)
        return out
    return _evaluate_rows(system, rows, limit)


def strengths(system: System, x: ArrayLike, clamp: bool = True) -> Array:
    """Strength (..., n_rules) of each rule at x (..., n_in), its weight included; NaN where an input is NaN."""
    limit = 1.0 if clamp else 0.0
    rows = _inputs(system, x)
    out = np.empty((*rows.shape[:-1], len(system.rules)))
    flat = np.ascontiguousarray(rows.reshape(-1, rows.shape[-1]))
    _many_strengths(system.packed, flat, limit, out.reshape(-1, len(system.rules)))
    return out


def aggregated(system: System, x: ArrayLike, output_index: int, clamp: bool = True) -> tuple[Array, Array]:
    """What all rules together say of one output at x (n_in,): places (n,) and heights (n,).

    A polyline for fuzzy sets, exact (samples when the system behaves as fuzzylab), with two points where it jumps;
    empty when no rule fires. Stems for singletons and for the conclusions of a Sugeno system, each with its height.

    Raises:
        InputError: no such output, or x is not one input of the system.
    """
    rows = _inputs(system, x)
    if rows.ndim != 1:
        raise InputError(f"the aggregate is drawn for one input; found an array of shape {rows.shape}")
    if not 0 <= output_index < len(system.outputs):
        raise InputError(f"{system.name!r} has outputs 0 to {len(system.outputs) - 1}; found {output_index}")
    found = _aggregate(system.packed, rows, 1.0 if clamp else 0.0, output_index)
    fresh = np.ones(len(found), dtype=bool)
    fresh[1:] = (found[1:] != found[:-1]).any(axis=1)
    return found[fresh, 0], found[fresh, 1]


def _evaluate_rows(system: System, rows: Array, limit: float) -> Array:
    flat = np.ascontiguousarray(rows.reshape(-1, rows.shape[-1]))
    out = np.empty((len(flat), len(system.outputs)))
    _in_threads(lambda cut: _many(system.packed, flat[cut], limit, out[cut]), len(flat))
    return out.reshape(*rows.shape[:-1], len(system.outputs))


def _inputs(system: System, x: ArrayLike) -> Array:
    try:
        rows = np.asarray(x, np.float64, "C")  # by place: by name takes a tenth of a microsecond more
    except (TypeError, ValueError) as error:
        raise InputError(f"inputs of {system.name!r} must be numbers: {error}") from error
    if rows.ndim == 0 or rows.shape[-1] != len(system.inputs):
        names = ", ".join(one.name for one in system.inputs)
        raise InputError(f"{system.name!r} takes {len(system.inputs)} inputs ({names}); found an array {rows.shape}")
    return rows


def _in_threads(run: Callable[[slice], object], n: int) -> None:
    """Rows in as many cuts as there are cores; the kernels give up the interpreter's lock."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = max(1, min(cores, n // _ROWS_PER_THREAD))
    if count == 1:
        run(slice(0, n))
        return
    bounds = np.linspace(0, n, count + 1).astype(int).tolist()
    with ThreadPoolExecutor(count) as pool:
        list(pool.map(run, map(slice, bounds, bounds[1:])))  # list: so that an exception comes out


@njit(cache=True, error_model="numpy")
def _one(spec, x, clamp, out):  # type: ignore[no-untyped-def]
    work = np.empty(int(spec[pk.WORK]))
    kernel.evaluate_into(spec, x, clamp, out, work)


@njit(cache=True, error_model="numpy", nogil=True)
def _many(spec, x, clamp, out):  # type: ignore[no-untyped-def]
    work = np.empty(int(spec[pk.WORK]))
    for i in range(x.shape[0]):
        kernel.evaluate_into(spec, x[i], clamp, out[i], work)


@njit(cache=True, error_model="numpy", nogil=True)
def _many_strengths(spec, x, clamp, out):  # type: ignore[no-untyped-def]
    for i in range(x.shape[0]):
        kernel.strengths_into(spec, x[i], clamp, out[i])


@njit(cache=True, error_model="numpy")
def _aggregate(spec, x, clamp, output):  # type: ignore[no-untyped-def]
    """(n, 2) points or stems."""
    work = np.empty(int(spec[pk.WORK]))
    at = int(spec[int(spec[pk.AT_OUTPUTS]) + output])
    form, n_sets, n_table = int(spec[at + pk.FORM]), int(spec[at + pk.N_SETS]), int(spec[at + pk.N_TABLE])
    if not kernel.fire_into(spec, x, clamp, work) or not kernel.raise_heights(spec, at, output, work):
        return np.empty((0, 2))
    if form == pk.SUGENO:
        return _sugeno_stems(spec, at, output, work)
    heights = work[kernel.heights_at(spec) :]
    if form == pk.SINGLETONS:
        stems = np.empty((n_sets, 2))
        for k in range(n_sets):
            stems[k, 0], stems[k, 1] = spec[at + pk.TABLE + k], heights[k]
        return stems[np.argsort(stems[:, 0])]
    if form == pk.SAMPLES:
        samples = np.empty((n_table, 2))
        for i in range(n_table):
            samples[i, 0] = spec[at + pk.TABLE + i]
            samples[i, 1] = kernel.sample(spec, at, i, heights)
        return samples
    kernel.list_parts(spec, at, output, work)
    return _polyline(spec, at, work[kernel.parts_at(spec) :])


@njit(cache=True, error_model="numpy")
def _sugeno_stems(spec, at, output, work):  # type: ignore[no-untyped-def]
    fired, column = kernel.fired_at(spec), pk.SLOTS + int(spec[pk.N_IN]) + output
    stems = np.empty((int(work[fired]), 2))
    n = 0
    for k in range(len(stems)):
        number = int(spec[int(work[fired + 1 + 2 * k]) + column])
        if number > 0:
            stems[n, 0], stems[n, 1] = kernel.conclusion(spec, at, number - 1, work), work[fired + 2 + 2 * k]
            n += 1
    return stems[:n][np.argsort(stems[:n, 0])]


@njit(cache=True, error_model="numpy")
def _polyline(spec, at, work):  # type: ignore[no-untyped-def]
    first, n_cells, n_sets = area.points_at(spec), int(spec[at + pk.N_TABLE]), int(spec[at + pk.N_SETS])
    points = np.empty((n_cells * (len(work) - first) // 2, 2))
    n = 0
    for cell in range(n_cells):
        count = area.cell_points(spec, at, cell, work)
        for k in range(count):
            points[n, 0], points[n, 1] = work[first + 2 * k], work[first + 2 * k + 1]
            n += 1
        if count == 0:
            row = at + pk.TABLE + cell * (2 + 2 * n_sets)
            for side in range(2):
                points[n, 0], points[n, 1] = spec[row + side], 0.0
                n += 1
    return points[:n].copy()
