"""A robot as it is described: frozen values in SI and radians. Files become these in `robots/files.py`.

Frames: `base_link` sits at the robot's reference point on the ground, x forward, y left.
"""

import math
from dataclasses import dataclass, field
from typing import Literal

from holodrive.types import Pose

WheelKind = Literal["omni", "mecanum", "swerve"]


@dataclass(frozen=True, slots=True)
class Motor:
    """A gearmotor seen from its output shaft (all values behind the gear).

    Attributes:
        name: entry of the motor library.
        kind: "dc" (brushed) or "bldc" (electronically commutated; averaged to an equivalent DC motor here).
        voltage_v: nominal supply.
        no_load_speed_rad_s: at nominal voltage and full duty.
        back_emf_v_s_rad: K_G, volts per output rad/s (also N m per A before the efficiency).
        resistance_ohm: terminal.
        inductance_h: terminal; neglected where L/R is far below the time step.
        efficiency: of the gear, 0..1: torque out = efficiency * K_G * current - friction.
        coulomb_friction_n_m, viscous_friction_n_m_s_rad: at the output shaft.
        inertia_kg_m2: rotor and gear seen at the output shaft.
        current_limit_a: of the driver.
        lag_s: time constant with which the first-order plant's wheel speed follows.
        gear: reduction: turns of the rotor per turn of the output shaft.
        source: where the numbers come from.
        poles: of the rotor, two for each pole pair; the electrical angle is poles / 2 times the rotor's.
        emf: shape of a BLDC motor's back-EMF, "trapezoid" (flat for 120 degrees) or "sine".
        drive: how a BLDC motor is fed on the plant "motors": "averaged" (as the equivalent DC motor), "six_step"
            (Hall sectors, one phase floating) or "foc" (currents controlled in the rotor's frame).

    A BLDC motor's constants are those between two terminals: back-EMF and torque constant, resistance and inductance
    of two phases in series; one phase has half of each.
    """

    name: str
    kind: Literal["dc", "bldc"]
    voltage_v: float
    no_load_speed_rad_s: float
    back_emf_v_s_rad: float
    resistance_ohm: float
    inductance_h: float = 0.0
    efficiency: float = 1.0
    coulomb_friction_n_m: float = 0.0
    viscous_friction_n_m_s_rad: float = 0.0
    inertia_kg_m2: float = 0.0
    current_limit_a: float = math.inf
    lag_s: float = 0.05
    gear: float = 1.0
    source: str = ""
    poles: int = 2
    emf: Literal["trapezoid", "sine"] = "trapezoid"
    drive: Literal["averaged", "six_step", "foc"] = "averaged"


@dataclass(frozen=True, slots=True)
class Encoder:
    """Incremental encoder on the wheel's shaft. `counts_per_turn` is behind all decoding, per wheel turn."""

    counts_per_turn: float
    name: str = "encoder"
    source: str = ""


@dataclass(frozen=True, slots=True)
class Steering:
    """The steering of a swerve module: a servo of rate and lag, or a motor with a position loop.

    Attributes:
        rate_rad_s: fastest steering.
        lag_s: time constant with which the angle follows inside that rate; of the servo, unused with a motor.
        caster_m: how far the contact point trails behind the steering axis, against the rolling direction; below 0
            it runs ahead.
        coupling: wheel turns against its drive per turn of the steering, as a bevel gear on the steering axis makes
            them; the board makes up for it.
        motor: that steers on the plant "motors"; None keeps the servo there as well.
        kp_v_rad, kd_v_s_rad: its position loop [V per rad of error, V per rad/s of steering rate].
        inertia_kg_m2: of the module about its axis, without the motor.
    """

    rate_rad_s: float = 6.0
    lag_s: float = 0.05
    caster_m: float = 0.0
    coupling: float = 0.0
    motor: Motor | None = None
    kp_v_rad: float = 6.0
    kd_v_s_rad: float = 0.3
    inertia_kg_m2: float = 0.0


