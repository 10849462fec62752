"""Who may call a server over HTTP: token files, bearer tokens, and the owner that a call is known by."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from client_runs import sequence
from folding_client.protocol.connection import TOKEN_VARIABLE, Connection, ConnectionLost, ServerAddress
from folding_server.mcp.auth import TokenFileError, caller, read_tokens
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.http.address import Address, listen
from folding_server.mcp.http.names import AcceptedNames
from folding_server.mcp.http.serving import configuration, http_app
from folding_server.mcp.server import FoldingServer
from hosts import Host, http_process, http_server, server, text_of
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from mcp.server.mcpserver.tools import Tool
from web_threads import serving_in_a_thread

ALICE, BOB = "alice-0123456789abcdef", "bob/0123456789+abcdef=="
EVERYWHERE = "0.0.0.0"  # noqa: S104 - what the tests are about
LISTING = {"jsonrpc": "2.0", "id": 1, "method": "tools/list"}
ACCEPT = {"Accept": "application/json, text/event-stream"}


@pytest.fixture
def tokens(tmp_path: Path) -> Path:
    """A token file of two owners."""
    return token_file(tmp_path, f"# who may fold\n\nalice {ALICE}\nbob\t{BOB}\n")


def token_file(folder: Path, text: str) -> Path:
    """A token file that only its owner can read."""
    file = folder / "tokens"
    file.write_text(text)
    file.chmod(0o600)
    return file


def bearing(token: str) -> httpx2.AsyncClient:
    """A web client that shows a token."""
    headers = {"Authorization": f"Bearer {token}"}
    return httpx2.AsyncClient(headers=headers, timeout=httpx2.Timeout(30, read=300))


@pytest.mark.slow
@pytest.mark.anyio
@pytest.mark.parametrize("mode", ["auto", "legacy"])
async def test_a_host_with_a_token_folds(tmp_path: Path, tokens: Path, mode: str) -> None:
    with http_server(tmp_path, "--token-file", str(tokens)) as url:
        async with (
            bearing(BOB) as web,
            Client(streamable_http_client(url, http_client=web), mode=mode) as client,
        ):
            run_id = (await Host(client).call("open_run"))["run_id"]
            folded = await Host(client).call("fold", edge=[1, 3], direction=1, run_id=run_id)
    assert len(folded["state"]["faces"]) == 2


@pytest.mark.anyio
async def test_a_call_without_a_known_token_is_answered_401_and_no_token_is_ever_shown(
    tmp_path: Path, tokens: Path
) -> None:
    wrong = [
        {},
        bearer("x"),
        bearer("mallory-0123456789abcdef"),
        bearer(ALICE[:-1]),
        {"Authorization": ALICE},
    ]
    wrong.append({"Authorization": b"Bearer \xff\xfe"})
    with http_process(tmp_path, "--token-file", str(tokens)) as process:
        async with httpx2.AsyncClient() as web:
            refused = [
                await web.post(process.url, json=LISTING, headers={**ACCEPT, **each}) for each in wrong
            ]
            refused.append(await web.delete(process.url))
            healthy = await web.get(process.url.replace("/mcp", "/health"))
        said = process.end()
    assert {answer.status_code for answer in refused} == {401}
    assert all(answer.headers["WWW-Authenticate"].startswith("Bearer error=") for answer in refused)
    assert healthy.json() == {"status": "ok"}
    everything = said + "".join(f"{answer.headers}{answer.text}" for answer in refused)
    assert not [word for word in (ALICE, ALICE[:-1], BOB, str(tokens)) if word in everything]


def bearer(token: str) -> dict[str, str]:
    """The header that shows a token."""
    return {"Authorization": f"Bearer {token}"}


@contextmanager
def served(tmp_path: Path, tokens: Path | None) -> Iterator[str]:
    """A server in a thread of this process, with a tool ``whoami`` that answers the caller."""
    verifier = read_tokens(tokens) if tokens else None
    with (
        AppContext(ServerSettings(tmp_path, shared=True)) as app,
        listen(Address("127.0.0.1", 0)) as listener,
    ):
        mcp = FoldingServer(app, verifier)

        def whoami() -> str:
            return json.dumps(caller())

        mcp.add_tool(whoami, structured_output=False)
        mcp.catalogue = {**mcp.catalogue, "whoami": Tool.from_function(whoami)}
        config = configuration(http_app(mcp, AcceptedNames.of("127.0.0.1")))
        with serving_in_a_thread(config, listener) as url:
            yield url


@pytest.mark.anyio
async def test_a_tool_knows_the_owner_of_the_token_that_it_was_called_with(
    tmp_path: Path, tokens: Path
) -> None:
    found = {}
    with served(tmp_path, tokens) as url:
        for mode in ("auto", "legacy"):
            async with (
                bearing(ALICE) as hers,
                bearing(BOB) as his,
                Client(streamable_http_client(url, http_client=hers), mode=mode) as alice,
                Client(streamable_http_client(url, http_client=his), mode=mode) as bob,
            ):
                found[mode] = [await who(each) for each in (alice, bob, alice)]
    assert found == {"auto": ["alice", "bob", "alice"], "legacy": ["alice", "bob", "alice"]}


@pytest.mark.anyio
async def test_a_server_without_tokens_knows_no_owner(tmp_path: Path) -> None:
    with served(tmp_path, None) as url:
        async with Client(url) as client:
            assert await who(client) is None
    assert caller() is None


async def who(client: Client) -> object:
    """What ``whoami`` answers."""
    return json.loads(text_of(await Host(client).answer("whoami")))


@pytest.mark.anyio
async def test_our_client_shows_the_token_of_its_environment_or_says_how_to(
    tmp_path: Path, tokens: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with http_server(tmp_path, "--token-file", str(tokens)) as url, (tmp_path / "log").open("w") as log:
        address = ServerAddress(sequence(2), tmp_path, url)
        monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
        with pytest.raises(ConnectionLost, match=TOKEN_VARIABLE):
            await Connection(address, log).open()
        monkeypatch.setenv(TOKEN_VARIABLE, f"{ALICE}\n")
        connection = Connection(address, log)
        await connection.open()
        answer = await connection.call("open_run", {})
        await connection.close()
    assert not answer.is_error


def test_other_machines_reach_a_server_only_with_tokens(tmp_path: Path) -> None:
    for everywhere in (f"{EVERYWHERE}:0", "[::]:0"):
        refused = server("--http", everywhere, "--data", tmp_path)
        if "not supported" in refused.stderr:
            continue
        assert refused.returncode == 1
        assert "--token-file" in refused.stderr
        assert refused.stderr.count("\n") == 1
        assert "Serving" not in refused.stderr


@pytest.mark.anyio
async def test_with_tokens_a_server_listens_everywhere(tmp_path: Path, tokens: Path) -> None:
    options = ("--http", f"{EVERYWHERE}:0", "--token-file", str(tokens))
    with http_process(tmp_path, *options) as process:
        url = process.url.replace(EVERYWHERE, "127.0.0.1")
        async with bearing(ALICE) as web:
            listed = await web.post(url, json=LISTING, headers=ACCEPT)
    assert listed.status_code not in (401, 403, 421)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no token"),
        ("# nobody yet\n", "holds no token"),
        (f"\n{ALICE}\n", "Line 2 .* is not OWNER TOKEN"),
        (f"alice: {ALICE}\n", "is not OWNER TOKEN"),
        (f"alice {ALICE} # her own\n", "is not OWNER TOKEN"),
        ("alice short-secret-01\n", "token of 15 characters; it must have at least 16"),
        ("alice sécret-0123456789-abcdef\n", "that HTTP cannot carry"),
        (f"alice {ALICE}\nbob {ALICE}\n", "Line 2 .* gives bob a token that alice has already"),
    ],
)
def test_a_token_file_that_says_something_else_is_refused_without_its_tokens(
    tmp_path: Path, text: str, says: str
) -> None:
    with pytest.raises(TokenFileError, match=says) as refusal:
        read_tokens(token_file(tmp_path, text))
    secrets = [word for word in text.split() if len(word) > 10]
    assert not [word for word in secrets if word in str(refusal.value)]


@pytest.mark.anyio
async def test_an_owner_may_have_several_tokens_and_only_whole_ones_count(tmp_path: Path) -> None:
    known = read_tokens(token_file(tmp_path, f"alice {ALICE}\nalice {BOB}\nalice {BOB}\n"))
    for token in (ALICE, BOB):
        access = await known.verify_token(token)
        assert access is not None
        assert access.client_id == "alice"
        assert token not in repr(access)
    for token in ("", ALICE[:-1], ALICE + "x", ALICE.upper(), "\udcff"):
        assert await known.verify_token(token) is None


@pytest.mark.slow
def test_a_token_file_that_is_missing_or_no_text_is_refused_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "binary").write_bytes(b"alice \xff\xfe\n")
    for name in ("missing", "binary"):
        refused = server("--http", "127.0.0.1:0", "--data", tmp_path, "--token-file", tmp_path / name)
        assert refused.returncode == 1
        assert refused.stderr.count("\n") == 1
        assert name in refused.stderr
    needless = server("--data", tmp_path, "--token-file", tmp_path / "missing")
    assert needless.returncode == 2
    assert "--http" in needless.stderr


@pytest.mark.skipif(os.name != "posix", reason="only POSIX has permissions of this kind")
def test_a_token_file_that_others_can_read_is_warned_about(
    tokens: Path, caplog: pytest.LogCaptureFixture
) -> None:
    read_tokens(tokens)
    assert caplog.messages == []
    tokens.chmod(0o640)
    read_tokens(tokens)
    (warning,) = caplog.messages
    assert "chmod 600" in warning
    assert ALICE not in warning
