"""Evidence for what a block of columns is: rows of log-odds, the rule that adds them, and words.

A row says by how much each candidate is less likely than its source's favourite. No source counts
for more than its cap, since its model may be false: a misfit, which grows with the number of
samples, outdoes no name, and no name outdoes a proof. A source neither decides nor speaks.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from ur5lib.records.account import Confidence, Evidence


class Source(NamedTuple):
    """What may speak for a candidate. cap: nats; says: in words; telling: whether it is more than a
    prior, without which nothing is known.
    """

    cap: float
    by: Evidence
    says: str
    telling: bool = True


SOURCES: Mapping[str, Source] = {
    "option": Source(60.0, "option", "`--columns` or `--unit` names it"),
    "bounds": Source(30.0, "numbers", "no current is above 60 A, no mA below 20", telling=False),
    "pose": Source(30.0, "numbers", "the flange by the arm's kinematics, within millimetres"),
    "gravity": Source(16.0, "numbers", "which unit gravity explains, by a maker's links"),
    "unit": Source(14.0, "name", "a unit, or a share of a rating, written in the name"),
    "motion": Source(12.0, "numbers", "accelerations: one factor"),
    "kind": Source(9.0, "numbers", "how common it is, before anything is seen", telling=False),
    "constants": Source(12.0, "numbers", "several joints show the arm's constants, or others"),
    "gravity absent": Source(8.0, "numbers", "friction and inertia alone explain it"),
    "name": Source(7.0, "name", "the name of the quantity"),
    "arm": Source(6.0, "numbers", "what the arm measures, by its description", telling=False),
    "own links": Source(4.0, "numbers", "gravity by links that the user described", telling=False),
    "place": Source(4.0, "position", "columns without a name", telling=False),
    "alone": Source(
        7.0, "position", "the one block beside positions and velocities", telling=False
    ),
    "container": Source(3.0, "name", "the convention of the message", telling=False),
}
WORDS = {  # by code; numbers of the row in braces
    "stated": "as stated",
    "named": "its name is read as {name}",
    "unit in name": "its name has the unit {unit}",
    "share in name": "a share of a rating, or counts, by its name",
    "too large": "no current: it reaches {peak:.3g}, and none is above {bound:g} A",
    "measures torques": "{arm} measures torques",
    "by gravity": "gravity tells {unit}, by {lead:.3g} of log-likelihood before {rival}",
    "share as near": "a share of rated torques may be as near: the maker's manual has the unit",
    "constants shown": "{constants}, nearer than those of other units",
    "other constants": "no unit has these constants: {constants}",
    "one factor": "one factor for all joints, and no unit, has these constants: {constants}",
    "gravity absent": "less gravity, for motion alone explains {share:.0%} of it, gravity no more",
    "accelerations": "accelerations: {factor:.2g} times the slopes of the velocities",
    "pose": "a pose in {unit}: within {miss:.1f} mm of the flange of {arm}, or a tool on it{turn}",
}
ASSUMED, PROVEN, DOUBT = 3.0, 8.0, 4.0  # nats: of the lead, and of the row that contradicts most


class Row(NamedTuple):
    """What a source says of a block.

    odds: log-odds by candidate [nats], 0 where it says nothing; code: of its words; numbers: behind
    it; exact: whether it may prove, as constants of several joints.
    """

    source: str
    odds: Mapping[str, float]
    code: str = ""
    numbers: Mapping[str, object] = {}
    exact: bool = False

    def capped(self, candidates: Sequence[str]) -> dict[str, float]:
        """Return the log-odds of candidates below the favourite's, by at most the source's cap."""
        odds = {one: self.odds.get(one, 0.0) for one in candidates}
        best = max(odds.values())
        return {one: max(value - best, -SOURCES[self.source].cap) for one, value in odds.items()}

    def words(self) -> str:
        """Return the row in words, "" where it has none."""
        return WORDS[self.code].format(**self.numbers) if self.code else ""

    def in_figures(self, candidates: Mapping[str, str]) -> str:
        """Return candidates, by their words, with the log-odds that the row adds."""
        odds = sorted(self.capped([*candidates]).items(), key=lambda one: -one[1])
        return ", ".join(f"{candidates[one]} {value:.3g}" for one, value in odds)


class Verdict(NamedTuple):
    """What is decided of a block.

    candidate, rival: the likeliest and the next; lead: of the first [nats]; told: whether anything
    but priors speaks for it; by: the kind of source that speaks most; doubt: the row that
    contradicts, None without one; speaking: rows that speak for it, the strongest first.
    """

    candidate: str
    rival: str
    lead: float
    confidence: Confidence
    told: bool
    by: Evidence
    doubt: Row | None
    speaking: Sequence[Row]

    def reason(self, candidates: Mapping[str, str]) -> str:
        """Return why, in words: what contradicts first, then what speaks for it, then the rival."""
        return "; ".join(filter(None, self._parts(candidates)))

    def _parts(self, candidates: Mapping[str, str]) -> Iterator[str]:
        if self.doubt is not None:
            yield f"but {self.doubt.words() or self.doubt.source}"
        yield from dict.fromkeys(row.words() for row in self.speaking)
        if self.confidence == "check":
            yield f"{self.lead:.2g} of log-odds before {candidates[self.rival]}"


def decide(
    rows: Sequence[Row], candidates: Sequence[str], surest: Confidence = "proven"
) -> Verdict:
    """Return the verdict on a block by all rows of evidence.

    It is proven if exact rows lead and nothing contradicts, assumed if it leads clearly by more
    than priors, or the user states it, else to be checked. candidates: the last is none of these;
    surest: as it may be.
    """
    capped = [row.capped(candidates) for row in rows]
    total = {one: sum(odds[one] for odds in capped) for one in candidates}
    best, rival = sorted(total, key=lambda one: -total[one])[:2]
    lead, ahead = total[best] - total[rival], [odds[best] - odds[rival] for odds in capped]
    other = max((one for one in candidates[:-1] if one != best), key=lambda one: total[one])
    told = any(
        SOURCES[row.source].telling and odds[best] > odds[other]
        for row, odds in zip(rows, capped, strict=True)
    )
    proof = sum(own for row, own in zip(rows, ahead, strict=True) if row.exact)
    doubt = _doubt(rows, [-odds[best] for odds in capped])
    stated = any(
        row.source == "option" and odds[best] > odds[other]
        for row, odds in zip(rows, capped, strict=True)
    )
    sure: Confidence = "check"
    if lead >= ASSUMED and told and (doubt is None or stated) and surest != "check":
        is_proven = proof >= PROVEN and lead >= PROVEN and surest == "proven"
        sure = "proven" if is_proven and doubt is None else "assumed"
    speaking = [*_speaking(rows, [odds[best] - _mean(odds) for odds in capped], doubt)]
    main = max(zip(ahead, rows, strict=True), key=lambda one: one[0])[1]
    by = SOURCES[main.source].by
    return Verdict(best, rival, lead, sure, told, by, doubt, speaking)


def _mean(odds: Mapping[str, float]) -> float:
    return sum(odds.values()) / len(odds)


def _doubt(rows: Sequence[Row], against: Sequence[float]) -> Row | None:
    """Return the row that contradicts the verdict most, None where none does clearly."""
    pairs = [pair for pair in zip(against, rows, strict=True) if pair[1].source != "kind"]
    most, row = max(pairs, key=lambda one: one[0], default=(0.0, None))
    return row if most > DOUBT else None


def _speaking(rows: Sequence[Row], ahead: Sequence[float], doubt: Row | None) -> Iterator[Row]:
    """Yield the rows that speak for the verdict more than for others, the strongest first."""
    ordered = sorted(zip(ahead, rows, strict=True), key=lambda one: -one[0])
    yield from (row for own, row in ordered if own > 0 and row is not doubt)
