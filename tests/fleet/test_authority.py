"""`zenvoy certs` makes an authority and its certificates, and a list says who may enter."""

from __future__ import annotations

import stat
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from tests.conftest import zenvoy
from zenvoy.bus.access import member_of
from zenvoy.fleet.authority import make_certificates, validity_of
from zenvoy.fleet.certificates import MEMBERS, CertificatesError, members_in

NAMES = ("world", "channel", "observer", "vehicle-1", "vehicle-2")
HOSTS = ("localhost", "127.0.0.1")


def certificate(path: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate(path.read_bytes())


def test_each_role_has_a_certificate_for_what_it_does(tmp_path: Path) -> None:
    made = make_certificates(tmp_path / "keys", NAMES, HOSTS, validity_of(30))
    assert [member.name for member in made] == [*NAMES]
    assert members_in(tmp_path / "keys") == tuple(made)
    authority = certificate(tmp_path / "keys" / "authority.pem")
    for member in made:
        own = certificate(tmp_path / "keys" / f"{member.name}.pem")
        own.verify_directly_issued_by(authority)
        (name,) = own.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
        assert name.value == member.common_name
        uses = set(own.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value)
        serves = ExtendedKeyUsageOID.SERVER_AUTH in uses
        assert serves == (member.role in {"world", "channel"})
        assert own.not_valid_after_utc - datetime.now(UTC) < timedelta(days=30)


def test_keys_are_private(tmp_path: Path) -> None:
    make_certificates(tmp_path / "keys", NAMES, HOSTS, validity_of(30))
    assert stat.S_IMODE((tmp_path / "keys").stat().st_mode) == 0o700
    keys = list((tmp_path / "keys").glob("*.key"))
    assert len(keys) == len(NAMES) + 1
    assert {stat.S_IMODE(key.stat().st_mode) for key in keys} == {0o600}


def test_a_second_call_makes_only_what_is_missing(tmp_path: Path) -> None:
    first = make_certificates(tmp_path, NAMES, HOSTS, validity_of(30))
    (tmp_path / "vehicle-2.pem").unlink()
    (tmp_path / "vehicle-2.key").unlink()
    (again,) = make_certificates(tmp_path, NAMES, HOSTS, validity_of(30))
    assert again.name == "vehicle-2"
    assert again.common_name != first[-1].common_name  # the earlier one can stay revoked
    assert members_in(tmp_path) == (*first, again)


def test_a_revoked_certificate_stays_revoked(tmp_path: Path) -> None:
    made = make_certificates(tmp_path, NAMES, HOSTS, validity_of(30))
    listed = (tmp_path / MEMBERS).read_text()
    (tmp_path / MEMBERS).write_text(listed.replace(f"{made[-1].common_name}\n", ""))
    assert make_certificates(tmp_path, NAMES, HOSTS, validity_of(30)) == []
    assert members_in(tmp_path) == tuple(made[:-1])


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("world.0123abcd\nvehicle-7\n", "line 2: 'vehicle-7' is not the name of a certificate"),
        ("world.0123abcd # ours\n\nworld.0123abcd\n", "line 3: world.0123abcd is listed twice"),
    ],
)
def test_a_faulty_list_is_refused(tmp_path: Path, text: str, wrong: str) -> None:
    (tmp_path / MEMBERS).write_text(text)
    with pytest.raises(CertificatesError, match=wrong):
        members_in(tmp_path)


def test_a_group_has_its_vehicles() -> None:
    assert member_of("vehicles-21-24.0123abcd").vehicles == (21, 22, 23, 24)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--host", "a b"), "--host a b: is not the name or the address of a host"),
        (("--group", "7-7"), "--group 7-7: is not N-M with 1 <= N < M <= 9999, as 21-40"),
        (("--group", "x"), "--group x: is not N-M with 1 <= N < M <= 9999, as 21-40"),
    ],
)
def test_wrong_options_are_refused(tmp_path: Path, arguments: tuple[str, ...], line: str) -> None:
    outcome = zenvoy(tmp_path, "certs", "keys", *arguments)
    assert (outcome.code, outcome.err) == (2, line + "\n")
    assert not (tmp_path / "keys").exists()


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    outcome = zenvoy(tmp_path, "certs", "mine")
    assert outcome.code == 2
    assert outcome.err.startswith("mine: is not empty and has no authority.pem")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["notes.txt"]


def test_the_command_says_what_it_has_made(tmp_path: Path) -> None:
    options = ("--vehicles", "3", "--group", "1-2", "--host", "10.9.8.7")
    outcome = zenvoy(tmp_path, "certs", "keys", *options)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("7 certificates in keys, valid to ")
    assert "10.9.8.7" in outcome.out
    names = {member.name for member in members_in(tmp_path / "keys")}
    vehicles = {"vehicle-1", "vehicle-2", "vehicle-3", "vehicles-1-2"}
    assert names == {"world", "channel", "observer", *vehicles}
    again = zenvoy(tmp_path, "certs", "keys", *options)
    assert (again.code, again.out) == (0, "keys has all of these already\n")
