"""The first screen of made-up tables: its sentence, cards, figure, and the tables they lead to."""

import re
from typing import Any

import pytest
from lxml.html import HtmlElement

from tests.conftest import Workflow
from tests.made_study import (
    DOUBTED,
    FAR,
    REFUSED,
    UNKNOWN,
    constant,
    finding,
    judged_anew,
    predicted,
    push,
    rates,
    sensed,
    study,
    torques,
    touched,
)
from tests.report.illustrated import EVERY
from tests.typeset_page import built, headline_of, page_of, plain, tables_of, text_of
from ur5lib.force.estimators import LEADING
from ur5lib.records.codes import Found
from ur5lib.records.verdicts import NO_DOUBT, STATES
from ur5lib.report.results import Results
from ur5lib.report.views.first_screen import first_figure

STUDIES: dict[str, dict[str, Any]] = {
    "nothing": {},
    "everything": EVERY,
    "a doubted sensor": EVERY | {"force_mae": touched(2.0, "seen") + touched(6.0, **DOUBTED)},
    "findings": EVERY | {"quality": [finding("error"), finding("warning", Found.JITTER)]},
    "no contact": EVERY | {"contact_errors": [], "force_mae": []},
    "refused": {"friction": [constant(1, 10.0, **REFUSED), constant(2, 10.0, **FAR)]},
    "stopped": EVERY | {"quality": [finding("stop", Found.CONTRADICTION)]},
    "contacts of fit": {"contact_errors": sensed((30.0, "found"), recording="fitted")},
    "a push that is not found": {
        "pushes": [push("slow", "x", None, bound=">", largest_tried=2943.0), push("fast", "y", 20)]
    },
}
MOST_WORDS = {"headline": 25, "said": 20, "key": 20, "first screen": 400}
MOST_NUMBERS = 4  # of the headline; “2 of 3” is one
NUMBER = re.compile(r"\d[\d,.]*(?: of \d+)?")
CARDS = "//div[@class='cards']/article"
BRIEF = "//div[@class='also']/details"
NEXT = "//h3[text()='What to do next']"


def words(text: str) -> list[str]:
    """Its words and numbers, without signs that are by themselves."""
    return [one for one in plain(text).split() if re.search(r"\w", one)]


def unfolded(section: HtmlElement) -> list[str]:
    """The words that a reader sees before opening anything, and before what to do next."""
    texts = section.xpath(
        ".//text()[following::h3[text()='What to do next']][not(ancestor::script)]"
        "[not(ancestor::details) or ancestor::summary][not(ancestor::*[local-name()='svg'])]"
    )
    return words(" ".join(texts))


@pytest.mark.parametrize("name", STUDIES)
def test_the_first_screen_is_short_and_has_the_states_of_the_table(name: str) -> None:
    check_first_screen(study(**STUDIES[name]))


def test_the_first_screen_of_the_default_study_is_short(demo: Workflow) -> None:
    check_first_screen(built(demo.folder / "results" / "demo"))


def check_first_screen(results: Results) -> None:
    page = page_of(results)
    told = headline_of(page)
    assert len(words(told)) <= MOST_WORDS["headline"]
    assert len(NUMBER.findall(told)) <= MOST_NUMBERS
    (section,) = page.xpath("//section[@class='first']")
    assert len(unfolded(section)) <= MOST_WORDS["first screen"]
    for kind in ("said", "key"):
        for element in page.xpath(f"{CARDS}/p[@class='{kind}']"):
            assert len(words(element.text_content())) <= MOST_WORDS[kind], element.text_content()
    shown = page.xpath(CARDS)
    assert all(len(card.xpath("p[@class='number']/b")) == 1 for card in shown)
    assert len(shown) <= 6
    rows = results.rows("verdicts", rank=1)
    states = rows.dropna(subset="state").set_index("question")["state"].to_dict()
    found = {card.get("data-question"): badge(card) for card in (*shown, *page.xpath(BRIEF))}
    assert {key: state for key, state in found.items() if state} == states


