"""``gnc recover``: a readable bag out of one that a crash cut off."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import JsonOption, QuietOption, print_json, print_table
from spacecraft_gnc.cli._progress import show_progress

if TYPE_CHECKING:
    from spacecraft_gnc.recording.rebuild import Rebuilt

BagArgument = Annotated[
    Path,
    typer.Argument(
        metavar="BAG", readable=False, help="Bag folder or .mcap file that was cut off."
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="DIR", help="New bag [BAG-recovered]."),
]


def recover(
    bag: BagArgument,
    out: OutOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Save what is whole of a bag that was cut off into a new bag; tell what is missing.

    A bag that is whole is refused (exit code 2), so that a script never looks for a copy that was
    not made.
    """
    from spacecraft_gnc.recording.rebuild import rebuild

    with show_progress("recovering [bytes]", silent=quiet or as_json) as progress:
        rebuilt = rebuild(bag, out, progress)
    if as_json:
        print_json(
            {
                "bag": bag,
                "out": rebuilt.folder,
                "messages": rebuilt.messages,
                "topics": rebuilt.topics,
                "last_whole_step": rebuilt.last_whole_step,
                "last_stamp": rebuilt.last_stamp,
                "missing_steps": rebuilt.missing_steps,
                "cut_bytes": rebuilt.cut_bytes,
                "damaged_chunks": rebuilt.damaged_chunks,
                "orphans": rebuilt.orphans,
            }
        )
    elif not quiet:
        print(f"{bag}: {rebuilt.messages} messages recovered into {rebuilt.folder}")
        print_table(_rows(rebuilt))


def _rows(rebuilt: Rebuilt) -> list[tuple[str, str]]:
    rows = [(name, str(count)) for name, count in rebuilt.topics.items() if count]
    if rebuilt.last_whole_step is not None:
        rows.append(("last whole step", str(rebuilt.last_whole_step)))
    rows.append(("recorded until", f"{rebuilt.last_stamp:g} s"))
    return [*rows, *_losses(rebuilt)]


def _losses(rebuilt: Rebuilt) -> list[tuple[str, str]]:
    """Return the known losses; messages that never reached the file cannot be counted."""
    rows = [(f"{name} lacks", f"{count} steps") for name, count in rebuilt.missing_steps.items()]
    if rebuilt.damaged_chunks:
        rows.append(("damaged chunks", f"{rebuilt.damaged_chunks}, left out"))
    if rebuilt.orphans:
        rows.append(("without a topic", f"{rebuilt.orphans} messages, left out"))
    if rebuilt.cut_bytes:
        rows.append(("cut off", f"{rebuilt.cut_bytes} bytes of an unfinished record"))
    return [
        *rows,
        ("not in the file", "what the recorder had not written: its last second at most"),
    ]
