"""The page's server: what it answers, and to whom it does not."""

from __future__ import annotations

import json
import socket

import pytest
from live.watching import EventReader, Stage, request

from spacecraft_gnc.analysis.live.hosts import host_is_ours, url_host
from spacecraft_gnc.analysis.live.server import PageServer, PortTaken

JSON = "application/json"


@pytest.fixture
def stage():
    return Stage()


@pytest.fixture
def server(stage):
    with PageServer(stage.feed, port=None) as server:
        yield server


@pytest.mark.parametrize(
    "path", ["/", "/view.js", "/scene.js", "/charts.js", "/status.js", "/view.css"]
)
def test_the_page_needs_nothing_from_elsewhere(server, path) -> None:
    status, headers, text = request(server, path)
    assert status == 200
    assert "://" not in text
    assert "script-src 'self'" in headers["Content-Security-Policy"]
    assert not [name for name in headers if name.lower().startswith("access-control")]


@pytest.mark.parametrize(
    "path",
    ["/nothing", "/page/index.html", "/../server.py", "/view.js/", "/etc/passwd"],
)
def test_no_other_file_is_served(server, path) -> None:
    assert request(server, path)[0] == 404


def test_events_reach_every_watcher(server, stage) -> None:
    readers = [EventReader(server.port) for _ in range(2)]
    stage.tick()
    for reader in readers:
        names = [next(reader)[0] for _ in range(3)]
        assert names == ["setup", "history", "frame"]
        reader.close()


def test_the_page_can_pause_and_seek(server, stage) -> None:
    for command in ({"action": "pause"}, {"action": "seek", "value": 30}):
        body = json.dumps(command)
        assert request(server, "/control", "POST", body, Content_Type=JSON)[0] == 200
    assert stage.flight.transport.paused
    assert stage.flight.transport.time() == 30.0


@pytest.mark.parametrize(
    "body",
    [
        *("", "{", "[]", "{}", '"pause"', "x" * 1024),
        *('{"action": "stop"}', '{"action": "seek"}', '{"action": "seek", "value": "a"}'),
        *('{"action": "seek", "value": NaN}', '{"action": "seek", "value": [1]}'),
        '{"action": "rate", "value": -1}',
    ],
)
def test_what_is_no_command_is_refused(server, stage, body) -> None:
    status, _, text = request(server, "/control", "POST", body, Content_Type=JSON)
    assert (status, len(text.splitlines())) == (400, 1)
    assert stage.flight.transport.time() == 0.0


@pytest.mark.parametrize("path", ["/", "/events", "/view.js", "/control"])
def test_another_name_for_this_machine_is_refused(server, path) -> None:
    # DNS rebinding: a page elsewhere makes its own name point at 127.0.0.1.
    method = "POST" if path == "/control" else "GET"
    body = '{"action": "pause"}' if method == "POST" else None
    headers = {"Content_Type": JSON, "Host": f"evil.example:{server.port}"}
    assert request(server, path, method, body, **headers)[0] == 421


@pytest.mark.parametrize(
    "headers",
    [
        {"Content_Type": "text/plain"},  # what another site may send without asking
        {"Content_Type": "application/x-www-form-urlencoded"},
        {"Content_Type": JSON, "Origin": "http://evil.example"},
        {"Content_Type": JSON, "Origin": "null"},
        {},
    ],
)
def test_a_command_of_another_site_is_refused(server, stage, headers) -> None:
    assert request(server, "/control", "POST", '{"action": "pause"}', **headers)[0] == 403
    assert not stage.flight.transport.paused


def test_a_browser_gets_no_leave_to_send_commands_from_elsewhere(server) -> None:
    status, headers, _ = request(server, "/control", "OPTIONS", Origin="http://evil.example")
    assert status == 501
    assert not [name for name in headers if name.lower().startswith("access-control")]


@pytest.mark.parametrize(
    ("header", "bound", "ours"),
    [
        ("127.0.0.1:8760", "127.0.0.1", True),
        ("localhost:8760", "127.0.0.1", True),
        ("[::1]:8760", "::1", True),
        ("LOCALHOST", "127.0.0.1", True),
        ("192.0.2.7:8760", "127.0.0.1", False),
        ("192.0.2.7:8760", "0.0.0.0", True),
        ("evil.example", "0.0.0.0", False),
        ("localhost.evil.example", "127.0.0.1", False),
        ("127.0.0.1.evil.example", "0.0.0.0", False),
        ("[", "127.0.0.1", False),
        ("", "127.0.0.1", False),
        (None, "127.0.0.1", False),
    ],
)
def test_whose_name_a_host_header_is(header, bound, ours) -> None:
    assert host_is_ours(header, bound) is ours


def reachable(address, port) -> bool:
    with socket.socket() as client:
        return client.connect_ex((address, port)) == 0


def test_only_the_address_asked_for_is_reached(stage, server) -> None:
    # All of 127/8 is this machine: another address of it stands for another interface.
    assert reachable("127.0.0.1", server.port)
    assert not reachable("127.0.0.2", server.port)
    with PageServer(stage.feed, "0.0.0.0", None) as everywhere:
        assert reachable("127.0.0.2", everywhere.port)


def test_a_port_that_is_taken_is_refused_by_name(stage, server) -> None:
    with pytest.raises(PortTaken, match=f"received {server.port}, where another process listens"):
        PageServer(stage.feed, port=server.port)


def test_without_a_wish_a_free_port_is_found(stage, server) -> None:
    with PageServer(stage.feed, port=None) as other:
        assert other.port != server.port


def test_an_address_of_another_machine_is_refused(stage) -> None:
    with pytest.raises(PortTaken, match=r"--host: received '192\.0\.2\.7'"):
        PageServer(stage.feed, "192.0.2.7", None)


@pytest.mark.parametrize(
    ("host", "url"),
    [("127.0.0.1", "127.0.0.1"), ("0.0.0.0", "127.0.0.1"), ("::1", "[::1]"), ("::", "[::1]")],
)
def test_the_url_can_be_opened_here(host, url) -> None:
    assert url_host(host) == url


def test_too_many_watchers_are_turned_away(server, stage, monkeypatch) -> None:
    readers = [EventReader(server.port) for _ in range(32)]
    assert request(server, "/events")[0] == 503
    for reader in readers:
        reader.close()
