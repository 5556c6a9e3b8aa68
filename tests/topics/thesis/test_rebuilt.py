"""The thesis's numbers, rebuilt: what the workflow made of its real recordings."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lxml.html import fromstring

import ur5lib
from tests.artefacts.documents import page_texts
from tests.conftest import PROJECT
from tests.topics.pages import Shown
from ur5lib.finished import FinishedStudy
from ur5lib.topics.thesis.reference import read_reference

TABLE_5_6 = "Movement_No5_Acc_slow_no_disturbance"
TABLE_5_7 = "Movement_No9_Singularity_Free_NoDist"
TABLE_6_1 = "Movement_No9_Singularity_Free_ForceSensor"
REFERENCE = read_reference(PROJECT / "workflow" / "studies" / "thesis_reference.yaml")
ERRATA = {erratum.place: f"{erratum.error} {erratum.choice}" for erratum in REFERENCE.errata}


@pytest.fixture(scope="module")
def study(thesis_results: Path) -> FinishedStudy:
    return ur5lib.load(thesis_results)


def test_gains_are_numbers_only_where_they_are_determined(study: FinishedStudy) -> None:
    """Of (C.4), joints 1 to 3 do not fit, 4 to 6 fit as well as the best."""
    gains = study.table("gains").query("recording == @TABLE_5_6")
    known = gains["determined"] == "yes"
    assert (gains["value"].notna() == known).all()
    assert gains[known][["joint", "gain"]].to_numpy().tolist() == [[2, "velocity"]]
    published = study.table("published_gains")
    fits = published.query("recording == @TABLE_5_6 and model == 'C'")["fits"]
    assert fits.tolist() == ["no", "no", "no", "yes", "yes", "yes"]


@pytest.fixture(scope="module")
def printed(study: FinishedStudy) -> pd.DataFrame:
    return study.table("printed")


MET = [  # numbers that are rebuilt: within a share, or half of the last of four decimals
    ("Table 5.6", "MAE of τ̂ [Nm]", [*"ABC"], 3, 0.06),  # joints 1 to 3
    ("Table 5.5", "MAE of q̂ [rad]", [*"AB"], 6, 0.2),
    ("Table 5.5", "MAE of q̂̇ [rad/s]", [*"AB"], 6, 0.2),
    ("Equations 6.5, 6.6", "k [Nm/A], b [Nm]", [*"kb"], 6, 0.05),  # offsets below 1 Nm: 0.1 Nm
    ("Table 6.1", "MAE of the force [N, Nm]", ["Fu"], 6, 0.01),
    ("Table 6.1", "MAE of the force [N, Nm]", ["F"], 6, 0.03),
    ("Table 6.1", "MAE of the force [N, Nm]", ["F*"], 6, 0.13),
    ("Table 6.2", "largest error of the force [N, Nm]", ["Fu"], 6, 0.04),
    ("Table 6.2", "largest error of the force [N, Nm]", ["F"], 6, 0.006),  # by erratum 13
    ("Table 6.2", "largest error of the force [N, Nm]", ["F*"], 6, 0.05),
]


@pytest.mark.parametrize(("source", "quantity", "rows", "count", "share"), MET)
def test_printed_numbers_are_met(
    printed: pd.DataFrame, source: str, quantity: str, rows: list[str], count: int, share: float
) -> None:
    found = printed.query("source == @source and quantity == @quantity and row in @rows")
    found = found.groupby("row").head(count)
    assert len(found) == count * len(rows)
    size, gap = found["printed"].abs(), (found["rebuilt"] - found["printed"]).abs()
    small = np.where((found["row"] == "b") & (size < 1), 0.1, 0.5e-4)
    assert (gap <= np.maximum(share * size, small)).all()


def test_every_printed_number_is_judged(printed: pd.DataFrame) -> None:
    rows = [row for table in REFERENCE.printed.values() for row in dict(table.values).values()]
    assert printed["printed"].tolist() == [number for row in rows for number in row]
    assert {"Table 5.1", "Table 5.5", "Table 5.6", "Table 5.7", "Table 6.1", "Table 6.2"} <= {
        *printed["source"]
    }
    assert printed["status"].str.fullmatch(r"equal|unexplained|erratum \d+").all()
    assert (printed["status"] == "unexplained").sum() <= 6
    older = (printed["row"] == "[21]") & (printed["quantity"] == "MAE of τ̂ [Nm]")
    assert (printed["right"].isna() == older).all()


def test_equal_and_explained_numbers_are_near_the_print(printed: pd.DataFrame) -> None:
    """Within 5 %, 10 % in Table 5.7, or half of the last of four decimals."""
    share = np.where(printed["source"] == "Table 5.7", 0.1, 0.05)
    near = np.maximum(share * printed["printed"].abs(), 0.5e-4)
    rows = printed["source"].str.startswith(("Table", "Section"))
    equal = (printed["rebuilt"] - printed["printed"]).abs() <= near
    explained = (printed["as_erratum_says"] - printed["printed"]).abs() <= near
    status = printed["status"]
    assert (equal == (status == "equal"))[rows].all()
    assert explained[rows & status.str.startswith("erratum")].all()
    assert not (explained | equal)[rows & (status == "unexplained")].any()


def test_every_erratum_that_explains_a_number_says_so(printed: pd.DataFrame) -> None:
    """It exists, explains the recording's row by a computation, and its text has numbers."""
    for row in printed[printed["status"].str.startswith("erratum")].itertuples():
        erratum = REFERENCE.errata[int(row.status.removeprefix("erratum ")) - 1]
        assert row.row in {way.row for way in erratum.explains}
        assert re.search(r"\d+(\.\d+)? (%|s|mm|Nm|ms|above)", erratum.error)


