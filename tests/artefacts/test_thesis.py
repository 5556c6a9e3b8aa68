"""The thesis, rebuilt: what the workflow made of its real recordings."""

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

from tests.conftest import PROJECT
from ur5lib.tables import channel, read_csv, read_json, read_table

TABLE_5_6 = "Movement_No5_Acc_slow_no_disturbance"
TABLE_6_1 = "Movement_No9_Singularity_Free_ForceSensor"

# Rigid models at the target motion, computed independently of this project [Nm].
INDEPENDENT = {
    "A": [0.3213, 1.7938, 1.9526, 0.1889, 0.2378, 0.0334],
    "B": [0.2959, 0.5891, 1.1844, 0.0795, 0.0561, 0.0334],
    "C": [0.2832, 0.5548, 1.1865, 0.0681, 0.0393, 0.0334],
}


@pytest.fixture(scope="module")
def torque(thesis_results: Path) -> pd.DataFrame:
    return read_csv(thesis_results / "tables" / "torque_mae.csv")


@pytest.fixture(scope="module")
def force(thesis_results: Path) -> pd.DataFrame:
    table = read_csv(thesis_results / "tables" / "force_mae.csv")
    return table[table["recording"] == TABLE_6_1]


@pytest.mark.parametrize("model", ["A", "B", "C"])
def test_torque_errors_agree_with_an_independent_computation(
    torque: pd.DataFrame, model: str
) -> None:
    rows = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == @model")
    assert rows["joint"].tolist() == [1, 2, 3, 4, 5, 6]
    assert np.abs(rows["mae"].to_numpy() - INDEPENDENT[model]).max() < 0.002


def test_printed_torque_errors_stand_beside(torque: pd.DataFrame) -> None:
    rows = torque.query("recording == @TABLE_5_6 and motion == 'target'").set_index("model")
    assert rows.loc[["A", "B", "C"], "printed"].notna().all()
    assert rows.loc["C+rotors", "printed"].isna().all()
    older = torque[torque["model"] == "[21]"]
    assert older["printed"].tolist() == [0.7090, 25.8024, 14.2721, 1.2721, 0.2001, 0.0333]
    assert older["mae"].isna().all()


@pytest.mark.parametrize(
    ("estimate", "within"),
    [("Fu", 0.01), ("F", 0.03), ("F*", 0.13)],
)
def test_printed_force_errors_are_met(force: pd.DataFrame, estimate: str, within: float) -> None:
    """Table 6.1."""
    rows = force.query("kind == 'printed' and estimate == @estimate")
    assert len(rows) == 6
    assert (rows["mae"] / rows["printed_mae"] - 1).abs().max() < within


def test_printed_largest_errors_are_met(force: pd.DataFrame) -> None:
    """Table 6.2; those of F need the Jacobian's lag (erratum 13)."""
    rows = force.query("kind == 'printed'")
    gap = (rows["max"] / rows["printed_max"] - 1).abs().groupby(rows["estimate"]).max()
    assert gap["Fu"] < 0.04
    assert gap["F"] < 0.006
    assert gap["F*"] < 0.05


@pytest.mark.parametrize(
    ("kind", "expected"), [("printed", [6.40, 3.31, 4.63]), ("corrected", [2.90, 2.39, 3.51])]
)
def test_errors_of_no_force_are_known(
    force: pd.DataFrame, kind: str, expected: list[float]
) -> None:
    """Against the raw and the bias-free sensor, computed independently [N]."""
    rows = force[(force["kind"] == kind) & (force["estimate"] == "Fu")]
    np.testing.assert_allclose(rows["zero_mae"][:3], expected, atol=0.006)


def test_tool_vector_is_the_origin_of_frame_6(thesis_results: Path) -> None:
    """The controller's own forward kinematics, to its resolution of 0.1 mm."""
    for folder in (thesis_results / "recordings").iterdir():
        pose = channel(read_table(folder / "robot.parquet"), "actual_TCP_pose")
        origin = channel(read_table(folder / "kinematics.parquet"), "o6", 3)
        assert np.abs(pose[:, :3] - origin).max() < 2e-4


