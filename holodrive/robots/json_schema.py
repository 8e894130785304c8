"""The JSON Schemas of robot, motor and sensor files. `python -m holodrive.robots.json_schema` writes them anew."""

from pathlib import Path
from typing import Any

from holodrive.files.edge import Form
from holodrive.files.json_schema import Schema, by_name, definitions, document, ref, text
from holodrive.robots import motors, sensors
from holodrive.robots.checks import ACCEPTABLE
from holodrive.robots.form import (
    BatteryForm,
    CurveGroupForm,
    EncoderForm,
    GroundForm,
    ImuForm,
    LidarForm,
    LimitsForm,
    LinearizerForm,
    MotorForm,
    MouseForm,
    PwmMapForm,
    RobotForm,
    SpeedLoopForm,
    WheelForm,
)

FOLDER = Path(__file__).parent
_PLACES = [{"required": ["x", "y"]}, {"required": ["distance", "bearing"]}]


def robot() -> Schema:
    """Of robot files."""
    forms: list[type[Form]] = [RobotForm, WheelForm, MotorForm, EncoderForm, LidarForm, ImuForm, MouseForm]
    forms += [BatteryForm, GroundForm, LimitsForm, SpeedLoopForm, LinearizerForm, PwmMapForm, CurveGroupForm]
    parts = definitions(forms)
    parts["At"]["oneOf"] = _PLACES
    parts["RobotForm"]["properties"]["accept"]["items"] = {"enum": list(ACCEPTABLE)}
    parts["CurveForm"]["oneOf"] = [{"required": ["cubic"]}, {"required": ["points"]}, {"required": ["knots", "pieces"]}]
    for name in ("LinearizerForm", "PwmMapForm"):
        parts[name]["additionalProperties"] = ref(CurveGroupForm)
    for name in ("LidarForm", "ImuForm", "MouseForm"):
        needed = parts[name].pop("required")
        parts[name]["anyOf"] = [{"required": ["model"]}, {"required": needed}]
    # what a wheel lacks may stand in [defaults.wheel], key by key; only the loader sees both
    for name in ("MotorForm", "EncoderForm", "SteeringForm"):
        parts[name].pop("required")
    parts["WheelForm"]["properties"]["motor"]["anyOf"][0] = {"enum": list(motors.names())}
    parts["SteeringForm"]["properties"]["motor"]["anyOf"][0] = {"enum": list(motors.names())}
    parts["WheelForm"]["properties"]["encoder"]["anyOf"][0] = {"enum": list(sensors.names("encoder"))}
    parts["SharedWheelForm"] = {k: v for k, v in parts["WheelForm"].items() if k != "required"}
    parts["WheelForm"]["required"] = ["at"]
    properties: dict[str, Any] = {
        "robot": ref(RobotForm),
        "defaults": _table({"wheel": {"$ref": "#/definitions/SharedWheelForm"}}),
        "wheel": by_name(ref(WheelForm)) | {"minProperties": 1},
        "sensor": _table({"lidar": ref(LidarForm), "imu": ref(ImuForm), "mouse": by_name(ref(MouseForm))}),
        "battery": ref(BatteryForm),
        "ground": ref(GroundForm),
        "limits": ref(LimitsForm),
        "speed_loop": ref(SpeedLoopForm),
        "linearizer": ref(LinearizerForm),
        "pwm_map": ref(PwmMapForm),
    }
    return document("holodrive robot file", properties, ["robot", "wheel"], parts)


def motor() -> Schema:
    """Of motor files."""
    return document("holodrive motor file", {"motor": ref(MotorForm)}, ["motor"], definitions([MotorForm]))


def sensor() -> Schema:
    """Of sensor files."""
    kinds: dict[str, type[Form]] = {"lidar": LidarForm, "imu": ImuForm, "mouse": MouseForm, "encoder": EncoderForm}
    found = document(
        "holodrive sensor file",
        {name: ref(form) for name, form in kinds.items()},
        [],
        definitions(list(kinds.values())),
    )
    return {**found, "oneOf": [{"required": [name]} for name in kinds]}


def _table(properties: dict[str, Schema]) -> Schema:
    return {"type": "object", "properties": properties, "additionalProperties": False}


SHIPPED = {"robot.schema.json": robot, "motor.schema.json": motor, "sensor.schema.json": sensor}

if __name__ == "__main__":
    for name, make in SHIPPED.items():
        (FOLDER / name).write_text(text(make()), encoding="utf-8")
