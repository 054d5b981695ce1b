"""Two-input fuzzy controller of a feed drive (Jee & Koren 2004, sections 2 and 4.3).

The functions compute with scalars of one axis, without branches on values; ``xp`` is explained
in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals, held, limited, outside
from hfc_design.controllers.neighbours import Degrees, Partition, firing_of, memberships, weighted
from hfc_design.core.numbers import RuleTable, Scalar, Triangles, Xp

#: Speed below which the axis counts as at rest [mm/s]: an encoder that moves less than half a BLU
#: in 10 ms reads V = 0.
STANDSTILL = 0.5


class Compensation(NamedTuple):
    """Low-velocity friction in units of the command, without its Coulomb part (JK04 eq. 28-30)."""

    forward: Sequence[Scalar]  # (3,) coefficients of V^2, V, 1 for V >= 0 in mm/s
    backward: Sequence[Scalar]  # (3,) the same for V < 0
    highest_velocity_mm_s: Scalar  # speed from which there is no compensation
    breakaway: Sequence[Scalar]  # (2,) command at rest towards + and towards -
    smallest_error: Scalar  # [BLU] below it, nothing is added at rest
    blu_mm: Scalar  # length of a BLU


class FlcGains(NamedTuple):
    """Numbers of the controller: of one individual, or of a population along the last axis."""

    error_terms: Triangles  # (7, 3) left, centre, right [BLU]; the outermost edges are not read
    change_terms: Triangles  # (7, 3) the same for e(k) - e(k-1) [BLU]
    singletons: RuleTable  # (7, 7) [term of e][term of its change], units of the command
    k_i: Scalar  # integral gain [units/(BLU s)]; k_i x sample time is K_I of JK95 eq. 3
    compensation: Compensation | None = None
    dead_zone: Scalar | None = None  # [BLU] errors up to it count as 0; None: all count


class FlcMemory(NamedTuple):
    """Memory of the controller; all zero before the first sample."""

    error: Scalar  # e(k-1) [BLU]
    fuzzy: Scalar  # u_F(k-1), for the form PI
    integral: Scalar  # u_I(k-1)


def flc(form: str, sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law of kind ``flc`` in a ``form`` of JK95 eq. 1.

    ``P``: u = F(e); ``PI``: du = F(e, de); ``PD``: u = F(e, de), d the change in a sample.
    """
    return AxisLaw(sample, initial_memory, sample_time, limit, form, tells=True, prime=primed)


def initial_memory(law: AxisLaw, zero: Scalar) -> FlcMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    return FlcMemory(zero, zero, zero)


def primed(xp: Xp, law: AxisLaw, gains: FlcGains, memory: FlcMemory, signals: Signals) -> FlcMemory:
    """Return the memory with this sample's error as the previous one, so that its change is 0."""
    return memory._replace(error=outside(xp, gains.dead_zone, signals["error"]))


class RuleBase(NamedTuple):
    """Terms of both inputs, and singletons, as they are at a sample."""

    error: Partition  # [BLU]
    change: Partition  # [BLU]
    singletons: RuleTable  # (7, 7)

    @classmethod
    def of(cls, gains: FlcGains) -> "RuleBase":
        """Return the rule base of a design."""
        return cls(
            Partition.of(gains.error_terms), Partition.of(gains.change_terms), gains.singletons
        )


class Parts(NamedTuple):
    """Parts of a command."""

    singletons: RuleTable  # (7, 7) as they are at this sample
    error: Scalar  # [BLU]
    change: Scalar  # [BLU]
    in_error: Degrees  # (7,) degrees
    in_change: Degrees  # (7,)
    inferred: Scalar  # F(e, de)
    fuzzy: Scalar  # u_F, in the form PI the sum of all F so far
    integral: Scalar  # u_I
    compensation: Scalar | None  # u_d; None without low-velocity compensation


