"""The body's twist where contacts trail behind their steering axes, and wheels that the steering turns.

For the plants without slip; a robot without casters and couplings never comes here. `model[md.CASTER_AT]` is where
the kinematics begin (`kinematics.kernel.arrays`). `state.WHEEL_SPEED` and `WHEEL_ANGLE` are the wheel's own;
drive and encoder turn with the wheel plus coupling times the steering rate.
"""

from holodrive.kinematics import kernel as kin
from holodrive.kinematics.caster_kernel import caster_forward_step, wheel_twist
from holodrive.leaf import leaf
from holodrive.sim import model as md
from holodrive.sim import state as st


@leaf
def trailing_step(model, state, n, dt):  # type: ignore[no-untyped-def]
    """`first_order.wheels_step`: step the wheel speeds; the body's mean twist, at the angles of the step's middle."""
    for i in range(n):
        w, carried = md.WHEELS + i * md.BLOCK, carried_by_steering(model, state, i)
        target = state[st.DUTY + i] * model[w + md.NO_LOAD]
        gap = state[st.WHEEL_SPEED + i] + carried - target
        speed = target + gap * model[w + md.MEAN] - carried
        state[st.WHEEL_SPEED + i] = target + gap * model[w + md.DECAY] - carried
        state[st.WHEEL_ANGLE + i] += speed * dt
        state[st.CONTACT + i] = speed
    twist_into(model, state, st.CONTACT, 0.5 * dt, st.CONTACT + n)
    return state[st.CONTACT + n], state[st.CONTACT + n + 1], state[st.CONTACT + n + 2]


@leaf
def twist_into(model, state, speeds_at, ago, out_at):  # type: ignore[no-untyped-def]
    """Write at `state[out_at]` the twist (3) of wheels with the speeds at `state[speeds_at]`, `ago` [s] before now."""
    caster_forward_step(
        model[int(model[md.CASTER_AT]) :],
        state[speeds_at:],
        state[st.STEER :],
        state[st.STEER_RATE :],
        ago,
        state[out_at : out_at + 3],
    )


@leaf
def lever(model, state, i, roll, sweep):  # type: ignore[no-untyped-def]
    """Twist (3) of `base_link` that wheel i alone makes at the present steering angles, the others standing.

    Args:
        model, state: the robot.
        i: the wheel.
        roll: how fast it rolls [m/s of rim]; a fixed wheel's speed [rad/s].
        sweep: how fast its contact is swept sideways [m/s]: caster times steering rate.
    """
    kinematics = model[int(model[md.CASTER_AT]) :]
    return wheel_twist(kinematics, i, state[st.STEER :], state[st.STEER_RATE :], 0.0, roll, sweep)


@leaf
def trail(model, i):  # type: ignore[no-untyped-def]
    """Caster [m] of wheel i; 0 without."""
    at = int(model[md.CASTER_AT])
    return model[at + kin.WHEELS + i * kin.BLOCK + kin.CASTER] if at > 0 else 0.0


@leaf
def coupling(model, i):  # type: ignore[no-untyped-def]
    """How far wheel i turns against its drive per turn of its steering; 0 without."""
    at = int(model[md.CASTER_AT])
    return model[at + kin.WHEELS + i * kin.BLOCK + kin.COUPLING] if at > 0 else 0.0


@leaf
def carried_by_steering(model, state, i):  # type: ignore[no-untyped-def]
    """How much faster the drive of wheel i turns than the wheel, for its steering turns [rad/s]."""
    j = int(model[md.WHEELS + i * md.BLOCK + md.STEERED])
    return coupling(model, i) * state[st.STEER_RATE + j] if j >= 0 else 0.0


@leaf
def steering_turned(model, state, i, angle, dt):  # type: ignore[no-untyped-def]
    """Note the rate of a steering that stood at `angle` a step ago; the drive keeps its speed, the wheel does not."""
    j = int(model[md.WHEELS + i * md.BLOCK + md.STEERED])
    rate = (state[st.STEER + j] - angle) / dt
    state[st.WHEEL_SPEED + i] -= coupling(model, i) * (rate - state[st.STEER_RATE + j])
    state[st.STEER_RATE + j] = rate
