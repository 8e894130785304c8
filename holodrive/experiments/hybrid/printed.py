"""What Tuama and Hadi print, number by number; lengths in cm and times in s where the paper has them so."""

EQ_19 = ((0.0, 19.6, 4.52), (26.78, 7.17, 4.52), (-26.78, 7.17, 4.52))
EQ_23 = ((0.0, 0.01867, 0.01867), (0.08, -0.04, 0.04), (-0.12761, 0.1744, 0.1744))

MOTOR_RPM = 22.0  # Table II, no load
WHEEL_DIAMETER_CM = 10.2  # Table I
WHEEL_RADIUS_CM = 5.0  # Table VI

START_CM, END_CM = (50.0, 50.0), (50.0, 450.0)  # text on Table IX
OBSTACLES_CM = ((50.0, 150.0, 15.0), (150.0, 150.0, 15.0), (150.0, 250.0, 15.0), (50.0, 450.0, 15.0))  # Table IX

# Table X: length cm, time s, via points cm, turns
ABC = (574.7, 33.634, ((88.0, 148.0), (175.0, 21.0)), 8)
FLC = (536.515, 25.44, ((88.0, 148.0), (275.0, 27.0)), 6)
SHORTER, FASTER = 0.07, 0.09  # conclusion: FLC against ABC
THREE_OMNI_S = 48.5  # text on Table IX

MSE = {"PID": (8.055e-2, 7.782e-2, 4.904e-3), "FLC": (3.344e-2, 6.798e-2, 3.041e-3)}  # Table XI: x, y, theta
MSE_BELOW = 0.06  # section VI.C, said of the MSE, in m
STEP = {
    "PID": (0.45, 2.35, 0.01, 0.77),
    "FLC": (0.36, 2.01, 0.02, 0.71),
}  # Table XII: rise s, settling s, error, overshoot

SETS: dict[str, dict[str, tuple[float, ...]]] = {  # section VI.B: parameters of trapmf and trimf
    "DH": {"N": (0, 0, 250, 500), "M": (250, 750, 1500), "F": (1000, 1500, 2500, 2500)},
    "DL": {"N": (0, 0, 250, 500), "M": (500, 750, 1000), "F": (750, 1000, 2500, 2500)},
    "DR": {"N": (0, 0, 250, 500), "M": (250, 750, 1500), "F": (500, 1500, 2500, 2500)},
    "L": {"N": (-300, -200, -175), "NZ": (-200, -150, -100), "PZ": (100, 150, 250), "P": (150, 200, 300)},
    "R": {"N": (-300, -200, -150), "NZ": (-200, -150, -50), "PZ": (100, 150, 200), "P": (150, 200, 300)},
}
STRUCTURE = "3 in, 27 rules, 2 out"  # Fig. 28 and Table VIII
STATES = "seventeen"  # abstract: cognitive states
UNIVERSE_MM, SENSOR_MM = (0.0, 2500.0), (120.0, 3000.0)  # inputs of the controller, range that the text gives the lidar
OUTPUT_RANGE = (-300.0, 300.0)
