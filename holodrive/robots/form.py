"""The tables of a robot file, a motor file and a sensor file, as pydantic forms.

Descriptions are what an editor shows, what a fault about a missing key says, and the words of the reference.
"""

from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, WithJsonSchema, field_validator, model_validator
from pydantic_core import CoreSchema

from holodrive.files.edge import Angle, Coordinate, Distance, Form, Quantity, Ratio, Whole, custom

Radius = Annotated[float, Quantity("length", 1e-4, 2.0)]
AngularSpeed = Annotated[float, Quantity("angular speed", 0.0, 1e5, above_low=True)]
Seconds = Annotated[float, Quantity("time", 0.0, 100.0)]


class At(Form):
    """A place in `base_link`: x and y, or distance and bearing."""

    x: Coordinate | None = Field(default=None, description="ahead of the robot's centre")
    y: Coordinate | None = Field(default=None, description="to the left of the robot's centre")
    distance: Distance | None = Field(default=None, description="from the robot's centre")
    bearing: Angle | None = Field(default=None, description="counter-clockwise from straight ahead")

    @model_validator(mode="before")
    @classmethod
    def _one_way(cls, table: Any) -> Any:
        if isinstance(table, dict):
            keys = set(table) & {"x", "y", "distance", "bearing"}
            if keys not in ({"x", "y"}, {"distance", "bearing"}):
                written = ", ".join(sorted(keys)) or "none of them"
                raise custom(f"a place is either {{ x, y }} or {{ distance, bearing }}; found {written}")
        return table


class Mount(Form):
    """Where a sensor sits in `base_link`, and which way its x axis looks."""

    x: Coordinate | None = Field(default=None, description="ahead of the robot's centre")
    y: Coordinate | None = Field(default=None, description="to the left of the robot's centre")
    distance: Distance | None = Field(default=None, description="from the robot's centre")
    bearing: Angle | None = Field(default=None, description="counter-clockwise from straight ahead")
    yaw: Angle = Field(default=0.0, description="direction of the sensor's x axis")

    @model_validator(mode="before")
    @classmethod
    def _one_way(cls, table: Any) -> Any:
        if isinstance(table, dict):
            keys = set(table) & {"x", "y", "distance", "bearing"}
            if keys and keys not in ({"x", "y"}, {"distance", "bearing"}):
                raise custom(
                    f"a place is either {{ x, y }} or {{ distance, bearing }}; found {', '.join(sorted(keys))}"
                )
        return table


class MotorForm(Form):
    """A gearmotor. Values are behind the gear unless `shaft = "motor"`."""

    model: str | None = Field(
        default=None, description="entry of the motor library that gives what is not written here"
    )
    name: str = Field(default="", description="name of the motor, for people")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    kind: Literal["dc", "bldc"] = Field(description='"dc" (brushed) or "bldc" (electronically commutated)')
    shaft: Literal["output", "motor"] = Field(
        default="output", description="the shaft that the other values are seen from: behind the gear or before it"
    )
    gear: Annotated[float, Quantity("number", 0.0, 1e5, above_low=True)] = Field(default=1.0, description="reduction")
    voltage: Annotated[float, Quantity("voltage", 0.0, 1e4, above_low=True)] = Field(
        description="the supply that no_load_speed is for"
    )
    no_load_speed: AngularSpeed = Field(description="speed at nominal voltage, full duty and no load")
    back_emf: Annotated[float, Quantity("motor constant", 0.0, 1e4, above_low=True)] = Field(
        description="volts per speed of the shaft, the same number as torque per ampere before losses"
    )
    resistance: Annotated[float, Quantity("resistance", 0.0, 1e4, above_low=True)] = Field(
        description="between the terminals"
    )
    inductance: Annotated[float, Quantity("inductance", 0.0, 100.0)] = Field(
        default=0.0, description="between the terminals"
    )
    inertia: Annotated[float, Quantity("inertia", 0.0, 1e3)] = Field(
        description="of the rotor and all that turns with it"
    )
    efficiency: Annotated[float, Quantity("number", 0.0, 1.0, above_low=True)] = Field(
        default=1.0, description="torque that arrives behind the gear, as a part of back_emf times current"
    )
    coulomb_friction: Annotated[float, Quantity("torque", 0.0, 1e4)] = Field(
        default=0.0, description="friction that is even"
    )
    viscous_friction: Annotated[float, Quantity("viscous friction", 0.0, 1e4)] = Field(
        default=0.0, description="friction that grows with speed"
    )
    current_limit: Annotated[float, Quantity("current", 0.0, 1e4, above_low=True)] | None = Field(
        default=None, description="of the driver; without it there is no limit"
    )
    lag: Seconds = Field(default=0.05, description="time constant with which the simple plant's wheel speed follows")
    poles: Annotated[int, Whole(2, 1000)] = Field(default=2, description="of the rotor, two for each pole pair")
    emf: Literal["trapezoid", "sine"] = Field(
        default="trapezoid", description='shape of a bldc motor\'s back-EMF: "trapezoid" or "sine"'
    )
    drive: Literal["averaged", "six_step", "foc"] = Field(
        default="averaged",
        description='how the plant motors feeds a bldc motor: "averaged" (as a dc motor), "six_step" or "foc"',
    )

    @field_validator("poles")
    @classmethod
    def _in_pairs(cls, poles: int) -> int:
        if poles % 2:
            raise custom(f"the poles of a rotor come in pairs, found {poles}; did you mean {2 * poles}?")
        return poles


