"""The work that every contender is given: plain arrays in a file, the same bytes for all."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

INPUTS, UNITS, TERMS = 5, 4, 7


class Machine(NamedTuple):
    """Coefficients of the C-axis (Lin & Lee 1999, eq. 1-2)."""

    current_decay: float  # R_sigma / L_sigma [1/s]
    back_emf: float  # L_s lambda_r / (L_sigma L_m) [A/rad]
    inverse_inductance: float  # 1 / L_sigma [1/H]
    torque_constant: float  # K_t [N m/A]
    inverse_rotor_inertia: float  # 1 / J_r [1/(kg m2)]
    inverse_spindle_inertia: float  # 1 / J_c [1/(kg m2)]
    rotor_damping: float  # b_r [N m s/rad]
    stiffness: float  # k [N m/rad]
    gear_ratio: float  # N [1]
    bristle_stiffness: float  # sigma_0 [N m/rad]
    bristle_damping: float  # sigma_1 [N m s/rad]
    viscous_friction: float  # sigma_2 [N m s/rad]
    coulomb_torque: float  # T_c [N m]
    stribeck_rise: float  # T_s - T_c [N m]
    inverse_stribeck_velocity: float  # 1 / omega_s [s/rad]


class Constants(NamedTuple):
    """What is left of the scenario."""

    sample_time: float  # [s]
    output_scale: float  # k_6 [V]
    error_weight: float  # a of eq. 5
    error_rate_weight: float  # b of eq. 5


class Work(NamedTuple):
    """Closed loops to be scored; float32 but for ``sources``, individuals in the last axis."""

    kp: np.ndarray  # (individuals,) [V/rad]
    kd: np.ndarray  # (individuals,) [V s/rad]
    scales: np.ndarray  # (5, individuals) k_1 .. k_5
    sources: np.ndarray  # (4, 2, individuals) int32, column and row source of each unit
    consequents: np.ndarray  # (4, 7, 7, individuals) [unit][row term][column term]
    reference: np.ndarray  # (samples,) [rad]
    reference_rate: np.ndarray  # (samples,) [rad/s]
    loads: np.ndarray  # (3, samples) at the start, middle and end of a sample [N m]
    terms: np.ndarray  # (3, 7) centre, half width and rate of the linguistic terms
    machine: np.ndarray  # (15,) the fields of Machine
    constants: np.ndarray  # (4,) the fields of Constants

    @property
    def steps(self) -> int:
        """Individual-steps: individuals times samples."""
        return self.kp.size * self.reference.size


def save(work: Work, path: Path) -> None:
    """Write ``work``; ``load`` reads it back."""
    with path.open("wb") as file:
        np.savez(file, **work._asdict())


def load(path: Path) -> Work:
    """Read what ``save`` wrote."""
    with np.load(path) as arrays:
        return Work(**arrays)
