"""Whether the recordings' files are complete and fit the study."""

import pandas as pd

from ur5lib.report.cells import sentence
from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.findings import SEVERITIES, count_findings, group_findings
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import bars

TOPIC = "Data quality"
LOST = "lost frames"
SPOKEN = {
    LOST: "lost {frames} (interpolated)",
    "impossible frames": "has impossible values in {frames} (discarded)",
}
STATES: dict[str, State] = {"stop": "do not use", "error": "usable", "warning": "usable"}


def verdict(results: Results) -> Verdict:
    """Judge by the most serious finding, and name its file."""
    found = results.tables["quality"]
    serious = found[found["severity"] != "note"]
    states = [STATES[name] for name in SEVERITIES[:-1] if name in {*serious["severity"]}]
    lost = lost_shares(results)
    return Verdict(
        topic=TOPIC,
        state=states[0] if states else "good",
        sentence=worst(results),
        evidence=_counts(found, len(lost)),
        drawing=bars(lost),
        caption="Share of frames lost, by recording.",
        numbers=tuple(
            Number(f"findings of severity “{name}”", int((found["severity"] == name).sum()), "")
            for name in SEVERITIES
        ),
    )


def worst(results: Results) -> str:
    """Return the most serious finding with its file: of equal ones, that of most frames."""
    found = group_findings(results.tables["quality"])
    found = found[found["severity"] != "note"]
    if found.empty:
        return "No file has an error or a warning."
    frames = results.tables["recordings"].set_index("recording")["frames"]
    rank = found["severity"].map(SEVERITIES.index)
    share = found["count"] / found["recording"].map(frames)
    ranked = found.assign(rank=rank, share=share).sort_values(
        ["rank", "share"], ascending=[True, False], kind="stable"
    )
    first = ranked.iloc[0]
    name = results.file_of(first["recording"])
    if first["finding"] in SPOKEN:
        count = f"{first['count']:,} of {frames[first['recording']]:,} frames"
        return f"{name} {SPOKEN[first['finding']].format(frames=count)}."
    return f"{name}, {first['finding']}: {first['detail'].partition('; ')[0]}."


def lost_shares(results: Results) -> dict[str, float]:
    """Return the share of lost frames of each recording."""
    frames = results.tables["recordings"].set_index("recording")["frames"]
    lost = results.rows("quality", finding=LOST).groupby("recording")["count"].sum()
    shares = (lost.reindex(frames.index) / frames).fillna(0.0)
    return {str(name): float(share) for name, share in shares.items()}


def _counts(found: pd.DataFrame, recordings: int) -> str:
    """Return how many findings there are by severity, and on how many recordings."""
    bad = found.loc[found["severity"] != "note", "recording"].nunique()
    where = f"errors or warnings on {bad} of {recordings} recordings" if bad else ""
    return sentence("; ".join(filter(None, [count_findings(found), where])))
