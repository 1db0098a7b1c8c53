"""Where the numbers of a solved horizon stand in a flat ``plan``: a solve allocates one array.

In turn: attitudes (N+1, 3, 3), momenta (N+1, 3), torques (N, 3), multipliers (N+1, 6), zone
margins, `NUMBERS`, reference (3, 3). The numbers are status, steps, residual, cost, curvature,
largest |u|^2, the angle from the first attitude to the reference and the angle turned over the
horizon.
"""

from __future__ import annotations

from spacecraft_gnc._kernels import inlined_kernel

NUMBERS = 8


def offsets(n: int, n_zones: int) -> tuple[int, int, int, int, int, int, int, int]:
    """Return where each part begins, for n steps, and the length of all."""
    momenta = 9 * (n + 1)
    torques = momenta + 3 * (n + 1)
    multipliers = torques + 3 * n
    margins = multipliers + 6 * (n + 1)
    numbers = margins + n_zones
    reference = numbers + NUMBERS
    return 0, momenta, torques, multipliers, margins, numbers, reference, reference + 9


_offsets = inlined_kernel(offsets)


@inlined_kernel
def cut(plan, N, n_zones):
    """Cut a plan into R, Pi, u, lam, margins, numbers, R_ref."""
    _, a, b, c, d, e, f, end = _offsets(N, n_zones)
    return (
        plan[:a].reshape((N + 1, 3, 3)),
        plan[a:b].reshape((N + 1, 3)),
        plan[b:c].reshape((N, 3)),
        plan[c:d].reshape((N + 1, 6)),
        plan[d:e],
        plan[e:f],
        plan[f:end].reshape((3, 3)),
    )
