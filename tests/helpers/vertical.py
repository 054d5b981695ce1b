"""A vertical screw axis of two masses under a PID, step by step; no code of the plants is in it."""

import numpy as np

EVERY, STEPS, INNER = 1e-3, 8000, 20
#: Motor as the table meets it and table [kg], screw [N/m], [N s/m], weight without balance [N].
MOTOR, TABLE, STIFF, DAMPED, WEIGHT = 1600.0, 200.0, 1.2e8, 2.5e4, 500.0
GAIN, LAG = 1570.8, 5e-4  # [N/V], [s]; the command waits a sample as well
STEP = 1e-6  # of the scale [m]


def reference():
    """(steps,) a sine, faster and smaller ones, and a slow one [m]."""
    time = EVERY * np.arange(STEPS)
    parts = ((0.0, 0.02, 1.0), (2.0, 1.5e-3, 6.0), (4.0, 4e-4, 15.0), (6.0, 0.003, 0.5))
    found = np.zeros(STEPS)
    for begin, size, hz in parts:
        here = (time >= begin) & (time < begin + 2.0)
        rise = np.minimum(1.0, 4.0 * np.minimum(time - begin, begin + 2.0 - time))
        found[here] = (size * rise * (1.0 - np.cos(2.0 * np.pi * hz * time)))[here]
    return found


def logged():
    """(steps,) the place that the scale shows [m] and the command [V]."""
    place, speed, motor, turning, force = 0.0, 0.0, 0.0, 0.0, WEIGHT
    wanted, waiting, total, before = reference(), WEIGHT / GAIN, WEIGHT / GAIN, 0.0
    shown, volts, dt = [], [], EVERY / INNER
    for target in wanted:
        seen = STEP * round(place / STEP)
        error = target - seen
        total += 300.0 * error
        volt = float(np.clip(total + 2e4 * error + 250.0 * (error - before) / EVERY, -10.0, 10.0))
        before = error
        shown.append(seen)
        volts.append(volt)
        for _ in range(INNER):
            force += dt / LAG * (GAIN * waiting - force)
            screw = STIFF * (motor - place) + DAMPED * (turning - speed)
            drag = 60.0 * np.tanh(speed / 1e-4) + 500.0 * speed
            own = 150.0 * np.tanh(turning / 1e-4) + 2000.0 * turning
            turning += dt * (force - screw - own) / MOTOR
            speed += dt * (screw - drag - WEIGHT) / TABLE
            motor += dt * turning
            place += dt * speed
        waiting = volt
    return np.array(shown), np.array(volts)
