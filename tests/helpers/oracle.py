"""The closed loop of Lin & Lee 1999 once more, in plain Python and without the package.

Written from the paper's equations so that the tests compare two independent programs. Nothing
here may import ``plants`` or ``hfc_design``.
"""

from math import exp, sin

import numpy as np
from scipy.integrate import solve_ivp

# Section 4 of the paper; 2 poles.
MACHINE = {
    "poles": 2.0,
    "rotor_flux": 0.6,
    "stator_resistance": 1.12,
    "rotor_resistance": 1.05,
    "stator_inductance": 0.341,
    "rotor_inductance": 0.306,
    "mutual_inductance": 0.225,
    "rotor_inertia": 0.11,
    "rotor_damping": 2.05,
    "spindle_inertia": 5.102,
    "gear_ratio": 1.0,
    "stiffness": 200.0,
    "bristle_stiffness": 17000.0,
    "bristle_damping": 126.5,
    "viscous_friction": 0.4,
    "coulomb_torque": 0.7,
    "static_torque": 1.2,
    "stribeck_velocity": 0.003,
}
SCALES = (50.0, 80.0, 20.0, 20.0, 10.0)  # of e, delta, ddelta/dt, omega_c(t), omega_c(t-1)
TERMS = (  # centre, half width, rate (eq. 3)
    (-1.0, 0.1, 4.0),
    (-0.6, 0.05, 8.0),
    (-0.2, 0.0, 32.0),
    (0.0, 0.0, 32.0),
    (0.2, 0.0, 32.0),
    (0.6, 0.05, 8.0),
    (1.0, 0.1, 4.0),
)


def plant(machine=MACHINE):
    """The right-hand side of eq. 2 as ``rhs(x, voltage, load) -> list of six rates``."""
    m = machine
    l_s, l_r, l_m = m["stator_inductance"], m["rotor_inductance"], m["mutual_inductance"]
    l_sigma = l_s - l_m**2 / l_r
    r_sigma = m["stator_resistance"] + m["rotor_resistance"] * l_s / l_r
    k_t = m["poles"] / 2 * l_m * m["rotor_flux"] / l_r
    k_e = l_s * m["rotor_flux"] / l_m
    k, n, b_r = m["stiffness"], m["gear_ratio"], m["rotor_damping"]
    j_r, j_c = m["rotor_inertia"], m["spindle_inertia"]
    s_0, s_1, s_2 = m["bristle_stiffness"], m["bristle_damping"], m["viscous_friction"]
    t_c, t_s, omega_s = m["coulomb_torque"], m["static_torque"], m["stribeck_velocity"]

    def rhs(x, voltage, load):
        i, theta_r, omega_r, theta_c, omega_c, z = x
        g = (t_c + (t_s - t_c) * exp(-((omega_c / omega_s) ** 2))) / s_0
        dz = omega_c - abs(omega_c) * z / g
        tau_f = s_0 * z + s_1 * dz + s_2 * omega_c
        twist = k * (theta_r - n * theta_c)
        return [
            (voltage - r_sigma * i - k_e * omega_r) / l_sigma,
            omega_r,
            (k_t * i - b_r * omega_r - twist) / j_r,
            omega_c,
            (n * twist - tau_f - load) / j_c,
            dz,
        ]

    return rhs


def sliding_poles(rhs, kp, kd):
    """Eigenvalues of ``rhs`` under PD control around the spindle sliding at 0.02 rad/s."""
    steady = np.array([1.0, 0.0, 0.02, 0.0, 0.02, 0.7 / 17000])

    def rates(x):
        return np.array(rhs(x, -kp * x[3] - kd * x[4], 0.0))

    steps = 1e-6 * np.eye(6)
    columns = [(rates(steady + step) - rates(steady - step)) / 2e-6 for step in steps]
    return np.linalg.eigvals(np.array(columns).T)


def cutting_load(t):
    """Eq. 7 [N m]."""
    return 5 + 2 * sin(t) + sin(50 * t + np.pi / 4)


def memberships(u):
    """Degrees of ``u`` in the seven terms (eq. 3)."""
    return [exp(-rate * max(abs(u - c) - half, 0.0) ** 2) for c, half, rate in TERMS]


def infer(table, column, row):
    """Eq. 4 as a loop over its 49 rules; 0 where none fires."""
    in_column, in_row = memberships(column), memberships(row)
    above = below = 0.0
    for i in range(7):
        for j in range(7):
            firing = in_row[i] * in_column[j]
            above += firing * table[i][j]
            below += firing
    return above / below if below else 0.0


def nested(inputs, sources, tables):
    """A list of units in evaluation order as nested triples (column, row, table)."""
    nodes = list(range(inputs))
    for (column, row), table in zip(sources, tables, strict=True):
        nodes.append((nodes[column], nodes[row], table))
    return nodes[-1]


def output(node, values):
    """What a nested hierarchy makes of its external inputs, by recursion."""
    if isinstance(node, int):
        return values[node]
    column, row, table = node
    return infer(table, output(column, values), output(row, values))


def voltage(tree, kp, kd, x, earlier, error, error_rate):
    """The command of section 3; ``tree`` is None for PD alone, ``earlier`` is omega_c(t-1)."""
    command = kp * error + kd * error_rate
    if tree is None:
        return command
    _, theta_r, omega_r, theta_c, omega_c, _ = x
    raw = (error, theta_r - theta_c, omega_r - omega_c, omega_c, earlier)
    values = [min(max(s * u, -1.0), 1.0) for s, u in zip(SCALES, raw, strict=True)]
    return command + 10.0 * output(tree, values)


def rk4(rates, t, x, h):
    """One classical Runge-Kutta step."""
    k1 = np.array(rates(t, x))
    k2 = np.array(rates(t + h / 2, x + h / 2 * k1))
    k3 = np.array(rates(t + h / 2, x + h / 2 * k2))
    k4 = np.array(rates(t + h, x + h * k3))
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def ramp(t):
    """The paper's reference [rad] and its rate [rad/s]."""
    return 0.02 * t, 0.02


def closed_loop(
    tree, kp, kd, seconds, load=None, method="LSODA", sample=1e-3, rtol=1e-10, reference=ramp
):
    """States (steps + 1, 6) and commands (steps,) from rest.

    The integrator starts anew at every sample, where the held voltage jumps.
    """
    rhs = plant()
    load = load or (lambda t: 0.0)
    # What 1e-14 relative is to the size that each state takes on the ramp.
    atol = 1e-14 * np.array([10.0, 0.02, 0.1, 0.02, 0.02, 4e-5])
    x, earlier = np.zeros(6), 0.0
    states, commands = [x], []
    for n in range(round(seconds / sample)):
        t = n * sample
        wanted, rate = reference(t)
        u = voltage(tree, kp, kd, x, earlier, wanted - x[3], rate - x[4])
        earlier = x[4]

        def rates(t, x, u=u):
            return rhs(x.tolist(), u, load(t))

        if method == "RK4":
            x = rk4(rates, t, x, sample)
        else:
            x = solve_ivp(rates, (t, t + sample), x, method, rtol=rtol, atol=atol).y[:, -1]
        states.append(x)
        commands.append(u)
    return np.array(states), np.array(commands)
