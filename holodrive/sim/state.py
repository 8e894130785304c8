"""The indices of the flat float64 vector that is one simulated robot: everything that changes, nothing that stays.

A batch is an array (n, SIZE) of such rows; counters are whole floats.
"""

from holodrive.layout import MAX_MICE, MAX_WHEELS

POSE = 0  # 3: base_link in the world; m, m, rad, heading not wrapped
TWIST = 3  # 3: of base_link in its own axes, as the ground sees it
TICK = 6  # control periods done
FREE = 7  # m that the robot may surely still travel before it can touch anything
MOVED = 8  # 3: integral of the twist over the last control period (m, m, rad), body axes
TICK_TWIST = 11  # 3: twist one control period ago
TICK_POSE = 14  # 3: pose one control period ago
ENERGY = 17  # J drawn from the battery
CHARGE = 18  # C drawn from the battery
VOLTAGE = 19  # V at the drivers
FAULT = 20  # 1.0 once a command was not finite; latched
DIRECT = 21  # 1.0 while the command is a duty
COLLISIONS = 22  # how many contacts began
MOVED_COLLISIONS = 23  # those in which the robot moved
N_EVENTS = 24  # rows written to the event table
CONTACTS = 25  # 4 x (obstacle number + 1, time of last touch)

GYRO = 34  # rad/s
ACCEL = 35  # 2: m/s^2
GYRO_WALK = 37  # rad/s, how far the gyro's bias has walked
IMU_SAMPLE = 38  # number of the sample held, from 1; 0 = none yet
SCANS = 39  # scans finished
SCAN_IS_NEW = 40  # 1.0 at the tick at which a scan arrived
SCAN_TIME = 41  # s
NEXT_BEAM = 42  # beams taken so far of the scan under way
PUSHED = 43  # 2: how far contacts have moved the robot since the last tick [m], body axes

WHEEL_SPEED = 48  # n: rad/s
WHEEL_ANGLE = WHEEL_SPEED + MAX_WHEELS  # n: rad
CURRENT = WHEEL_ANGLE + MAX_WHEELS  # n: A
DUTY = CURRENT + MAX_WHEELS  # n: -1..1
COMMAND = DUTY + MAX_WHEELS  # n: rad/s, or duty while DIRECT
COUNT = COMMAND + MAX_WHEELS  # n: encoder counts
MEASURED = COUNT + MAX_WHEELS  # n: rad/s, the motor board's filtered encoder speed
INTEGRAL = MEASURED + MAX_WHEELS  # n: rad/s, of the speed loop
STEER = INTEGRAL + MAX_WHEELS  # m: rad
STEER_COMMAND = STEER + MAX_WHEELS  # m: rad
MICE = STEER_COMMAND + MAX_WHEELS  # 2 k: m told at this tick
MICE_CARRY = MICE + 2 * MAX_MICE  # 2 k: counts not told yet, below 1
AIM = MICE_CARRY + 2 * MAX_MICE  # n: rad/s that the duty leads to, plant "pwm_map"; and so are the next two
HEADED = AIM + MAX_WHEELS  # n: -1, 0 or 1, which way the wheel turns or is about to
WAIT = HEADED + MAX_WHEELS  # n: s of dead time still to go
STEER_RATE = WAIT + MAX_WHEELS  # m: rad/s of the last physics step; robots with casters or couplings only
CONTACT = STEER_RATE + MAX_WHEELS  # n rows: scratch of the slip plant, see there
CONTACT_ROW = 17
SIZE = CONTACT + CONTACT_ROW * MAX_WHEELS

# --- plant "motors" only, see there: numbers of the body, then a row for each drive motor and each steering ----------
BUS_CURRENT = SIZE  # A that the drivers drew in the last sub-step
CARRIED = BUS_CURRENT + 1  # 3: twist of the centre of mass at the end of that step, in its axes
MASS = CARRIED + 3  # 6: what the body and all shafts do together in this step, upper triangle of a matrix
MOTOR = SIZE + 16  # the rows: n drive motors, then m steerings
MOTOR_ELECTRIC = 0  # 16: currents, electrical angle and sums, see `actuators.bldc`
MOTOR_SPEED = 16  # rad/s of the output shaft
MOTOR_DUTY = 17  # -1..1
MOTOR_MEASURED = 18  # rad/s, the board's filtered speed of a wheel
MOTOR_TARGET = 18  # rad, the board's target of a steering
MOTOR_INTEGRAL = 19  # rad/s, of the loop of a drive
MOTOR_LAST = 19  # rad, the command of a steering one tick ago
MOTOR_ACCEL = 20  # rad/s^2 in the last sub-step
MOTOR_TURNED = 21  # rad in this physics step
MOTOR_READY = 22  # N m: scratch of a sub-step
MOTOR_LEVER = 23  # 3: twist of the centre of mass per speed of the shaft; m, m, 1
MOTOR_CURRENT = 26  # A that make torque: the current of the equivalent DC motor
MOTOR_TORQUE = 27  # N m behind gear and its losses; means of the last control period, and so are the next two
MOTOR_INPUT = 28  # W from the drivers; below 0 while it brakes
MOTOR_OUTPUT = 29  # W that the shaft gives to the load
MOTOR_INPUT_J, MOTOR_COPPER_J, MOTOR_OUTPUT_J = 30, 31, 32  # J since start: electrical, lost in copper, at the shaft
MOTOR_SHAFT_J = 33  # J at the shaft in this control period
MOTOR_MOVING = 34  # rad/s, how fast a steering's target moves evenly; 0 while it does not
MOTOR_FROM = 35  # rad, a steering's angle at the start of this physics step
MOTOR_IMPULSE = 36  # N m s of the rotor in this control period
MOTOR_RATE = 37  # rad/s, how fast the commands of a steering moved in this tick
MOTOR_ROW = 38

# --- event table: one row for each event of a robot ----------------------------------------------
EVENT_TIME = 0  # s
EVENT_KIND = 1  # COLLISION or COMMAND_FAULT
EVENT_POSE = 2  # 3
EVENT_PLACE = 5  # 2: point of contact, world [m]
EVENT_OBSTACLE = 7  # number of the obstacle, see `obstacles.Obstacles`
EVENT_ROBOT_SPEED = 8  # m/s just before the contact
EVENT_MOVER_SPEED = 9  # m/s of the obstacle
EVENT_SIZE = 10
COLLISION, COMMAND_FAULT = 1.0, 2.0