def test_errata_state_the_numbers_of_the_printed_tables(printed: pd.DataFrame) -> None:
    """As rounded there; 0.168 Nm is printed in Section 5.2."""
    text, known = ERRATA, printed[["printed", "rebuilt", "as_erratum_says"]]
    torques = known[printed["source"].isin(["Table 5.1", "Table 5.6"])].to_numpy().ravel()
    for place in text:
        if place.startswith(("Table 5.6", "Table 5.1,")):
            stated = re.findall(r"\d+\.\d{3,}(?! mm)", text[place])
            digits = {len(number.partition(".")[2]) for number in stated}
            assert {*stated} <= {f"{own:.{n}f}" for own in torques for n in digits} | {"0.168"}
    missing = 100 * (1 - printed["printed"] / printed["rebuilt"])
    for model in ("[21]", "C"):
        rows = missing[(printed["quantity"] == "MAE of q̂̇ [rad/s]") & (printed["row"] == model)]
        assert f"{rows.min():.0f} to {rows.max():.0f} %" in text["Tables 5.1, 5.5"]
    ratio = printed[printed["source"] == "Table 5.7"].set_index("number")["ratio"]
    y, z = 100 * (1 - ratio[["y", "z"]])
    assert f"{y:.0f} and {z:.0f} % below" in text["Table 5.7, Section 5.5"]


@pytest.fixture(scope="module")
def published(thesis_results: Path) -> Shown:
    """The page of the published numbers."""
    return Shown(fromstring((thesis_results / "published.html").read_text()))


def test_every_unexplained_number_is_listed(published: Shown, printed: pd.DataFrame) -> None:
    """By table, row and per cent."""
    found = published.tables["unexplained"]
    rows = printed[printed["status"] == "unexplained"]
    assert len(found) == len(rows)
    for told, row in zip(found, rows.itertuples(), strict=True):
        assert [*told.values()][:3] == [row.source, row.quantity, row.row]
        nearest = row.rebuilt if np.isnan(row.as_erratum_says) else row.as_erratum_says
        off = float(told["off by"].replace("−", "-").removesuffix(" %"))
        assert off == pytest.approx(100 * (nearest / row.printed - 1), abs=0.5)


def test_table_5_7_follows_from_another_order_of_steps(printed: pd.DataFrame) -> None:
    rows = printed[printed["source"] == "Table 5.7"].set_index("number")
    assert (rows["as_erratum_says"] / rows["printed"] - 1).abs().max() < 0.07
    as_written = (rows["rebuilt"] / rows["printed"] - 1).abs()
    assert as_written[["x", "rx", "ry", "rz"]].max() < 0.07


@pytest.fixture(scope="module")
def constants(study: FinishedStudy) -> pd.DataFrame:
    return study.table("published_constants")


def test_the_printed_offset_of_joint_2_is_regression_to_the_mean(
    study: FinishedStudy, constants: pd.DataFrame
) -> None:
    """It follows the mean torque from run to run, and vanishes where the torque varies widely."""
    rows = constants.query("joint == 2").set_index(["regression", "recording"])
    forward, reverse = rows.loc["torque_on_current"], rows.loc["current_on_torque"]
    assert len(forward) == len(reverse) == 12
    assert np.corrcoef(forward["offset"], forward["mean_torque"])[0, 1] > 0.9
    small = forward.index[forward["mean_torque"].abs() < 20]
    assert len(small) == 3
    assert forward.loc[small, "offset"].abs().max() < 2
    assert forward.loc[small, "torque_constant"].between(9.9, 11.0).all()
    assert reverse.loc[TABLE_5_7, "offset"] < 5
    friction = study.table("friction").query("joint == 2")
    right = friction.set_index("parameter")
    assert abs(right.loc["offset", "value"]) < 2 * right.loc["offset", "std_error"]


