"""Blocks of runs on real workers: every run comes back once, whatever happens to a worker."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import campaign_tasks
import dask
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.campaign.cluster import connected
from spacecraft_gnc.campaign.engine import BlockSize, Engine
from spacecraft_gnc.errors import ParameterError


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    import distributed  # noqa: F401 - its defaults first, which the setting would replace

    one_death_is_enough = {"distributed.scheduler.allowed-failures": 0}
    with dask.config.set(one_death_is_enough), connected(workers=2) as client:
        yield client


def test_every_run_comes_back_once(client, spec) -> None:
    engine = Engine(client)
    assert engine.threads() == 2
    blocks = list(engine.map(campaign_tasks.runs_and_process, spec, [range(3), range(7, 30)]))
    assert sorted(run for block in blocks for run in block.runs) == [*range(3), *range(7, 30)]
    assert all(block.result[0] == list(block.runs) for block in blocks)
    assert len({block.result[1] for block in blocks}) == 2, "both workers fly"


def test_a_worker_does_not_keep_profiles_of_itself(client) -> None:
    """They would grow by 0.1 MB a second, for an hour."""
    told = client.run(campaign_tasks.periodic_callbacks)
    assert len(told) == 2
    assert all("heartbeat" in names for names in told.values())
    assert not [name for names in told.values() for name in names if "profile" in name]


def test_nothing_to_fly(client, spec) -> None:
    assert list(Engine(client).map(campaign_tasks.runs_and_process, spec, [])) == []


def test_a_run_that_ends_every_worker_is_found(client, spec) -> None:
    size = BlockSize()
    size.learn(0.1)
    size.next(1000, 1)
    blocks = list(Engine(client).map(campaign_tasks.deadly_for_run_5, spec, [range(8)], size))
    assert sorted(run for block in blocks for run in block.runs) == list(range(8))
    (dead,) = [block for block in blocks if block.result is None]
    assert dead.runs == range(5, 6)


def test_what_a_worker_refuses_is_raised(client, spec) -> None:
    with pytest.raises(ParameterError, match="worker: received another version"):
        list(Engine(client).map(campaign_tasks.refused, spec, [range(4)]))
    with pytest.raises(ZeroDivisionError, match="ours"):
        list(Engine(client).map(campaign_tasks.defective, spec, [range(4)]))


def test_a_map_that_is_given_up_leaves_nothing_behind(client, spec) -> None:
    engine = Engine(client)
    blocks = engine.map(campaign_tasks.runs_and_process, spec, [range(100)])
    next(blocks)
    blocks.close()
    again = engine.map(campaign_tasks.runs_and_process, spec, [range(200, 210)])
    assert sorted(run for block in again for run in block.runs) == list(range(200, 210))


@given(st.integers(1, 10**6), st.integers(1, 64), st.floats(1e-6, 100.0), st.integers(1, 2000))
def test_blocks_last_a_second_and_end_together(left, threads, seconds, largest) -> None:
    size = BlockSize(largest)
    assert size.next(left, threads) == 1, "its time is not known"
    size.learn(seconds)
    sizes = [size.next(left, threads) for _ in range(8)]
    assert all(b <= 4 * a for a, b in zip([1, *sizes], sizes, strict=False))
    assert max(sizes) <= max(1, round(1.0 / seconds), 1)
    assert max(sizes) <= largest
    assert max(sizes) <= -(-left // (2 * threads))
    assert sizes[-1] == max(1, min(round(1.0 / seconds), largest, -(-left // (2 * threads))))


def test_a_scheduler_that_does_not_answer_is_refused(monkeypatch) -> None:
    monkeypatch.setattr("spacecraft_gnc.campaign.cluster._CONNECTING", 0.5)
    told = r"^--scheduler: received 'tcp://127\.0\.0\.1:9', which does not answer within 0\.5 s"
    with pytest.raises(ParameterError, match=told), connected(scheduler="tcp://127.0.0.1:9"):
        pass


def test_a_scheduler_without_workers_is_refused(monkeypatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr("spacecraft_gnc.campaign.cluster._GATHERING", 0.5)
    with (
        LocalCluster(
            n_workers=0,
            processes=False,
            host="127.0.0.1",
            protocol="tcp",
            scheduler_kwargs={"dashboard": False},
            dashboard_address="127.0.0.1:0",
        ) as cluster,
        pytest.raises(ParameterError, match="which has no worker within"),
        connected(scheduler=cluster.scheduler_address),
    ):
        pass
