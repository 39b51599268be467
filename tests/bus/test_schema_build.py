"""The generated modules match messages.proto, so a forgotten rebuild fails."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from google.protobuf.descriptor_pb2 import DescriptorProto, FileDescriptorProto, FileDescriptorSet

from zenvoy.bus import messages_pb2 as pb

BUS = Path(__file__).parents[2] / "bus"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> FileDescriptorProto:
    """Return the descriptors that protoc builds now. Module texts differ between versions."""
    out = tmp_path_factory.mktemp("schema") / "messages.binpb"
    subprocess.run(
        [
            *(sys.executable, "-m", "grpc_tools.protoc"),
            *(f"-I{BUS}", f"--descriptor_set_out={out}", "messages.proto"),
        ],
        check=True,
    )
    (file,) = FileDescriptorSet.FromString(out.read_bytes()).file
    for message in file.message_type:
        for field in message.field:
            field.ClearField("json_name")  # derived from the name; Python's descriptors have none
    return file


def test_the_module_is_up_to_date(built: FileDescriptorProto) -> None:
    compiled = FileDescriptorProto()
    pb.DESCRIPTOR.CopyToProto(compiled)
    assert compiled == built


def constants(body: list[ast.stmt]) -> set[str]:
    return {
        node.target.id
        for node in body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }


def numbers(message: DescriptorProto) -> set[str]:
    return {f"{field.name.upper()}_FIELD_NUMBER" for field in message.field}


def test_the_stub_is_up_to_date(built: FileDescriptorProto) -> None:
    stub = ast.parse((BUS / "messages_pb2.pyi").read_text())
    classes = {
        node.name: {name for name in constants(node.body) if name.endswith("_FIELD_NUMBER")}
        for node in stub.body
        if isinstance(node, ast.ClassDef)
    }
    assert {name: found for name, found in classes.items() if found} == {
        message.name: numbers(message) for message in built.message_type
    }
    values = {value.name for enum in built.enum_type for value in enum.value}
    prefixes = tuple(f"{enum.name.removesuffix('Kind').upper()}_" for enum in built.enum_type)
    assert {name for name in constants(stub.body) if name.startswith(prefixes)} == values
