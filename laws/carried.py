"""Laws and estimators that are sent to a process on another machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from zenvoy.laws.by_name import ESTIMATORS, LAWS, Kind, registered, resolve
from zenvoy.laws.code import code_in
from zenvoy.laws.errors import UnknownLawError
from zenvoy.laws.sources import Sources
from zenvoy.laws.table import sources_of

_KINDS: Final = {kind.group: kind for kind in (LAWS, ESTIMATORS)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Carried:
    """A law or an estimator that can be pickled: its reference and its source."""

    reference: str
    group: str
    """The group of entry points of its kind."""
    sources: Sources | None
    """None if Python finds its module here, and so must find the same one there."""

    def load(self) -> None:
        """Load it in this process, under the same reference; raises UnknownLawError."""
        target, _, digest = self.reference.partition("#")
        kind = _KINDS[self.group]
        try:
            if self.sources is None:
                resolve(self.reference, None, kind, allow_code=True)
            else:
                registered(code_in(self.sources, digest), target, kind)
        except UnknownLawError as error:
            raise UnknownLawError(f"{target} on the worker: {error}") from error


def carried(reference: str, kind: Kind) -> Carried | None:
    """Return a law or an estimator that is loaded here; None for one that comes with Zenvoy."""
    if reference in kind.taken():
        return None
    return Carried(reference=reference, group=kind.group, sources=sources_of(reference))
