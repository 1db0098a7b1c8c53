"""The page's server under a hostile client: it answers with one line, and serves its page on."""

from __future__ import annotations

import json
import socket
from contextlib import ExitStack

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.watching import PATIENCE, EventReader, Stage, request

from spacecraft_gnc.analysis.live.bounded import MOST_BYTES, MOST_CONNECTIONS
from spacecraft_gnc.analysis.live.server import PageServer

JSON = "application/json"
TYPED = b"Content-Type: application/json\r\nContent-Length: 20\r\n"
SOON = 0.2  # [s] wall that a client has for its request here


@pytest.fixture(scope="module")
def stage():
    return Stage()


@pytest.fixture(scope="module")
def server(stage):
    """A server that is patient, so that nothing here depends on the load of the machine."""
    with PageServer(stage.feed, port=None, patience=PATIENCE) as server:
        yield server


@pytest.fixture
def hasty(stage):
    with PageServer(Stage().feed, port=None, patience=SOON) as server:
        yield server


def connect(server):
    return socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE)


def answer(client):
    """Return status and body, once the server has closed the connection."""
    received = b""
    while chunk := client.recv(65536):
        received += chunk
    head, _, body = received.partition(b"\r\n\r\n")
    return int(head.split(b" ")[1]), body.decode()


def sent(server, data):
    """Return the answer to some bytes."""
    with connect(server) as client:
        client.sendall(data)
        client.shutdown(socket.SHUT_WR)
        return answer(client)


def is_one_line(text):
    return text.endswith("\n") and len(text.splitlines()) == 1


def post(server, body, **headers):
    return request(server, "/control", "POST", body, Content_Type=JSON, **headers)


def test_connections_beyond_the_bound_are_turned_away_and_free_their_places(server):
    with ExitStack() as stack:
        idle = [stack.enter_context(connect(server)) for _ in range(MOST_CONNECTIONS)]
        # The last of them is accepted once one beyond is turned away: they wait in one queue.
        for _ in range(3):
            with connect(server) as late:
                assert answer(late) == (503, "too many connections\n")
        idle[0].sendall(b"GET /nothing HTTP/1.0\r\nHost: localhost\r\n\r\n")
        assert answer(idle[0])[0] == 404
    with ExitStack() as stack:  # all places are free again, as the clients have gone
        for _ in range(2 * MOST_CONNECTIONS):
            status = 503
            while status == 503:  # until the threads have noticed
                status = request(server, "/")[0]
            assert status == 200


def test_the_page_is_watched_on_while_others_idle(server, stage):
    reader = EventReader(server.port)
    with ExitStack() as stack:
        for _ in range(MOST_CONNECTIONS // 2):
            stack.enter_context(connect(server))
        stage.tick()
        assert next(reader)[0] == "setup"
        assert request(server, "/view.js")[0] == 200
        assert post(server, '{"action": "pause"}')[0] == 200
    reader.close()
    stage.tick()  # the server notices that it has gone


def test_who_says_nothing_is_not_waited_for(hasty):
    with connect(hasty) as client:
        assert answer(client) == (408, f"no request within {SOON:g} s\n")


@pytest.mark.parametrize(
    "data",
    [
        b"G",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ",
        b"POST /control HTTP/1.1\r\nHost: localhost\r\n" + TYPED + b"\r\n{",
    ],
    ids=["request line", "header", "body"],
)
def test_a_byte_now_and_then_wins_no_time(hasty, data):
    """The deadline is that of the whole request: each byte comes well within it."""
    with connect(hasty) as client:
        client.sendall(data)
        client.settimeout(SOON / 10.0)
        received = b""
        while not received:
            try:
                received = client.recv(65536)
            except TimeoutError:
                client.sendall(b" ")
        assert received.startswith(b"HTTP/1.0 408 ")


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ("[" * 1000, 400),
        ('{"action":' + "[" * 900, 400),
        ('{"a":' * 150, 400),
        ('{"action": "seek", "value": 1e999}', 400),
        ('{"action": "seek", "value": 1' + "0" * 500 + "}", 400),
        (r'{"action": "\ud800"}', 400),
        (r'{"action": "a\nb\r\nc"}', 400),
        ("x" * 1025, 413),
        ("[" * 100_000, 413),
    ],
    ids=[
        "arrays",
        "nested",
        "objects",
        "infinity",
        "integer",
        "surrogate",
        "lines",
        "1025",
        "huge",
    ],
)
def test_a_body_that_is_none_is_answered_with_one_line(server, body, status):
    found, _, text = post(server, body)
    assert found == status
    assert is_one_line(text)


