"""Faults of our solutions of the random problems, by what the model and IPOPT say of them."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

CORRECTION = 1e-8  # Newton step, relative to the largest control, from which CONVERGED is false
WORSE = 1e-6  # of the part of the cost that the controls move
ROUNDING = 1e-13  # of the whole cost
COST = 1e-9  # by which the cost we state may differ from the model's
UNLIKE = 1e-8  # of the controls of one problem in two sets of units
MOST_LINES = 40  # of each kind of fault
SHARE = 0.95  # of the problems that IPOPT solves

Row = dict[str, Any]


@dataclass
class Verdict:
    """Accounts of all problems by seed, and the faults: seeds and reasons, by kind."""

    accounts: dict[int, Row]
    false: list[Row] = field(default_factory=list)
    exceptions: list[Row] = field(default_factory=list)
    worse: list[Row] = field(default_factory=list)
    better: list[Row] = field(default_factory=list)
    cost: list[Row] = field(default_factory=list)
    missed: list[Row] = field(default_factory=list)
    unlike: list[Row] = field(default_factory=list)

    @property
    def judged(self) -> int:
        """Problems that IPOPT was given."""
        return sum("ipopt" in account for account in self.accounts.values())

    @property
    def by_ipopt(self) -> int:
        """Problems that IPOPT solves."""
        return sum(
            account.get("ipopt", {}).get("solved", False) for account in self.accounts.values()
        )

    @property
    def beyond(self) -> int:
        """Problems for which IPOPT's motion has a step that the integrator does not have."""
        return sum("controls" in a.get("ipopt", {}) for a in self.accounts.values()) - self.by_ipopt

    @property
    def share(self) -> float:
        """Share of the problems that IPOPT solves that we solve, too."""
        return 1.0 - len(self.missed) / self.by_ipopt if self.by_ipopt else 1.0

    @property
    def faults(self) -> bool:
        """Whether a figure is not reached."""
        wrong = self.false or self.exceptions or self.cost or self.worse or self.unlike
        return bool(wrong) or self.share < SHARE

    def plain(self) -> dict[str, Any]:
        """Return figures and faults as what JSON holds."""
        kinds = ("false", "exceptions", "cost", "worse", "better", "missed", "unlike")
        return {
            "problems": len(self.accounts),
            "judged": self.judged,
            "solved by IPOPT": self.by_ipopt,
            "found by IPOPT beyond (3)": self.beyond,
            "share": self.share,
            "statuses": dict(Counter(a.get("status", "") for a in self.accounts.values())),
            **{kind: getattr(self, kind) for kind in kinds},
        }


def lines(path: Path) -> list[Row]:
    """Return the objects of a file of JSON lines; a line may be cut off."""
    found = []
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                found.append(json.loads(line))
            except json.JSONDecodeError:
                continue
    return found


def judge(accounts: dict[int, Row], checks: list[Row], ipopt: list[Row]) -> Verdict:
    """Put what is known of each problem together, and find the faults."""
    for row in checks:
        accounts[row["seed"]]["check"] = row
    for row in ipopt:
        accounts[row["seed"]]["ipopt"] = row
    verdict = Verdict(accounts)
    for seed, account in sorted(accounts.items()):
        what = {"seed": seed, "horizon": account["horizon"], "status": account.get("status")}
        if "exception" in account:
            verdict.exceptions.append(what | {"reason": account["exception"].splitlines()[-1]})
            continue
        _judge_units(verdict, what, account)
        if account["status"] == "CONVERGED":
            _judge_solution(verdict, what | {"way": account["way"]}, account)
        elif account.get("ipopt", {}).get("solved"):
            cost = account["ipopt"]["cost"]
            verdict.missed.append(what | {"cold": account["cold"], "cost of IPOPT": cost})
    return verdict


def _judge_units(verdict: Verdict, what: Row, account: Row) -> None:
    other = account.get("other")
    if other is None:
        return
    unlike = account["unlike"]
    same = account["cold"] == other["cold"]
    if other["exact"]:  # no rounding differs, so that nothing else may
        same = same and account["iterations"] == other["iterations"]
    if not same or (unlike is not None and unlike > UNLIKE):
        ways = [f"{a['cold']} after {a['iterations']}" for a in (account, other)]
        verdict.unlike.append(what | {"ways": ways, "difference": unlike})


def _judge_solution(verdict: Verdict, what: Row, account: Row) -> None:
    check, ipopt = account.get("check"), account.get("ipopt", {})
    if check is None:
        return
    if "fault" in check:
        verdict.false.append(what | {"reason": check["fault"]})
        return
    if not check["positive"] or not check["correction"] <= CORRECTION:
        reason = {key: check[key] for key in ("positive", "correction")}
        verdict.false.append(what | reason)
    error = account["cost"] / check["cost"] - 1.0 if check["cost"] > 0.0 else 0.0
    if not abs(error) <= COST:
        verdict.cost.append(what | {"error": error})
    if ipopt.get("solved"):
        excess = check["cost"] - ipopt["cost"]
        moved = max(check["moved"], ipopt["moved"])
        bound = WORSE * moved + ROUNDING * check["cost"]
        row = what | {"excess": excess / moved if moved > 0.0 else 0.0, "cost": check["cost"]}
        if excess > bound:
            verdict.worse.append(row)
        elif -excess > bound:
            verdict.better.append(row)


def report(verdict: Verdict, seconds: float) -> str:
    """Return the table."""
    accounts = verdict.accounts.values()
    both = [a for a in accounts if a.get("status") == "CONVERGED" and "ipopt" in a]
    compared = sum(a["ipopt"]["solved"] for a in both)
    pairs = [a for a in accounts if a.get("other") is not None]
    differences = np.array([a["unlike"] for a in pairs if a["unlike"] is not None])
    alike = [
        float((differences <= bound).mean()) if len(differences) else 1.0 for bound in (0.0, 1e-12)
    ]
    solved = sum(a.get("status") == "CONVERGED" for a in accounts)
    ways = Counter(a["way"] for a in accounts if a.get("status") == "CONVERGED")
    units = f"{len(pairs)}: {100 * alike[0]:.1f} % equal, {100 * alike[1]:.1f} % to 1e-12"
    rows = [
        ("problems", f"{len(verdict.accounts)}, ours in {seconds:.1f} s"),
        ("CONVERGED", f"{solved}: {dict(ways)}"),
        ("false CONVERGED", str(len(verdict.false))),
        ("cost not that of the torques", str(len(verdict.cost))),
        ("exceptions", str(len(verdict.exceptions))),
        ("solved by IPOPT", f"{verdict.by_ipopt} of {verdict.judged}"),
        ("found by IPOPT beyond (3)", str(verdict.beyond)),
        ("of these not by us", f"{len(verdict.missed)}: {100 * verdict.share:.2f} % solved"),
        ("compared", str(compared)),
        ("worse than IPOPT", str(len(verdict.worse))),
        ("better than IPOPT", str(len(verdict.better))),
        ("solved in two sets of units", units),
        ("of these unlike", str(len(verdict.unlike))),
    ]
    table = [f"| {name} | {value} |" for name, value in rows]
    table.insert(0, "| | |\n|---|---|")
    for kind in ("false", "exceptions", "cost", "worse", "missed", "unlike"):
        rows = getattr(verdict, kind)
        table += [f"{kind}: {row}" for row in rows[:MOST_LINES]]
        if len(rows) > MOST_LINES:
            table.append(f"{kind}: {len(rows) - MOST_LINES} more; --json has them all")
    return "\n".join(table)
