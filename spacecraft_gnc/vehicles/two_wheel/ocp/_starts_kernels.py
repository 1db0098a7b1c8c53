"""Kernel of the plans that a solve starts from: speeds within the limits; `starts` documents it."""

from __future__ import annotations

from spacecraft_gnc._kernels import kernel


@kernel
def keep_limits(wanted, top, change, speeds):
    """Fill rows 1 on of ``speeds`` (N+1, 2) near ``wanted`` (N+1, 2), at rest at the end."""
    N = speeds.shape[0] - 1
    for k in range(N):
        most = min(top, (N - k - 1) * change) if k < N - 1 else 0.0
        for i in range(2):
            low, high = speeds[k, i] - change, speeds[k, i] + change
            near = min(max(wanted[k + 1, i], low), high)
            stop = min(max(near, -most), most)
            speeds[k + 1, i] = min(max(stop, low), high)
