"""Bags of flights of a spacecraft with wheels without ROS: cores fly, the signals' codec writes."""

from __future__ import annotations

import math

import numpy as np
from mcap.reader import make_reader
from recording.bags import CODEC

from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.graph import CLOCK, WALL_TIMING
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback.law import WheelFeedback
from spacecraft_gnc.vehicles.two_wheel.controllers.report import (
    Diagnosis,
    Mode,
    Rest,
    WheelReport,
)
from spacecraft_gnc.vehicles.two_wheel.monitor import ResidualTest, WheelMonitor
from spacecraft_gnc.vehicles.two_wheel.outputs import Outputs
from spacecraft_gnc.vehicles.two_wheel.signals import SIGNALS

SECTIONS = {
    "plant": {
        "vehicle": "two_wheel",
        "inertia": [1.0, 0.05, -0.1, 0.05, 0.8, 0.02, -0.1, 0.02, 0.9],
        "wheel_axes": [1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, -1.0, 1.0, 1.0, 1.0, 1.0],
        "wheel_inertias": [0.01, 0.011, 0.012, 0.013],
        "max_wheel_speed": 40.0,
        "max_wheel_acceleration": 3.0,
        "wheel_lost_at": [-1.0, 1.0, -1.0, -1.0],
        "time_step": 0.1,
        "duration": 4.0,
        "initial_euler_321": [0.5, 0.3, -0.4],
        "initial_angular_velocity": [0.05, -0.1, 0.02],
        "initial_wheel_speed": [10.0, -39.5, 30.0, 20.0],
        "pose_every": 3,
    },
    "nmpc_controller": {"time_step": 0.2, "feedback_bandwidth": 0.4},
    "reference_governor": {"target_rotation_vector": [0.1, 0.0, 0.2]},
}
"""Twenty steps of a pyramid of wheels that saturate, one of which is lost."""


RECORDED = [signal for signal in (*SIGNALS, *graph.SIGNALS) if signal.recorded]


def announce(writer, without=()):
    """Announce the topics of a flight to a writer, but for some."""
    for signal in RECORDED:
        if f"/{signal.name.strip('/')}" in without:
            continue
        text, hashed = CODEC.text(signal.type), signal.type_hash
        writer.add_topic(
            f"/{signal.name.strip('/')}",
            signal.type,
            text,
            type_hash=hashed,
            gapless=signal.every_step and signal.is_stepped,
        )


def sections(**changes):
    """Return these sections with some values changed, by section name."""
    names = {**SECTIONS, **changes}
    return {name: {**SECTIONS.get(name, {}), **changes.get(name, {})} for name in names}


class Watching:
    """A feedback law that excludes the wheels which a residual test finds."""

    def __init__(self, scenario):
        p = scenario.plant
        none = np.zeros(p.wheel_inertias.size)
        viscous, coulomb = p.wheel_viscous_friction, p.wheel_coulomb_friction
        self.monitor = WheelMonitor(
            ResidualTest(
                scenario.period,
                p.wheel_inertias,
                viscous if viscous.size else none,
                coulomb if coulomb.size else none,
                p.max_wheel_speed,
                p.max_wheel_acceleration,
                scenario.substeps,
            )
        )
        self.scenario = scenario

    def command(self, state, reference):
        """Return the command of the law with the wheels that are left."""
        seen = self.monitor.observe(state)
        law = WheelFeedback(
            believed_gyrostat(self.scenario),
            self.scenario.controller.feedback_bandwidth,
            healthy=seen.healthy,
        )
        mode = Mode.NOMINAL if seen.healthy.all() else Mode.REALLOCATED
        diagnosis = Diagnosis(
            seen.healthy, seen.residual, seen.threshold, seen.response, mode, Rest.AT_TARGET,
            np.zeros(3), reference.attitude, 0.0,
        )  # fmt: skip
        control = law.acceleration(state, reference.attitude)
        return Command(control, Source.METHOD, WheelReport(None, diagnosis))


def fly(folder, flown=SECTIONS, targets=None, late=(), *, watching=False):
    """Fly a scenario and record it as the nodes would; return the bag and the flown states.

    At the steps of ``targets`` the target changes; at the steps ``late`` no command arrives. With
    ``watching`` the wheels are watched, and those that fail are excluded.
    """
    scenario = from_sections(flown)
    plant, controller, governor = (
        scenario.build_plant(),
        scenario.build_controller(),
        scenario.build_governor(),
    )
    controller = Watching(scenario) if watching else controller
    outputs, period = Outputs(scenario), period_ns(scenario.period)
    last = applied = (plant.idle_control, Source.ZERO)
    misses, states = 0, []
    with BagWriter(folder / "bag") as bag:
        announce(bag)
        bag.attach("scenario.yaml", "application/yaml", scenario.to_yaml().encode())
        bag.attach("defaults.yaml", "application/yaml", scenario.stated_defaults().encode())

        def publish(step, told):
            for signal, value in told:
                data = signal.encode(stamp_of(step, period), step, value)
                bag.write(f"/{signal.name.strip('/')}", step * period, step * period, data)

        for k in range(plant.n_steps + 1):
            state = plant.state
            states.append(state)
            publish(k, plant.outputs(applied))
            if k == plant.n_steps:
                break
            publish(k, [(CLOCK, [stamp_of(k, period)])])
            if k in (targets or {}):
                governor.set_target(targets[k])
                publish(k, outputs.accepted(targets[k]))
            decision = governor.decide(state)
            publish(k, outputs.governor(decision))
            command = controller.command(state, decision.reference)
            misses = misses + 1 if k in late else 0
            if not misses:
                last = (command.control, command.source)
                publish(
                    k, outputs.controller(state, decision.reference, command, (math.nan, math.nan))
                )
            gone = misses > (scenario.plant.max_held_steps if _is_free(scenario) else 0)
            applied = (plant.idle_control, Source.ZERO) if gone else last
            held = sum(step <= k for step in late)
            publish(k + 1, [(WALL_TIMING, (0.0, 0.0, 0.0, held, held, 0))])
            plant.step(applied[0])
    return folder / "bag", states


def _is_free(scenario):
    return scenario.plant.mode == "free_run"


def rewrite(bag, folder, messages, without=()):
    """Write the bag again with other messages, and without the channels of some topics."""
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream, BagWriter(folder) as writer:
        announce(writer, without)
        for item in make_reader(stream).iter_attachments():
            writer.attach(item.name, item.media_type, item.data)
        for topic, stamp, data in messages:
            writer.write(topic, stamp, stamp, data)
    return folder