@dataclass(frozen=True, slots=True)
class WheelSpec:
    """One named wheel.

    Attributes:
        x, y: contact point in `base_link` [m].
        yaw: direction in which positive speed drives [rad]; for swerve the zero of the steering angle.
        radius: [m].
        roller: from the rolling direction to the axis of the roller on the ground [rad]:
            0 for omni, +-45 deg for a usual Mecanum wheel; unused for swerve.
        width: [m], for drawing.
        motor, encoder, steering: parts; `encoder` None means that the wheel's speed is not measured.
        inverted: the hardware counts and turns the other way; the software's sign is not touched.
        max_speed_rad_s: limit of this wheel, at most the motor's no-load speed.
    """

    name: str
    kind: WheelKind
    x: float
    y: float
    yaw: float
    radius: float
    motor: Motor
    max_speed_rad_s: float
    roller: float = 0.0
    width: float = 0.03
    encoder: Encoder | None = None
    steering: Steering | None = None
    inverted: bool = False


@dataclass(frozen=True, slots=True)
class Lidar:
    """A planar scanning range sensor.

    Attributes:
        mount: pose in `base_link` [m, m, rad].
        rate_hz: revolutions per second.
        beams: per revolution, evenly spread over `field_of_view_rad`.
        clockwise: direction of rotation (RPLIDAR: True).
        range_min, range_max: [m].
        noise_m, noise_relative: standard deviation is the larger of noise_m and noise_relative * range.
        dropout: probability that a beam returns nothing.
        motion_distortion: beams are taken one after another while the robot moves.
    """

    name: str
    mount: Pose = Pose(0.0, 0.0, 0.0)
    rate_hz: float = 10.0
    beams: int = 360
    field_of_view_rad: float = 2.0 * math.pi
    clockwise: bool = True
    range_min: float = 0.15
    range_max: float = 12.0
    noise_m: float = 0.0
    noise_relative: float = 0.0
    dropout: float = 0.0
    motion_distortion: bool = True
    source: str = ""


@dataclass(frozen=True, slots=True)
class Imu:
    """Yaw gyro and planar accelerometer; noise per sample at `rate_hz`."""

    name: str
    mount: Pose = Pose(0.0, 0.0, 0.0)
    rate_hz: float = 100.0
    gyro_noise_rad_s: float = 0.0
    gyro_bias_rad_s: float = 0.0
    gyro_bias_walk_rad_s: float = 0.0  # standard deviation of the bias after one second of walk
    accel_noise_m_s2: float = 0.0
    source: str = ""


@dataclass(frozen=True, slots=True)
class Mouse:
    """A ball or optical mouse looking at the ground: two counters of displacement in its own axes.

    `axes` "x" is a measuring wheel: it counts along its x axis alone and rolls freely across; its y is NaN.
    """

    name: str
    mount: Pose = Pose(0.0, 0.0, 0.0)
    resolution_m: float = 1e-5
    noise_relative: float = 0.0
    source: str = ""
    axes: Literal["xy", "x"] = "xy"


@dataclass(frozen=True, slots=True)
class Battery:
    """Open-circuit voltage and inner resistance."""

    voltage_v: float = 12.0
    resistance_ohm: float = 0.1
    capacity_c: float = math.inf  # coulomb


@dataclass(frozen=True, slots=True)
class Ground:
    """Wheel-ground contact: grip, rolling resistance of free rollers, slip speed at which grip saturates."""

    friction: float = 0.6
    roller_resistance: float = 0.02
    slip_speed_m_s: float = 0.01


@dataclass(frozen=True, slots=True)
class Limits:
    """What the base may do, beside what its wheels can do (the wheel-speed polytope)."""

    speed_m_s: float = math.inf
    yaw_rate_rad_s: float = math.inf
    accel_m_s2: float = math.inf
    yaw_accel_rad_s2: float = math.inf


@dataclass(frozen=True, slots=True)
class SpeedLoop:
    """The wheel-speed loop on the motor board: duty = feed-forward + kp * error + ki * integral of error.

    Gains are per unit of the wheel's no-load speed: an error of the whole speed range times `kp` is that much duty.
    """

    kp: float = 0.5
    ki: float = 4.0
    filter_s: float = 0.03  # time constant of the encoder speed
    feed_forward: float = 1.0  # share of the commanded speed that becomes duty at once


