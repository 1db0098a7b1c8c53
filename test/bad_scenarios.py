"""A valid scenario, and invalid variants of it with the expected error messages."""

from __future__ import annotations

from bad_controllers import CONTROLLER_CASES, Bad

GOOD = """\
plant:
  ros__parameters:
    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
    time_step: 0.4
    duration: 4.0
    initial_momentum: [0.0, 0.0, 0.1]
nmpc_controller:
  ros__parameters:
    time_step: 0.8
    horizon: 5
    max_torque: 1.0
    weights: {stage_torque: 1.0}
    zone_names: [star]
    zones:
      star:
        kind: exclusion
        body_axis: [1.0, 0.0, 0.0]
        inertial_axis: [0.0, 0.0, 1.0]
        half_angle_deg: 5.0
launcher:
  ros__parameters:
    nodes: [plant, nmpc_controller, reference_governor, recorder]
"""


CASES = {
    "unknown key": Bad(
        "time_step: 0.4", "time_stp: 0.4", "plant.time_stp", "a parameter of plant", "'time_step'?"
    ),
    "key of another node": Bad(
        "duration: 4.0", "horizon: 5", "plant.horizon", "a parameter of plant", "nmpc_controller"
    ),
    "unknown node": Bad(
        "launcher:", "lancher:", "lancher", "one of plant, nmpc_controller", "mean 'launcher'?"
    ),
    "no ros__parameters": Bad(
        "launcher:\n  ros__parameters:\n",
        "launcher:\n  parameters:\n",
        "launcher",
        "ros__parameters beneath",
        "write 'ros__parameters:' beneath 'launcher:'",
    ),
    "integer for a double": Bad(
        "duration: 4.0", "duration: 4", "plant.duration", "a number with a decimal point [s]",
        "write 4.0",
    ),
    "integers in a list": Bad(
        "[0.0, 0.0, 0.1]", "[0, 0, 0.1]", "plant.initial_momentum", "3 numbers [N m s]",
        "write [0.0, 0.0, 0.1]",
    ),
    "string for a double": Bad(
        "duration: 4.0", "duration: long", "plant.duration", "a number", "without quotes"
    ),
    "quoted number": Bad(
        "duration: 4.0", "duration: '4'", "plant.duration", "[s], 1e-06 to", "write 4.0"
    ),
    "boolean among words": Bad(
        "[plant, nmpc_controller, reference_governor, recorder]", "[plant, off]", "launcher.nodes",
        "a list of strings", 'write [plant, "off"]',
    ),
    "double for an integer": Bad(
        "horizon: 5", "horizon: 5.0", "nmpc_controller.horizon", "an integer", "write 5"
    ),
    "list for a number": Bad(
        "duration: 4.0", "duration: [4.0]", "plant.duration", "a number", "write one value"
    ),
    "number for a list": Bad(
        "[0.0, 0.0, 0.1]", "0.1", "plant.initial_momentum", "3 numbers", "write a list"
    ),
    "wrong shape": Bad(
        "[0.0, 0.0, 0.1]", "[0.0, 0.1]", "plant.initial_momentum", "3 numbers", "exactly 3"
    ),
    "nested matrix": Bad(
        "[1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
        "[[1.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]]",
        "plant.inertia",
        "a flat list",
        "row by row",
    ),
    "no inertia": Bad(
        "    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]\n", "", "plant.inertia",
        "9 numbers (3x3, row-major) [kg m^2]", "add it",
    ),
    "inertia not positive definite": Bad(
        "0.8, 0.0, 0.0, 0.0, 0.8]", "0.8, 0.0, 0.0, 0.0, -0.8]", "plant.inertia",
        "positive definite", "check the signs",
    ),
    "inertia breaks the triangle inequality": Bad(
        "[1.0, 0.0, 0.0, 0.0, 0.8", "[2.0, 0.0, 0.0, 0.0, 0.8", "plant.inertia",
        "triangle inequality", "largest",
    ),
    "inertia not symmetric": Bad(
        "[1.0, 0.0, 0.0,", "[1.0, 0.1, 0.0,", "plant.inertia", "a symmetric matrix", "mirror"
    ),
    "zero axis": Bad(
        "[1.0, 0.0, 0.0]", "[0.0, 0.0, 0.0]", "nmpc_controller.zones.star.body_axis",
        "non-zero length", "such as [1.0, 0.0, 0.0]",
    ),
    "not a number": Bad(
        "[0.0, 0.0, 0.1]", "[0.0, .nan, 0.1]", "plant.initial_momentum", "finite", "replace NaN"
    ),
    "infinite": Bad("duration: 4.0", "duration: .inf", "plant.duration", "finite", "infinity"),
    "horizon 0": Bad(
        "horizon: 5", "horizon: 0", "nmpc_controller.horizon", "1 to 10000", "raise it"
    ),
    "negative time step": Bad(
        "time_step: 0.4", "time_step: -0.4", "plant.time_step", "[s], 1e-06 to", "raise it"
    ),
    "time step too large for the momentum": Bad(
        "[0.0, 0.0, 0.1]", "[0.0, 0.0, 9.0]", "plant.time_step", "Kalabic et al. 2014, (3)",
        "use a smaller time step",
    ),
    "period no multiple of the step": Bad(
        "time_step: 0.8", "time_step: 1.0", "nmpc_controller.time_step",
        "a whole multiple of plant.time_step (0.4 s)", "use for example 0.8",
    ),
    "period below the step": Bad(
        "time_step: 0.8", "time_step: 0.2", "nmpc_controller.time_step", "a whole multiple",
        "use for example 0.4",
    ),
    "duration below one step": Bad(
        "duration: 4.0", "duration: 0.7", "plant.duration", "at least one control step (0.8 s)",
        "lengthen it",
    ),
    "endless": Bad(
        "duration: 4.0", "duration: 1e300", "plant.duration", "to 2147483647", "lower it"
    ),
    "too many steps": Bad(
        "duration: 4.0", "duration: 2e9", "plant.duration", "at most 1e+09 control steps",
        "shorten it",
    ),
    "number of four hundred digits": Bad(
        "time_step: 0.4", f"time_step: {'9' * 400}", "plant.time_step", "a number",
        "write a number that double precision holds",
    ),
    "attitude of a million turns": Bad(
        "duration: 4.0", "initial_rotation_vector: [6e6, 0.0, 0.0]",
        "plant.initial_rotation_vector", "[rad], -1000 to 1000", "lower it",
    ),
    "momentum of no spacecraft": Bad(
        "[0.0, 0.0, 0.1]", "[0.0, 0.0, -1e16]", "plant.initial_momentum", "-1e+15 to 1e+15",
        "raise it",
    ),
    "inertia of nothing": Bad(
        "[1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
        "[1e-200, 0.0, 0.0, 0.0, 1e-200, 0.0, 0.0, 0.0, 1e-200]",
        "plant.inertia", "1e-12 to 1e+15 kg m^2", "check the unit",
    ),
    "inertia of a planet": Bad(
        "[1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
        "[1e37, 0.0, 0.0, 0.0, 1e37, 0.0, 0.0, 0.0, 1e37]",
        "plant.inertia", "1e-12 to 1e+15 kg m^2", "check the unit",
    ),
    "products of inertia without their sign": Bad(
        "[1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
        "[1.0, 0.3, 0.3, 0.3, 0.8, 0.3, 0.3, 0.3, 0.8]",
        "plant.inertia", "triangle inequality", "J_xy = -(integral of x y dm)",
    ),
    "zone without definition": Bad(
        "[star]", "[star, moon]", "nmpc_controller.zone_names", "zones.moon", "define it"
    ),
    "zone not listed": Bad(
        "zone_names: [star]", "zone_names: []", "nmpc_controller.zones.star.kind",
        "'star' among zone_names", "add it",
    ),
    "zone name that is no name": Bad(
        "[star]", "[star, 1st]", "nmpc_controller.zone_names", "letters", "rename"
    ),
    "zone without an axis": Bad(
        "        body_axis: [1.0, 0.0, 0.0]\n", "", "nmpc_controller.zones.star.body_axis",
        "3 numbers", "add it",
    ),
    "kind of zone unknown": Bad(
        "kind: exclusion", "kind: excluded", "nmpc_controller.zones.star.kind",
        "one of exclusion, inclusion", "did you mean 'exclusion'?",
    ),
    "half-angle out of range": Bad(
        "half_angle_deg: 5.0", "half_angle_deg: 180.0", "nmpc_controller.zones.star.half_angle_deg",
        "> 0 and < 180", "lower it",
    ),
    "method unknown": Bad(
        "horizon: 5", "method: shoting", "nmpc_controller.method", "one of shooting",
        "did you mean 'shooting'?",
    ),
    "variant unknown": Bad(
        "horizon: 5", "variant: exakt", "nmpc_controller.variant", "one of exact", "'exact'?"
    ),
    "vehicle unknown": Bad(
        "duration: 4.0", "vehicle: rigid", "plant.vehicle", "rigid_body", "'rigid_body'?"
    ),
    "mode unknown": Bad(
        "duration: 4.0", "mode: lock", "plant.mode", "one of lockstep, free_run", "'lockstep'?"
    ),
    "scalar weight not positive": Bad(
        "stage_torque: 1.0", "stage_torque: 0.0", "nmpc_controller.weights.stage_torque", "> 0",
        "raise it",
    ),
    "matrix weight semi-definite": Bad(
        "stage_torque: 1.0", "stage_torque: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]",
        "nmpc_controller.weights.stage_torque", "symmetric positive definite", "eigenvalue",
    ),
    "matrix weight indefinite": Bad(
        "stage_torque: 1.0", "stage_attitude: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]",
        "nmpc_controller.weights.stage_attitude", "semi-definite", "eigenvalues",
    ),
    "definite matrix weight indefinite": Bad(
        "stage_torque: 1.0", "stage_torque: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]",
        "nmpc_controller.weights.stage_torque", "symmetric positive definite",
        "make every eigenvalue positive",
    ),
    "matrix weight not symmetric": Bad(
        "stage_torque: 1.0", "stage_torque: [1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]",
        "nmpc_controller.weights.stage_torque", "a symmetric matrix", "mirror",
    ),
    "weight of two numbers": Bad(
        "stage_torque: 1.0", "stage_torque: [1.0, 1.0]", "nmpc_controller.weights.stage_torque",
        "or 9 of them", "write exactly 9",
    ),
    "weight unknown": Bad(
        "stage_torque: 1.0", "stage_torqe: 1.0", "nmpc_controller.weights.stage_torqe",
        "a parameter of nmpc_controller", "'weights.stage_torque'?",
    ),
    "node to launch unknown": Bad(
        "recorder]", "recoder]", "launcher.nodes", "one of plant", "did you mean 'recorder'?"
    ),
    "node to launch twice": Bad(
        "recorder]", "plant]", "launcher.nodes", "each element once", "remove the second 'plant'"
    ),
    "nothing to launch": Bad(
        "[plant, nmpc_controller, reference_governor, recorder]", "[]", "launcher.nodes",
        "at least one", "add one",
    ),
    "key twice": Bad(
        "duration: 4.0", "duration: 4.0\n    duration: 5.0", "plant.duration", "each key once",
        "delete one",
    ),
    "key dotted and nested": Bad(
        "weights: {stage_torque: 1.0}",
        "weights: {stage_torque: 1.0}\n    weights.stage_torque: 2.0",
        "nmpc_controller.weights.stage_torque",
        "each key once",
        "delete one",
    ),
    "node twice": Bad(
        "launcher:", "/plant:\n  ros__parameters:\n    time_step: 1.0\nlauncher:", "/plant",
        "one section for a node", "merge",
    ),
    "no value": Bad("duration: 4.0", "duration:", "plant.duration", "a value", "write one"),
    "YAML tag": Bad(
        "duration: 4.0", "duration: !!float 4", "plant.duration", "without a YAML tag", "remove"
    ),
    "wildcard key unknown": Bad(
        "launcher:", "/**:\n  ros__parameters:\n    foo: 1\nlauncher:", "/**.foo",
        "at least one node", "remove it",
    ),
    **CONTROLLER_CASES,
}  # fmt: skip

