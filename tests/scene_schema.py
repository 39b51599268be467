"""`make proto` takes the schemas of Foxglove's scene messages from its SDK.

They go to bus/scene.binpb, so that a log can have a scene without the SDK.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from foxglove.messages import FrameTransforms, SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

FILE: Final = Path(__file__).parents[1] / "bus" / "scene.binpb"


def schemas() -> bytes:
    """Return the files that declare both messages, each after those that it imports."""
    files: dict[str, FileDescriptorProto] = {}
    for schema in (SceneUpdate.get_schema(), FrameTransforms.get_schema()):
        for file in FileDescriptorSet.FromString(schema.data).file:
            files.setdefault(file.name, file)
    return FileDescriptorSet(file=files.values()).SerializeToString(deterministic=True)


if __name__ == "__main__":
    FILE.write_bytes(schemas())
