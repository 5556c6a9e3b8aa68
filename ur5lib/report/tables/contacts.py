"""Each alarm: when, the largest force in it, the mass of a load, and where a contact may be."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ur5lib.force.contact_link import touched_link
from ur5lib.report.study_results import Row, StudyResults

LINKS = [f"on_link_{link}" for link in range(1, 7)]
COLUMNS = [
    "recording",
    "estimate",
    "start_s",
    "end_s",
    "peak_s",
    "Fx",
    "Fx_std",
    "Fy",
    "Fy_std",
    "Fz",
    "Fz_std",
    "kind",
    "load_mass",
    "load_mass_std",
    "link",
    *LINKS,
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    links = results.all("links")
    for name, summary in results.each("detection"):
        yield from contact_rows(name, summary, links[name])


def contact_rows(
    recording: str, detection: Mapping[str, Any], links: Mapping[str, Any]
) -> Iterator[Row]:
    """Yield each alarm: its time, largest force, the mass of a load, and the links where it may be.

    detection, links: detection.json and links.json.
    """
    for estimate, found in detection.items():
        known = {own["start"]: own["links"] for own in links.get(estimate, [])}
        for alarm in found["raised"]:
            values = zip("xyz", alarm["force"], alarm["force_std"], strict=True)
            yield {
                "recording": recording,
                "estimate": estimate,
                "kind": alarm.get("kind", "contact"),
                "load_mass": alarm.get("load_mass"),
                "load_mass_std": alarm.get("load_mass_std"),
                "start_s": alarm["start"],
                "end_s": alarm["end"],
                "peak_s": alarm["peak"],
                **_place(known.get(alarm["start"])),
                **{
                    name: number
                    for axis, force, std in values
                    for name, number in ((f"F{axis}", force), (f"F{axis}_std", std))
                },
            }


def _place(probabilities: Sequence[float] | None) -> Row:
    """Return the probability of each link, and the link, None where the torques cannot tell."""
    if probabilities is None:
        return {}
    link = touched_link(dict(enumerate(probabilities, start=1)))
    return {"link": link, **dict(zip(LINKS, probabilities, strict=True))}