class EncoderForm(Form):
    """An incremental encoder; what it counts in one turn of the wheel, behind all decoding and the gear."""

    model: str | None = Field(
        default=None, description="entry of the sensor library that gives what is not written here"
    )
    name: str = Field(default="", description="name of the encoder, for people")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    counts_per_turn: Annotated[float, Quantity("number", 1.0, 1e9)] = Field(description="counts in one wheel turn")


class _ByName:
    """Annotation of a key that holds a library name or a table."""

    def __init__(self, form: str, library: str) -> None:
        self.form, self.library = form, library

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, {"$ref": f"#/definitions/{self.form}"}], "x-library": self.library}


class SteeringForm(Form):
    """The steering of a swerve wheel: a servo, or a motor with a position loop."""

    rate: AngularSpeed = Field(description="fastest steering")
    lag: Seconds = Field(description="time constant with which the angle follows inside that rate")
    caster: Annotated[float, Quantity("length", -1.0, 1.0)] = Field(
        default=0.0, description="how far the contact point trails behind the steering axis; below 0 it runs ahead"
    )
    coupling: Annotated[float, Quantity("number", -1e3, 1e3)] = Field(
        default=0.0, description="turns of the wheel against its drive in one turn of the steering"
    )
    motor: Annotated[Any, _ByName("MotorForm", "motors")] = Field(
        default=None, description="that steers on the plant motors; without it a servo does"
    )
    kp: Annotated[float, Quantity("voltage per angle", 0.0, 1e6)] = Field(
        default=6.0, description="of the motor's position loop, for each radian of error"
    )
    kd: Annotated[float, Quantity("voltage per angular speed", 0.0, 1e6)] = Field(
        default=0.3, description="of the motor's position loop, against the steering rate"
    )
    inertia: Annotated[float, Quantity("inertia", 0.0, 1e3)] = Field(
        default=0.0, description="of the module about its axis, without the motor"
    )


class WheelForm(Form):
    """One wheel. What is the same for all wheels may stand in [defaults.wheel]."""

    kind: Literal["omni", "mecanum", "swerve"] = Field(description="omni, mecanum or swerve")
    at: At = Field(description='contact point, such as { x = "20 cm", y = "15 cm" }')
    yaw: Angle = Field(default=0.0, description="direction in which positive speed drives; a swerve wheel's zero")
    roller: Angle = Field(
        default=0.0,
        description="axis of the roller on the ground, from the rolling direction (45 deg or -45 deg as a rule)",
    )
    radius: Radius = Field(description='a length such as "51 mm"')
    width: Annotated[float, Quantity("length", 1e-4, 2.0)] = Field(default=0.03, description="of the wheel")
    motor: Annotated[Any, _ByName("MotorForm", "motors")] = Field(description="a name of the motor library or a table")
    encoder: Annotated[Any, _ByName("EncoderForm", "encoders")] = Field(
        default=None, description="a name of the sensor library or a table; without it the speed is not measured"
    )
    steering: SteeringForm | None = Field(default=None, description='{ rate = "6 rad/s", lag = "50 ms" }')
    inverted: bool = Field(default=False, description="the hardware turns and counts the other way")
    max_speed: Annotated[Any, WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string"}]})] = Field(
        default=None,
        description='limit of the wheel, "20 rpm" or "0.1 m/s" of rim; without it the motor\'s no-load speed',
    )