FILES = {
    "empty": (b"", "an empty file", "copy an example"),
    "only a comment": (b"# nothing\n", "an empty file", "copy an example"),
    "a list": (b"- plant\n", "no mapping of nodes", "copy an example"),
    "not UTF-8": (b"plant:\n  a: \xff\xfe\n", "no UTF-8", "save it as UTF-8"),
    "control character": (b"plant:\n  a: \x01\n", "a forbidden character", "remove it"),
    "broken YAML": (b"plant:\n  a: [1.0,\nb: 2\n", "bad YAML", "mend this line"),
    "two documents": (b"plant: {}\n---\nplant: {}\n", "bad YAML", "mend this line"),
    "alias": (b"plant:\n  a: &x 1.0\n  b: *x\n", "ROS 2 reads no aliases", "mend this line"),
    "too deep": (b"[" * 5000, "nested too deeply", "flatten it"),
    "too long": (b"#" * (5 << 20), "bytes", "name a scenario file"),
}
"""Contents of a file -> (bytes, what was received, remedy)."""

SETTINGS = {
    "no equals sign": ("plant.duration", "NODE.PARAMETER=VALUE", "plant.duration=10.0"),
    "no key": ("=3", "NODE.PARAMETER=VALUE", "plant.duration=10.0"),
    "no parameter": ("plant=3", "NODE.PARAMETER", "did you mean 'plant'?"),
    "unknown node": ("plnt.duration=3", "NODE.PARAMETER", "did you mean 'plant'?"),
    "unknown parameter": ("plant.durasion=3", "a parameter of plant", "did you mean 'duration'?"),
    "no value": ("plant.duration=", "a value", "write ''"),
    "broken YAML": ("plant.duration=[1", "one YAML value", "quote it"),
    "alias": ("plant.duration=*x", "one YAML value", "quote it"),
    "nested list": ("plant.inertia=[[1.0]]", "a flat list", "row by row"),
    "wrong type": ("plant.duration=long", "a number", "without quotes"),
    "wrong range": ("nmpc_controller.horizon=0", "1 to 10000", "raise it"),
    "weight twice": ("nmpc_controller.weights={a: 1.0, a: 2.0}", "each key once", "delete one"),
}
"""Argument of --set -> (text, requirement, remedy)."""
