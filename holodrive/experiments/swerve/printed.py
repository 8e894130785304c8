"""What Rosyidin et al. print, number by number; lengths in m, angles in degrees, wheel speeds in rpm.

Figures 6 to 9 are images: what is said of them here is what the text says of them.
"""

START = (0.0, 0.0, 0.0)  # section 3: x, y, heading
GOAL_TEXT = (5.0, 10.0, 180.0)  # section 3
GOAL_FIGURES = (10.0, 10.0, 180.0)  # section 3.1, of figure 6(a)

BLDC_ARRIVAL_S = 7.0  # section 3.1: "within 7 seconds the robot has arrived"
BLDC_PEAK_RPM = 700.0  # section 3.1 and conclusion
DC_ARRIVAL_S = 4.0  # section 3.2: "the error value reaches 0 in the 4th second"
DC_PEAK_RPM = 450.0  # conclusion: "the maximum speed is only 450 RPM"
CONCLUSION_S = 5.0  # conclusion: "reaches an error value of 0 within 5 seconds"

# Rows of eq. 18 and 19 for wheels at (x_i, y_i): coefficients of body vx, vy and omega. In eq. 18 the fourth row has
# y_2 where the second has x_1; in eq. 19 the wheels of radius 1 stand at (L, 0), (L/2, -sqrt(3)/2 L) and
# (-L/2, sqrt(3)/2 L).
EQ_19_PLACES = ((1.0, 0.0), (0.5, -(3.0**0.5) / 2.0), (-0.5, 3.0**0.5 / 2.0))  # (x_i, y_i) / L that its rows mean

# Factors of the terms of eq. 30 and 31 times L: R i, then e_a, e_b, e_c, v_a, v_b, v_c
EQ_30 = (-3.0, -2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0)
EQ_31 = (-3.0, 1.0 / 3.0, -2.0 / 3.0, 1.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0)
# Eq. 34: R i / L on the diagonal, and what V_ab - E_ab and V_bc - E_bc are multiplied with, times L
EQ_34_RESISTIVE = -1.0
EQ_34_INPUT = ((2.0 / 3.0, 2.0 / 3.0), (-2.0 / 3.0, 2.0 / 3.0))
FRICTION = ("K_f (eq. 25)", "β (eq. 32)", "b (eq. 34)")  # names of one constant

# Reference [29] (Hekimoglu): Ra [ohm], J [kg m2], D [N m s], K [N m/A], Kb [V s]; inductance in two readings [H]
DC_MOTOR = {"Ra": 0.4, "J": 4e-4, "D": 2.2e-3, "K": 0.015, "Kb": 0.05}
DC_INDUCTANCE_H = (2.7, 2.7e-3)
DC_TRANSFER = (15.0, (1.08, 6.1, 1.63))  # numerator and denominator of speed over voltage, as published with it
