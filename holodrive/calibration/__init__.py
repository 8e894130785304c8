"""CALIBRATE: from measurements to better numbers in a robot's file; the only way back to the description."""
