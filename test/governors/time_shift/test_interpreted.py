"""The kernels of the time shift governor give the same numbers compiled and interpreted."""

from __future__ import annotations

import numpy as np
from both_ways import compiled_and_interpreted

PROGRAM = """
import math, sys
import numpy as np
import formations
from spacecraft_gnc.governors.time_shift import NEVER, TimeShiftGovernor, fly, start_violation
from spacecraft_gnc.governors.time_shift.passages import Passages
from spacecraft_gnc.governors.time_shift.prediction import Predictor

p = formations.problem(
    p=8, phases=(0, 3, 5), horizon=16, min_separation=700.0, max_angle=math.radians(70.0)
)
found = {}
near = formations.start(p.natural, (0, 4, 6), (900.0, 1200.0, 1000.0), (1.1, 1.0, 0.9))
far = formations.start(p.natural, (0, 4, 6), (900.0, 9e4, 1000.0), (1.1, 1.0, 0.9))
governor = TimeShiftGovernor(p)
governor.warm_up()
parked = p.commanded(0, np.array([0, 4, 4]))
for name, start, failures in (
    ("near", near, [NEVER] * 3), ("lost", near, [NEVER, 2, NEVER]), ("parked", parked, [NEVER] * 3)
):
    flight = fly(governor, start, 14, failures=np.array(failures))
    found[name] = flight.states
    found[f"{name}_shifts"] = flight.shifts
    found[f"{name}_numbers"] = [
        (d.cost, d.shift_cost, d.margin.share, d.n_admissible, d.answer, d.deadlocked,
         d.waypoints_left, -1.0 if d.refused is None else d.refused.share)
        for d in flight.decisions
    ]
missed = start_violation(p, far)
found["missed"] = [missed.constraint, *missed.craft, missed.ahead, missed.share]
lost = np.array([True, False, False])
predictor = Predictor(p)
predicted = predictor.predict(3, near, np.array([1, 2, 3]), lost)
found["until"] = predictor.kept_until(predicted)
found["distances"] = Passages(predictor, np.zeros(3, dtype=bool)).distances
alone = np.array([False, True, False])
drifting = predictor.predict(3, parked, np.array([0, 4, 4]), alone)
found["around"] = Passages(predictor, alone, drifting).distances
np.savez(sys.argv[1], **found)
"""


def test_compiled_and_interpreted_governors_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    assert compiled.keys() == interpreted.keys()
    for name, value in compiled.items():
        np.testing.assert_allclose(value, interpreted[name], rtol=1e-12, atol=1e-9, err_msg=name)
    assert compiled["parked_numbers"][:, 5].any()
    assert compiled["parked_numbers"][:, 4].max() == 4  # a passage was flown
