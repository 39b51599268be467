"""The server of a page answers to that page only."""

from __future__ import annotations

import pytest

from zenvoy.analysis.view.doors import refusal


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "127.0.0.1:8600"},
        {"Host": "localhost:8600", "Sec-Fetch-Site": "same-origin"},
        {"Host": "[::1]:8600", "Sec-Fetch-Site": "none"},
        {"Host": "127.0.0.1:8600", "Origin": "http://127.0.0.1:8600"},
    ],
)
def test_its_own_page_is_answered(headers: dict[str, str]) -> None:
    assert refusal(headers) is None


@pytest.mark.parametrize(
    ("headers", "why"),
    [
        ({}, "Host"),
        ({"Host": "evil.example:8600"}, "Host"),  # a name that was pointed to 127.0.0.1
        ({"Host": "127.0.0.1.evil.example"}, "Host"),
        ({"Host": "evil.example/@127.0.0.1"}, "Host"),
        ({"Host": "[::1"}, "Host"),
        ({"Host": "127.0.0.1:8600", "Origin": "http://evil.example"}, "Origin"),
        ({"Host": "127.0.0.1:8600", "Origin": "http://127.0.0.1:9999"}, "Origin"),
        ({"Host": "127.0.0.1:8600", "Origin": "null"}, "Origin"),
        ({"Host": "127.0.0.1:8600", "Sec-Fetch-Site": "cross-site"}, "cross-site"),
        ({"Host": "127.0.0.1:8600", "Sec-Fetch-Site": "same-site"}, "same-site"),
    ],
)
def test_others_are_refused(headers: dict[str, str], why: str) -> None:
    assert why in (refusal(headers) or "")
