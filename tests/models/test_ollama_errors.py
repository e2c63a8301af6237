from __future__ import annotations

from datetime import UTC, datetime, timedelta
from email.utils import format_datetime

import pytest

import ollama_cases as cases
from foundry.errors import RequestError, ServerError, TransientError
from foundry.models.base import UnusableReply
from foundry.models.http.pausing import seconds_to_wait

OTHER_FORMAT = "The model produced output that does not match the expected peg-native format"


@pytest.mark.parametrize(
    ("case", "kind", "says"),
    [
        (cases.refused(400, "invalid think value"), RequestError, "invalid think value. It would be refused again"),
        (cases.refused(413, "too large"), RequestError, "413 too large"),
        (cases.refused(401, "unauthorized"), ServerError, "wants a key"),
        (cases.refused(403, "forbidden"), ServerError, "OLLAMA_HOST"),
        (cases.refused(403, "remote model is unavailable: ollama cloud is disabled"), ServerError, "cloud: name one"),
        (cases.refused(500, OTHER_FORMAT), UnusableReply, "expected peg-native format"),
        (cases.refused(500, "prediction aborted, token repeat limit reached"), UnusableReply, "token repeat limit"),
        (cases.refused(404, "model 'x' not found"), ServerError, "ollama pull qwen3:4b-instruct"),
        (cases.refused(302, ""), ServerError, "no answer of an Ollama API"),
        (cases.busy(), TransientError, "server busy, please try again. maximum pending"),
        (cases.refused(429, "too many"), TransientError, "429 too many"),
        (cases.refused(502, "bad gateway"), TransientError, "502 bad gateway"),
        *((cases.refused(status, "too slow"), TransientError, f"{status} too slow") for status in (408, 499, 504)),
        (cases.RUNNER_DIED, TransientError, "unexpected EOF"),
        (cases.BAD_OPTION, ServerError, 'option "seed" must be of type integer'),
        (cases.BAD_FORMAT, ServerError, "invalid format"),
        (cases.ERROR_WITH_200, TransientError, "no longer running"),
        (cases.CUT, TransientError, "not JSON, or was cut"),
        (cases.ChatCase(raw=b"[1]"), TransientError, "not a JSON object"),
        (cases.ChatCase(raw=b'{"done": true}'), TransientError, "no message"),
        (cases.DROPPED, TransientError, "ServerDisconnectedError"),
        (cases.ChatCase(text="a" * 50, drop=True, cut=True), TransientError, "ClientPayloadError|ClientConnection"),
    ],
)
def test_every_failure_is_an_error_of_one_line_of_the_right_kind(ask, case, kind, says):
    with pytest.raises(kind, match=says) as caught:
        ask(case)
    message = str(caught.value)
    assert type(caught.value) is kind
    assert not isinstance(caught.value, TransientError) or caught.value.busy == (case.status in (429, 502, 503))
    assert "\n" not in message
    assert "Ollama at http://127.0.0.1:" in message
    assert "qwen3:4b-instruct-2507-q4_K_M" in message


def test_retry_after_is_read_as_seconds_or_as_a_date(ask):
    with pytest.raises(TransientError) as caught:
        ask(cases.busy("7"))
    assert caught.value.retry_after_s == 7
    now = datetime(2026, 9, 1, tzinfo=UTC)
    assert seconds_to_wait(format_datetime(now + timedelta(seconds=90), usegmt=True), now) == 90
    assert seconds_to_wait(format_datetime(now - timedelta(days=1), usegmt=True), now) == 0