class RobotForm(Form):
    """The base as a whole."""

    name: str = Field(description="a short name")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    accept: list[str] = Field(default=[], description='faults that are meant: "wheels-outside-footprint"')
    mass: Annotated[float, Quantity("mass", 1e-6, 1e6)] = Field(description='of the whole robot, such as "3.26 kg"')
    inertia: Annotated[float, Quantity("inertia", 1e-12, 1e9)] | None = Field(
        default=None, description="about the centre of mass; without it a disc out to the farthest wheel: 1/2 m R^2"
    )
    centre_of_mass: At | None = Field(default=None, description="without it the robot's centre")
    footprint_radius: Annotated[float, Quantity("length", 1e-3, 100.0)] | None = Field(
        default=None, description="circle that encloses all parts; without it the farthest corner of a wheel"
    )
    control_period: Annotated[float, Quantity("time", 1e-4, 1.0)] = Field(
        default=0.01, description="of the control loop"
    )


class LidarForm(Form):
    """A scanning range sensor."""

    model: str | None = Field(
        default=None, description="entry of the sensor library that gives what is not written here"
    )
    name: str = Field(default="lidar", description="name of the sensor, for people")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    mount: Mount = Field(default=Mount(), description="place on the robot; without it the centre")
    rate: Annotated[float, Quantity("frequency", 0.0, 1e4, above_low=True)] = Field(description="revolutions a second")
    beams: Annotated[int, Whole(1, 100_000)] = Field(description="beams in one revolution")
    field_of_view: Annotated[float, Quantity("angle", 0.0, 6.2831853071796, above_low=True)] = Field(
        default=6.283185307179586, description="angle over which the beams spread"
    )
    clockwise: bool = Field(default=True, description="direction of rotation, seen from above")
    range_min: Annotated[float, Quantity("length", 0.0, 1e4)] = Field(description="nearest distance it can tell")
    range_max: Annotated[float, Quantity("length", 0.0, 1e4, above_low=True)] = Field(
        description="farthest distance it can tell"
    )
    noise: Annotated[float, Quantity("length", 0.0, 10.0)] = Field(
        default=0.0, description="standard deviation, at least"
    )
    noise_relative: Ratio = Field(
        default=0.0, description="standard deviation as a part of the distance, if that is more"
    )
    dropout: Ratio = Field(default=0.0, description="probability that a beam tells nothing")
    motion_distortion: bool = Field(default=True, description="beams are taken one after another while the robot moves")


class ImuForm(Form):
    """A yaw gyro with an accelerometer."""

    model: str | None = Field(
        default=None, description="entry of the sensor library that gives what is not written here"
    )
    name: str = Field(default="imu", description="name of the sensor, for people")
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    mount: Mount = Field(default=Mount(), description="place on the robot; without it the centre")
    rate: Annotated[float, Quantity("frequency", 0.0, 1e6, above_low=True)] = Field(description="samples a second")
    gyro_noise: Annotated[float, Quantity("angular speed", 0.0, 100.0)] = Field(
        default=0.0, description="of one sample"
    )
    gyro_bias: Annotated[float, Quantity("angular speed", -100.0, 100.0)] = Field(
        default=0.0, description="at the start"
    )
    gyro_bias_walk: Annotated[float, Quantity("angular speed", 0.0, 100.0)] = Field(
        default=0.0, description="spread of the bias after one second of walk"
    )
    accel_noise: Annotated[float, Quantity("acceleration", 0.0, 1e3)] = Field(default=0.0, description="of one sample")


class MouseForm(Form):
    """A ball or optical mouse that looks at the ground, or a measuring wheel."""

    model: str | None = Field(
        default=None, description="entry of the sensor library that gives what is not written here"
    )
    title: str = Field(default="", description="one line for people")
    source: str = Field(default="", description="where the numbers come from")
    mount: Mount = Field(default=Mount(), description="place on the robot; without it the centre")
    resolution: Annotated[float, Quantity("length", 0.0, 1.0, above_low=True)] = Field(description="one count")
    noise_relative: Ratio = Field(default=0.0, description="standard deviation as a part of the distance travelled")
    axes: Literal["xy", "x"] = Field(
        default="xy", description='"x" is a measuring wheel: it counts along x alone and rolls freely across'
    )


class BatteryForm(Form):
    """The supply of the motors."""

    voltage: Annotated[float, Quantity("voltage", 0.0, 1e4, above_low=True)] = Field(description="without load")
    resistance: Annotated[float, Quantity("resistance", 0.0, 1e3)] = Field(default=0.1, description="inner")
    capacity: Annotated[float, Quantity("charge", 0.0, 1e9, above_low=True)] | None = Field(
        default=None, description="without it the battery does not run down"
    )


class GroundForm(Form):
    """Wheel and ground."""

    friction: Annotated[float, Quantity("number", 0.0, 10.0)] = Field(default=0.6, description="grip")
    roller_resistance: Annotated[float, Quantity("number", 0.0, 10.0)] = Field(
        default=0.02, description="of free rollers"
    )
    slip_speed: Annotated[float, Quantity("speed", 1e-6, 10.0)] = Field(
        default=0.01, description="at which grip saturates"
    )


