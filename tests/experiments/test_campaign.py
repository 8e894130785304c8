"""The bars of the papers' robots on worlds and motors that no design or tuning has seen."""

import pytest

from holodrive.experiments import Setting
from holodrive.experiments.hybrid import courses, tracks, variants
from holodrive.experiments.mecanum import monte_carlo


@pytest.mark.campaign
@pytest.mark.parametrize(("variant", "bar"), [(variants.REPAIRED, 99.0), (variants.TUNED, 99.5)])
def test_a3_3000_random_worlds_are_driven_and_none_is_touched(variant, bar):
    row = courses.judged(variants.swept(variant, Setting(worlds=3000)), moved_only=False)
    assert row["success_pct"] >= bar
    assert row["hit_pct"] == 0.0


@pytest.mark.campaign
def test_a4_1000_worlds_with_crossers_nearly_all_are_driven():
    row = courses.judged(variants.swept(variants.REPAIRED, Setting(worlds=1000), crossers=2), moved_only=True)
    assert row["success_pct"] >= 95.0


@pytest.mark.campaign
@pytest.mark.parametrize("track", [tracks.t1_track, tracks.t2_track])
def test_both_cascades_track_better_than_the_goal_blend_alone(track):
    alone, *cascades = (tracks.medians(v, track(), 3)["rms_error_m"] for v in tracks.NAVIGATORS)
    assert all(rms < alone for rms in cascades)


@pytest.mark.campaign
@pytest.mark.parametrize("variant", monte_carlo.VARIANTS, ids=lambda v: v.params["variant"])
def test_robots_with_other_motors_and_batteries_keep_the_straight_paths_within_a_centimetre(variant):
    straight, _ = monte_carlo.swept(variant, monte_carlo.ROBOTS)
    assert straight["distance_max_m"].max() < monte_carlo.BAR_M