def test_the_erratum_on_joint_2_states_the_numbers_of_the_tables(
    study: FinishedStudy, constants: pd.DataFrame
) -> None:
    rows = constants.query("joint == 2").set_index(["regression", "recording"])
    forward, reverse = rows.loc["torque_on_current"], rows.loc["current_on_torque"].loc[TABLE_5_7]
    varied = forward[forward["mean_torque"].abs() < 20]
    friction = study.table("friction").query("joint == 2")
    fit = friction.set_index("parameter")
    ranges = [
        (forward["offset"], " Nm"),
        (varied["offset"], " Nm"),
        (varied["torque_constant"], ""),
    ]
    fitted = [(fit.loc["offset"], " Nm"), (fit.loc["torque_constant"], " Nm/A")]
    numbers = [f"{own.min():.1f} to {own.max():.1f}{unit}" for own, unit in ranges]
    numbers += [f"{reverse['offset']:.1f} Nm and {reverse['torque_constant']:.1f} Nm/A"]
    numbers += [f"{own['value']:.1f} ± {own['std_error']:.1f}{unit}" for own, unit in fitted]
    text = ERRATA["Equations 6.5, 6.6"]
    assert [number for number in numbers if number.replace("-", "−") not in text] == []


def test_table_5_6_shows_the_numbers_of_the_csv(published: Shown, printed: pd.DataFrame) -> None:
    [name] = (name for name in published.tables if name.startswith("printed-torques-"))
    rows = published.tables[name]
    assert len(rows) == 6
    for model in "ABC":
        expected = printed.query("table == 'torque_mae' and row == @model").set_index("number")
        for row in rows:
            known = expected.loc[row["joint"]]
            assert row[f"{model} printed"] == f"{known['printed']:.4f}"
            assert row[f"{model} rebuilt"].lstrip("▼▲ ") == f"{known['rebuilt']:.4f}"


def test_the_page_has_the_figures_errata_and_numbers_of_the_thesis(published: Shown) -> None:
    captions = " ".join(own.text_content() for own in published.section.iter("figcaption"))
    for figure in ("5.1", "5.9", "5.10", "5.14", "6.1", "6.4", "6.6", "6.8"):
        assert re.search(rf"Figures? [0-9., andto]*{re.escape(figure)}\b", captions), figure
    errata = [own for own in published.section.iter("li") if own.get("id", "").startswith("erra")]
    assert len(errata) == len(REFERENCE.errata) == 23
    targets = {*published.section.xpath("//*/@id")}
    links = {
        link.removeprefix("#") for link in published.section.xpath("//a/@href[starts-with(., '#')]")
    }
    assert links <= targets


def test_the_report_counts_the_published_numbers(
    thesis_results: Path, printed: pd.DataFrame
) -> None:
    """And so does the PDF."""
    equal = (printed["status"] == "equal").sum()
    told = f"{equal} of {len(printed)} numbers that the thesis prints are rebuilt here"
    assert told in Shown(fromstring((thesis_results / "report.html").read_text())).text
    assert told in "\n".join(page_texts(thesis_results / "report.pdf"))


def test_the_page_of_the_thesis_tells_the_numbers_of_the_tables(
    study: FinishedStudy, printed: pd.DataFrame
) -> None:
    torque, force = study.table("torque_mae"), study.table("force_mae")
    known = printed.set_index(["table", "row", "number"])["printed"]
    page = (PROJECT / "docs" / "errata.md").read_text()
    found = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == 'identified'")
    assert f"| | {found['mae'].iloc[1]:.4f} | |" in page
    table = study.table("acceleration_mae")
    rows = table.query("recording == @TABLE_5_7 and component == 'x'").set_index("estimate")
    ours = rows.loc["encoders"]
    assert f"| {known['acceleration_mae', 'euler', 'x']:.2f} | {ours['mae']:.3f} | |" in page
    row = torque.query("recording == @TABLE_5_6 and motion == 'target' and model == 'C'").iloc[1]
    assert f"| {known['torque_mae', 'C', '2']:.3f} | {row['mae']:.3f} | |" in page
    along_x = force.query("recording == @TABLE_6_1 and component == 'Fx'").set_index(
        ["kind", "estimate", "during"]
    )
    whole = along_x.loc["printed", "F*", "all"]
    values = (known["force_mae", "F*", "Fx"], whole["mae"], whole["zero_mae"])
    assert "| {:.2f} | {:.2f} | {:.2f} |".format(*values) in page
    for words, estimate in (
        ("the same in contact", "F*"),
        ("contact force by this project, x, in contact", "Fmap"),
    ):
        row = along_x.loc["compensated", estimate, "contact"]
        (line,) = [line for line in page.splitlines() if words in line]
        assert f"(mean force there {row['mean_force']:.1f} N)" in line
        assert line.endswith(f"| | {row['mae']:.2f} | {row['zero_mae']:.2f} |")
