"""Random robots of every kind of wheel, right in everything that a file can be wrong in."""

import math

from hypothesis import strategies as st

from holodrive.robots import checks, curves
from holodrive.robots.spec import (
    Battery,
    DutyMap,
    Encoder,
    Ground,
    Imu,
    Lidar,
    Limits,
    Linearizer,
    Motor,
    Mouse,
    PwmMap,
    Robot,
    SpeedLoop,
    Steering,
    WheelSpec,
)
from holodrive.types import Pose

TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=20)
NAME = st.text("abcdefghijklmnopqrstuvwxyzABCXYZ0123456789_-äßλ", min_size=1, max_size=12)
ANGLE = st.floats(-2.0 * math.pi, 2.0 * math.pi)
POSE = st.builds(Pose, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), ANGLE)


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, exclude_min=True)


@st.composite
def motors(draw):
    voltage, speed = draw(between(1.0, 48.0)), draw(between(0.5, 200.0))
    constant, resistance = voltage / speed, draw(between(0.01, 10.0))
    efficiency = draw(between(0.2, 1.0))
    # little enough friction that no-load speed, voltage and constant still tell of one motor
    friction = draw(st.floats(0.0, 0.1)) * voltage * efficiency * constant / resistance
    kind = draw(st.sampled_from(["dc", "bldc"]))
    return Motor(
        name=draw(TEXT),
        kind=kind,
        voltage_v=voltage,
        no_load_speed_rad_s=speed,
        back_emf_v_s_rad=constant,
        resistance_ohm=resistance,
        inductance_h=draw(st.floats(0.0, 3.0)),
        efficiency=efficiency,
        coulomb_friction_n_m=friction,
        viscous_friction_n_m_s_rad=draw(st.floats(0.0, 0.1)) * efficiency * constant**2 / resistance,
        inertia_kg_m2=draw(st.floats(0.0, 0.1)),
        current_limit_a=draw(st.one_of(st.just(math.inf), between(0.1, 100.0))),
        lag_s=draw(st.floats(0.0, 1.0)),
        gear=draw(between(1.0, 300.0)),
        source=draw(TEXT),
        poles=2 * draw(st.integers(1, 40)),
        emf=draw(st.sampled_from(["trapezoid", "sine"])),
        drive="averaged" if kind == "dc" else draw(st.sampled_from(["averaged", "six_step", "foc"])),
    )


@st.composite
def wheels(draw, name, bearing):
    kind = draw(st.sampled_from(["omni", "mecanum", "swerve"]))
    distance = draw(st.floats(0.4, 0.5))
    motor = draw(motors())
    steering = st.builds(
        Steering,
        between(0.1, 20.0),
        st.floats(0.0, 1.0),
        st.floats(-0.03, 0.03),
        st.floats(-3.0, 3.0),
        st.none() | motors(),
        st.floats(0.0, 100.0),
        st.floats(0.0, 10.0),
        st.floats(0.0, 0.1),
    )
    rollers = st.floats(0.1, 1.4).flatmap(lambda angle: st.sampled_from([angle, -angle, math.pi - angle]))
    return WheelSpec(
        name=name,
        kind=kind,
        x=distance * math.cos(bearing),
        y=distance * math.sin(bearing),
        yaw=draw(ANGLE),
        radius=draw(st.floats(0.01, 0.1)),
        motor=motor,
        max_speed_rad_s=motor.no_load_speed_rad_s * draw(st.floats(0.1, 1.0)),
        roller=draw(rollers) if kind == "mecanum" else 0.0,
        width=draw(st.floats(0.005, 0.06)),
        encoder=draw(st.none() | st.builds(Encoder, st.floats(1.0, 1e6), TEXT.filter(bool), TEXT)),
        steering=draw(steering) if kind == "swerve" else None,
        inverted=draw(st.booleans()),
    )


AXES = st.sampled_from(["xy", "x"])
LIDARS = st.builds(
    Lidar,
    name=TEXT,
    mount=POSE,
    rate_hz=between(0.1, 50.0),
    beams=st.integers(1, 2000),
    field_of_view_rad=between(0.1, 2.0 * math.pi),
    clockwise=st.booleans(),
    range_min=st.floats(0.0, 0.5),
    range_max=between(0.5, 40.0),
    noise_m=st.floats(0.0, 0.1),
    noise_relative=st.floats(0.0, 0.1),
    dropout=st.floats(0.0, 1.0),
    motion_distortion=st.booleans(),
    source=TEXT,
)
IMUS = st.builds(
    Imu,
    name=TEXT,
    mount=POSE,
    rate_hz=between(1.0, 1000.0),
    gyro_noise_rad_s=st.floats(0.0, 1.0),
    gyro_bias_rad_s=st.floats(-1.0, 1.0),
    gyro_bias_walk_rad_s=st.floats(0.0, 1.0),
    accel_noise_m_s2=st.floats(0.0, 1.0),
    source=TEXT,
)


