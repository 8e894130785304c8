"""The message definitions that a log carries, so that any MCAP tool can read it without this package.

ROS 2 messages by their own names, and four of our own (`holodrive_msgs`) where ROS has none that keeps
a heading's turns, unrounded numbers, a scan with uneven beams or sensors that look at the ground.
"""

_SEPARATOR = "=" * 80

TICK = "holodrive_msgs/msg/Tick"
SCAN = "holodrive_msgs/msg/Scan"
EVENT = "holodrive_msgs/msg/Event"
STRING = "std_msgs/msg/String"
ODOMETRY = "nav_msgs/msg/Odometry"
TWIST = "geometry_msgs/msg/TwistStamped"
POSE = "geometry_msgs/msg/PoseStamped"
JOINTS = "sensor_msgs/msg/JointState"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
IMU = "sensor_msgs/msg/Imu"
MICE = "holodrive_msgs/msg/Mice"
MOTORS = "holodrive_msgs/msg/Motors"

_BODIES: dict[str, str] = {
    TICK: """\
# One control tick, every number unrounded. SI units and radians; NaN where a value is not known.
float64 time
float64[3] estimate               # x y theta in odom, theta not wrapped
float64[3] estimate_twist         # vx vy omega in base_link
float64[9] covariance             # of the estimated pose, world axes, row by row
float64 slip                      # m/s of rim
float64[3] reference
float64[3] reference_twist        # time derivative of reference
float64[3] reference_accel
float64 reference_last            # 1 when the reference will not move any more
float64[3] truth                  # x y theta in map
float64[3] true_twist             # in base_link
float64 decided_kind              # 0 twist, 1 wheel speeds, 2 motor duties
float64[3] decided_twist
float64[] decided_wheels          # rad/s, or duties
float64[] decided_steer
float64[] applied_wheels          # rad/s
float64[] applied_steer
float64[] wheel_position          # rad since start
float64[] wheel_speed
float64[] steer
float64[] duty
""",
    SCAN: """\
# A scan that sensor_msgs/LaserScan cannot tell: uneven beams, or a mount that is not the robot file's.
float64 stamp                     # of the last beam
float64[3] mount                  # x y theta in base_link
float64 range_min
float64 range_max
float64[] angles
float64[] ranges
float64[] offsets                 # of each beam against stamp
""",
    EVENT: """\
float64 time
float64[3] pose
string kind
string text
string data                       # JSON object
""",
    STRING: "string data\n",
    ODOMETRY: """\
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
""",
    TWIST: "std_msgs/Header header\ngeometry_msgs/Twist twist\n",
    POSE: "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    JOINTS: """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
""",
    LASER_SCAN: """\
std_msgs/Header header
float32 angle_min
float32 angle_max
float32 angle_increment
float32 time_increment
float32 scan_time
float32 range_min
float32 range_max
float32[] ranges
float32[] intensities
""",
    TRANSFORMS: "geometry_msgs/TransformStamped[] transforms\n",
    IMU: """\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
""",
    MICE: """\
# How far each ground sensor went over the ground since the last tick, in its own axes (frame mouse_NAME) [m].
std_msgs/Header header
string[] name
float64[] x
float64[] y
""",
    MOTORS: """\
# What drives and steerings did in the control period that begins at the stamp; NaN where unknown.
std_msgs/Header header
string[] name                     # wheels, then NAME_steer
float64[] current                 # A that make torque
float64[] torque                  # N m behind gear and its losses
float64[] electrical              # W from the driver
float64[] mechanical              # W that the shaft gives to its load
""",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "geometry_msgs/msg/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/msg/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "geometry_msgs/msg/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    "geometry_msgs/msg/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
    "geometry_msgs/msg/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    "geometry_msgs/msg/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    "geometry_msgs/msg/TransformStamped": """\
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
""",
}


def schema(name: str) -> str:
    """The full `ros2msg` text of a message: its own definition, then each that it uses, once."""
    order = [name]
    for parent in order:
        order += [child for child in _uses(parent) if child not in order]
    parts = [_BODIES[name]]
    parts += [f"{_SEPARATOR}\nMSG: {child.replace('/msg/', '/')}\n{_BODIES[child]}" for child in order[1:]]
    return "".join(parts)


def _uses(name: str) -> list[str]:
    """Names of the messages that are fields of a message, in order."""
    kinds = [line.split()[0].removesuffix("[]") for line in _BODIES[name].splitlines() if not line.startswith("#")]
    return list(dict.fromkeys(kind.replace("/", "/msg/") for kind in kinds if "/" in kind))
