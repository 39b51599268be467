"""A law to compare as its user writes it: NAME, file.py:NAME, or NAME:{parameter: value}."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from zenvoy.laws import builtin
from zenvoy.scenarios import COMMAND_LINE, Place, Spelling
from zenvoy.scenarios.reading.source import parse
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study

_FORMS: Final = "NAME, module:NAME, file.py:NAME, and NAME:{parameter: value}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LawChoice:
    """A law, and what is given with it.

    Keys of `given` with a dot in them are settings of the scenario, the others parameters of the
    law.
    """

    text: str
    reference: str
    given: Mapping[str, Any]
    place: Place
    """The option where the law is written."""

    @property
    def parameters(self) -> dict[str, Any]:
        """The given parameters of the law."""
        return {key: value for key, value in self.given.items() if "." not in key}

    def settings(self, model: str) -> dict[str, Any]:
        """Return the settings that give this law to a scenario whose own model is `model`.

        The parameters of the scenario's own law stay if this is the same law without parameters.
        """
        law = builtin().get(self.reference)
        own = self.parameters
        found: dict[str, Any] = {"control.model": self.reference}
        if law is not None and law.section is not None:
            found["control.parameters"] = {}
            found |= {f"control.{law.section}.{name}": value for name, value in own.items()}
        elif own or self.reference != model.partition("#")[0]:
            found["control.parameters"] = own
        return found | {key: value for key, value in self.given.items() if "." in key}

    def found_from(self, folder: Path | None) -> LawChoice:
        """Return the choice with a path that the rules for `control.model` find.

        These look beside the scenario, in `folder`; None: a built-in scenario. A file that is not
        there may be named from the current folder.
        """
        name, colon, attribute = self.reference.rpartition(":")
        if folder is None or not name.endswith(".py") or (folder / name).is_file():
            return self
        here = Path(name).absolute()
        return replace(self, reference=f"{here}{colon}{attribute}") if here.is_file() else self


def law_choice(text: str, spelling: Spelling = COMMAND_LINE) -> LawChoice:
    """Return the law that a text names; raises BadStudyError."""
    text = text.strip()
    head, brace, rest = text.partition("{")
    reference = head.strip().removesuffix(":").strip()
    place = Place(source=spelling.option("laws", text))
    if not reference:
        raise bad_study("", f"names no law; allowed: {_FORMS}", place)
    given = _mapping(brace + rest, place) if brace else {}
    return LawChoice(text=text, reference=reference, given=given, place=place)


def _mapping(text: str, place: Place) -> dict[str, Any]:
    """Return the mapping that a text in YAML describes; raises BadStudyError."""
    root, problems = parse(text, lambda _: place)
    if problems:
        raise BadStudyError(problems)
    found = None if root is None else root.plain()
    if not isinstance(found, dict):
        raise bad_study("", f"no mapping of parameters; allowed: {_FORMS}", place)
    for key, value in found.items():
        name, colon, rest = key.partition(":")
        if value is None and colon:
            raise bad_study(key, f"a space is missing after the colon; write {name}: {rest}", place)
    return found
