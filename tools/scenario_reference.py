"""Write docs/scenario.md, the reference of the scenario file, from the one schema.

`.venv/bin/python tools/scenario_reference.py` writes it; a test compares it with the schema.
"""
# ruff: noqa: E501 - the rows of a table

from __future__ import annotations

from pathlib import Path

from spacecraft_gnc.parameters.parameter import MatrixRule, ParameterSpec, specs_of
from spacecraft_gnc.parameters.sections import (
    DEFAULT_VEHICLE,
    ControllerHost,
    GovernorHost,
    PlantHost,
)
from spacecraft_gnc.scenario.schema import ROLES, schema_of
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.vehicle import Vehicle

ROOT = Path(__file__).resolve().parents[1]
VEHICLE = registry.vehicle_of(DEFAULT_VEHICLE)
OTHERS = [
    registry.vehicle_of(name)
    for name in registry.own_names(registry.VEHICLES)
    if name != DEFAULT_VEHICLE
]
HOSTS = {
    "plant": (PlantHost,),
    "nmpc_controller": (ControllerHost,),
    "reference_governor": (GovernorHost,),
}
"""What every vehicle's section has."""
_NAMES = ("method", "governor")
"""Of these, those whose words are the vehicle's own."""
PAGE = ROOT / "docs" / "scenario.md"

HEAD = """\
# The scenario file

<!-- Written by tools/scenario_reference.py from the schema in spacecraft_gnc/scenario. -->

One scenario is one standard ROS 2 parameter file. It is handed unchanged to every node
(`plant --ros-args --params-file FILE`), to `gnc launch` and to `gnc simulate`; `gnc check FILE`
names every mistake in it at once. `--set node.parameter=VALUE` (VALUE is YAML) replaces a value for
one run; of several agents `/sc1/node.parameter` means that of one, `node.parameter` that of all. A scenario that comes with the package is found by its name (`gnc check gupta2015_case1`);
a file of that name in the working directory, with or without `.yaml`, goes first.

- A parameter that is left out takes its default. `required` ones have none. A formula as default
  is explained [below](#defaults-that-follow-from-the-spacecraft).
- Numbers with a decimal point are doubles, without one integers, and ROS 2 tells them apart: write
  `150.0` where a double is due.
- Matrices are row-major, 9 numbers; a weight may also be one number `s`, which stands for `s I`.
- Angles are in radians unless the name ends in `_deg`. Vectors are in the body frame unless the
  description says otherwise.
- A vehicle, method or governor of another package takes its parameters from `plugin.<name>`.

## Which node a section is for

`check`, `simulate`, `launch` and the nodes read what rclpy gives each node (rclpy 7.1, Jazzy; a
test compares every form with live nodes). A section's name is a pattern of full node names:

| section | nodes that are given its values |
|---|---|
| `plant`, `/plant` | `/plant`, not `/sat1/plant` |
| `/sat1/plant`, `sat1/plant`, or `plant:` nested beneath `sat1:` | `/sat1/plant` |
| `/**`, `'**'` | every node |
| `/*`, `'*'` | every node in the root namespace |
| `/**/plant`, or `plant:` nested beneath `/**:` | `/plant`, `/sat1/plant`, `/a/b/plant` |
| `/*/plant`, or `plant:` nested beneath `/*:` | `/sat1/plant`, not `/plant`, not `/a/b/plant` |
| `/sat1/*` | every node whose namespace is `/sat1` |
| `/sat1/**` | every node in `/sat1` or in a namespace beneath it |

- Sections that match the same node are laid over each other **in the order of the file**, and the
  last value wins: a `/**` below `plant` replaces the values of `plant`. Write wildcards first.
- Of several `--params-file` a section keeps the place at which its name first appeared, and takes
  the later value. `-p name:=value` is laid into `/**`, `-p node:name:=value` into `/node`, each at
  the place of that section, at the end if there is none.
- A wildcard gives a node all its values, also those that only another node knows; a node ignores
  these. A value that no node knows is refused.
- Sections in several namespaces are those of several agents, each with a `plant` and an
  `nmpc_controller` of its own, unless the root has a controller or governor too. One plant node in
  the root simulates all of them; a section `plant` of the root holds for each agent, beneath its
  own `plant`, and `recorder` and `launcher` stand in the root ([Agents](graph.md#agents)).
- The controllers of a vehicle's [craft](graph.md#craft) (`/sc1/nmpc_controller`) belong to the vehicle whose `plant` stands above
  them; all of them must be given the same values, best by `/**/nmpc_controller`.
- `--namespace sat1` reads the sections as nodes in `/sat1` do: of several agents it picks one.
  Without it the nodes are those of the root, of the only namespace that the file names, or of all
  agents. A section that matches none is told.
- Refused although ROS 2 takes it, because part of it would be lost without a word: the same section
  or key twice in one file, keys beside `ros__parameters`, sections of unknown nodes.
- `gnc launch` starts the nodes of one vehicle in the root namespace, those of agents in their own.
  It hands them the file itself, or, where
  that would not give them these values (options, another namespace, a wildcard that comes last),
  the `scenario.yaml` that it writes into the folder of the run.
"""


