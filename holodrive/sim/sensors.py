"""What encoders, IMU, ground mice and lidar tell at a control tick, from the state of the robot."""

import math

import numpy as np

from holodrive.leaf import leaf
from holodrive.sim import lidar as rays
from holodrive.sim import model as md
from holodrive.sim import state as st
from holodrive.sim import streams
from holodrive.sim.caster import coupling


@leaf
def sense(model, obstacles, state, key, ranges, pending):  # type: ignore[no-untyped-def]
    """Read all sensors at the end of a control period (or at the start of a run).

    Args:
        model, obstacles, state: the robot.
        key: of its random streams.
        ranges: (b,) the newest whole scan.
        pending: (b,) the scan under way.
    """
    time = state[st.TICK] * model[md.PERIOD]
    read_encoders(model, state)
    if model[md.IMU_RATE] > 0.0:
        read_imu(model, state, key, time)
    if model[md.MICE] > 0.0:
        read_mice(model, state, key)
    if model[md.BEAMS] > 0.0:
        state[st.SCAN_IS_NEW] = 0.0
        if model[md.BEAM_PERIOD] > 0.0:
            sweep(model, obstacles, state, key, ranges, pending, time)
        elif time >= state[st.SCANS] * model[md.SCAN_PERIOD] - 1e-9:
            rays.cast(ranges, model, obstacles, time, state[st.POSE], state[st.POSE + 1], state[st.POSE + 2])
            rays.read(ranges, model, key, int(state[st.SCANS]))
            scan_done(state, time)


@leaf
def read_encoders(model, state):  # type: ignore[no-untyped-def]
    """Whole counts since the start, and the motor board's filtered speed; NaN without an encoder."""
    share, moved, trails = model[md.LOOP_FILTER], state[st.TICK] > 0.0, model[md.CASTER_AT] > 0.0
    for i in range(int(model[md.N])):
        w = md.WHEELS + i * md.BLOCK
        angle = state[st.WHEEL_ANGLE + i]
        if trails and model[w + md.STEERED] >= 0.0:  # the encoder sits on the drive, which the steering does not turn
            angle += coupling(model, i) * state[st.STEER + int(model[w + md.STEERED])]
        count = np.floor(angle * model[w + md.COUNTS])
        if moved:
            speed = (count - state[st.COUNT + i]) * model[w + md.COUNT_SPEED]
            speed = state[st.MEASURED + i] + share * (speed - state[st.MEASURED + i])
            # a filter of a standing wheel dies away into numbers that cost a hundred times the time of others
            state[st.MEASURED + i] = 0.0 if abs(speed) < 1e-200 else speed
        state[st.COUNT + i] = count


@leaf
def read_imu(model, state, key, time):  # type: ignore[no-untyped-def]
    """Hold a sample until the next one is due; noise belongs to the sample's number, bias walks with it."""
    rate = model[md.IMU_RATE]
    sample = math.floor(time * rate + 1e-9) + 1.0
    if sample == state[st.IMU_SAMPLE]:
        return
    passed = min(sample - state[st.IMU_SAMPLE], sample - 1.0)
    state[st.IMU_SAMPLE] = sample
    number = int(sample)
    walk = streams.gauss(streams.draw(key, streams.GYRO_WALK, number))
    state[st.GYRO_WALK] += model[md.GYRO_WALK] * math.sqrt(passed / rate) * walk
    noise = model[md.GYRO_NOISE] * streams.gauss(streams.draw(key, streams.GYRO, number))
    omega = state[st.TWIST + 2]
    state[st.GYRO] = omega + model[md.GYRO_BIAS] + state[st.GYRO_WALK] + noise
    # mean acceleration of the last control period in body axes: dv/dt + omega x v, then the lever arm
    t = model[md.PERIOD]
    ax = ay = alpha = 0.0
    if state[st.TICK] > 0.0:
        ax = (state[st.TWIST] - state[st.TICK_TWIST]) / t - omega * state[st.TWIST + 1]
        ay = (state[st.TWIST + 1] - state[st.TICK_TWIST + 1]) / t + omega * state[st.TWIST]
        alpha = (omega - state[st.TICK_TWIST + 2]) / t
    ax -= alpha * model[md.IMU_Y] + omega * omega * model[md.IMU_X]
    ay += alpha * model[md.IMU_X] - omega * omega * model[md.IMU_Y]
    c, s = math.cos(model[md.IMU_THETA]), math.sin(model[md.IMU_THETA])
    state[st.ACCEL] = (
        c * ax + s * ay + model[md.ACCEL_NOISE] * streams.gauss(streams.draw(key, streams.ACCEL, 2 * number))
    )
    state[st.ACCEL + 1] = (
        c * ay - s * ax + model[md.ACCEL_NOISE] * streams.gauss(streams.draw(key, streams.ACCEL, 2 * number + 1))
    )