def badge(card: HtmlElement) -> str:
    """The state of a card, without its reason."""
    text = " ".join(map(str, card.xpath(".//span[contains(@class, 'badge')]/text()"))).strip()
    return {"": "", NO_DOUBT: "good", **{words: state for state, words in STATES.items()}}[text]


def card_of(results: Results, question: str) -> dict[str, str]:
    """The parts of a card: its number, its sentence, its evidence."""
    (card,) = page_of(results).xpath(f"{CARDS}[@data-question='{question}']")
    parts = {"number": "p[@class='number']", "said": "p[@class='said']", "evidence": "details"}
    return {name: plain(card.find(path).text_content()) for name, path in parts.items()}


def test_a_card_is_the_rows_of_its_question() -> None:
    card = card_of(study(force_mae=EVERY["force_mae"]), "force")
    assert card["number"] == "4.00 N"
    for told in ("zero: 10.0 N", "least squares without a detector at its worst: 5.00 N", "x, R3"):
        assert told in card["evidence"]
    card = card_of(study(force_mae=touched(2.0, "seen") + touched(6.0, **DOUBTED)), "force")
    assert card["number"].startswith("2.00 N")
    assert "6.00 N" in card["said"]


def test_results_without_verdicts_have_a_page_without_cards() -> None:
    made = study(**EVERY)
    bare = {"verdicts": made.tables["verdicts"][:0]}
    results = Results(made.study, made.tables | bare, drawn=made.drawn)
    page = page_of(results)
    assert page.xpath(f"{CARDS} | {BRIEF}") == []
    assert headline_of(page) == ""
    assert "force-decided" in tables_of(results)


# The first sentence


@pytest.mark.parametrize(
    ("name", "numbers", "said"),
    [
        ("everything", ["1 of 2", "4.00", "2 of 3"], "contacts.*absolute error.*; .*constant"),
        ("a doubted sensor", ["1 of 2", "2.00", "2 of 3"], "contacts.*absolute error.*;"),
        ("no contact", ["2 of 3", "2", "0.200"], "constant may be used; predicted currents"),
        ("contacts of fit", [], "^$"),
        ("stopped", [], "^$"),
        ("nothing", [], "^$"),
    ],
)
def test_the_sentence_states_contacts_or_pushes_force_and_constants(
    name: str, numbers: list[str], said: str
) -> None:
    """Nothing where a stop sign stands."""
    told = headline_of(page_of(study(**STUDIES[name])))
    assert NUMBER.findall(re.sub(r"joint\s\d", "", told)) == numbers
    assert re.search(said, told)


def test_an_arm_with_a_stop_sign_has_no_sentence() -> None:
    sign = {"robot": "ur5", "step": "stop sign", "remark": "wrong", "code": "unknown side"}
    assert headline_of(page_of(study(**EVERY, remarks=[sign]))) == ""


# The first figure


def test_the_first_figure_shows_what_the_study_is_about() -> None:
    alone: dict[str, Any] = {"torque_mae": torques({"A": 1})}
    without = alone | {"current_rmse": predicted(0.2)}
    sensor = without | {"force_mae": touched(1.0)}
    found = [first_figure(study(**own)) for own in (sensor, without, alone, {})]
    assert [one.get("kind") for one in found] == ["forces", "currents", "torques", None]
    assert [one.get("recording") for one in found] == ["pushed", "seen", "seen", None]


def test_a_recording_without_a_load_is_shown_first() -> None:
    """The load is an error of the prediction that is none of the fit."""
    rows = [row | {"recording": name} for name in ("seen", "pushed") for row in predicted(0.2)]
    loaded = study(current_rmse=rows, payload=[{"recording": "seen", "taken": "yes"}])
    entries = [one | {"role": "validate"} for one in loaded.study["recordings"]]
    both = judged_anew(loaded, study={**loaded.study, "recordings": entries})
    assert first_figure(both) == {"kind": "currents", "recording": "pushed"}


# Tables of the sections


