"""The indices of the flat float64 arrays that compiled controllers, estimators and roll-outs share.

A compiled controller is `void(obs, memory, params, command)`, a compiled estimator
`void(obs, memory, params, estimate)`; all four are contiguous float64 vectors.
Sizes are fixed by the maxima here so that every index is a constant.
"""

MAX_WHEELS = 16
MAX_MICE = 4

# --- observation -------------------------------------------------------------------------------
TIME = 0  # s
DT = 1  # s since the previous control tick
POSE = 2  # 3: x, y, theta of the estimate, odom frame, theta not wrapped
TWIST = 5  # 3: vx, vy, omega of the estimate, base_link
REF_POSE = 8  # 3: world
REF_TWIST = 11  # 3: time derivative of the reference pose, world axes
REF_ACCEL = 14  # 3: second derivative, world axes
REF_LAST = 17  # 1.0 when the reference will not move any more
GYRO = 18  # rad/s, NaN without a gyro
ACCEL = 19  # 2: m/s^2, NaN without an accelerometer
SCAN_IS_NEW = 21  # 1.0 when the beams arrived since the last tick
SCAN_TIME = 22  # s, stamp of the last beam; NaN before the first scan
N_WHEELS = 23
N_STEER = 24
N_BEAMS = 25
BEAM_FIRST = 26  # rad, direction of beam 0 in the sensor frame
BEAM_STEP = 27  # rad from one beam to the next (negative for a clockwise sensor)
BEAM_PERIOD = 28  # s from one beam to the next; 0 for an instantaneous scan
N_MICE = 29
WHEEL_POSITION = 32  # n: rad since start, as the encoder tells it
WHEEL_SPEED = WHEEL_POSITION + MAX_WHEELS  # n: rad/s
STEER = WHEEL_SPEED + MAX_WHEELS  # m: rad
MICE = STEER + MAX_WHEELS  # 2 k: m since the last tick, sensor axes
BEAMS = MICE + 2 * MAX_MICE  # b: m; infinite = no return, NaN = invalid
OBS_HEADER = BEAMS  # an observation has OBS_HEADER + b numbers

# --- command -----------------------------------------------------------------------------------
VALUE = 0  # twist (3), wheel speeds (n) [rad/s] or duties (n), by the controller's command_kind
COMMAND_STEER = MAX_WHEELS  # m: rad, beside wheel speeds or duties
ARRIVED = 2 * MAX_WHEELS  # 1.0 when done
NO_RULE = ARRIVED + 1  # 1.0 when a fuzzy controller had no rule to fire
FAULT = ARRIVED + 2  # a fault number of the controller, 0 = none
COMMAND_SIZE = ARRIVED + 4

# --- estimate ----------------------------------------------------------------------------------
EST_POSE = 0  # 3
EST_TWIST = 3  # 3
EST_COVARIANCE = 6  # 9, row by row
EST_SLIP = 15  # m/s of rim
EST_SUSPECT = 16  # bit k is set while ground sensor k is not trusted, see `types.Estimate`
ESTIMATE_SIZE = 17

# --- memory of an estimator --------------------------------------------------------------------
START_POSE = 0  # 3: whoever starts an estimator writes the known start pose here; all else starts as zeros
