"""The Foxglove layout names what there is: topics, fields, panels and their settings."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from foxglove import layouts
from recording.bags import definition

from spacecraft_gnc import lie
from spacecraft_gnc.recording.schema_text import fields
from spacecraft_gnc.scenario.shipped import shipped_file

NAME = "spacecraft_gnc.foxglove-layout.json"
LAYOUT = json.loads((Path(__file__).parents[2] / "config" / NAME).read_text())
PANELS = LAYOUT["configById"]
SCRIPT = LAYOUT["userNodes"]["attitude_error"]["sourceCode"]
CONFIGS = {
    "3D": layouts.ThreeDeeConfig(),
    "Plot": layouts.PlotConfig(),
    "StateTransitions": layouts.StateTransitionsConfig(),
    "RawMessages": layouts.RawMessagesConfig(),
}
"""What foxglove-sdk knows of the settings of each kind of panel."""


@pytest.fixture(scope="module")
def topics():
    """Return the type of every topic of the graph, by full name."""
    pytest.importorskip("rclpy")
    from spacecraft_gnc.nodes._topics import TOPICS

    return {
        f"/{topic.name.strip('/')}": "/".join(
            (topic.type.__module__.split(".")[0], "msg", topic.type.__name__)
        )
        for topic in TOPICS
    }


def paths():
    """Yield every message path of the layout."""
    for config in PANELS.values():
        yield from (series["value"] for series in config.get("paths", ()))
        if "topicPath" in config:
            yield config["topicPath"]


def field_type(type_name, path):
    """Return the type at the end of a path of field names; raises KeyError where it breaks."""
    for name in path:
        known = {field: kind for kind, field in fields(definition(type_name))}
        type_name = known[name]
        if "/" in type_name:
            package, leaf = type_name.split("/")
            type_name = f"{package}/msg/{leaf}"
    return type_name


def test_every_topic_and_field_exists(topics) -> None:
    own = re.search(r'export const output = "([^"]+)"', SCRIPT)[1]
    made = set(re.findall(r"(\w+): number", SCRIPT.splitlines()[1]))
    seen = 0
    for path in paths():
        topic, *names = path.split(".")
        if topic == own:
            assert set(names) <= made
        elif names:
            kind = field_type(topics[topic], names)
            assert kind in {"float64", "uint8", "uint32", "bool"}, path
        else:
            assert topic in topics
        seen += 1
    assert seen > 10
    assert set(PANELS["3D!attitude"]["topics"]) <= set(topics)


def test_the_script_listens_to_what_is_published(topics) -> None:
    inputs = json.loads(re.search(r"inputs = (\[[^\]]*\])", SCRIPT)[1])
    assert set(inputs) <= set(topics)
    for name in re.findall(r"event\.message\.(\w+)", SCRIPT):
        for topic in inputs:
            assert field_type(topics[topic], [name])


def test_every_panel_is_placed_once_and_known() -> None:
    def leaves(node):
        return (
            [node] if isinstance(node, str) else [*leaves(node["first"]), *leaves(node["second"])]
        )

    assert sorted(leaves(LAYOUT["layout"])) == sorted(PANELS)
    assert set(LAYOUT) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}


@pytest.mark.parametrize("panel", PANELS)
def test_settings_are_those_of_the_app(panel) -> None:
    known = set(CONFIGS[panel.partition("!")[0]]._to_dict())
    assert set(PANELS[panel]) - {"title"} <= known
    series = set(layouts.PlotSeries(value="")._to_dict())
    for item in PANELS[panel].get("paths", ()):
        assert set(item) <= series


def test_the_script_computes_the_angle(browser) -> None:
    """Run the script, its type annotations taken off, against the Lie algebra."""
    plain = re.sub(r"^type .*$|export (default )?", "", SCRIPT, flags=re.MULTILINE)
    plain = re.sub(r"let reference: any", "let reference", plain)
    plain = re.sub(r"\(event: \{[^)]*\}\): Output \| undefined", "(event)", plain)
    rng = np.random.default_rng(1)
    turns = [lie.exp(angle * axis) for angle in (0.0, 1e-6, 0.3, 3.1) for axis in np.eye(3)]
    reference = lie.exp(rng.normal(size=3))
    attitudes = [(reference @ turn).ravel().tolist() for turn in turns]
    browser.get("data:text/html,<title>script</title>")
    found = browser.execute_script(
        plain
        + """
        const say = (topic, attitude) => script({ topic, message: { attitude, step: 3n } });
        const early = say("/attitude_state", arguments[1][0]);
        const nothing = say("/attitude_reference", arguments[0]);
        return [early === undefined, nothing === undefined,
                arguments[1].map((a) => say("/attitude_state", a).error_deg)];
        """,
        reference.ravel().tolist(),
        attitudes,
    )
    assert found[:2] == [True, True]
    expected = [math.degrees(angle) for angle in (0.0, 1e-6, 0.3, 3.1) for _ in range(3)]
    assert found[2] == pytest.approx(expected, abs=1e-7)


def test_it_is_installed_with_the_package() -> None:
    assert shipped_file(NAME) is not None
