"""The recipes for services, containers and clusters are valid, as far as can be told offline."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import kubernetes_validate
import pytest
import typer
from ruamel.yaml import YAML
from typer.core import TyperGroup
from typer.exceptions import TyperException

from zenvoy.cli.app import app

ROOT: Final = Path(__file__).parents[2]
DEPLOY: Final = ROOT / "examples" / "deploy"
UNITS: Final = sorted((DEPLOY / "systemd").glob("*.service"))
KUBERNETES: Final = "1.34"
BIN: Final = Path(sys.executable).parent


COMPOSED: Final[dict[str, Any]] = YAML(typ="safe").load(DEPLOY / "compose.yaml")
MANIFESTS: Final[list[dict[str, Any]]] = [*YAML(typ="safe").load_all(DEPLOY / "kubernetes.yaml")]
PODS: Final = [one for one in MANIFESTS if "template" in one["spec"]]


def commands() -> Iterator[tuple[str, list[str]]]:
    """Yield the commands of Zenvoy in all recipes, each with its place."""
    for unit in UNITS:
        for line in unit.read_text().splitlines():
            if line.startswith("ExecStart=/opt/zenvoy/bin/zenvoy "):
                arguments = shlex.split(line.replace("%i", "21-40").replace("%H", "here"))[1:]
                yield unit.name, arguments
    for name, service in COMPOSED["services"].items():
        if service["image"] == "zenvoy":
            yield f"compose {name}", service["command"]
    for resource in PODS:
        for container in resource["spec"]["template"]["spec"]["containers"]:
            if container["image"] == "zenvoy":
                yield f"kubernetes {resource['metadata']['name']}", container["args"]


COMMANDS: Final = dict(commands())


@pytest.mark.parametrize("place", COMMANDS)
def test_the_command_line_takes_the_commands(place: str) -> None:
    parse(COMMANDS[place])


def parse(command: Sequence[str]) -> None:
    """Parse a command without running it; raises TyperException for what it does not know."""
    group = typer.main.get_command(app)
    assert isinstance(group, TyperGroup)
    context = group.make_context("zenvoy", [command[0]])
    found = group.get_command(context, command[0])
    assert found is not None, command[0]
    found.make_context(command[0], [*command[1:]], parent=context)


def test_all_recipes_have_commands_and_others_are_not_taken() -> None:
    assert len(COMMANDS) == 9
    with pytest.raises(TyperException, match="No such option: --hots"):
        parse(["join", "--vehicles", "1-4", "--hots", "here"])


def test_the_units_are_valid(tmp_path: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("needs systemd-analyze, of Debian's package systemd")
    for unit in UNITS:
        text = unit.read_text()
        for there, here in (
            ("/opt/zenvoy/bin/zenvoy", str(BIN / "zenvoy")),
            ("/usr/bin/zenohd", "/usr/bin/true"),  # no package index here has it
        ):
            text = text.replace(there, here)
        (tmp_path / unit.name.replace("@", "@21-40")).write_text(text)
    verify = ["systemd-analyze", "verify", "--man=no", *map(str, tmp_path.iterdir())]
    outcome = subprocess.run(verify, check=False, capture_output=True, text=True)
    assert (outcome.returncode, outcome.stderr) == (0, "")


def test_the_compose_file_follows_the_compose_specification(tmp_path: Path) -> None:
    assert _follows(DEPLOY / "compose.yaml")
    broken = tmp_path / "compose.yaml"
    broken.write_text((DEPLOY / "compose.yaml").read_text().replace("depends_on", "depend_on"))
    assert not _follows(broken)


def _follows(path: Path) -> bool:
    check = [str(BIN / "check-jsonschema"), "--builtin-schema", "vendor.compose-spec", str(path)]
    return subprocess.run(check, check=False, capture_output=True).returncode == 0


def test_the_dockerfile_has_no_finding() -> None:
    lint = [str(BIN / "hadolint"), str(DEPLOY / "Dockerfile")]
    outcome = subprocess.run(lint, check=False, capture_output=True, text=True)
    assert (outcome.returncode, outcome.stdout) == (0, "")


@pytest.mark.parametrize("resource", MANIFESTS, ids=lambda one: one["metadata"]["name"])
def test_the_manifest_follows_the_schemas_of_kubernetes(resource: dict[str, Any]) -> None:
    kubernetes_validate.validate(resource, KUBERNETES, strict=True)
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate({**resource, "specs": {}}, KUBERNETES, strict=True)


@pytest.mark.parametrize("resource", PODS, ids=lambda one: one["metadata"]["name"])
def test_every_volume_of_the_manifest_is_there(resource: dict[str, Any]) -> None:
    claims = {one["metadata"]["name"] for one in MANIFESTS if "Claim" in one["kind"]}
    pod = resource["spec"]["template"]["spec"]
    mounted = {one["name"] for container in pod["containers"] for one in container["volumeMounts"]}
    assert mounted == {one["name"] for one in pod["volumes"]}
    claimed = [
        one["persistentVolumeClaim"] for one in pod["volumes"] if "persistentVolumeClaim" in one
    ]
    assert {one["claimName"] for one in claimed} <= claims
