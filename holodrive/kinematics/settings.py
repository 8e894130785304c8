"""Numbers of the command pipeline that no robot file sets."""

import math

HOLD_SPEED = 1e-3  # m/s: a module whose contact is slower keeps its angle
HYSTERESIS = math.radians(5.0)  # a module changes its mind about driving backwards this far from 90 degrees
FLIP_SLACK = 1e-9  # rad: far more than rounding, far less than any encoder tells; square to rounding is square
BAND = HYSTERESIS + FLIP_SLACK
TIGHT = 1e-9
GOAL = 1.0 - TIGHT  # a saturated wheel runs at this share of its limit, to TIGHT
SLOW_DOWN_ROUNDS = 6
CASTER_ROUNDS = 8
NEW_WAY = 0.2  # rad: a contact velocity that turns more in a tick does not go on turning so
POWERED = 2  # what `Chassis.trails` is then
POWERED_CASTER = 0.01  # m: modules that trail at least this far are driven as powered casters
