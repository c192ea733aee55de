"""Time integration methods for H' = F(T, t), each a list of implicit stages.

A stage i solves H(T_i) - d dt F(T_i) = H_n + dt sum_j a_ij F_j with the same d in every stage,
and the last stage is the new state, so what enters in a step is dt sum_j b_j F_j exactly:
the heat balance holds whatever the step.

tr_bdf2 : trapezium to gamma, then BDF2; second order, L-stable, third order error estimate.
    Bank et al. 1985; Hosea and Shampine 1996, Appl. Numer. Math. 20, 21-37.
sdirk2 : Alexander 1977, SIAM J. Numer. Anal. 14, 1006-1021; second order, L-stable in every
    stage, so it also starts from a state that does not fit its surroundings.
implicit_euler : first order; never overshoots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_D = 1.0 - 1.0 / np.sqrt(2.0)
_W = np.sqrt(2.0) / 4.0


@dataclass(frozen=True)
class Method:
    """A tableau.

    explicit : whether F at the step's start is the first of the F_j
    diagonal : d; time : of each implicit stage; couple : a_ij of each stage for the F_j before it
    weight : b_j; error : b_j less the embedded method's, or None
    """

    order: int
    explicit: bool
    diagonal: float
    time: tuple[float, ...]
    couple: tuple[tuple[float, ...], ...]
    weight: tuple[float, ...]
    error: tuple[float, ...] | None = None


TR_BDF2 = Method(
    order=2,
    explicit=True,
    diagonal=_D,
    time=(2.0 * _D, 1.0),
    couple=((_D,), (_W, _W)),
    weight=(_W, _W, _D),
    error=(_W - (1.0 - _W) / 3.0, _W - (3.0 * _W + 1.0) / 3.0, _D - _D / 3.0),
)
SDIRK2 = Method(
    order=2,
    explicit=False,
    diagonal=_D,
    time=(_D, 1.0),
    couple=((), (1.0 - _D,)),
    weight=(1.0 - _D, _D),
)
IMPLICIT_EULER = Method(order=1, explicit=False, diagonal=1.0, time=(1.0,), couple=((),), weight=(1.0,))
METHODS = {"tr_bdf2": TR_BDF2, "sdirk2": SDIRK2, "implicit_euler": IMPLICIT_EULER}
