"""The server of the page: refused from elsewhere, without the token, and for garbage."""

import asyncio
import os
import random
import socket
import subprocess
import sys
from types import SimpleNamespace

import pytest
from fingerdesign_cli import studio
from fingerdesign_cli.main import main

from fingerdesign.studio.door import MOST_BYTES, message_fault, new_token, refusal
from fingerdesign.studio.serve import serve
from fingerdesign.studio.session import Session
from tests.support.house import ROOT
from tests.support.session import never_called
from tests.support.studio import memory_MB, running

WHY = "trame is missing: pip install 'fingerdesign[studio]'"
aiohttp, msgpack, yarl = (
    pytest.importorskip(name, reason=WHY) for name in ("aiohttp", "msgpack", "yarl")
)
TOKEN = "aB3-xY7_kQ9-mN2"


@pytest.mark.slow
def test_the_library_is_not_loaded_before_it_is_needed():
    code = (
        "import sys, fingerdesign_cli.main, fingerdesign.studio.serve; "
        "sys.exit(bool({'trame', 'aiohttp', 'wslink'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT).returncode == 0


@pytest.fixture(scope="module")
def answers():
    """What a running studio answers to requests, by name: (status, text, headers)."""
    pytest.importorskip("trame", reason=WHY)
    return asyncio.run(_requested())


async def _requested():
    token, address = new_token(), asyncio.get_running_loop().create_future()
    server = asyncio.create_task(serve(Session(), token, ready=address.set_result))
    page = await asyncio.wait_for(address, 60)
    own = page.removesuffix("index.html")
    base = own.removesuffix(f"{token}/")
    found = {"page": page, "token": token}

    async def ask(name, address, **headers):
        url = yarl.URL(address, encoded=True)
        async with aiohttp.ClientSession() as client, client.get(url, headers=headers) as answer:
            found[name] = (answer.status, await answer.text(), answer.headers)

    try:
        await ask("host", own, Host="[::::")
        await ask("none", base)
        await ask("wrong", f"{base}{new_token()}/index.html")
        await ask("asked", f"{base}?token={token}")
        await ask("script", base + "plotly/plotly.min.js")
        await ask("socket", base + "ws", Connection="Upgrade", Upgrade="websocket")
        await ask("name", own, Host="elsewhere.example")
        await ask("site", own, Origin="http://elsewhere.example")
        await ask("right", own)
        await ask("after", own + "studio/chart.js")
        for name, path in BAD.items():
            await ask(name, own + path)
        await ask("half a socket", own + "ws", Connection="Upgrade", Upgrade="websocket")
        async with aiohttp.ClientSession() as client, client.post(own, data=b"x") as answer:
            found["post"] = (answer.status, await answer.text(), answer.headers)
        async with aiohttp.ClientSession() as client:
            found["closed"] = [await closed_with(client, own + "ws", each) for each in GARBAGE]
            found["hello"] = await closed_with(client, own + "ws", framed(HELLO))
        found["bound"] = [each.laddr.ip for each in _listening() if str(each.laddr.port) in base]
    finally:
        server.cancel()
        await asyncio.gather(server, return_exceptions=True)
    return found


BAD = {
    "no socket": "ws",
    "no file": "studio/none.js",
    "no name": "studio/%00",
    "long name": f"studio/{'x' * 5000}",
    "a folder above": "studio/..%2f..%2fserve.py",
}


def framed(found, offset=0, size=None):
    """A message as wslink frames it: id, offset, whole size, content."""
    content = found if isinstance(found, bytes) else msgpack.packb(found)
    numbers = (1, offset, len(content) if size is None else size)
    return b"".join(each.to_bytes(4, "little") for each in numbers) + content


def called(method, *given):
    return framed({"wslink": "1.0", "id": "r", "method": method, "args": list(given)})


HELLO = {"wslink": "1.0", "id": "system:c0:1", "method": "wslink.hello", "args": []}
GARBAGE = [
    *(b"", b"x", "text", os.urandom(100), framed(b""), framed(b"\xc1"), framed(7)),
    *(framed(HELLO, size=2**32 - 1), framed(HELLO, offset=5), framed(HELLO, size=3)),
    *(framed([HELLO]), framed({"id": 1, "method": "wslink.hello"}), framed({"id": "r"})),
    framed(b"\x91" * 2000 + b"\xc0"),
    framed(HELLO | {"args": ["x" * MOST_BYTES]}),
    *(called("trame.trigger"), called("trame.trigger", "pick", 3, {})),
    *(called("trame.trigger", "none", [], {}), called("trame.trigger", "pick", [], {})),
    called("trame.trigger", "pin", [], {"more": 1}),
    *(called("trame.state.update", 3), called("trame.state.update", [{"key": "name"}])),
    *(called("trame.state.update", [{"key": []}]), called("trame.force.push", "values")),
    called("application.exit"),
]


async def closed_with(client, address, message):
    """The code with which a socket closes for a message; 0: it answers."""
    async with client.ws_connect(address) as one:
        await (one.send_str if isinstance(message, str) else one.send_bytes)(message)
        try:
            answer = await one.receive(timeout=10)
        except TimeoutError:
            return -1
        return one.close_code if answer.type is aiohttp.WSMsgType.CLOSE else 0


def _listening():
    import psutil

    return [each for each in psutil.Process().net_connections() if each.status == "LISTEN"]


def test_it_listens_to_this_machine_alone(answers):
    assert answers["page"].startswith("http://127.0.0.1:")
    assert set(answers["bound"]) == {"127.0.0.1"}


@pytest.mark.parametrize(
    "name", ["none", "wrong", "asked", "script", "socket", "name", "site", "host"]
)
def test_without_the_token_or_from_elsewhere_nothing_is_answered(answers, name):
    status, text, _ = answers[name]
    assert status == 403
    assert answers["token"] not in text
    assert len(text) < 200


@pytest.mark.parametrize("name", [*BAD, "half a socket", "post"])
def test_a_request_that_makes_no_sense_gets_a_4xx_without_traceback(answers, name):
    status, text, _ = answers[name]
    assert 400 <= status < 500
    assert "Traceback" not in text


def test_no_answer_sets_a_cookie(answers):
    """Browsers send a cookie to every port of a machine."""
    for _, _, headers in (each for each in answers.values() if isinstance(each, tuple)):
        assert "Set-Cookie" not in headers


def test_a_socket_with_a_message_that_no_page_sends_is_closed(answers):
    assert answers["closed"] == [1008] * len(GARBAGE)
    assert answers["hello"] == 0


@pytest.mark.slow
def test_random_messages_take_little_memory_and_print_nothing(tmp_path):
    with running("homogeneous", folder=tmp_path) as (process, address):
        asyncio.run(_flooded(address.replace("http", "ws").replace("index.html", "ws")))
        assert memory_MB(process) < 600
        assert (tmp_path / "err.txt").read_text() == ""


async def _flooded(address):
    """5,000 messages, half of them random bytes, the others of a random claim in their header."""
    source = random.Random(0)
    async with aiohttp.ClientSession() as client:
        for k in range(5000):
            size = source.choice((0, 12, 100, 5000, 100_000))
            content = source.randbytes(size)
            if k % 2:
                content = framed(content, 0, source.randrange(2**32))
            async with client.ws_connect(address) as one:
                await one.send_bytes(content)
                await one.receive(timeout=30)


def refused(given, headers=(), remote="127.0.0.1"):
    """Why a request to port 8123 is refused whose path begins with this; TOKEN is right."""
    url = yarl.URL("http://127.0.0.1:8123/")
    known = {"remote": remote, "url": url, "host": "127.0.0.1:8123"}
    return refusal(SimpleNamespace(**known, headers=dict(headers), path=f"/{given}/ws"), TOKEN)


@pytest.mark.parametrize(
    "given",
    ["", TOKEN[:1], TOKEN[:-1], TOKEN[1:], TOKEN + "x", TOKEN.swapcase(), TOKEN[::-1], "\udcff"],
)
def test_a_token_that_is_nearly_right_is_refused(given):
    assert "token" in refused(given)


@pytest.mark.parametrize(
    "origin",
    [
        *("http://elsewhere-127.0.0.1:8123", "http://127.0.0.1:81234", "http://127.0.0.1:812"),
        *("http://127.0.0.1", "https://127.0.0.1:8123", "127.0.0.1:8123", "null", ""),
    ],
)
def test_an_origin_that_is_nearly_right_is_refused(origin):
    assert refused(TOKEN, {"Origin": origin}) == "this page answers no other site"


@pytest.mark.parametrize("remote", ["192.168.1.5", "10.0.0.2", "fd00::2", "8.8.8.8", "", None])
def test_another_machine_is_refused_however_near(remote):
    assert refused(TOKEN, remote=remote) == "this page is for its own machine"


def test_one_key_that_a_page_may_set_lets_no_other_in():
    def fault(*keys):
        rows = [{"key": key, "value": 1} for key in keys]
        return message_fault(called("trame.state.update", rows), None, ("values", "rest"))

    assert fault("values", "rest") == ""
    for keys in [("values", "name"), ("name", "values"), ("name",)]:
        assert fault(*keys) == "a page sets values, rest"


def test_the_right_token_from_its_own_page_is_answered():
    assert refused(TOKEN) == refused(TOKEN, {"Origin": "http://127.0.0.1:8123"}) == ""


def test_a_port_that_is_taken_is_refused_before_any_work(capsys):
    with never_called(studio, "Session"), socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        assert main(["studio", "homogeneous", "--no-open", "--port", port]) == 2
    assert "must be a port that is free" in capsys.readouterr().err


def test_with_the_token_the_page_and_its_scripts_are_there(answers):
    status, text, headers = answers["right"]
    assert status == 200
    assert "<html" in text
    assert "connect-src 'self'" in headers["Content-Security-Policy"]
    assert answers["after"][0] == 200
    assert "finger-chart" in answers["after"][1]
