"""Forms of a ROS 2 parameter file: section names that match a node, and their order."""

from __future__ import annotations

from textwrap import dedent
from typing import NamedTuple


def values(*sections: str) -> str:
    """Return a file whose sections set ``plugin.x``, known to all nodes, to different values."""
    lines = [
        f"{name}: {{ros__parameters: {{plugin: {{x: {number}}}}}}}"
        for number, name in enumerate(sections)
    ]
    return "\n".join(lines)


def nested(*names: str) -> str:
    """Return a file of one section nested under its namespace."""
    return (
        "".join(f"{name}: {{" for name in names)
        + "ros__parameters: {plugin.x: 1}"
        + "}" * len(names)
    )


ONE_SECTION = """
    plant /plant sat1/plant /sat1/plant /** '**' /* '*' /**/plant /*/plant /*/* /*/*/plant /sat1/*
    /sat1/** /a/**/plant /a/**/b/plant /a/*/plant /**/b/* /**/** /**/* /**/plant/** /**/plant/*
    /nowhere/plant
"""
NESTED = "sat1,plant /sat1,plant /,plant /**,plant '*',plant sat1,'*' sat1,'**' a/b,plant a,b,plant"
SEVERAL = """
    plant,/** /**,plant /**,/**/plant /**/plant,/** /*,/**,plant plant,/*,/sat1/plant,/**/plant
"""
FORMS: dict[str, list[str]] = {
    **{name: [values(name)] for name in ONE_SECTION.split()},
    **{f"nested {names}": [nested(*names.split(","))] for names in NESTED.split()},
    **{names: [values(*names.split(","))] for names in SEVERAL.split()},
    "a node, then a wildcard in a second file": [values("plant"), values("sat1/plant", "/**")],
    "files change the first place": [values("/**", "plant"), values("plant"), values("/*", "/**")],
    "-p is laid into /**": [values("/**", "plant"), "-p plugin.x:=7"],
    "-p comes last without a /**": [values("plant", "/*"), "-p plugin.x:=7"],
    "-p before a file": ["-p plugin.x:=7", values("/**", "plant")],
    "-p NODE": [values("plant", "/**"), "-p plant:plugin.x:=7", "--param plugin.y:=[1.5, 2.0]"],
}
"""Files and ``-p`` options of a command line, by name."""


class Form(NamedTuple):
    """A scenario in one of the forms."""

    text: str
    namespace: str
    """Of the nodes that it is started with."""
    horizon: int
    """That these nodes are given (the default is 20 here)."""


def _form(text: str, horizon: int, namespace: str = "/") -> Form:
    for word, meant in {
        "BODY": "time_step: 0.4, inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
        "FLIGHT": "duration: 8.0, initial_rotation_vector: [0.05, 0.0, 0.0]",
    }.items():
        text = text.replace(word, meant)
    return Form(dedent(text), namespace, horizon)


_ONE_WORD = """
    /**: {ros__parameters: {BODY}}
    /**/plant: {ros__parameters: {FLIGHT}}
    /*/nmpc_controller: {ros__parameters: {horizon: 7}}
"""
WILDCARD_LAST = "a wildcard beneath the nodes wins"
SCENARIOS = {
    "shared by a wildcard": _form(
        """
        /**: {ros__parameters: {BODY}}
        plant: {ros__parameters: {FLIGHT}}
        nmpc_controller: {ros__parameters: {horizon: 7}}
        """,
        7,
    ),
    "all in a wildcard": _form(
        "/**: {ros__parameters: {BODY, FLIGHT, horizon: 7, peers: [], autostart: true}}", 7
    ),
    WILDCARD_LAST: _form(
        """
        plant: {ros__parameters: {BODY, FLIGHT}}
        nmpc_controller: {ros__parameters: {horizon: 7, autostart: false}}
        /**: {ros__parameters: {horizon: 9, autostart: true, storage_folder: elsewhere}}
        """,
        9,
    ),
    "a node undoes what the launcher lays into the wildcard": _form(
        """
        /**: {ros__parameters: {BODY, FLIGHT, horizon: 7, autostart: false}}
        nmpc_controller: {ros__parameters: {autostart: true}}
        """,
        7,
    ),
    "one word is no root": _form(_ONE_WORD, 20),
    "one word is a namespace": _form(_ONE_WORD, 7, "/sat1"),
    "nested in a wildcard": _form(
        """
        /**:
          plant: {ros__parameters: {BODY, FLIGHT}}
          nmpc_controller: {ros__parameters: {horizon: 7}}
        """,
        7,
    ),
    "nested in a namespace": _form(
        """
        sat1:
          plant: {ros__parameters: {BODY, FLIGHT}}
          nmpc_controller: {ros__parameters: {horizon: 7}}
        """,
        7,
        "/sat1",
    ),
}
