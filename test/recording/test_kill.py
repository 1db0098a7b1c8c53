"""SIGKILL at any moment costs at most the last second of a recording."""

from __future__ import annotations

import os
import random
import signal
import struct
import subprocess
import sys
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from recording.bags import CODEC
from rosbags.highlevel import AnyReader

from spacecraft_gnc.recording.rebuild import rebuild

SOURCE = Path(__file__).parents[2]
KILLS = 20
AT_ONCE = 4
RATE = 500.0  # [messages/s] of each of two topics
STRING = "std_msgs/msg/String"
STATE = "spacecraft_gnc_msgs/msg/AttitudeState"
HEAD = struct.Struct("<IQ")  # length, stamp [ns]
# The recorder's two ways to the file: a message arrives, and a timer flushes.
RECORDER = """
import os, select, struct, sys, time
from spacecraft_gnc.recording.writer import FLUSH_PERIOD, BagWriter
folder, state_text = sys.argv[1:]
bag = BagWriter(folder)
bag.add_topic("/words", "std_msgs/msg/String", "string data")
bag.add_topic("/attitude_state", "spacecraft_gnc_msgs/msg/AttitudeState", state_text)
head, pending, due = struct.Struct("<IQ"), b"", time.monotonic() + FLUSH_PERIOD
print("ready", flush=True)
while True:
    if select.select([0], [], [], max(0.0, due - time.monotonic()))[0]:
        pending += os.read(0, 1 << 16) or sys.exit("the sender went away")
    while len(pending) >= head.size:
        length, stamp = head.unpack_from(pending)
        end = head.size + length
        if len(pending) < end:
            break
        topic = "/words" if pending[head.size] else "/attitude_state"
        bag.write(topic, stamp, stamp, pending[head.size + 1 : end])
        pending = pending[end:]
    if time.monotonic() >= due:
        bag.flush()
        due = time.monotonic() + FLUSH_PERIOD
"""


def record_until_killed(folder, seed):
    """Feed a recorder, kill it at a random moment; return what was sent more than 1 s before."""
    chance = random.Random(seed)
    moment = chance.uniform(1.1, 3.0)  # something is older than a second
    code = [sys.executable, "-c", RECORDER, str(folder), CODEC.texts[STATE]]
    environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
    with subprocess.Popen(
        code, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
    ) as recorder:
        recorder.stdout.readline()
        sent = send(recorder.stdin, chance, moment)
        killed = time.monotonic()
        os.kill(recorder.pid, signal.SIGKILL)
    assert recorder.returncode == -signal.SIGKILL
    assert not (folder / "metadata.yaml").exists()
    found = defaultdict(list)
    for at, topic, data in sent:
        found[topic].append((at < killed - 1.0, data))
    return found


def send(pipe, chance, moment):
    """Write numbered messages at `RATE` into a pipe; return (time, topic, data) of each."""
    sent = []
    begun = time.monotonic()
    step = 0
    while (now := time.monotonic() - begun) < moment:
        for number in range(step, int(now * RATE)):
            filler = chance.randbytes(chance.randrange(300)).hex()
            words = f"{number} {filler}".encode() + b"\0"
            words = b"\0\1\0\0" + struct.pack("<I", len(words)) + words
            state = CODEC.state(number, np.eye(3), np.zeros(3))
            for kind, topic, data in ((1, "/words", words), (0, "/attitude_state", state)):
                stamp = int(now * 1e9)
                pipe.write(HEAD.pack(len(data) + 1, stamp) + bytes([kind]) + data)
                sent.append((time.monotonic(), topic, data))
            step = number + 1
        time.sleep(1e-3)
    return sent


def check_one(folder, seed):
    """Return (seed, messages owed, messages saved) of one kill."""
    sent = record_until_killed(folder, seed)
    owed = sum(old for messages in sent.values() for old, _ in messages)
    bag = rebuild(folder).folder
    saved = defaultdict(list)
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            saved[connection.topic].append(bytes(data))
    for topic, messages in sent.items():
        found = saved[topic]
        assert found == [data for _, data in messages[: len(found)]], f"seed {seed}: {topic}"
        lost = [data for old, data in messages[len(found) :] if old]
        assert not lost, f"seed {seed}: {topic} lacks {len(lost)} messages older than 1 s"
    return seed, owed, sum(map(len, saved.values()))


def test_twenty_kills_cost_no_message_older_than_a_second(tmp_path):
    with ThreadPoolExecutor(AT_ONCE) as pool:
        folders = [tmp_path / f"bag{seed}" for seed in range(KILLS)]
        results = list(pool.map(check_one, folders, range(KILLS)))
    assert len(results) == KILLS
    assert all(saved >= owed > 0 for _, owed, saved in results)
