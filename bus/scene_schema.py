"""Foxglove's messages of a 3D scene, by the schemas that its SDK has under the MIT licence."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any, Final

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

SCENE: Final = "foxglove.SceneUpdate"
"""A scene: vehicles and road."""
TRANSFORMS: Final = "foxglove.FrameTransforms"
"""Frames of reference, which a camera can follow."""


@cache
def scene_schema() -> bytes:
    """Return the FileDescriptorSet that declares both messages; `make proto` writes it."""
    return files("zenvoy.bus").joinpath("scene.binpb").read_bytes()


@cache
def scene_class(name: str) -> Any:
    """Return the class of a message by its full name."""
    return GetMessageClass(_pool().FindMessageTypeByName(name))


@cache
def _pool() -> DescriptorPool:
    """Return a pool of its own, because packages of Foxglove register the same files elsewhere."""
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(scene_schema()).file:
        pool.Add(file)
    return pool