@dataclass(frozen=True, slots=True)
class DutyCurve:
    """Steady duty over the speed of one wheel in one direction: a piecewise cubic that rises everywhere.

    duty(w) = sum_j pieces[k][j] (w - knots[k])^j for knots[k] <= w <= knots[k + 1]; duty(0) is where the dead zone
    ends, and a wheel that shall stand gets no duty at all.

    Attributes:
        knots: (K + 1,) wheel speeds, the first 0 [rad/s]; beyond the last the curve goes on straight.
        pieces: (K, 4) coefficients, the constant first [1, s/rad ...].
    """

    knots: tuple[float, ...]
    pieces: tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True, slots=True)
class DutyMap:
    """The two curves of a wheel; the backward one is over |speed| and gives |duty|."""

    forward: DutyCurve
    backward: DutyCurve


@dataclass(frozen=True, slots=True)
class Linearizer:
    """What the motor board knows of its actuators: the duty that a wheel speed takes (Keek et al., eq. 9 to 12).

    Attributes:
        wheels: (n) in the order of the robot's wheels.
        speed_scale: rim speed of a wheel over the speed in the file's curves; sqrt(2) where a diagonal pair of a
            Mecanum base was measured alone, for the record and for people.
    """

    wheels: tuple[DutyMap, ...]
    speed_scale: float = 1.0


@dataclass(frozen=True, slots=True)
class PwmMap:
    """What the actuators of a simulated base really do (plant "pwm_map"); a linearizer is an estimate of it.

    Attributes:
        wheels: (n) in the order of the robot's wheels.
        counts: PWM counts of full duty; the driver takes whole counts.
        voltage_v: of the battery when the curves were measured; duty counts in proportion to the voltage.
        dead_time_s: from a duty to the start of motion out of standstill or against the motion.
        dead_time_spread_s: standard deviation of that from start to start.
        lag_s: time constant with which a wheel's speed follows.
        speed_spread: standard deviation of a wheel's constant deviation from its curve, as a part of its speed.
        speed_noise: the same for a deviation that is new in every control period.
        speed_scale: as in `Linearizer`.
    """

    wheels: tuple[DutyMap, ...]
    counts: int = 255
    voltage_v: float = 12.0
    dead_time_s: float = 0.0
    dead_time_spread_s: float = 0.0
    lag_s: float = 0.05
    speed_spread: float = 0.0
    speed_noise: float = 0.0
    speed_scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Robot:
    """A whole robot, as its file describes it.

    Attributes:
        name, title, source: for people.
        mass_kg, inertia_kg_m2: body about its centre of mass (wheels included).
        centre_of_mass: (x, y) in `base_link` [m].
        footprint_radius_m: circle about `base_link` that encloses all parts.
        wheels: in the order of the file; every array of wheels has this order.
        control_period_s: of the one loop.
        linearizer: wheel speed to duty, used by the motor board where the actuators are not linear; None for none.
        pwm_map: the actuators as the plant "pwm_map" simulates them; None where nobody has measured them.
        text: the TOML it came from, "" for one made in code (then `robots.files.dump` writes it).
    """

    name: str
    wheels: tuple[WheelSpec, ...]
    mass_kg: float
    inertia_kg_m2: float
    footprint_radius_m: float
    title: str = ""
    source: str = ""
    centre_of_mass: tuple[float, float] = (0.0, 0.0)
    battery: Battery = field(default_factory=Battery)
    ground: Ground = field(default_factory=Ground)
    limits: Limits = field(default_factory=Limits)
    speed_loop: SpeedLoop = field(default_factory=SpeedLoop)
    lidar: Lidar | None = None
    imu: Imu | None = None
    mice: tuple[Mouse, ...] = ()
    control_period_s: float = 0.01
    linearizer: Linearizer | None = None
    pwm_map: PwmMap | None = None
    text: str = ""

    @property
    def steered(self) -> tuple[int, ...]:
        """Indices of the steered wheels; steering arrays (m,) have this order."""
        return tuple(i for i, wheel in enumerate(self.wheels) if wheel.kind == "swerve")

    def _repr_html_(self) -> str:
        from holodrive.robots.drawing import robot_svg

        return robot_svg(self)
