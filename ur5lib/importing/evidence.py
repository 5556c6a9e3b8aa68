"""The evidence of an import: what is proven, assumed or ambiguous."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Evidence:
    """Sentences about a file; ambiguous: parts that the entry therefore leaves out."""

    proven: list[str] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    ambiguous: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return the three lists as comments of a study."""
        return [
            f"# {kind}: {sentence}"
            for kind in ("proven", "assumed", "ambiguous")
            for sentence in getattr(self, kind)
        ]