def test_contacts_without_an_alarm_of_their_own_are_named() -> None:
    contacts = sensed((20.0, "found"), (30.0, "merged"), (7.0, "missed"))
    results = study(detection=[rates("pushed", 1.0)], contact_errors=contacts)
    (line,) = tables_of(results)["noticed"]
    assert line["found"] == "1 of 3"
    assert (line["missed at [s]"], line["merged at [s]"]) == ("20.0", "10.0")
    assert (line["strongest missed [N]"], line["weakest found [N]"]) == ("7.0", "20.0")
    fates = [row["fate"] for row in tables_of(results, "details")["contact-errors-pushed"]]
    assert fates == ["found", "merged", "missed"]


def test_no_contact_found_is_said_with_what_could_be_hidden() -> None:
    """By the recording that may hide most; without it, in results of an earlier version, not."""
    limits = {"untouched_n": 5.2, "hidden_n": 14.0, "hidden_at_all_n": 22.0}
    known = study(detection=[rates("pushed", 1.0) | limits])
    (line,) = tables_of(known)["noticed"]
    assert line["if untouched, median [N]"] == "± 5.2"
    assert (line["may hide, median [N]"], line["at all, median [N]"]) == ("14", "22")
    assert re.search(r"more than 14 N along an axis could .*hidden.*than 22 N", text_of(known))
    assert "before the wrist" not in text_of(known)
    older = study(detection=[rates("pushed", 1.0)])
    assert "may hide, median [N]" not in tables_of(older)["noticed"][0]
    assert "along an axis could" not in text_of(older)


def test_what_is_not_seen_before_the_wrist_is_said() -> None:
    limits = {"unseen_link_2_n": 212.0, "unseen_link_3_n": 61.0}
    text = text_of(study(detection=[rates("pushed", 1.0) | limits]))
    assert re.search(r"before the wrist may be unseen: .* below 212\sN .* and 61\sN", text)


@pytest.mark.parametrize(("threshold", "said"), [(0.0, False), (15.4, True)])
def test_an_unusual_threshold_is_said_on_the_card(threshold: float, said: bool) -> None:
    """It is what contacts in the fits raise, and hides others."""
    contacts = sensed((20.0, "found"), (7.0, "missed"))
    searched = [rates("pushed", 1.0) | {"threshold": threshold}]
    results = study(detection=searched, contact_errors=contacts)
    words = "Log-odds that raise an alarm, usually below 5: 15.4."
    assert (words in " ".join(card_of(results, "contacts")["said"].split())) == said


def test_each_contact_has_the_cause_of_its_error_in_words() -> None:
    """And the sensor's bias as another one, where that is uncertain."""
    rows = [row | {"cause": "stiction"} for row in sensed((20.0, "found"))]
    parts: dict[str, Any] = {"mae_missed": 1.0, "mae_shut": 0.5, "mae_gain": 0.25}
    known: dict[str, Any] = {
        "sensed": [{"recording": "pushed", "contacts": 1}],
        "detection": [rates("pushed")],
    }
    doubt = finding("warning", Found.OFFSET, device="force", recording="pushed")
    sure, doubted = (
        study(contact_errors=rows, force_mae=touched(2.0, **parts), quality=own, **known)
        for own in ([], [doubt])
    )
    (told,) = tables_of(sure, "details")["contact-errors-pushed"]
    assert told["cause"] == "stiction at rest"
    (told,) = tables_of(doubted, "details")["contact-errors-pushed"]
    assert told["cause"] == "stiction at rest, or the sensor's bias"


def test_whether_a_constant_may_be_used_is_said_by_joint() -> None:
    rows = [
        constant(1, 11.0),
        constant(2, 17.0, **FAR),
        constant(3, 10.0, **UNKNOWN),
        constant(4, 10.0, **REFUSED),
        constant(5, 30.0, use="no", reason="unlikely"),
    ]
    lines = tables_of(study(friction=rows))["constants-by-joint"]
    assert [line["may be used"] for line in lines] == [
        *("yes", "yes, far from known", "no: rests on other arms", "no: known one used"),
        "no: contradicts known",
    ]


