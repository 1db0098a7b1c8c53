"""Time CasADi with IPOPT."""

from __future__ import annotations

from common import Problem, main
from nlp import MultipleShooting

COST_SCALE = 1e2  # with 1e3 the line search is lost at N = 40
OPTIONS = {
    "ipopt.tol": 1e-10,
    "ipopt.max_iter": 500,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.nlp_scaling_method": "none",  # scaled by hand
}


class Ipopt(MultipleShooting):
    """The penalized problem has no inequality, so that no barrier slows the warm start."""

    formulation = (
        "penalized, multiple shooting in (quaternion, momentum), exact Hessian, mumps, functions "
        "compiled by gcc -O3"
    )
    tolerance = "tol 1e-10, cost scaled by 1e2"

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem, "ipopt", OPTIONS, hard=False, cost_scale=COST_SCALE)


if __name__ == "__main__":
    main(Ipopt)