@pytest.mark.parametrize(
    ("length", "status"),
    [("-1", 400), ("0", 400), ("abc", 400), ("9" * 30, 413), ("9" * 9000, 400), ("1e3", 400)],
    ids=["negative", "none", "a word", "huge", "more digits than an integer", "float"],
)
def test_a_length_that_is_none_is_answered_with_one_line(server, length, status):
    head = f"POST /control HTTP/1.0\r\nHost: localhost\r\nContent-Type: {JSON}\r\n"
    found, text = sent(server, f"{head}Content-Length: {length}\r\n\r\n{{}}".encode())
    assert found == status
    assert is_one_line(text)


def test_a_body_in_chunks_is_refused(server):
    head = f"POST /control HTTP/1.1\r\nHost: localhost\r\nContent-Type: {JSON}\r\n"
    found, text = sent(server, f"{head}Transfer-Encoding: chunked\r\n\r\n2\r\n{{}}\r\n".encode())
    assert (found, is_one_line(text)) == (400, True)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"GET /" + b"a" * MOST_BYTES + b" HTTP/1.0\r\n\r\n", 431),
        (b"GET / HTTP/1.0\r\nX: " + b"a" * 2 * MOST_BYTES + b"\r\n\r\n", 431),
        (b"GET / HTTP/1.0\r\n" + b"X: a\r\n" * 10_000 + b"\r\n", 431),
        (b"GET / HTTP/1.0\r\n" + b"X: a\r\n" * 101 + b"\r\n", 431),
        (b"GET / HTTP/9.9\r\n\r\n", 505),
        (b"\x16\x03\x01\x02\x00\x01\x00 a TLS greeting\r\n", 400),
        (b"GET / HTTP/1.0 more words\r\n\r\n", 400),
        (b"\0" * 100 + b"\r\n", 400),
    ],
    ids=["path", "header", "headers", "101 headers", "version", "TLS", "words", "zeros"],
)
def test_what_is_no_request_is_answered_with_one_line(server, data, status):
    found, text = sent(server, data)
    assert found == status
    assert is_one_line(text)


def test_the_answer_is_kept_for_who_still_sends(server):
    """A connection closed at once would be reset, and the answer lost with it."""
    with connect(server) as client:
        client.sendall(b"GET / HTTP/1.0\r\nX: " + b"a" * 2 * MOST_BYTES)
        assert answer(client) == (431, "too long a request\n")
        for _ in range(3):
            client.sendall(b"a" * MOST_BYTES)
        client.shutdown(socket.SHUT_WR)


def test_who_sends_without_end_is_let_go(server):
    def send():
        while True:
            client.sendall(b"a" * MOST_BYTES)

    with connect(server) as client, pytest.raises((BrokenPipeError, ConnectionResetError)):
        send()


@pytest.mark.parametrize(
    "method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "get", "BREW", "<script>"]
)
def test_other_methods_are_refused_with_one_line(server, method):
    found, text = sent(server, f"{method} / HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
    assert (found, is_one_line(text)) == (501, True)


@settings(max_examples=25, deadline=None)
@given(data=st.binary(min_size=1, max_size=300))
def test_random_bytes_are_answered_or_let_go(server, data):
    with connect(server) as client:
        client.sendall(data)
        client.shutdown(socket.SHUT_WR)
        received = b""
        while chunk := client.recv(65536):
            received += chunk
    assert not received or is_one_line(received.decode().rpartition("\r\n\r\n")[2])
    assert request(server, "/view.css")[0] == 200


@settings(max_examples=25, deadline=None)
@given(
    value=st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
        max_leaves=20,
    )
)
def test_any_json_is_answered(server, value):
    body = json.dumps({"action": "seek", "value": value})
    status, _, text = post(server, body)
    assert status in (200, 400, 413)
    assert is_one_line(text)