def sample(
    xp: Xp, law: AxisLaw, gains: FlcGains, memory: FlcMemory, signals: Signals
) -> tuple[Scalar, FlcMemory, Parts]:
    """Return the command of one sample, the memory after it, and the command's parts.

    In every form the integral term of JK95 eq. 3 is added. ``signals``: error [BLU], and, with
    compensation, velocity [BLU/s].
    """
    base, error = RuleBase.of(gains), outside(xp, gains.dead_zone, signals["error"])
    in_error = memberships(xp, base.error, error)
    return commanded(xp, law, gains, base, in_error, memory, signals)


def commanded(
    xp: Xp,
    law: AxisLaw,
    gains: FlcGains,
    base: RuleBase,
    in_error: Degrees,
    memory: FlcMemory,
    signals: Signals,
) -> tuple[Scalar, FlcMemory, Parts]:
    """Return the same as ``sample``, from a rule ``base`` and the degrees of the error in it."""
    error = outside(xp, gains.dead_zone, signals["error"])
    change = 0.0 * error if law.structure == "P" else error - memory.error
    in_change = memberships(xp, base.change, change)
    inferred = fuzzy = infer(xp, in_error, in_change, base.singletons)
    if law.structure == "PI":
        fuzzy = limited(xp, law.limit, memory.fuzzy + inferred)
    integral = memory.integral + gains.k_i * law.sample_time * error
    pushed = None
    if gains.compensation is not None:
        pushed = compensate(xp, gains.compensation, signals["velocity"], error)
    command = _sum(fuzzy, integral, pushed)
    if law.limit is not None:
        integral = held(xp, law.limit, command, memory.integral, integral)
        command = _sum(fuzzy, integral, pushed)
    shares = inferred, fuzzy, integral, pushed
    parts = Parts(base.singletons, error, change, in_error, in_change, *shares)
    return command, FlcMemory(error, fuzzy, integral), parts


def _sum(fuzzy: Scalar, integral: Scalar, compensation: Scalar | None) -> Scalar:
    return fuzzy + integral if compensation is None else fuzzy + integral + compensation


def infer(xp: Xp, in_error: Degrees, in_change: Degrees, singletons: RuleTable) -> Scalar:
    """Return the overall action u_0: the average of singletons, weighted by products of degrees.

    Where no rule fires the action is 0; with terms that overlap everywhere some rule always fires.
    Between evenly spaced centres E_i, E_i + alpha and D_j, D_j + beta, with edges on the
    neighbours' centres, this is the bilinear form that JK04 eq. 7 prints without its last term::

        u = U_ij + (U_i+1,j - U_ij) x + (U_i,j+1 - U_ij) y
            + (U_i+1,j+1 - U_i+1,j - U_i,j+1 + U_ij) x y,    x = (e - E_i) / alpha, y likewise
    """
    action = weighted(xp, in_error, in_change, singletons)
    firing = firing_of(in_error) * firing_of(in_change)
    return xp.sure(action / xp.where(firing > 0.0, firing, 1.0))


def compensate(xp: Xp, law: Compensation, velocity: Scalar, error: Scalar) -> Scalar:
    """Return u_d for an axis at ``velocity`` [BLU/s] with ``error`` [BLU] (JK04 eq. 28-30).

    The paper adds u_d to every singleton (eq. 29), which adds it to the overall action. An axis at
    rest is pushed towards its reference, but not by an error as small as the encoder's noise.
    """
    v = law.blu_mm * velocity
    (a, b, c), (d, e, f) = law.forward, law.backward
    sliding = xp.where(v >= 0.0, (a * v + b) * v + c, (d * v + e) * v + f)
    sliding = xp.where(abs(v) < law.highest_velocity_mm_s, sliding, 0.0)
    ahead, back = law.breakaway
    resting = xp.where(error >= law.smallest_error, ahead, 0.0)
    resting = xp.where(error <= -law.smallest_error, back, resting)
    return xp.sure(xp.where(abs(v) < STANDSTILL, resting, sliding))
