"""The distance to a path."""

import math

import numpy as np
import pytest

from holodrive import planning, references
from holodrive.errors import InputError
from holodrive.planning.deviation import distance_to_path

RNG = np.random.default_rng(0)


def test_the_distance_to_a_circle_is_the_difference_of_radii() -> None:
    table = planning.follow(planning.circle(0.5), speed_m_s=0.05)
    angle, radius = RNG.uniform(-math.pi, math.pi, 200), RNG.uniform(0.3, 0.8, 200)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    assert np.allclose(distance_to_path(table, points), np.abs(radius - 0.5), atol=1e-6)


def test_the_distance_to_a_line_is_across_it_beside_it_and_to_the_end_beyond_it() -> None:
    table = planning.follow(planning.line((0.0, 0.0), (0.3, 0.0)), speed_m_s=0.02)
    assert np.allclose(distance_to_path(table, [[0.1, 0.02], [0.4, 0.0], [-0.03, 0.04]]), [0.02, 0.1, 0.05])


def test_points_on_the_path_have_no_distance_and_shapes_are_kept() -> None:
    table = planning.follow(planning.lemniscate(0.15), speed_m_s=0.02)
    points = table.rows[::7, 1:3][:120].reshape(2, 60, 2)
    found = distance_to_path(table, points)
    assert found.shape == (2, 60)
    assert np.max(found) < 1e-12


def test_an_unknown_place_has_no_distance() -> None:
    table = planning.follow(planning.circle(0.5), speed_m_s=0.05)
    assert np.isnan(distance_to_path(table, [[math.nan, 0.0]])).all()


def test_a_reference_that_stays_is_no_path() -> None:
    with pytest.raises(InputError, match="stays at one place"):
        distance_to_path(references.fixed_goal((1.0, 0.0, 0.0)), [[0.0, 0.0]])
