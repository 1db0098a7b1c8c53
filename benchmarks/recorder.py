"""How many messages a second the recorder takes without losing one.

`.venv/bin/python benchmarks/recorder.py [RATE ...] [--seconds S] [--json]` starts the real recorder
node as a process, PUBLISHERS processes that send numbered messages of SIZE bytes on TOPICS topics
each, over DDS, at each RATE [messages/s, all together], and reads the bag back: what was sent and
is not in it is lost. "said" is what the bag itself tells of losses. The recorder's memory and
processor time (100 % is one core) are sampled meanwhile; "load" is that of the whole machine.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import psutil

from spacecraft_gnc.launcher import domain
from spacecraft_gnc.launcher.environment import for_node
from spacecraft_gnc.recording.bag import open_bag

RATES = (1000, 2000, 5000, 7500, 10000)  # [messages/s]
SIZE = 200  # [bytes] serialized
PUBLISHERS = 2  # processes
TOPICS = 5  # a process
_NUMBERED = struct.Struct("<Qd")  # count from 0, wall time of sending [s]
_HEAD = struct.Struct("<4sIII")  # encapsulation, no dimensions, offset 0, length of the data
_SAMPLE = 0.1  # [s] wall between two looks at the memory
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the time of sending, at which the memory is quoted
_TICK = 1e-3  # [s] wall between two looks at the clock
_PATIENCE = 60.0  # [s] wall


def main() -> int:
    """Sweep the rates, print a table; return 1 where a message was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rates", nargs="*", type=float, default=RATES, metavar="RATE")
    parser.add_argument("--seconds", type=float, default=10.0, help="of sending, at each rate")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--publish", help=argparse.SUPPRESS)  # a process of ours
    options = parser.parse_args()
    if options.publish:
        return publish(**json.loads(options.publish))
    results = []
    if not options.json:
        print(_TITLE)
    for rate in options.rates:
        results.append(measure(rate, options.seconds))
        if not options.json:
            print(_line(results[-1]), flush=True)
    if options.json:
        print(json.dumps(results, indent=2))
    return int(any(result["lost"] for result in results))


_TITLE = (
    f"{'asked':>7} {'sent/s':>7} {'sent':>8} {'lost':>7} {'said':>7} {'CPU':>5} "
    f"{'memory at 0, 25, 50, 75, 100 % [MB]':>36} {'load':>6}"
)


def _line(r: dict[str, Any]) -> str:
    memory = " ".join(f"{value:.1f}" for value in r["memory"])
    return (
        f"{r['rate']:>7.0f} {r['sent_per_second']:>7.0f} {r['sent']:>8} {r['lost']:>7} "
        f"{r['lost_said']:>7} {100 * r['processor']:>4.0f}% {memory:>36} {r['load']:>6.1f}"
    )


def measure(rate: float, seconds: float) -> dict[str, Any]:
    """Record for a while at one rate."""
    names = [[f"/bench/p{p}/t{t}" for t in range(TOPICS)] for p in range(PUBLISHERS)]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="gnc_bench_")))
        lock = domain.claim_free({"benchmark": "recorder"})
        stack.callback(lock.release)
        environment = for_node(os.environ, lock.domain_id)
        environment.pop("SPACECRAFT_GNC_SUPERVISED")
        recorder = stack.enter_context(
            _recorder(folder, [name for group in names for name in group], environment)
        )
        job = {"rate": rate / PUBLISHERS, "seconds": seconds}
        children = [
            stack.enter_context(_child(environment, {**job, "names": group})) for group in names
        ]
        samples, processor = _watch(recorder, children, seconds)
        reports = [json.loads(child.stdout.read()) for child in children]
        recorder.send_signal(signal.SIGTERM)
        recorder.wait(_PATIENCE)
        found, lost_said = _count(folder / "bag")
        if recorder.returncode:
            print((folder / "recorder.log").read_text(), file=sys.stderr)
    sent = {name: count for report in reports for name, count in report["sent"].items()}
    duration = max(report["seconds"] for report in reports)
    memory = [samples[int(share * (len(samples) - 1))] / 1e6 for share in _SHARES]
    return {
        "rate": rate,
        "sent": sum(sent.values()),
        "sent_per_second": sum(sent.values()) / duration,
        "lost": sum(count - found.get(name, 0) for name, count in sent.items()),
        "lost_said": lost_said,
        "memory": memory,
        "processor": processor,
        "load": os.getloadavg()[0],
    }