def test_a_joint_that_never_moved_has_no_friction() -> None:
    known = {"robot": "ur5", "joint": 6, "value": 0.0, "std_error": 59.792, "prior_share": 1.0}
    known |= {"low": -100.0, "high": 100.0, "determined": "no", "use": "no"}
    known |= {"known": 10.0, "known_std": 3.0}
    rows = [known | {"parameter": "torque_constant", "reason": "prior_only"}]
    rows += [known | {"parameter": "coulomb", "reason": "no_motion"}]
    results = study(friction=rows)
    (line,) = tables_of(results)["constants-by-joint"]
    assert (line["torque constant"], line["Coulomb"]) == ("0 ± 100*", "did not move")
    _, coulomb = tables_of(results, "details")["friction-parameters"]
    assert not re.search(r"\d", "".join(coulomb.values()).removeprefix("6"))


def test_the_model_that_comes_next_is_shown_with_the_best() -> None:
    rows = torques({"A": 0.3, "B": 0.1, "C": 0.2})
    line, *_ = tables_of(study(torque_mae=rows))["links-by-joint"]
    names = ("model", "error", "next model", "its error")
    assert [line[name] for name in names] == ["B", "0.100", "C", "0.200"]


def test_excited_is_not_called_determined() -> None:
    known = [{"robot": "ur5", "determined": told} for told in ("yes", "no")]
    groups = ("combinations", "undetermined", "gravity", "inertia", "rotors", "all")
    excited = [{"robot": "ur5"} | dict.fromkeys(groups, 1.0)]
    results = study(parameters=known, torque_mae=torques({"A": 0.1}), excitation=excited)
    told = plain(page_of(results).get_element_by_id("links").text_content())
    assert "determine 1 of its 2 base parameters" in told
    assert "less than its errors, even where the motion excites them" in told
    assert "not excited" in tables_of(results, "details")["excitation"][0]


def test_each_recording_says_what_it_serves_and_what_not() -> None:
    errors = [
        {"recording": name, "model": "fitted", "fitted": fitted, "joint": 1}
        for name, fitted in (("fitted", "yes"), ("seen", "no"), ("pushed", "no"))
    ]
    load = {"recording": "seen", "taken": "yes"}
    known: dict[str, Any] = {"current_rmse": errors, "detection": [rates("pushed")]}
    assert uses(study(**known, payload=[load])) == [
        "torque constants and friction",
        "weighing its load; not for testing currents: undeclared load",
        "finding contacts; not for the size of forces: no force sensor",
    ]
    sensor = known | {"sensed": [{"recording": "pushed", "contacts": 5}]}
    assert (
        uses(study(**sensor, force_mae=touched(2.0)))[2] == "the size of forces, finding contacts"
    )
    doubt = finding("warning", Found.OFFSET, device="force", recording="pushed")
    doubted = touched(2.0, **DOUBTED)
    assert uses(study(**sensor, force_mae=doubted, quality=[doubt]))[2] == (
        "finding contacts; not for the size of forces: sensor bias uncertain"
    )
    stopped = study(quality=[finding("stop", Found.CONTRADICTION, recording="seen")])
    assert uses(stopped)[1] == "not for anything: stop sign"


def uses(results: Results) -> list[str]:
    return [row["use"] for row in tables_of(results)["legend"]]


def test_what_could_not_be_checked_is_nobodys_gravest_finding() -> None:
    results = study(quality=[finding("note", Found.ORDER_NOT_CHECKED)])
    assert all("gravest finding" not in row for row in tables_of(results)["legend"])


def test_a_force_without_a_fit_states_its_assumptions() -> None:
    static = [row | {"estimate": "static"} for row in touched(2.0)]
    told = plain(page_of(study(force_mae=static)).get_element_by_id("force").text_content())
    assert "No friction was fitted to this arm" in told
    assert LEADING not in told
