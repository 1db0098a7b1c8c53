"""``gnc inspect params``: the parameters of a live node."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import JsonOption, print_json, print_table
from spacecraft_gnc.cli._domain import DomainOption, choose_domain
from spacecraft_gnc.cli._help import App, Group
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.ros.remote import ParameterInfo

NodeArgument = Annotated[str, typer.Argument(metavar="NODE", help="Name, e.g. plant.")]
NameArgument = Annotated[str, typer.Argument(metavar="NAME", help="Parameter, e.g. max_torque.")]
_COMMANDS = ("list", "get", "set")


class _ListByDefault(Group):
    """``params NODE`` means ``params list NODE``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put ``list`` in front where no command is named."""
        if args and args[0] not in (*_COMMANDS, *ctx.help_option_names):
            args = ["list", *args]
        return list(super().parse_args(ctx, args))


params = App(
    cls=_ListByDefault,
    help="List, get or set the parameters of a node; params NODE means params list NODE.",
    no_args_is_help=True,
)


@params.command("list")
def list_(node: NodeArgument, domain_id: DomainOption = None, as_json: JsonOption = False) -> None:
    """List a node's parameters with their values."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.remote import RemoteParameters

    with GraphView(choose_domain(domain_id)) as view:
        remote = RemoteParameters(view, view.find_node(node))
        values = remote.values(remote.names())
    if as_json:
        print_json({"node": remote.name, "parameters": values})
    else:
        print_table((name, _text(value)) for name, value in values.items())


@params.command()
def get(
    node: NodeArgument,
    name: NameArgument,
    domain_id: DomainOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show one parameter: value, description, whether it may change."""
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.remote import RemoteParameters

    with GraphView(choose_domain(domain_id)) as view:
        remote = RemoteParameters(view, view.find_node(node))
        info = remote.get(name)
    if as_json:
        print_json({"node": remote.name, **info._asdict()})
    else:
        print(_text(info.value) + _about(info))


@params.command("set", context_settings={"ignore_unknown_options": True})
def set_(
    node: NodeArgument,
    name: NameArgument,
    value: Annotated[
        str, typer.Argument(metavar="VALUE", help="As YAML, e.g. 0.01 or [1.0, 2.0].")
    ],
    domain_id: DomainOption = None,
    as_json: JsonOption = False,
) -> None:
    """Set a parameter; the node may refuse, and says why."""
    from spacecraft_gnc.parameters.yaml_file import parse_value
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.remote import RemoteParameters

    try:
        wanted = parse_value(value)
    except ValueError as error:
        raise ParameterError(f"{name}: received {value!r}; required {error}") from error
    if isinstance(wanted, dict):
        raise ParameterError(f"{name}: received {value!r}; required one value; set each by itself")
    with GraphView(choose_domain(domain_id)) as view:
        remote = RemoteParameters(view, view.find_node(node))
        now = remote.set(name, wanted)
    if as_json:
        print_json({"node": remote.name, "name": name, "value": now})
    else:
        print(f"{remote.name} {name}: {_text(now)}")


def _about(info: ParameterInfo) -> str:
    fixed = ["read-only"] if info.read_only else []
    notes = [note for note in (info.description, *fixed) if note]
    return f"  ({', '.join(notes)})" if notes else ""


def _text(value: Any) -> str:
    if value is None:
        return "not set"
    return str(value).lower() if isinstance(value, bool) else repr(value)