@st.composite
def duty_curves(draw):
    """Through points that rise by steps of whole counts and of some mm/s, or a cubic that rises by its signs."""
    measured = {"speed_unit_m_s": 1e-3, "counts": 255, "speed_scale": draw(between(0.5, 2.0)), "radius_m": 0.03}
    start = draw(st.integers(0, 80))
    if draw(st.booleans()):
        rising = [draw(st.floats(0.0, 10.0)) for _ in range(2)]
        return curves.from_cubic([start, draw(between(0.1, 5.0)), *rising], **measured)
    steps = draw(st.lists(st.tuples(st.integers(1, 34), between(0.01, 20.0)), min_size=1, max_size=5))
    points = [(start, 0.0)]
    for pwm, speed in steps:
        points.append((points[-1][0] + pwm, points[-1][1] + speed))
    return curves.from_points(points, **measured)


@st.composite
def duty_maps(draw, count):
    """Of all wheels; some of them have the same curves."""
    known = draw(st.lists(st.builds(DutyMap, duty_curves(), duty_curves()), min_size=1, max_size=2))
    return tuple(draw(st.sampled_from(known)) for _ in range(count))


def pwm_maps(count):
    part = st.floats(0.0, 1.0)
    return st.builds(
        PwmMap,
        wheels=duty_maps(count),
        counts=st.integers(1, 65535),
        voltage_v=between(1.0, 60.0),
        dead_time_s=part,
        dead_time_spread_s=part,
        lag_s=part,
        speed_spread=part,
        speed_noise=part,
        speed_scale=between(0.1, 10.0),
    )


@st.composite
def inside(draw, radius):
    """A mount within a circle about the robot's centre."""
    distance, bearing = draw(st.floats(0.0, 0.99)) * radius, draw(st.floats(-3.0, 3.0))
    return Pose(distance * math.cos(bearing), distance * math.sin(bearing), draw(st.floats(-3.0, 3.0)))


@st.composite
def robots(draw):
    count = draw(st.integers(1, 5))
    names = draw(st.lists(NAME, min_size=count, max_size=count, unique=True))
    found = tuple(draw(wheels(name, 2.0 * math.pi * i / count)) for i, name in enumerate(names))
    top, reach = checks.top_speed(found), checks.reach(found)
    speed = draw(st.floats(0.1, 1.0)) * top if math.isfinite(top) and top > 0.0 else math.inf
    endless = st.just(math.inf)
    return Robot(
        name=draw(TEXT),
        wheels=found,
        mass_kg=draw(between(0.1, 500.0)),
        inertia_kg_m2=draw(between(1e-4, 100.0)),
        footprint_radius_m=reach * draw(st.floats(1.0, 3.0)),
        title=draw(TEXT),
        source=draw(TEXT),
        centre_of_mass=(draw(st.floats(-0.5, 0.5)), draw(st.floats(-0.5, 0.5))),
        battery=Battery(draw(between(1.0, 60.0)), draw(st.floats(0.0, 1.0)), draw(endless | between(1.0, 1e6))),
        ground=Ground(draw(st.floats(0.0, 2.0)), draw(st.floats(0.0, 1.0)), draw(st.floats(1e-4, 1.0))),
        limits=Limits(
            draw(st.sampled_from([math.inf, speed])),
            *(draw(endless | between(0.1, 100.0)) for _ in range(3)),
        ),
        speed_loop=SpeedLoop(*(draw(st.floats(0.0, 10.0)) for _ in range(3)), draw(st.floats(0.0, 1.0))),
        lidar=draw(st.none() | LIDARS),
        imu=draw(st.none() | IMUS),
        mice=tuple(
            Mouse(
                name, draw(inside(reach)), draw(between(1e-7, 1e-3)), draw(st.floats(0.0, 1.0)), draw(TEXT), draw(AXES)
            )
            for name in draw(st.lists(NAME, max_size=4, unique=True))
        ),
        control_period_s=draw(st.floats(1e-3, 0.1)),
        linearizer=draw(st.none() | st.builds(Linearizer, duty_maps(count), between(0.1, 10.0))),
        pwm_map=draw(st.none() | pwm_maps(count)),
    )
