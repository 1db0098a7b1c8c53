"""The Foxglove layout names what there is: topics, fields, panels and their settings.

That its panels are filled by a recorded bag is checked where one is recorded, in
``test/graph/test_flight.py``.
"""

from __future__ import annotations

import pytest
from foxglove import layouts
from live.layout import LAYOUT, NAME, PANELS, paths
from recording.bags import definition

from spacecraft_gnc.recording.schema_text import fields
from spacecraft_gnc.scenario.shipped import shipped_file
from spacecraft_gnc.signals import graph
from spacecraft_gnc.vehicles.rigid_body import signals as rigid_body

CONFIGS = {
    "3D": layouts.ThreeDeeConfig(),
    "Plot": layouts.PlotConfig(),
    "StateTransitions": layouts.StateTransitionsConfig(),
    "RawMessages": layouts.RawMessagesConfig(),
}
"""What foxglove-sdk knows of the settings of each kind of panel."""


@pytest.fixture(scope="module")
def topics():
    """Return the type of every topic that a bag holds, by full name."""
    signals = (*rigid_body.SIGNALS, *graph.SIGNALS)
    return {f"/{s.name.strip('/')}": s.type for s in signals if s.recorded}


def field_type(type_name, path):
    """Return the type at the end of a path of field names; raises KeyError where it breaks."""
    for name in path:
        known = {field: kind for kind, field in fields(definition(type_name))}
        type_name = known[name]
        if "/" in type_name:
            package, leaf = type_name.split("/")
            type_name = f"{package}/msg/{leaf}"
        elif type_name == "Vector3":  # of the same package
            type_name = "geometry_msgs/msg/Vector3"
    return type_name


def test_every_topic_is_recorded_and_every_field_exists(topics) -> None:
    seen = 0
    for config in PANELS.values():
        for path in paths(config):
            topic, *names = path.split(".")
            assert topic in topics
            if names:
                kind = field_type(topics[topic], names)
                assert kind in {"float64", "uint8", "uint32", "bool"}, path
            seen += 1
    assert seen > 10


def test_every_panel_is_placed_once_and_known() -> None:
    def leaves(node):
        return (
            [node] if isinstance(node, str) else [*leaves(node["first"]), *leaves(node["second"])]
        )

    assert sorted(leaves(LAYOUT["layout"])) == sorted(PANELS)
    assert set(LAYOUT) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    assert not LAYOUT["userNodes"]  # a script's output is in no bag, and not every viewer has them


@pytest.mark.parametrize("panel", PANELS)
def test_settings_are_those_of_the_app(panel) -> None:
    known = set(CONFIGS[panel.partition("!")[0]]._to_dict())
    assert set(PANELS[panel]) - {"title"} <= known
    series = set(layouts.PlotSeries(value="")._to_dict())
    for item in PANELS[panel].get("paths", ()):
        assert set(item) <= series


def test_it_is_installed_with_the_package() -> None:
    assert shipped_file(NAME) is not None
