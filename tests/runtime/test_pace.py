"""Keeping to the wall clock, on a clock of our own."""

from holodrive.runtime.pace import RealTime


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def test_ticks_come_on_absolute_deadlines_even_after_a_late_one():
    clock = Clock()
    pace = RealTime(clock=clock, sleep=clock.sleep)
    for tick in range(10):
        pace(tick * 0.01)
        clock.now += 0.025 if tick == 4 else 0.001
    assert abs(clock.now - 100.0 - 0.091) < 1e-9
    assert pace.late == 2
    assert abs(pace.worst_s - 0.015) < 1e-9


def test_twice_the_speed_takes_half_the_time():
    clock = Clock()
    pace = RealTime(speed=2.0, clock=clock, sleep=clock.sleep)
    for tick in range(101):
        pace(tick * 0.01)
    assert abs(clock.now - 100.5) < 1e-9