FORMULAS = """\
## Defaults that follow from the spacecraft

What carries units has no number as its default: it follows from the inertia, the torque limit and
the settling time, each as given or by its own formula. In units of J, 1/omega and J omega^2 every
spacecraft then solves the same problem. [docs/tuning.md](tuning.md) says where the formulas come
from; `gnc check` prints the settling time they lead to. The recorder keeps the numbers beside the
scenario, `gnc launch` writes them into the `scenario.yaml` that it saves, and a live node has them
(`gnc inspect params`).

| symbol | is |
|---|---|
| J, tr(J) | inertia that the controller believes, its trace |
| J_1 | its largest principal moment |
| J_max | the same; with actuators sqrt of the largest eigenvalue of J V J, V = (B B^T)^-1 |
| J_d | smallest eigenvalue of tr(J)/2 I - J |
| U | `nmpc_controller.max_torque` |
| omega | 8 / `settling_time` [rad/s]: (1 + 8) e^-8 is 0.1 deg of 30 deg |
| u_0 | J_max omega^2 / 4 [N m], which is U where the settling time follows from U |
| h, N, T | control period, horizon, max(N - 1, 1) h |
| Pi_0 | `plant.initial_momentum` |
| S | (tr(Q) I - Q)/2 of the `stage_torque` Q, the cost being h u . S u; the number q where Q = q I |
| W | (B S^-1 B^T)^-1, the weight of a body torque; S without actuators. A torque that no actuator makes weighs as the dearest that one does |
| E(X) | tr(X) I - 2 X, its eigenvalues raised to 1e-4 of the largest: a weight whose cost is h x . X x |

Numbers are kept with 12 digits. Where a node alone knows no inertia, J = I.
"""


def page() -> str:
    """Return the text of docs/scenario.md."""
    parts = [_section(VEHICLE, name) for name in ROLES]
    return "\n".join([HEAD, FORMULAS, *parts, *map(_vehicle, OTHERS)])


def _vehicle(vehicle: Vehicle) -> str:
    """Return the tables of another vehicle: what is not as the default one has it."""
    what = vehicle.description[:1].upper() + vehicle.description[1:]
    intro = (
        f"## Vehicle `{vehicle.name}`\n\n{what}; "
        f"[docs/{vehicle.name}.md]({vehicle.name}.md) explains the symbols. Beside these parameters "
        "it has those that concern a node and not the vehicle: mode and pace, `variant`, period.\n"
    )
    return "\n".join([intro, *(_section(vehicle, name) for name in vehicle.sections)])


def _section(vehicle: Vehicle, name: str) -> str:
    schema = schema_of(vehicle)
    elements = {field: ("<name>",) for field, _ in schema.named_groups(name)}
    rows = schema.declarations(name, elements)
    title = f"## `{name}`"
    if vehicle is not VEHICLE:
        shared = {key: spec for host in HOSTS[name] for key, spec in specs_of(host)}
        rows = tuple(row for row in rows if row.name in _NAMES or shared.get(row.name) != row.spec)
        title = f"### `{name}` of `{vehicle.name}`"
    lines = [
        f"{title}\n",
        "| parameter | type | default | unit | admissible | meaning |",
        "|---|---|---|---|---|---|",
    ]
    for key, spec in rows:
        cells = (
            f"`{key}`", _type(spec), _default(spec), spec.unit, _admissible(spec, vehicle),
            spec.description,
        )  # fmt: skip
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _type(spec: ParameterSpec) -> str:
    words = spec.kind.value.lower().replace("_array", "s").replace("dynamic", "double(s)")
    sizes = {(3,): " (3)", (3, 3): " (9)", (3, -1): " (3 m)"}
    return words + sizes.get(spec.shape, "")


def _default(spec: ParameterSpec) -> str:
    return (
        "required"
        if spec.required
        else spec.formula or f"`{spec.default if spec.default != '' else repr('')}`"
    )


def _admissible(spec: ParameterSpec, vehicle: Vehicle) -> str:
    words = []
    if spec.choices:
        words.append(spec.listed_choices)
    if spec.plugins:
        words.append(", ".join(registry.own_names(spec.plugins, vehicle)) + " or a plug-in")
    if spec.matrix is not MatrixRule.NONE:
        words.append(spec.matrix.value)
    bounds = ((">=", spec.minimum), (">", spec.above), ("<=", spec.maximum), ("<", spec.below))
    words += [f"{sign} {bound:g}" for sign, bound in bounds if bound is not None]
    if spec.nonzero:
        words.append("not zero")
    return "; ".join(words)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"written: {PAGE.relative_to(ROOT)}")
