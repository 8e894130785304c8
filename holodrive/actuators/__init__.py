"""Motor models: lag, DC gearmotor and battery, the wheel-speed loop of the motor board."""
