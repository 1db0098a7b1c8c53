"""Bags of docking flights without ROS: cores fly, the signals' codec writes."""

from __future__ import annotations

import math

from mcap.reader import make_reader
from recording.bags import CODEC

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.vehicles.docking.outputs import Outputs
from spacecraft_gnc.vehicles.docking.signals import SIGNALS

SECTIONS = {
    "plant": {
        "vehicle": "docking",
        "duration": 50.0,
        "chief_spin_rate": 2.0 * math.pi / 20.0,
        "chief_spin_axis": [0.1, 0.0, 1.0],
        "initial_port_offset": [2.0, 0.4, -0.3],
        "initial_rotation_vector": [0.1, -0.1, 0.05],
        "max_force": 90.0,
        "max_moment": 2.0,
        "pose_every": 3,
    },
    "reference_governor": {"distance_margin": 0.002, "hold_port_offset": [3.0, 0.0, 0.0]},
}
"""Ten steps beside a chief that rotates in four: its admissible sets take a second."""
RECORDED = [signal for signal in (*SIGNALS, *graph.SIGNALS) if signal.recorded]


def sections(**changes):
    """Return these sections with some values changed, by section name."""
    names = {**SECTIONS, **changes}
    return {name: {**SECTIONS.get(name, {}), **changes.get(name, {})} for name in names}


def ungoverned(**plant):
    """Return the same without a governor, and with some values of the plant changed."""
    return {**sections(plant=plant), "reference_governor": {"governor": "none"}}


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


def fly(folder, flown=SECTIONS, targets=None):
    """Fly a scenario and record it as the nodes would; at steps of ``targets`` they change."""
    scenario = from_sections(flown)
    plant, controller, governor = (
        scenario.build_plant(),
        scenario.build_controller(),
        scenario.build_governor(),
    )
    outputs, period = Outputs(scenario), period_ns(scenario.period)
    applied = (plant.idle_control, Source.ZERO)
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
            publish(k, outputs.controller(state, decision.reference, command, (math.nan, math.nan)))
            applied = (command.control, command.source)
            plant.step(command.control)
    return folder / "bag"


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
