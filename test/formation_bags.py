"""Bags of flights in formation without ROS: cores fly, the signals' codec writes."""

from __future__ import annotations

import math

import numpy as np
from mcap.reader import make_reader
from recording.bags import CODEC

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.graph import CLOCK, WALL_TIMING
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.outputs import Outputs
from spacecraft_gnc.vehicles.formation.signals import COMMAND, SIGNALS

ORBIT = 2.0 * math.pi * math.sqrt((6378137.0 + 350e3) ** 3 / 3.986004418e14)
"""Period of the orbit at 350 km [s]."""
SECTIONS = {
    "plant": {
        "vehicle": "formation",
        "duration": 9.5 * ORBIT / 20,
        "initial_phase": [18.0, 8.4, 4.0],
        "initial_along_track_offset": [6103.0, 8325.0, 5036.0],
        "initial_amplitude": [1.53, 1.705, 0.877],
    },
    "nmpc_controller": {"time_step": ORBIT / 20},
    "reference_governor": {"phase": [6, 0, 13], "horizon": 40},
}
"""Nine steps of a twentieth of the orbit each, from the start of the report's figures."""
PARKED = {
    "plant": {
        "vehicle": "formation",
        "duration": 64.5 * ORBIT / 50,
        "initial_phase": [16.0, 33.0, 0.0],
        "initial_along_track_offset": [0.0, 0.0, 0.0],
        "initial_amplitude": [1.0, 1.0, 1.0],
    },
}
"""The second and the third craft each at the other's place: parked, and deadlocked."""
OTHERS = [s for s in (*SIGNALS, *graph.SIGNALS) if s.recorded and not s.of_craft]


def sections(**changes):
    """Return these sections with some values changed, by section name."""
    names = {**SECTIONS, **changes}
    return {name: {**SECTIONS.get(name, {}), **changes.get(name, {})} for name in names}


def ungoverned(**plant):
    """Return the same without a governor, and with some values of the plant changed."""
    phase = SECTIONS["reference_governor"]["phase"]
    none = {"governor": "none", "phase": phase}
    return {**sections(plant=plant), "reference_governor": none}


def nanoseconds():
    """Return the control period [ns]."""
    return period_ns(from_sections(SECTIONS).period)


def topics_of(scenario):
    """Return the signal of each topic of a flight, by full name."""
    commands = [COMMAND.of(name) for name in craft(scenario)]
    return {f"/{signal.name.strip('/')}": signal for signal in (*OTHERS, *commands)}


def announce(writer, scenario):
    """Announce the topics of a flight to a writer."""
    for topic, signal in topics_of(scenario).items():
        text, hashed = CODEC.text(signal.type), signal.type_hash
        gapless = signal.every_step and signal.is_stepped
        writer.add_topic(topic, signal.type, text, type_hash=hashed, gapless=gapless)


def fly(folder, flown=SECTIONS, late=(), silent=(), counted=True):
    """Fly a scenario and record it as the nodes would; return the bag.

    ``late``: pairs (step, row of a craft) of commands that do not come in time; of those in
    ``silent`` no message is recorded. Not ``counted``: the plant tells of none.
    """
    scenario = from_sections(flown)
    plant, controller, governor = (
        scenario.build_plant(),
        scenario.build_controller(),
        scenario.build_governor(),
    )
    outputs, period = Outputs(scenario), period_ns(scenario.period)
    names, missed = craft(scenario), {*late, *silent}
    applied = (plant.idle_control, Source.ZERO)
    with BagWriter(folder / "bag") as bag:
        announce(bag, scenario)
        bag.attach("scenario.yaml", "application/yaml", scenario.to_yaml().encode())
        bag.attach("defaults.yaml", "application/yaml", scenario.stated_defaults().encode())

        def publish(step, told, prefix=""):
            for signal, value in told:
                data = signal.encode(stamp_of(step, period), step, value)
                bag.write(f"{prefix}/{signal.name.strip('/')}", step * period, step * period, data)

        for k in range(plant.n_steps + 1):
            state = plant.state
            publish(k, plant.outputs(applied))
            if k == plant.n_steps:
                break
            publish(k, [(CLOCK, [stamp_of(k, period)])])
            decision = governor.decide(state)
            publish(k, outputs.governor(decision))
            asked, sources = [], []
            for i, name in enumerate(names):
                command = controller.craft[i].command(state, decision.reference)
                if (k, i) not in silent:
                    wall = (math.nan, math.nan)
                    told = outputs.controller(state, decision.reference, command, wall)
                    publish(k, told, f"/{name}")
                here = (k, i) not in missed
                asked.append(command.control if here else np.zeros(3))
                sources.append(command.source if here else Source.ZERO)
            applied = (np.stack(asked), sources)
            held = len({step for step, _ in missed if step <= k}) if counted else 0
            timing = (0.1 * k, math.nan, math.nan, held, held, 0)
            publish(k + 1, [(WALL_TIMING, timing)])
            plant.step(applied[0])
    return folder / "bag"


def rewrite(bag, folder, messages, flown=SECTIONS):
    """Write the bag again with other messages."""
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream, BagWriter(folder) as writer:
        announce(writer, from_sections(flown))
        for item in make_reader(stream).iter_attachments():
            writer.attach(item.name, item.media_type, item.data)
        for topic, stamp, data in messages:
            writer.write(topic, stamp, stamp, data)
    return folder
