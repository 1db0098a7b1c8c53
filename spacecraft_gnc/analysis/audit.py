"""Audit of a bag, from the file to the table of checks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spacecraft_gnc.analysis.vehicle import part, require_vehicle
from spacecraft_gnc.audit.channels import audit_channels
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import read_evidence
from spacecraft_gnc.audit.ledger import Check, Difference, Ledger
from spacecraft_gnc.audit.limits import Exceedance, as_dicts
from spacecraft_gnc.audit.order import audit_order
from spacecraft_gnc.audit.telemetry import audit_telemetry
from spacecraft_gnc.audit.vehicle import VehicleAudit, Watch
from spacecraft_gnc.audit.wire import audit_wire
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.steps import flight_namespace
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.craft import craft_of
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.scenario.recorded import SCENARIO_ATTACHMENT, parse_scenario, scenario_texts
from spacecraft_gnc.vehicles.known_signals import state_signals


@dataclass(frozen=True, slots=True)
class Audit:
    """What an audit found, and what it rests on.

    Attributes
    ----------
    path
        The bag.
    steps
        Control steps flown.
    checks
        The lines of the table.
    first
        The check, step and field that differ first; None where the bag holds what it says.
    counts
        Failures solved again, fallbacks justified, standstills looked for.
    scenario
        What flew, as the bag says: everything else rests on it.
    exceeded
        Limits that the flight exceeded by more than 0.1 %; no fault of the recording.
    remarks
        What of the bag is not read, one line each.
    """

    path: Path
    steps: int
    checks: tuple[Check, ...]
    first: tuple[Check, Difference] | None
    counts: Counts
    scenario: Scenario
    exceeded: tuple[Exceedance, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return self.first is None

    def as_dict(self) -> dict[str, Any]:
        """Return the audit as a JSON-able mapping."""
        found: dict[str, Any] | None = None
        if self.first is not None:
            check, difference = self.first
            found = {"check": check.name, **difference._asdict()}
        return {
            "bag": str(self.path),
            "steps": self.steps,
            "passed": self.passed,
            "first": found,
            "scenario_hash": fingerprint(self.scenario),
            "counts": self.counts.as_dict(),
            "limits_exceeded": as_dicts(self.exceeded),
            "remarks": list(self.remarks),
            "checks": [check.as_dict() for check in self.checks],
        }


def audit_bag(
    path: Path | str,
    *,
    tolerance: float | None = None,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Watch | None = None,
) -> Audit:
    """Audit the flight in a bag.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    tolerance
        What motion and decisions may differ from those made again, as a share of each field's
        largest magnitude; None: not in a bit.
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Audit what is whole of a bag that was cut off, or of a flight that was stopped.
    progress
        Returns, for the name of a part of the work, what is called with its progress.

    Raises
    ------
    RecordingError
        If there is no readable bag, no flight of one spacecraft in it, or no scenario.
    """
    watch = progress or (lambda _: None)
    ledger, counts = Ledger(), Counts()
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        bag.verify(watch("checksums"))
        require_vehicle(bag)
        text, defaults = scenario_texts(bag.attachments())
        name = flight_namespace(bag, namespace, state_signals())
        scenario, problem = parse_scenario(text, bag.path, name, defaults)
        vehicle: VehicleAudit = part("audit", scenario)
        topics = vehicle.topics.of_craft(() if scenario is None else craft_of(scenario))
        evidence = read_evidence(
            bag, topics, scenario, namespace, watch("reading"), stopped=allow_unfinished
        )
        vehicle.require_flight(evidence)
        if scenario is None:
            reason = problem or "none is attached"
            raise RecordingError(
                f"{bag.path}: received no scenario to audit by ({reason}); required the attachment "
                f"{SCENARIO_ATTACHMENT} of `gnc launch`, in this version's form; read it with the "
                "version that flew"
            )
        held = vehicle.held_steps(evidence)
        audit_channels(evidence, ledger, part("signals", scenario))
        audit_order(evidence, ledger, held, allow_unfinished)
        audit_wire(evidence, ledger)
        exceeded = vehicle.audit(evidence, ledger, counts, held, tolerance, watch)
        audit_telemetry(evidence, ledger, tolerance)
        remarks = tuple(bag.remarks())
    return Audit(
        path=Path(path),
        steps=evidence.n,
        checks=tuple(ledger.checks.values()),
        first=ledger.first,
        counts=counts,
        scenario=scenario,
        exceeded=exceeded,
        remarks=remarks,
    )