@leaf
def read_mice(model, state, key):  # type: ignore[no-untyped-def]
    """Whole counts that the ground has passed by since the last tick; what is left of a count is carried on.

    A measuring wheel counts along its x axis only; the other number is NaN.
    """
    tick = int(state[st.TICK])
    for k in range(int(model[md.MICE])):
        m = int(model[md.MICE_AT]) + k * md.MOUSE
        # a sensor's displacement is linear in the body's, so that the integral over the period is enough
        dx = state[st.MOVED] + state[st.PUSHED] - state[st.MOVED + 2] * model[m + md.MOUSE_Y]
        dy = state[st.MOVED + 1] + state[st.PUSHED + 1] + state[st.MOVED + 2] * model[m + md.MOUSE_X]
        c, s = math.cos(model[m + md.MOUSE_THETA]), math.sin(model[m + md.MOUSE_THETA])
        noise, resolution = model[m + md.MOUSE_NOISE], model[m + md.MOUSE_COUNT]
        for axis in range(2):
            way = c * dx + s * dy if axis == 0 else c * dy - s * dx
            at = 2 * k + axis
            if axis >= model[m + md.MOUSE_AXES]:
                state[st.MICE + at] = math.nan
                continue
            if noise > 0.0:
                way *= 1.0 + noise * streams.gauss(
                    streams.draw_index(streams.draw(key, streams.MICE, tick), np.uint64(at))
                )
            total = state[st.MICE_CARRY + at] + way / resolution
            count = math.floor(total)
            state[st.MICE_CARRY + at] = total - count
            state[st.MICE + at] = count * resolution
    state[st.PUSHED] = state[st.PUSHED + 1] = 0.0


@leaf
def sweep(model, obstacles, state, key, ranges, pending, time):  # type: ignore[no-untyped-def]
    """Take the beams whose time has come since the last tick, each from where the robot was at its time."""
    period, beams = model[md.PERIOD], int(model[md.BEAMS])
    x0, y0, t0 = state[st.TICK_POSE], state[st.TICK_POSE + 1], state[st.TICK_POSE + 2]
    dx, dy, turn = state[st.POSE] - x0, state[st.POSE + 1] - y0, state[st.POSE + 2] - t0
    while True:
        scan, beam = int(state[st.SCANS]), int(state[st.NEXT_BEAM])
        at = scan * model[md.SCAN_PERIOD] + (beam + 1.0) * model[md.BEAM_PERIOD]
        if at > time + 1e-9:
            return
        share = 1.0 + (at - time) / period
        distance = rays.cast_beam(beam, model, obstacles, at, x0 + share * dx, y0 + share * dy, t0 + share * turn)
        pending[beam] = rays.read_beam(distance, model, key, scan, beam)
        state[st.NEXT_BEAM] += 1.0
        if beam + 1 == beams:
            for i in range(beams):
                ranges[i] = pending[i]
            scan_done(state, at)


@leaf
def scan_done(state, time):  # type: ignore[no-untyped-def]
    """A whole scan is there; its last beam was taken at `time`."""
    state[st.SCANS] += 1.0
    state[st.SCAN_IS_NEW], state[st.SCAN_TIME], state[st.NEXT_BEAM] = 1.0, time, 0.0