class LimitsForm(Form):
    """What the base may do, besides what its wheels can do. A missing key is no limit."""

    speed: Annotated[float, Quantity("speed", 0.0, 1e4, above_low=True)] | None = Field(
        default=None, description="of the base"
    )
    yaw_rate: AngularSpeed | None = Field(default=None, description="of the base")
    accel: Annotated[float, Quantity("acceleration", 0.0, 1e5, above_low=True)] | None = Field(
        default=None, description="of the base"
    )
    yaw_accel: Annotated[float, Quantity("angular acceleration", 0.0, 1e6, above_low=True)] | None = Field(
        default=None, description="of the base"
    )


class SpeedLoopForm(Form):
    """The wheel-speed loop; gains are duty per part of the no-load speed."""

    kp: Annotated[float, Quantity("number", 0.0, 1e6)] = Field(
        default=0.5, description="duty for an error of the whole range"
    )
    ki: Annotated[float, Quantity("number", 0.0, 1e6)] = Field(default=4.0, description="the same, a second")
    filter: Seconds = Field(default=0.03, description="time constant of the encoder's speed")
    feed_forward: Ratio = Field(default=1.0, description="share of the commanded speed that becomes duty at once")


Plain = Annotated[float, Quantity("number", -1e12, 1e12)]


class CurveForm(Form):
    """What duty a speed takes in one direction: a cubic, measured points, or the pieces a canonical file has."""

    cubic: list[Plain] | None = Field(
        default=None, description="[c0, c1, c2, c3] of PWM = c0 + c1 v + c2 v^2 + c3 v^3, in counts over speed_unit"
    )
    top: Annotated[float, Quantity("number", 0.0, 1e9, above_low=True)] | None = Field(
        default=None, description="speed at which the cubic ends; without it where it reaches full duty"
    )
    points: list[list[Plain]] | None = Field(
        default=None,
        description="[[pwm, speed], ...] as measured, rising; the first at speed 0 where the dead zone ends",
    )
    knots: list[Plain] | None = Field(default=None, description="wheel speeds [rad/s] between the pieces, from 0 on")
    pieces: list[list[Plain]] | None = Field(
        default=None, description="of each piece [c0, c1, c2, c3]: duty 0 to 1 over rad/s from its knot on"
    )

    @model_validator(mode="before")
    @classmethod
    def _one_way(cls, table: Any) -> Any:
        if isinstance(table, dict) and not set(table) - set(cls.model_fields):  # an unknown key is told as such
            keys = set(table)
            if keys - {"top"} not in ({"cubic"}, {"points"}, {"knots", "pieces"}):
                written = ", ".join(sorted(keys)) or "none of them"
                raise custom(f"a curve is one of {{ cubic }}, {{ points }} and {{ knots, pieces }}; found {written}")
            if "top" in keys and "cubic" not in keys:
                raise custom("'top' ends a cubic; points and pieces end with their last")
        return table


class CurveGroupForm(Form):
    """Wheels that were measured together, or alone, and their two curves."""

    wheels: list[str] = Field(description="names of wheels")
    forward: CurveForm = Field(description="curve of positive speed, such as { cubic = [43.5, 2.86, -0.16, 0.0056] }")
    backward: CurveForm = Field(description="curve of negative speed, over its amount")


class LinearizerForm(Form):
    """What the motor board knows of its actuators; beside these keys, groups of wheels [linearizer.NAME]."""

    counts: Annotated[int, Whole(1, 1_000_000)] = Field(default=255, description="PWM counts of full duty")
    speed_unit: str = Field(default="m/s", description='of the speeds in the curves, such as "mm/s" of rim or "rad/s"')
    speed_scale: Annotated[float, Quantity("number", 1e-3, 1e3)] = Field(
        default=1.0, description="a wheel's speed over the speed in the curves"
    )


class PwmMapForm(LinearizerForm):
    """What simulated actuators really do; beside these keys, groups of wheels [pwm_map.NAME]."""

    voltage: Annotated[float, Quantity("voltage", 0.0, 1e4, above_low=True)] | None = Field(
        default=None, description="of the battery while the curves were measured; without it that of [battery]"
    )
    dead_time: Seconds = Field(default=0.0, description="from a duty to motion, out of standstill and at reversal")
    dead_time_spread: Seconds = Field(default=0.0, description="its standard deviation from start to start")
    lag: Seconds = Field(default=0.05, description="time constant with which a wheel's speed follows")
    speed_spread: Ratio = Field(default=0.0, description="of a wheel's constant deviation from its curve")
    speed_noise: Ratio = Field(default=0.0, description="of its deviation in each control period")
