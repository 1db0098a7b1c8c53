"""Random damage to scenario files: each is refused with a reason, or flies.

    python benchmarks/fuzz_scenarios.py [--cases 2000] [--seed 1] [--first 0] [--ros]

Every case takes a shipped scenario, damages it once or twice (bytes; lines dropped, doubled,
swapped, indented; sections renamed; values scaled, or replaced by extreme ones or by others of the
wrong type), and has it loaded, checked, built and, where all that succeeds, flown for two steps, in
this process and under limits of memory and CPU time. Anything but a result or the package's own
error is a fault, also a warning of NumPy, and so is a case of more than 10 s of CPU time, or of
60 s where the admissible sets of a docking are computed first. A case depends on seed and number
alone: `--first N --cases 1` repeats case N. `--ros` gives every file that is accepted to nodes of
rclpy, too, which must read from it what we read. Exit code 1 where there is a fault.
"""

from __future__ import annotations

import argparse
import faulthandler
import os
import random
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.launcher.domain import claim_free
from spacecraft_gnc.launcher.environment import DOMAIN_ID, prepare
from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.sections import NODE_NAMES
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.scenario.node_sections import add_file, given_to, node_names

CONFIG = Path(__file__).parents[1] / "config"
CPU_LIMIT = 10.0  # [s] of one case
SETS_LIMIT = 60.0  # [s] of one with admissible sets, whose search lasts 33 s on a slow machine
WALL_LIMIT = 120.0  # [s] of one case, after which its stack is shown and all ends
MEMORY_LIMIT = 8 << 30  # [bytes] of address space, most of it reserved by LLVM and never used
STEPS = 2  # flown of a scenario that is accepted
DAMAGES = 2  # of one file, at most
VALUE = re.compile(r"(?<=: )[^#\n{}\[\]]+|(?<=[\[ ])[-+.\w]+(?=[,\]])")
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]+)?")
POWERS = (1, 2, 3, 6, 9, 15, 30, 80, 150, 200)  # of ten
EXTREMES = [
    *"""
    0 0.0 -0.0 1 -1 1.0 -1.0 3 1e-300 5e-324 2.3e-308 1e-200 1e-100 1e-30 1e-12 1e12 1e30 1e100
    1e200 1e300 1.7e308 1e309 -1e308 .nan .inf -.inf 2147483648 9223372036854775807
    9223372036854775808 -9223372036854775809 1000000000 0x10 0x1p3 0xffffffffffffffffff 0777 08
    07777777777777777777777777 1_000 1:30 2020-01-01 true no on Y null ~ "" '' "1.0" 'shooting'
    shooting neighboring_extremal slsqp fsolve terminal_set feedback attitude none rigid_body
    lockstep free_run exclusion inclusion exact star sun [] {} [[1.0]] [1.0] [1,2,3]
    [0.0,0.0,0.0] [1.0,0.0,0.0] [1e200,0.0,0.0] [3.14159265358979,0.0,0.0] [1.0,true,a] {a:1}
    [1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0] [1e-200,0,0,0,1e-200,0,0,0,1e-200] *a &a !!int !!str
    !!python/object:os.system - ? : | > % @ ` \\ \\" é 😀 plant /** ros__parameters
    """.split(),  # noqa: SIM905 - a list of a hundred quoted words is not clearer
    *("9" * 400, "0." + "0" * 400 + "1", "1" * 5000, "a" * 5000, "[" * 50, "- " * 50, " "),
]
SECTIONS = (
    *("/**", "/*", "*", "**", "/**/plant", "/*/plant", "/plant", "/sat1/plant", "/plant/**", "a/b"),
    *("nmpc_controller", "/nmpc_controller", "/**/nmpc_controller", "launcher"),
)

Damage = Callable[[random.Random, bytes], bytes]


def damaged_bytes(rng: random.Random, data: bytes) -> bytes:
    """Change, insert, remove or cut off some bytes."""
    text = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        at = rng.randrange(len(text) + 1)
        what = rng.random()
        if what < 0.5:
            text[at : at + 1] = bytes([rng.choice([rng.randrange(256), *b"\t\n :-.,[]{}'\"*/#0e"])])
        elif what < 0.75:
            text[at:at] = rng.randbytes(rng.randint(1, 4))
        elif what < 0.97:
            del text[at : at + rng.randint(1, 20)]
        else:
            del text[at:]
    return bytes(text)


def damaged_lines(rng: random.Random, data: bytes) -> bytes:
    """Drop, double, move, swap or indent lines."""
    lines = data.splitlines(keepends=True) or [b""]
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(5)
    if what == 0:
        del lines[at : at + rng.randint(1, 5)]
    elif what == 1:
        lines[other:other] = lines[at : at + rng.randint(1, 5)]
    elif what == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif what == 3:
        lines[at] = b" " * rng.randint(1, 4) + lines[at]
    else:
        lines[at] = lines[at].lstrip(b" ")
    return b"".join(lines)


def damaged_values(rng: random.Random, data: bytes) -> bytes:
    """Replace a value by one of another size or type."""
    text = data.decode(errors="surrogateescape")
    found = list(VALUE.finditer(text))
    if found:
        place = rng.choice(found)
        text = text[: place.start()] + rng.choice(EXTREMES) + text[place.end() :]
    return text.encode(errors="surrogateescape")


def scaled_numbers(rng: random.Random, data: bytes) -> bytes:
    """Multiply a number, or all of a list, so that the types stay what they were."""
    numbers = list(
        re.finditer(rb"(?<=[: \[])(\[[-+.0-9e, ]+\]|-?[0-9]+(\.[0-9]+)?(e-?[0-9]+)?)", data)
    )
    if not numbers:
        return data
    place = rng.choice(numbers)
    factor = rng.choice([-1.0, 0.5, 2.0, 3.0, 10.0 ** (rng.choice([-1, 1]) * rng.choice(POWERS))])
    text = re.sub(NUMBER, lambda found: scaled(found[0], factor), place[0].decode())
    return data[: place.start()] + text.encode() + data[place.end() :]


