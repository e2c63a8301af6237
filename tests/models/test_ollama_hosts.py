import heapq
from collections import Counter, defaultdict
from contextlib import AbstractContextManager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from foundry.errors import InputError, RequestError, TransientError
from foundry.models.http.hosts import HostPool
from foundry.models.ollama.ollama_server import parse_host, parse_hosts
from foundry.models.serving import RUN


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("", "http://127.0.0.1:11434"),
        ("127.0.0.1:11434", "http://127.0.0.1:11434"),
        ("127.0.0.1", "http://127.0.0.1:11434"),
        ("0.0.0.0", "http://127.0.0.1:11434"),
        ("0.0.0.0:8080", "http://127.0.0.1:8080"),
        (":56789", "http://127.0.0.1:56789"),
        ("gpu1", "http://gpu1:11434"),
        (" GPU1 ", "http://gpu1:11434"),
        ("http://gpu1:11434/", "http://gpu1:11434"),
        ("http://gpu1", "http://gpu1:80"),
        ("https://example.org", "https://example.org:443"),
        ("HTTPS://example.org/ollama/", "https://example.org:443/ollama"),
        ("example.org/path", "http://example.org:11434/path"),
        ("::", "http://[::1]:11434"),
        ("::1", "http://[::1]:11434"),
        ("[::1]", "http://[::1]:11434"),
        ("[fe80::2]:5000", "http://[fe80::2]:5000"),
    ],
)
def test_every_form_of_a_host_gives_its_base_url(host, url):
    assert parse_host(host) == url
    assert parse_host(url) == url


@pytest.mark.parametrize("host", ["ftp://gpu1", "gpu1:port", "gpu1:99999", "http://me@gpu1", "gpu1/?a=b", "gpu 1"])
def test_a_host_that_cannot_be_called_is_refused_in_one_line(host):
    with pytest.raises(InputError, match="cannot be read: .* Write it as in"):
        parse_host(host)


@given(st.text(st.characters(codec="ascii"), max_size=20))
def test_any_text_is_a_stable_base_url_or_an_input_error(text):
    try:
        url = parse_host(text)
    except InputError:
        return
    assert parse_host(url) == url


def test_hosts_come_as_one_as_several_with_commas_or_as_a_list_each_once_without_the_quotes_of_a_shell():
    for host in ('"gpu1:8080"', "'gpu1:8080'", ' "gpu1:8080" ', '"gpu1:8080,gpu1:8080"'):
        assert parse_hosts(host) == ("http://gpu1:8080",)
    expected = ("http://a:11434", "http://b:80")
    assert parse_hosts("a, http://b,a") == parse_hosts(["a", "http://b"]) == expected
    assert parse_hosts("") == parse_hosts([]) == ("http://127.0.0.1:11434",)


def test_a_failure_weighs_like_a_call_in_flight_until_the_host_answers():
    pool = HostPool(("a", "b"))
    with pytest.raises(TransientError), pool.least_loaded() as host:
        assert host == "a"
        raise TransientError("down")
    with pool.least_loaded() as second, pool.least_loaded() as third:
        assert (second, third) == ("b", "a")
    with pool.least_loaded() as fourth, pool.least_loaded() as fifth:
        assert {fourth, fifth} == {"a", "b"}


def test_a_host_that_was_down_is_asked_again_however_few_calls_are_in_flight():
    pool = HostPool(("a", "b"))
    with pool.least_loaded(), pytest.raises(TransientError), pool.least_loaded() as down:
        raise TransientError("down")
    asked = Counter[str]()
    for _ in range(1000):
        with pool.least_loaded(), pool.least_loaded() as host:
            asked[host] += 1
    assert asked[down] > 300


@pytest.fixture
def of_run():
    """Sets the run that is asked for, until the test ends."""
    token = RUN.set(None)
    yield RUN.set
    RUN.reset(token)


@pytest.mark.parametrize("runs", [1, 8])
@pytest.mark.parametrize(("slots", "times"), [((4, 16), 1.6), ((8, 8), 1.0), ((16, 4), 0.63)])
def test_a_server_that_answers_more_has_more_calls_in_flight_and_equal_ones_equally_many(slots, times, runs, of_run):
    """Two servers that take one unit of time for a call, with as many calls in flight as they have slots."""
    pool, now = HostPool(("a", "b")), 0.0
    free_at = {host: [0.0] * number for host, number in zip("ab", slots, strict=True)}
    under_way: list[tuple[float, int, str, AbstractContextManager[str]]] = []
    in_flight, of_runs = Counter[str](), defaultdict[str, Counter[str]](Counter)
    for number in range(1500):
        if len(under_way) == sum(slots):
            now, _, _, ended = heapq.heappop(under_way)
            ended.__exit__(None, None, None)
        of_run(name := f"run {number * 3 // 2 % runs}")
        call = pool.least_loaded()
        host = call.__enter__()
        ends = max(now, heapq.heappop(free_at[host])) + 1
        heapq.heappush(free_at[host], ends)
        heapq.heappush(under_way, (ends, number, host, call))
        of_runs[name][host] += 1
        in_flight.update(host for _, _, host, _ in under_way if number >= 500)
    assert in_flight["b"] / in_flight["a"] == pytest.approx(times, rel=0.1)
    mostly = sum(max(hosts.values()) for hosts in of_runs.values())
    assert runs == 1 or mostly > 0.7 * 1500, "most calls of a run go to one server"


def test_a_refused_request_says_nothing_against_its_host():
    pool = HostPool(("a", "b"))
    with pytest.raises(RequestError), pool.least_loaded():
        raise RequestError("bad")
    with pool.least_loaded() as host:
        assert host == "a"
