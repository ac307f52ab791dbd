"""What is longer than any message may be is not read; an upload has a limit of its own."""

import asyncio

import pytest

from app.message_limit import MessageLimit


def sent(path, parts, declared=None):
    """Return what an app reads of a request, and the status that is answered."""
    read, status = [], []

    async def app(scope, receive, send):
        while (message := await receive())["type"] == "http.request":
            read.append(message["body"])
            if not message["more_body"]:
                break
        await send({"type": "http.response.start", "status": 200})

    async def receive():
        part = left.pop(0)
        return {"type": "http.request", "body": part, "more_body": bool(left)}

    async def send(message):
        status.append(message.get("status"))

    left = list(parts)
    length = [] if declared is None else [(b"content-length", declared)]
    scope = {"type": "http", "path": path, "headers": length}
    asyncio.run(MessageLimit(app, 10)(scope, receive, send))
    return b"".join(read), status[0]


@pytest.mark.parametrize("declared", [b"11", b"99999999999999999999", b"-1", b"ten"])
def test_a_message_that_says_it_is_too_long_is_refused_unread(declared):
    assert sent("/gradio_api/call/ask", [b"x"], declared) == (b"", 413)


def test_one_that_grows_too_long_is_cut_off():
    assert sent("/mcp", [b"12345"] * 4) == (b"1234512345", 200)


def test_a_short_one_and_an_upload_are_passed_on():
    assert sent("/mcp", [b"12345", b"6789"], b"9") == (b"123456789", 200)
    assert sent("/gradio_api/upload", [b"12345"] * 4, b"20") == (b"12345" * 4, 200)
