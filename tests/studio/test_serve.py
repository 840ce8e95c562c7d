"""The page's server: loopback alone, refused without its token, moves answered, newest first."""

import asyncio
import socket
import subprocess
import sys
from types import SimpleNamespace

import pytest
from fingerdesign_cli.main import main

from fingerdesign.studio.serve import MISSING, new_token, refusal, serve
from fingerdesign.studio.session import Session
from tests.support.house import ROOT

WHY = "trame is missing: pip install 'fingerdesign[studio]'"
TOKEN = "aB3-xY7_kQ9-mN2"


def test_without_trame_one_line_names_the_install_command(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "trame.app", None)
    assert main(["studio", "homogeneous", "--no-open"]) == 1
    assert capsys.readouterr().err.strip() == f"failed: {MISSING}"


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
    import aiohttp

    token, address = new_token(), asyncio.get_running_loop().create_future()
    running = asyncio.create_task(serve(Session(), token, ready=address.set_result))
    page = await asyncio.wait_for(address, 60)
    base = page.partition("?")[0]
    found = {"page": page, "token": token}

    async def ask(name, path="", given=(), headers=(), jar=None):
        async with (
            aiohttp.ClientSession(cookie_jar=jar) as client,
            client.get(base + path, params=given, headers=headers) as answer,
        ):
            found[name] = (answer.status, await answer.text(), answer.headers)

    try:
        await ask("host", given={"token": token}, headers={"Host": "[::::"})
        await ask("none")
        await ask("wrong", given={"token": new_token()})
        await ask("script", "plotly/plotly.min.js")
        await ask("socket", "ws", headers={"Connection": "Upgrade", "Upgrade": "websocket"})
        await ask("name", given={"token": token}, headers={"Host": "elsewhere.example"})
        await ask("site", given={"token": token}, headers={"Origin": "http://elsewhere.example"})
        jar = aiohttp.CookieJar(unsafe=True)
        await ask("right", given={"token": token}, jar=jar)
        await ask("after", "studio/chart.js", jar=jar)
        found["bound"] = [each.laddr.ip for each in _listening() if str(each.laddr.port) in base]
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
    return found


def _listening():
    import psutil

    return [each for each in psutil.Process().net_connections() if each.status == "LISTEN"]


def test_it_listens_to_this_machine_alone(answers):
    assert answers["page"].startswith("http://127.0.0.1:")
    assert set(answers["bound"]) == {"127.0.0.1"}


@pytest.mark.parametrize("name", ["none", "wrong", "script", "socket", "name", "site", "host"])
def test_without_the_token_or_from_elsewhere_nothing_is_answered(answers, name):
    status, text, _ = answers[name]
    assert status == 403
    assert answers["token"] not in text
    assert len(text) < 200


def refused(given, headers=()):
    """Why a request to port 8123 is refused whose cookie holds this token; TOKEN is right."""
    yarl = pytest.importorskip("yarl", reason=WHY)
    url = yarl.URL("http://127.0.0.1:8123/")
    known = {"remote": "127.0.0.1", "url": url, "host": "127.0.0.1:8123", "query": {}}
    cookies = {"studio-8123": given}
    return refusal(SimpleNamespace(**known, headers=dict(headers), cookies=cookies), TOKEN)


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


def test_the_right_token_from_its_own_page_is_answered():
    assert refused(TOKEN) == refused(TOKEN, {"Origin": "http://127.0.0.1:8123"}) == ""


def test_a_port_that_is_taken_is_refused_before_any_work(monkeypatch, capsys):
    monkeypatch.setattr("fingerdesign_cli.studio.Session", None)
    with socket.create_server(("127.0.0.1", 0)) as other:
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
