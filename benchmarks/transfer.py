"""Attitude transfers: ours beside CasADi with IPOPT, and the time over the number of steps.

python benchmarks/transfer.py [COUNT [FILE]]

COUNT (200) random transfers of the range of Phogat et al. (10-90 deg about any axis, 5-30 s, 190
steps, at rest at both ends) are solved by both from the same start, the one along the eigenaxis;
where IPOPT finds no plan, or a costlier one, it is given further starts, five random ones at least,
unless ours proves that there is none. Times are of one thread each, the best of three. Then the
transfer of figure 4 with 100 to 2,000 steps, from which an exponent is fitted.

Results are kept in FILE (runs/transfer.jsonl), one line each: a run that was ended goes on there.
"""

from __future__ import annotations

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # before NumPy and CasADi

import json
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from spacecraft_gnc.studies.phogat_compare import Comparison
from spacecraft_gnc.studies.phogat_speed import growth, time_lengths
from spacecraft_gnc.studies.phogat_transfers import random_transfer

STEPS = 190


def results(count, file):
    """Yield the result of each transfer, kept in the file."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    kept = {row["index"]: row for row in map(json.loads, lines)}
    comparison = Comparison()
    for index in range(count):
        if index not in kept:
            found = comparison.of(random_transfer(index, STEPS))
            row = {
                "index": index,
                "outcome": found.outcome,
                "difference": found.difference,
                "ours": found.ours,
                "ipopts": found.ipopts,
                "ipopt_starts": found.ipopt_starts,
            }
            file.parent.mkdir(parents=True, exist_ok=True)
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(row) + "\n")
            kept[index] = row
        yield kept[index]


def compare(count, file):
    """Print the comparison with IPOPT."""
    rows = list(results(count, file))
    for name, number in sorted(Counter(row["outcome"] for row in rows).items()):
        print(f"{name}: {number}")
    print(
        f"largest excess of the cost over IPOPT's: {np.nanmax([r['difference'] for r in rows]):.1e}"
    )
    times = np.array([(row["ours"], row["ipopts"]) for row in rows])
    times = times[np.isfinite(times).all(axis=1)]
    ours, ipopts = 1e3 * np.median(times, axis=0)
    ratio = times[:, 1] / times[:, 0]
    print(
        f"{len(times)} timed: median {ours:.2f} ms, IPOPT {ipopts:.1f} ms; ratio "
        f"{np.median(ratio):.1f} in the median, {ratio.min():.1f} at least"
    )


def lengths():
    """Print the time over the number of steps."""
    found = time_lengths()
    for one in found:
        print(f"N = {one.n_steps}: {1e3 * one.time:.1f} ms, {one.iterations} Newton steps")
    print(f"time of a Newton step grows with N to the power {growth(found):.2f}")


if __name__ == "__main__":
    compare(
        int(sys.argv[1]) if len(sys.argv) > 1 else 200,
        Path(sys.argv[2] if len(sys.argv) > 2 else "runs/transfer.jsonl"),
    )
    lengths()
