"""The schemas of the messages in a log, by which any reader decodes them."""

from __future__ import annotations

from functools import cache

from google.protobuf.descriptor_pb2 import FileDescriptorSet

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.scene_schema import scene_schema


def schema_of(message: str) -> bytes:
    """Return a FileDescriptorSet that declares a message, given by its full name."""
    own = message.startswith(f"{pb.DESCRIPTOR.package}.")
    return _own_schema() if own else scene_schema()


@cache
def _own_schema() -> bytes:
    """Return messages.proto as a FileDescriptorSet."""
    files = FileDescriptorSet()
    pb.DESCRIPTOR.CopyToProto(files.file.add())
    return files.SerializeToString()
