"""A test authority, and the certificates that it signs for the processes of a fleet."""

from __future__ import annotations

import ipaddress
import os
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from zenvoy.bus.access import ROUTER, SERVERS, Member, member_of
from zenvoy.fleet.certificates import AUTHORITY, MEMBERS, CertificatesError, members_in

AUTHORITY_KEY: Final = "authority.key"
_SLACK: Final = timedelta(minutes=5)  # for clocks of other machines that are behind
_HEADER: Final = (
    "# The certificates that may enter, one a line. Without its line a certificate is revoked\n"
    "# for every run that starts afterwards.\n"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Validity:
    """The first and the last instant at which certificates are valid."""

    begin: datetime
    end: datetime


@dataclass(frozen=True, slots=True, kw_only=True)
class Authority:
    """A certificate that signs others, and its key."""

    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    @classmethod
    def opened(cls, folder: Path, validity: Validity) -> Authority:
        """Return the authority of a folder; make it, and an empty list of members, if need be."""
        if not (folder / AUTHORITY).exists():
            made = cls._made(validity)
            _write_key(folder / AUTHORITY_KEY, made.key)
            _write_certificate(folder / AUTHORITY, made.certificate)
            (folder / MEMBERS).write_text(_HEADER, encoding="utf-8")
            return made
        try:
            key = serialization.load_pem_private_key((folder / AUTHORITY_KEY).read_bytes(), None)
            certificate = x509.load_pem_x509_certificate((folder / AUTHORITY).read_bytes())
        except (ValueError, TypeError) as error:
            raise CertificatesError(f"{folder}: {AUTHORITY} or its key is not valid") from error
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise CertificatesError(f"{folder / AUTHORITY_KEY}: is not an elliptic-curve key")
        return cls(certificate=certificate, key=key)

    @classmethod
    def _made(cls, validity: Validity) -> Authority:
        key = ec.generate_private_key(ec.SECP256R1())
        name = _name(f"zenvoy test authority {secrets.token_hex(4)}")
        certificate = (
            _begun(name, name, key, validity)
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(_usage(signs=True), critical=True)
            .sign(key, hashes.SHA256())
        )
        return cls(certificate=certificate, key=key)

    def issue(self, member: Member, folder: Path, hosts: Sequence[str], validity: Validity) -> None:
        """Write the certificate and the key of a member; only world, channel and router have hosts.

        A certificate of a vehicle cannot serve as that of a world, since it has no such use.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        uses = [ExtendedKeyUsageOID.CLIENT_AUTH]
        builder = _begun(_name(member.common_name), self.certificate.subject, key, validity)
        if member.role in (*SERVERS, ROUTER):
            uses.append(ExtendedKeyUsageOID.SERVER_AUTH)
            names = x509.SubjectAlternativeName([_general_name(host) for host in hosts])
            builder = builder.add_extension(names, critical=False)
        certificate = (
            builder.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage(signs=False), critical=True)
            .add_extension(x509.ExtendedKeyUsage(uses), critical=False)
            .sign(self.key, hashes.SHA256())
        )
        _write_key(folder / f"{member.name}.key", key)
        _write_certificate(folder / f"{member.name}.pem", certificate)


def make_certificates(
    folder: Path, names: Sequence[str], hosts: Sequence[str], validity: Validity
) -> list[Member]:
    """Make the certificates that a folder lacks, and list them as members; return these.

    `names` are such as `world` or `vehicle-7`. Raises CertificatesError, OSError.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not (folder / AUTHORITY).exists() and any(folder.iterdir()):
        raise CertificatesError(
            f"{folder}: is not empty and has no {AUTHORITY}; name a new folder, or that of an "
            "authority"
        )
    authority = Authority.opened(folder, validity)
    members_in(folder)  # so that a faulty list is found before anything is written
    made = []
    for name in names:
        if (folder / f"{name}.pem").exists():
            continue
        member = member_of(f"{name}.{secrets.token_hex(4)}")
        authority.issue(member, folder, hosts, validity)
        made.append(member)
    with (folder / MEMBERS).open("a", encoding="utf-8") as file:
        file.writelines(f"{member.common_name}\n" for member in made)
    return made


def validity_of(days: int) -> Validity:
    """Return the validity from now on."""
    now = datetime.now(UTC)
    return Validity(begin=now - _SLACK, end=now + timedelta(days=days))


def _begun(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePrivateKey, validity: Validity
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(validity.begin)
        .not_valid_after(validity.end)
    )


def _name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _usage(*, signs: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs,
        crl_sign=signs,
        encipher_only=False,
        decipher_only=False,
    )


def _write_certificate(path: Path, certificate: x509.Certificate) -> None:
    path.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))


def _write_key(path: Path, key: ec.EllipticCurvePrivateKey) -> None:
    """Write a key that only this user can read."""
    text = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(text)