def test_tool_speed_is_the_jacobian_times_the_joint_speed(thesis_results: Path) -> None:
    folder = thesis_results / "recordings" / TABLE_5_6
    robot, kinematics = (read_table(folder / f"{n}.parquet") for n in ("robot", "kinematics"))
    J = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    speed = (J @ channel(robot, "actual_qd")[..., None])[..., 0]
    assert np.abs(speed - channel(robot, "actual_TCP_speed")).mean() < 2e-3


def test_known_defects_are_found(thesis_results: Path) -> None:
    quality = read_csv(thesis_results / "tables" / "quality.csv")
    stale = quality.query("recording == @TABLE_6_1 and finding == 'stale copy'")
    assert stale["device"].tolist() == ["imu"]
    absent = quality.query("finding == 'no sensor'")
    assert TABLE_5_6 in set(absent["recording"])
    torn = quality.query("recording == @TABLE_5_6 and finding == 'torn last line'")
    assert torn["detail"].str.contains("log_i_target.csv, line 3244").any()
    devices = read_json(thesis_results / "recordings" / TABLE_5_6 / "quality.json")["devices"]
    assert devices == ["robot", "imu"]


def test_clocks_come_with_their_error(thesis_results: Path) -> None:
    clocks = read_csv(thesis_results / "tables" / "clocks.csv").set_index(["recording", "device"])
    force = clocks.loc[(TABLE_6_1, "force")]
    assert force["offset_s"] == pytest.approx(-0.0056, abs=1e-3)
    assert (clocks["offset_std_s"] > 0).all()


# The report