def scaled(text: str, factor: float) -> str:
    """Return a number times a factor, as an integer where it was one and still can be."""
    value = float(text) * factor
    is_whole = re.fullmatch(r"-?[0-9]+", text) is not None and abs(value) < 1e18
    return repr(round(value)) if is_whole else repr(value)


def renamed_section(rng: random.Random, data: bytes) -> bytes:
    """Give a section another name."""
    names = list(re.finditer(rb"^[a-z_]+(?=:)", data, re.MULTILINE))
    if not names:
        return data
    place = rng.choice(names)
    name = rng.choice(SECTIONS)
    quoted = f"'{name}'" if name.startswith("*") else name
    return data[: place.start()] + quoted.encode() + data[place.end() :]


DAMAGE: tuple[Damage, ...] = (
    damaged_bytes,
    damaged_lines,
    renamed_section,
    *[damaged_values] * 3,
    *[scaled_numbers] * 4,
)


def case(seed: int, number: int) -> bytes:
    """Return the damaged file of a case."""
    rng = random.Random(f"{seed}/{number}")  # noqa: S311 - to be repeatable, not secret
    data = rng.choice(sorted(CONFIG.glob("*.yaml"))).read_bytes()
    for _ in range(rng.randint(1, DAMAGES)):
        data = rng.choice(DAMAGE)(rng, data)
    return data


def limit_of(path: Path) -> float:
    """Return the CPU time [s] that a case may take."""
    return SETS_LIMIT if "vehicle: docking" in path.read_text(errors="replace") else CPU_LIMIT


def examine(path: Path, *, ros: bool) -> tuple[str, float]:
    """Load, check, build and fly a file; return how far it came, and the CPU time before [s].

    Raises
    ------
    AssertionError
        If rclpy reads the file otherwise.
    Exception
        Whatever is a fault.
    """
    begun = time.process_time()
    try:
        scenario = load(path)
    except GncError:
        return "refused when loaded", time.process_time() - begun
    try:
        loop = short(scenario).build()
    except GncError:
        return "refused when built", time.process_time() - begun
    spent = time.process_time() - begun
    if ros:
        compare_with_ros(path)
    try:
        loop.run()
    except GncError:
        return "ended in flight", spent
    return "flew", spent


def short(scenario: Scenario) -> Scenario:
    """Return a scenario cut down to its first steps."""
    flown = STEPS * scenario.period * (1.0 + 1e-9)
    return load(scenario.path, {"plant.duration": min(scenario.plant.duration, flown)})


def compare_with_ros(path: Path) -> None:
    """Require that nodes of rclpy are given what we read."""
    import rclpy
    from rclpy.node import Node

    sections: Sections = {}
    add_file(sections, path)
    ours = plain_values(given_to(sections, node_names()))
    rclpy.init(args=["fuzz", "--ros-args", "--params-file", str(path)])
    try:
        for name in NODE_NAMES:
            node = Node(name, start_parameter_services=False)
            theirs = {key: item.value for key, item in node._parameter_overrides.items()}  # noqa: SLF001
            node.destroy_node()
            for key, value in ours.get(name, {}).items():
                same = list(theirs[key] or []) if isinstance(value, list) else theirs[key]
                assert repr(same) == repr(value), f"{name}.{key}: {value!r}, rclpy {same!r}"  # noqa: S101
    finally:
        rclpy.try_shutdown()


def run(arguments: argparse.Namespace, folder: Path) -> tuple[Counter[str], list[str], float]:
    """Examine all cases; return how they ended, the faults, and the longest CPU time [s]."""
    ends: Counter[str] = Counter()
    faults: list[str] = []
    longest = 0.0
    path = folder / "scenario.yaml"
    for number in range(arguments.first, arguments.first + arguments.cases):
        path.write_bytes(case(arguments.seed, number))
        faulthandler.dump_traceback_later(WALL_LIMIT, exit=True)
        spent = 0.0
        try:
            end, spent = examine(path, ros=arguments.ros)
            ends[end] += 1
        except Exception:  # noqa: BLE001 - it is what is looked for
            faults.append(f"case {number}: {traceback.format_exc()}")
        faulthandler.cancel_dump_traceback_later()
        longest = max(longest, spent)
        if spent > CPU_LIMIT / 2.0:
            print(f" case {number} took {spent:.1f} s", file=sys.stderr)
        if spent > limit_of(path):
            faults.append(f"case {number}: {spent:.1f} s of CPU time")
        print(f"\rcase {number}: {len(faults)} faults", end="", file=sys.stderr)
    print(file=sys.stderr)
    return ends, faults, longest


def main() -> int:
    """Examine, print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--ros", action="store_true")
    arguments = parser.parse_args()
    load(CONFIG / "gupta2015_case1.yaml").build().run()  # loads the kernels, which is no case
    if arguments.ros:  # on a domain and a network device of its own
        prepare(os.environ)
        os.environ[DOMAIN_ID] = str(claim_free({"fuzz": "scenarios"}).domain_id)
    warnings.simplefilter("error")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    with tempfile.TemporaryDirectory() as folder:
        ends, faults, longest = run(arguments, Path(folder))
    for fault in faults:
        print(fault)
    told = ", ".join(f"{count} {end}" for end, count in sorted(ends.items()))
    print(f"{arguments.cases} cases, {len(faults)} faults; longest {longest:.1f} s of CPU; {told}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
