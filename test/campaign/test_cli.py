"""``gnc campaign`` as a user calls it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from short_campaign import SHORT, VARIATIONS

from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.cli import campaign as module
from spacecraft_gnc.cli.main import main

SET = [word for name, value in SHORT.items() for word in ("--set", f"{name}={value}")]


@pytest.fixture
def variations(tmp_path: Path) -> Path:
    path = tmp_path / "variations.yaml"
    path.write_text(VARIATIONS)
    return path


@pytest.fixture
def command(variations: Path, tmp_path: Path) -> list[str]:
    out = str(tmp_path / "out")
    words = ["campaign", "gupta2015_case1", str(variations), "--out", out, *SET]
    return [*words, "--workers", "1", "--keep", "2", "--keep-failed", "3"]


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(argv)
    captured = capsys.readouterr()
    return int(end.value.code or 0), captured.out, captured.err


def test_a_campaign_is_flown_and_the_same_command_again_finds_it_complete(
    command, tmp_path, capsys, monkeypatch
) -> None:
    code, out, err = run(capsys, *command)
    assert (code, err) == (0, "")
    assert out.startswith(f"{tmp_path / 'out'}: 12 runs of ")
    assert max(map(len, out.splitlines()[1:])) <= 80
    found = Campaign.open(tmp_path / "out")
    assert found.is_complete
    assert found.spec.seed == 0
    kept = {path.name for path in found.flights.iterdir()}
    assert {"run-0.npz", "run-1.npz"} <= kept
    monkeypatch.setattr("spacecraft_gnc.campaign.cluster.connected", None)  # nobody is needed
    code, out, err = run(capsys, *command, "--json")
    summary = json.loads(out)
    assert (code, err, summary["done"], summary["folder"]) == (0, "", 12, str(tmp_path / "out"))
    assert {f"run-{kept_run}.npz" for kept_run in summary["kept"]} == kept
    stored = found.summary
    assert {name: summary[name] for name in stored} == stored


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Heed SIGINT, which a shell ignores on behalf of what it starts in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_with_what_is_done_and_says_how_to_go_on(
    command, tmp_path, capsys, monkeypatch
) -> None:
    def interrupt(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(module._Rate, "__call__", interrupt)
    code, out, err = run(capsys, *command)
    done = sum(map(len, Campaign.open(tmp_path / "out").done))
    assert (code, out) == (130, "")
    assert 1 <= done < 12
    assert err == (
        f"interrupted: {done} of 12 runs are in {tmp_path / 'out'}; the same command goes on\n"
    )
    monkeypatch.undo()
    assert run(capsys, *command, "--quiet") == (0, "", "")
    assert Campaign.open(tmp_path / "out").is_complete


def test_a_scheduler_of_somebody_else_is_used(command, tmp_path, capsys) -> None:
    from distributed import LocalCluster

    at = command.index("--workers")
    with LocalCluster(
        n_workers=1, threads_per_worker=2, host="127.0.0.1", dashboard_address="127.0.0.1:0",
        scheduler_kwargs={"dashboard": False},
    ) as cluster:  # fmt: skip
        words = [*command[:at], "--scheduler", cluster.scheduler_address, *command[at + 2 :]]
        assert run(capsys, *words, "--quiet") == (0, "", "")
    assert Campaign.open(tmp_path / "out").is_complete


def refused(capsys, *argv: str) -> str:
    """Return the one line in which a command is refused."""
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    return err.removeprefix("error: ").rstrip("\n")


def test_bad_input_is_one_line(command, variations, tmp_path, capsys) -> None:
    assert refused(capsys, *command, "--runs", "0").startswith(
        "--runs: received 0; required a whole number, "
    )
    assert refused(capsys, *command, "--seed", "-1").startswith("--seed: received -1; required")
    assert refused(capsys, *command, "--workers", "0").startswith("--workers: received 0; requi")
    assert refused(capsys, *command, "--scheduler", "tcp://127.0.0.1:9").startswith(
        "--workers: received beside --scheduler; required one of them"
    )
    assert refused(capsys, *command, "--set", "plant.nope=1").startswith("--set: plant.nope: ")
    assert "did you mean 'max_torque'?" in (
        variations.write_text(VARIATIONS.replace("max_torque <", "max_torqe <"))
        and refused(capsys, *command)
    )
    assert not (tmp_path / "out").exists(), "a folder is made for what can be flown"
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").touch()
    variations.write_text(VARIATIONS)
    assert "which holds other files; required a new folder" in refused(capsys, *command)


def test_the_folder_of_another_campaign_is_refused(command, variations, capsys, tmp_path) -> None:
    assert run(capsys, *command, "--quiet")[0] == 0
    for change, told in (
        (["--seed", "3"], "(seed 0 instead of 3)"),
        (["--runs", "13"], "(runs 12 instead of 13)"),
        (["--set", "plant.time_step=0.2"], "(plant.time_step 0.4 instead of 0.2)"),
    ):
        assert told in refused(capsys, *command, *change)
    variations.write_text(VARIATIONS + "# another text\n")
    assert "(other variations)" in refused(capsys, *command)
    about = json.loads((tmp_path / "out" / "campaign.json").read_text())
    about["package_version"] = "9.9.9"
    (tmp_path / "out" / "campaign.json").write_text(json.dumps(about))
    variations.write_text(VARIATIONS)
    assert "(package_version 9.9.9 instead of " in refused(capsys, *command)


def test_a_worker_of_another_version_is_refused(command, tmp_path, capsys) -> None:
    """A real worker process, in which the package has another version."""
    from distributed import LocalCluster

    preload = tmp_path / "other_version.py"
    preload.write_text("import spacecraft_gnc\nspacecraft_gnc.__version__ = '9.9.9'\n")
    at = command.index("--workers")
    with LocalCluster(
        n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0",
        scheduler_kwargs={"dashboard": False},
    ) as cluster:  # fmt: skip
        worker = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address,
             "--preload", str(preload), "--nthreads", "1", "--no-dashboard"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        )  # fmt: skip
        try:
            words = [*command[:at], "--scheduler", cluster.scheduler_address]
            told = refused(capsys, *words)
        finally:
            worker.terminate()
            worker.wait()
    assert told.startswith("worker: received package_version 9.9.9; required package_version 0.")


def test_what_needs_an_extra_says_so(command, capsys, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'spacecraft_gnc[campaign]'" in refused(capsys, *command)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_of_a_terminal_ends_every_process_in_order(variations, tmp_path) -> None:
    """A terminal sends the signal to the workers as well."""
    words = ["campaign", "gupta2015_case1", str(variations), "--runs", "100000", "--workers", "2"]
    command = subprocess.Popen(
        [sys.executable, "-m", "spacecraft_gnc", *words, "--out", str(tmp_path / "out"), *SET],
        stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    assert command.stderr is not None
    first = command.stderr.readline()
    assert re.fullmatch(r"(\S+/s, )?\d+ passed, \d+ failed(, \S+ left)?: \d+ of 100000\n", first)
    os.killpg(command.pid, signal.SIGINT)
    last = command.communicate()[1].splitlines()[-1]
    assert command.returncode == 130
    done = sum(map(len, Campaign.open(tmp_path / "out").done))
    assert last == (
        f"interrupted: {done} of 100000 runs are in {tmp_path / 'out'}; the same command goes on"
    )


def test_who_finds_no_scheduler_leaves_no_folder(variations, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("spacecraft_gnc.campaign.cluster._CONNECTING", 0.5)
    words = ["campaign", "gupta2015_case1", str(variations), "--out", str(tmp_path / "out"), *SET]
    code, out, err = run(capsys, *words, "--scheduler", "tcp://127.0.0.1:9")
    assert (code, out) == (2, "")
    assert err.startswith("error: --scheduler: received 'tcp://127.0.0.1:9', which does not answer")
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "out").exists()
