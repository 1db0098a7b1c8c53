"""Time CasADi's own SQP."""

from __future__ import annotations

from common import Problem, main
from nlp import MultipleShooting

OPTIONS = {
    "qpsol": "qrqp",
    "qpsol_options": {"print_iter": False, "print_header": False, "error_on_fail": False},
    "print_header": False,
    "print_iteration": False,
    "print_status": False,
    "error_on_fail": False,
    "tol_pr": 1e-10,
    "tol_du": 1e-10,
    "min_step_size": 1e-16,
    "max_iter": 50,
}


class SqpMethod(MultipleShooting):
    """The limit is a constraint: with the penalty some states stay above the tolerance."""

    formulation = (
        "limit as a constraint, multiple shooting in (quaternion, momentum), exact Hessian, qrqp, "
        "functions compiled by gcc -O3"
    )
    tolerance = "1e-10 primal and dual, cost scaled by 1e3"

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem, "sqpmethod", OPTIONS, hard=True)


if __name__ == "__main__":
    main(SqpMethod)