class Page(HTMLParser):
    """Tags, and the cells of each table by its caption."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict]] = []
        self.tables: dict[str, list[list[str]]] = {}
        self.caption = ""
        self.inside = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.tags.append((tag, dict(attrs)))
        self.inside = tag
        if tag == "caption":
            self.caption = ""
        elif tag == "tr":
            self.tables.setdefault(self.caption, []).append([])
        elif tag in ("td", "th"):
            self.tables[self.caption][-1].append("")

    def handle_data(self, data: str) -> None:
        if self.inside == "caption":
            self.caption += data
        elif self.inside in ("td", "th"):
            self.tables[self.caption][-1][-1] += data

    def handle_endtag(self, _: str) -> None:
        self.inside = ""

    def table(self, words: str) -> list[list[str]]:
        (rows,) = [rows for caption, rows in self.tables.items() if words in caption]
        return rows


@pytest.fixture(scope="module")
def page(thesis_results: Path) -> Page:
    return Page((thesis_results / "report.html").read_text())


def test_the_report_needs_no_network(thesis_results: Path, page: Page) -> None:
    for tag, attributes in page.tags:
        assert tag not in ("script", "link", "iframe")
        for name in ("src", "href"):
            assert attributes.get(name, "#").startswith(("data:", "#"))
    assert "@import" not in (thesis_results / "report.html").read_text()


def test_the_report_is_well_formed_for_readers(page: Page) -> None:
    names = [tag for tag, _ in page.tags]
    assert names.count("h1") == 1
    assert all(attributes["alt"] for tag, attributes in page.tags if tag == "img")
    assert ("html", {"lang": "en"}) in page.tags


def test_table_5_6_shows_the_numbers_of_the_csv(page: Page, torque: pd.DataFrame) -> None:
    header, *rows = page.table("beside Table 5.6")
    target = torque.query("recording == @TABLE_5_6 and motion == 'target'")
    for model in "ABC":
        expected = target[target["model"] == model].set_index("joint")
        for row in rows:
            cells = dict(zip(header, row, strict=True))
            joint = int(cells["joint"])
            assert cells[f"{model} printed"] == f"{expected.loc[joint, 'printed']:.4f}"
            assert cells[f"{model} rebuilt"].lstrip("▼▲ ") == f"{expected.loc[joint, 'mae']:.4f}"


def test_the_torque_table_shows_each_number_in_its_column(page: Page, torque: pd.DataFrame) -> None:
    header, *rows = page.table(f"on {TABLE_5_6}, at the target and at the measured motion")
    computed = torque[(torque["recording"] == TABLE_5_6) & torque["mae"].notna()]
    expected = computed.set_index(["motion", "model", "joint"])["mae"]
    assert len(rows) * (len(header) - 2) == len(expected)
    for row in rows:
        for title, cell in list(zip(header, row, strict=True))[1:-1]:
            model, motion = title.split(", ")
            assert cell.lstrip("▼▲ ") == f"{expected[motion, model, int(row[0])]:.4f}"


@pytest.mark.parametrize(
    ("figure", "words"), [("mae", "beside Table 6.1"), ("max", "beside Table 6.2")]
)
def test_tables_6_show_the_numbers_of_the_csv(
    page: Page, force: pd.DataFrame, figure: str, words: str
) -> None:
    header, *rows = page.table(words)
    printed = force[force["kind"] == "printed"].set_index(["component", "estimate"])
    for row in rows:
        cells = dict(zip(header, row, strict=True))
        component = cells["component"].split()[0]
        for estimate, label in (("Fu", "F̂ᵘ"), ("F", "F̂"), ("F*", "F̂*")):
            expected = printed.loc[(component, estimate)]
            assert cells[f"{label} printed"] == f"{expected[f'printed_{figure}']:.2f}"
            assert cells[f"{label} rebuilt"].lstrip("▼▲ ") == f"{expected[figure]:.2f}"


@pytest.mark.parametrize("figure", ["mae", "max"])
def test_the_force_tables_show_each_number_in_its_column(
    page: Page, force: pd.DataFrame, figure: str
) -> None:
    name = {"mae": "Mean", "max": "Largest"}[figure]
    header, *rows = page.table(f"{name} absolute error on {TABLE_6_1}, as printed and corrected")
    labels = {"F̂ᵘ": "Fu", "F̂": "F", "F̂*": "F*", "zero": "Fu"}
    kinds = {"as printed": "printed", "corrected": "corrected"}
    expected = force.set_index(["kind", "estimate", "component"])
    assert [len(row) for row in rows] == [9] * 6
    for row in rows:
        for title, cell in list(zip(header, row, strict=True))[1:]:
            label, _, kind = title.partition(" ")
            column = f"zero_{figure}" if label == "zero" else figure
            value = expected.loc[(kinds[kind], labels[label], row[0].split()[0]), column]
            assert cell.lstrip("▼▲ ") == f"{value:.2f}"


def test_the_report_holds_what_was_promised(thesis_results: Path, page: Page) -> None:
    text = (thesis_results / "report.html").read_text()
    for figure in ("5.11", "5.12", "6.4", "6.6", "6.8"):
        assert re.search(rf"after Figures? [0-9. and]*{re.escape(figure)}", text), figure
    assert len(re.findall(r"<li>[^<]*Here: ", text)) == 15  # errata
    assert "Made by commit" in text
    assert "cutoff_hz: 1.454" in text
    assert "pytorch-kinematics" in text
    images = [tag for tag, _ in page.tags if tag == "img"]
    assert len(images) >= 3 * 2 + 6
    assert (thesis_results / "report.html").stat().st_size < 6e6


def test_the_pdf_says_the_same(thesis_results: Path, torque: pd.DataFrame) -> None:
    pages = PdfReader(thesis_results / "report.pdf").pages
    text = "\n".join(page.extract_text() for page in pages)
    for value in torque.query("motion == 'target'")["mae"]:
        assert f"{value:.4f}" in text
    for section in ("What was found", "Joint torques", "Contact forces", "Errata", "Provenance"):
        assert section in text


def test_the_readme_tells_the_numbers_of_the_tables(
    torque: pd.DataFrame, force: pd.DataFrame
) -> None:
    readme = (PROJECT / "README.md").read_text()
    row = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == 'C'").iloc[1]
    assert f"| {row['printed']:.3f} | {row['mae']:.3f} | |" in readme
    rotors = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == 'C+rotors'")
    assert f"| | {rotors['mae'].iloc[1]:.3f} | |" in readme
    along_x = force.query("estimate == 'F*' and component == 'Fx'").set_index("kind")
    printed, corrected = along_x.loc["printed"], along_x.loc["corrected"]
    values = (printed["printed_mae"], printed["mae"], printed["zero_mae"])
    assert "| {:.2f} | {:.2f} | {:.2f} |".format(*values) in readme
    assert f"| | {corrected['mae']:.2f} | {corrected['zero_mae']:.2f} |" in readme
