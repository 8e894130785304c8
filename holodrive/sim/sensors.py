"""What encoders, IMU, ground mice and lidar tell at a control tick, from the state of the robot."""

import math

from numba import njit

from holodrive.sim import lidar as rays
from holodrive.sim import state as st
from holodrive.sim import streams


@njit(cache=True, error_model="numpy")
def sense(model, obstacles, state, key, ranges, pending):  # type: ignore[no-untyped-def]
    """Read all sensors at the end of a control period (or at the start of a run).

    Args:
        model, obstacles, state: the robot.
        key: of its random streams.
        ranges: (b,) the newest whole scan.
        pending: (b,) the scan under way.
    """
    time = state[st.TICK] * model.period
    read_encoders(model, state)
    if model.imu.rate > 0.0:
        read_imu(model, state, key, time)
    if model.mice.shape[0] > 0:
        read_mice(model.mice, state, key)
    if model.lidar.beams > 0:
        state[st.SCAN_IS_NEW] = 0.0
        if model.lidar.beam_period > 0.0:
            sweep(model, obstacles, state, key, ranges, pending, time)
        elif time >= state[st.SCANS] * model.lidar.period - 1e-9:
            rays.cast(ranges, model.lidar, obstacles, time, state[st.POSE], state[st.POSE + 1], state[st.POSE + 2])
            rays.read(ranges, model.lidar, key, int(state[st.SCANS]))
            scan_done(state, time)


@njit(cache=True, error_model="numpy")
def read_encoders(model, state):  # type: ignore[no-untyped-def]
    """Whole counts since the start, and the motor board's filtered speed. A wheel without encoder tells NaN."""
    counts = model.wheels.counts
    for i in range(model.n):
        if counts[i] == 0.0:
            state[st.COUNT + i] = state[st.MEASURED + i] = math.nan
            continue
        count = math.floor(state[st.WHEEL_ANGLE + i] * counts[i])
        if state[st.TICK] > 0.0:
            speed = (count - state[st.COUNT + i]) / (counts[i] * model.period)
            state[st.MEASURED + i] += model.loop_filter * (speed - state[st.MEASURED + i])
        state[st.COUNT + i] = count


@njit(cache=True, error_model="numpy")
def read_imu(model, state, key, time):  # type: ignore[no-untyped-def]
    """Hold a sample until the next one is due; noise belongs to the sample's number, bias walks with it."""
    imu = model.imu
    sample = math.floor(time * imu.rate + 1e-9) + 1.0
    if sample == state[st.IMU_SAMPLE]:
        return
    passed = min(sample - state[st.IMU_SAMPLE], sample - 1.0)
    state[st.IMU_SAMPLE] = sample
    number = int(sample)
    walk = streams.gauss(streams.draw(key, streams.GYRO_WALK, number))
    state[st.GYRO_WALK] += imu.gyro_walk * math.sqrt(passed / imu.rate) * walk
    noise = imu.gyro_noise * streams.gauss(streams.draw(key, streams.GYRO, number))
    omega = state[st.TWIST + 2]
    state[st.GYRO] = omega + imu.gyro_bias + state[st.GYRO_WALK] + noise
    # mean acceleration of the last control period in body axes: dv/dt + omega x v, then the lever arm
    t = model.period
    ax = ay = alpha = 0.0
    if state[st.TICK] > 0.0:
        ax = (state[st.TWIST] - state[st.TICK_TWIST]) / t - omega * state[st.TWIST + 1]
        ay = (state[st.TWIST + 1] - state[st.TICK_TWIST + 1]) / t + omega * state[st.TWIST]
        alpha = (omega - state[st.TICK_TWIST + 2]) / t
    ax -= alpha * imu.y + omega * omega * imu.x
    ay += alpha * imu.x - omega * omega * imu.y
    c, s = math.cos(imu.theta), math.sin(imu.theta)
    state[st.ACCEL] = c * ax + s * ay + imu.accel_noise * streams.gauss(streams.draw(key, streams.ACCEL, 2 * number))
    state[st.ACCEL + 1] = (
        c * ay - s * ax + imu.accel_noise * streams.gauss(streams.draw(key, streams.ACCEL, 2 * number + 1))
    )


@njit(cache=True, error_model="numpy")
def read_mice(mice, state, key):  # type: ignore[no-untyped-def]
    """Whole counts that the ground has passed by since the last tick; what is left of a count is carried on."""
    tick = int(state[st.TICK])
    for k in range(mice.shape[0]):
        # a sensor's displacement is linear in the body's, so that the integral over the period is enough
        dx = state[st.MOVED] - state[st.MOVED + 2] * mice[k, 1]
        dy = state[st.MOVED + 1] + state[st.MOVED + 2] * mice[k, 0]
        c, s = math.cos(mice[k, 2]), math.sin(mice[k, 2])
        for axis in range(2):
            way = c * dx + s * dy if axis == 0 else c * dy - s * dx
            at = 2 * k + axis
            if mice[k, 4] > 0.0:
                way *= 1.0 + mice[k, 4] * streams.gauss(streams.draw(key, streams.MICE + 16 * at, tick))
            total = state[st.MICE_CARRY + at] + way / mice[k, 3]
            count = math.floor(total)
            state[st.MICE_CARRY + at] = total - count
            state[st.MICE + at] = count * mice[k, 3]


@njit(cache=True, error_model="numpy")
def sweep(model, obstacles, state, key, ranges, pending, time):  # type: ignore[no-untyped-def]
    """Take the beams whose time has come since the last tick, each from where the robot was at its time."""
    lidar, period = model.lidar, model.period
    x0, y0, t0 = state[st.TICK_POSE], state[st.TICK_POSE + 1], state[st.TICK_POSE + 2]
    dx, dy, turn = state[st.POSE] - x0, state[st.POSE + 1] - y0, state[st.POSE + 2] - t0
    while True:
        scan, beam = int(state[st.SCANS]), int(state[st.NEXT_BEAM])
        at = scan * lidar.period + (beam + 1.0) * lidar.beam_period
        if at > time + 1e-9:
            return
        share = 1.0 + (at - time) / period
        distance = rays.cast_beam(lidar, obstacles, beam, at, x0 + share * dx, y0 + share * dy, t0 + share * turn)
        pending[beam] = rays.read_beam(distance, lidar, key, scan, beam)
        state[st.NEXT_BEAM] += 1.0
        if beam + 1 == lidar.beams:
            ranges[:] = pending
            scan_done(state, at)


@njit(cache=True, error_model="numpy")
def scan_done(state, time):  # type: ignore[no-untyped-def]
    """A whole scan is there; its last beam was taken at `time`."""
    state[st.SCANS] += 1.0
    state[st.SCAN_IS_NEW], state[st.SCAN_TIME], state[st.NEXT_BEAM] = 1.0, time, 0.0
