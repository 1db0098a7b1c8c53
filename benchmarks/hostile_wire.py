"""Attacks on the topics of a flight: 50,000 hostile messages, and thousands that steer."""

from __future__ import annotations

from argparse import Namespace
from typing import Any, Final, NamedTuple

from hostile_checks import audit_failures, differing, refusals_due, refused, traces
from hostile_flight import NODES, SCENARIO, Flight, Late, Row

FREE_RUN: Final = ("plant.mode=free_run", "plant.real_time_factor={:g}")
_SURE: Final = 0.99  # of the refusals due: a tick of /clock that equals the one before is none
_NOISE: Final = 0.01  # of all deadlines: two free runs on one machine differ by as much
_ENDED: Final = (130, 1)  # ended by Ctrl-C; 1: and because of the stranger


class Attacked(NamedTuple):
    """A flight after hostile messages."""

    sent: dict[str, Any]
    ended: list[str]
    """What ended that should not have, or told of a defect."""
    refused: int
    due: int
    """Refusals that the nodes owe (`hostile_checks.refusals_due`)."""
    missed: int
    steps: int
    code: int
    told: str
    """Why something went wrong."""

    @property
    def share(self) -> float:
        """Deadlines missed, of all."""
        return self.missed / max(self.steps, 1)


def messages(options: Namespace) -> list[Row]:
    """Send hostile messages on all topics while a scenario is flown, in lockstep and free run."""
    rows = [_lockstep(options)]
    if not options.short:
        rows.append(_free_run(options))
    return rows


def _lockstep(options: Namespace) -> Row:
    flight = Flight(options.folder / "lockstep")
    hit = _attacked(flight, options, echo=False)
    steps, wrong = differing(flight.bag, flight.changes) if not hit.told else (0, [])
    wrong += [f"ended: {name}" for name in hit.ended]
    audit = "" if hit.told else audit_failures(flight.bag, unfinished=True)
    wrong += [f"audit: {audit}"] if audit else []
    told = hit.told or ", ".join(wrong) or f"{steps} steps equal, audit passes"
    passed = not hit.told and not wrong and hit.sent.get("total") == options.messages
    return Row(
        "messages, lockstep",
        "hostile messages of ten kinds on every topic, by a stranger",
        hit.sent.get("total", 0),
        "nothing ends; bag equals `gnc simulate` bit for bit, audit passes; refusals counted",
        f"{told}; {hit.refused} of {hit.due} refusals due counted; exit code {hit.code}",
        passed and hit.refused >= _SURE * hit.due,
    )


def _free_run(options: Namespace) -> Row:
    changes = [change.format(options.factor) for change in FREE_RUN]
    hits = {}
    for echo in (True, False):
        flight = Flight(options.folder / f"free_run_{'echo' if echo else 'hostile'}", *changes)
        hits[echo] = _attacked(flight, options, echo=echo)
    harmless, hostile = hits[True], hits[False]
    problems = [hit.told or ", ".join(hit.ended) for hit in hits.values()]
    is_fine = not any(problems) and hostile.share <= harmless.share + _NOISE
    return Row(
        "messages, free run",
        f"the same at {options.factor:g} times real time; before it as many repeated genuine ones",
        hostile.sent.get("total", 0),
        "nothing ends; no more deadlines missed than with the genuine ones; refusals counted",
        f"{hostile.missed} of {hostile.steps} deadlines missed, {harmless.missed} of "
        f"{harmless.steps} with genuine ones; {hostile.refused} of {hostile.due} refusals due "
        f"counted; exit code {hostile.code}" + "".join(f"; {text}" for text in problems if text),
        is_fine and hostile.refused >= _SURE * hostile.due,
    )


def _attacked(flight: Flight, options: Namespace, *, echo: bool) -> Attacked:
    """Fly, send, end the flight, and say what came of it."""
    with flight:
        try:
            # one that listens and one that sends: who sends 2,000 a second hears nothing else
            watch = flight.observe()
            side = flight.beside(
                act="send",
                scenario=str(SCENARIO),
                seed=options.seed,
                count=options.messages,
                rate=options.rate,
                echo=echo,
                listen=len(flight.changes) > 1,
            )
            wall = options.messages / options.rate
            flight.until(lambda: side.said("sent") or side.ended, "all sent", 120.0 + 3.0 * wall)
            sent = side.said("sent")[0] if side.said("sent") else {}
            gone = {*NODES, "launcher"} - set(flight.running())
            seen = flight.progress()
            flight.interrupt()
            code = flight.wait_end()
        except Late as error:
            return Attacked({}, traces(flight), 0, 0, 0, 0, -1, str(error))
        ended = sorted(gone) + [f"{name} (defect)" for name in traces(flight)]
        told = "" if code in _ENDED else f"exit code {code}"
        topics = {name.strip("/"): count for name, count in sent.get("topics", {}).items()}
        counted, due = refused(watch), refusals_due(topics)
        ended += [
            f"{n}: {t} refused {counted[n, t]} of {c}"
            for (n, t), c in due.items()
            if counted[n, t] > c
        ]
        count = sum(counted[end] for end in due)
        seen_last = seen["missed"], seen["step"]
        return Attacked(sent, ended, count, sum(due.values()), *seen_last, code, told)


def steering(options: Namespace) -> list[Row]:
    """Have a stranger command the vehicle, in lockstep and in free run."""
    modes = {"lockstep": (), "free run": tuple(c.format(options.factor) for c in FREE_RUN)}
    return [
        _steered(options, mode, *changes)
        for mode, changes in modes.items()
        if not options.short or not changes
    ]


def _steered(options: Namespace, mode: str, *changes: str) -> Row:
    steps = max(int(options.steering), 400)
    flight = Flight(options.folder / mode.replace(" ", "_"), *changes, steps=steps)
    with flight:
        try:
            watch = flight.observe()
            side = flight.beside(act="steer", scenario=str(SCENARIO), count=options.steering)
            code = flight.wait_end(600.0)
            sent = side.said("sent")
        except Late as error:
            return Row(f"steering, {mode}", "", 0, "", str(error), False)
        total = sent[0]["total"] if sent else 0
        named = flight.errors.first("^error: .*stranger: received what comes from none") is not None
        told = flight.errors.text
        counted = sum(refused(watch).values())
    problems = [] if code == 1 and named else [f"exit code {code}", told.splitlines()[-1:]]
    if not changes:
        count, wrong = differing(flight.bag, flight.changes)
        problems += [f"{wrong} differ"] if wrong or count != steps else []
    audit = audit_failures(flight.bag)
    problems += [f"audit: {audit}"] if audit else []
    named_text = "the launch names the stranger" if named else "the stranger is not named"
    return Row(
        f"steering, {mode}",
        "well-formed torques, references, states and clocks, of the step due and of four to come",
        total,
        "none acted upon; exit code 1; the stranger named",
        f"{'; '.join(map(str, problems)) or 'none acted upon'}; {named_text}; "
        f"{counted} refusals counted; exit code {code}",
        not problems and total == 4 * options.steering,
    )
