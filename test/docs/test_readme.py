"""README: its commands are accepted as written, those without ROS run, its links lead somewhere."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import typer

from spacecraft_gnc.cli.main import app, main
from spacecraft_gnc.scenario import load_fleet

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
_BLOCKS = re.findall(r"^```bash\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
_INLINE = re.findall(r"<br>`(gnc [^`\n]+)`", TEXT)
COMMANDS = [
    shlex.split(line, comments=True)[1:]
    for line in [*"".join(_BLOCKS).splitlines(), *_INLINE]
    if line.startswith("gnc ")
]
# What needs neither a graph nor half a minute, in the order in which README has it.
RUN = [words for words in COMMANDS if words[0] in {"check", "simulate"} or "--animate" in words]
RUN_WITHOUT_BAG = [words for words in RUN if "runs/case2" not in words]


def test_the_commands_were_found():
    assert len(COMMANDS) > 25
    assert len(RUN_WITHOUT_BAG) >= 5


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command_is_accepted(words):
    command = typer.main.get_command(app)
    context = command.make_context("gnc", list(words))
    while isinstance(command, typer.core.TyperGroup):  # `gnc`, `gnc inspect`
        arguments = [*context._protected_args, *context.args]
        name, command, rest = command.resolve_command(context, arguments)
        context = command.make_context(name, rest, parent=context)
        command = context.command  # `gnc campaign` flies where no further command is named


@pytest.mark.parametrize(
    "words", [words for words in COMMANDS if any("config/" in word for word in words)], ids=" ".join
)
def test_its_scenario_flies_with_its_overrides(words):
    scenarios = [word for word in words if word.startswith("config/")]
    overrides = [words[i + 1] for i, word in enumerate(words) if word == "--set"]
    for scenario in scenarios:
        load_fleet(ROOT / scenario, overrides)


def test_what_needs_no_graph_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "config").symlink_to(ROOT / "config")
    (tmp_path / "runs").mkdir()
    monkeypatch.chdir(tmp_path)
    for words in RUN_WITHOUT_BAG:
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert not ended.value.code, f"gnc {' '.join(words)}: {capsys.readouterr().err}"
    assert (tmp_path / "runs" / "sun_moon.gif").stat().st_size > 100_000


def test_the_ten_lines_print_what_they_say(capsys):
    (lines,) = re.findall(r"^```python\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
    exec(compile(lines, "README.md", "exec"), {})
    assert lines.rstrip().endswith(f"# {capsys.readouterr().out[:6]}...")


def test_links_and_pictures_are_there():
    targets = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)|src=\"([^\"]+)\"", TEXT)
    local = {a or b for a, b in targets if not (a or b).startswith("http")}
    assert len(local) > 15
    assert not [name for name in sorted(local) if not (ROOT / name).exists()]