@contextmanager
def _recorder(folder: Path, topics: list[str], environment: dict[str, str]) -> Iterator[Any]:
    parameters = folder / "parameters.yaml"
    listed = ", ".join(f'"{name}"' for name in topics)
    parameters.write_text(
        f"recorder:\n  ros__parameters:\n    topics: [{listed}]\n"
        f'    storage_folder: "{folder / "bag"}"\n    compression: zstd\n'
    )
    command = [sys.executable, "-m", "spacecraft_gnc.nodes.recorder"]
    command += ["--ros-args", "--params-file", str(parameters)]
    with (folder / "recorder.log").open("w") as log:
        process = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
        try:
            yield process
        finally:
            process.kill()
            process.wait()


@contextmanager
def _child(environment: dict[str, str], job: dict[str, Any]) -> Iterator[Any]:
    command = [sys.executable, __file__, "--publish", json.dumps(job)]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _watch(recorder: Any, children: list[Any], seconds: float) -> tuple[list[float], float]:
    """Sample the recorder's memory while the publishers send; return it and its processor share."""
    for child in children:
        child.stdout.readline()  # it begins to send
    process = psutil.Process(recorder.pid)
    begun, used = time.monotonic(), sum(process.cpu_times()[:2])
    samples: list[float] = []
    while any(child.poll() is None for child in children):
        if time.monotonic() > begun + seconds + _PATIENCE or recorder.poll() is not None:
            raise SystemExit("error: the recorder or a publisher did not end as it should")
        samples.append(process.memory_info().rss)
        time.sleep(_SAMPLE)
    spent = sum(process.cpu_times()[:2]) - used
    return samples, spent / (time.monotonic() - begun)


def _count(bag: Path) -> tuple[dict[str, int], int]:
    """Return the messages in a bag by topic, whose numbers must ascend; and the losses it tells."""
    found: dict[str, int] = defaultdict(int)
    last: dict[str, int] = defaultdict(lambda: -1)
    with open_bag(bag) as opened:
        for topic, data in opened.messages(opened.topics):
            number = _NUMBERED.unpack_from(data, _HEAD.size)[0]
            if number <= last[topic]:
                raise SystemExit(f"error: {topic}: number {number} after {last[topic]}")
            last[topic] = number
            found[topic] += 1
        losses = opened.metadata()["losses"]
    return found, sum(map(int, losses.values()))


def publish(names: list[str], rate: float, seconds: float) -> int:
    """Send numbered messages on the topics in turn; say what was sent."""
    import rclpy
    from rclpy.duration import Duration
    from rclpy.node import Node
    from rclpy.qos import QoSProfile
    from std_msgs.msg import UInt8MultiArray

    rclpy.init(args=[])
    node = Node(f"sender_{os.getpid()}", start_parameter_services=False)
    publishers = [
        node.create_publisher(UInt8MultiArray, name, QoSProfile(depth=1000)) for name in names
    ]
    while any(publisher.get_subscription_count() < 1 for publisher in publishers):
        time.sleep(0.05)
    # as CDR: encapsulation, no dimensions, offset 0, and the bytes
    head = _HEAD.pack(b"\0\1\0\0", 0, 0, SIZE - _HEAD.size)
    filler = os.urandom(SIZE - _HEAD.size - _NUMBERED.size)
    counts = [0] * len(names)
    print("begun", flush=True)
    begun = time.perf_counter()
    sent, total = 0, round(rate * seconds)
    while sent < total:
        due = min(total, int((time.perf_counter() - begun) * rate))
        for number in range(sent, due):
            index = number % len(names)
            body = _NUMBERED.pack(counts[index], time.time())
            publishers[index].publish(head + body + filler)
            counts[index] += 1
        sent = max(sent, due)
        time.sleep(_TICK)
    duration = time.perf_counter() - begun
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=10))
    print(json.dumps({"sent": dict(zip(names, counts, strict=True)), "seconds": duration}))
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
