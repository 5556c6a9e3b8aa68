"""What there is fits on a screen: names, and the help of each."""

import pydoc

import ur5lib
from ur5lib.chain.single import Single

NAMES, LINES = 40, 50  # of a screen


def test_names_fit_on_a_screen(model: ur5lib.Model, free: ur5lib.Recordings) -> None:
    for one in (ur5lib, model, free, ur5lib.read_arm("ur5e")):
        assert 0 < len(dir(one)) <= NAMES, one
    assert {"torque", "export", "single"} <= {*dir(model)}


def test_the_help_of_each_function_fits_on_a_screen() -> None:
    classes = ur5lib.Model, ur5lib.Recordings, ur5lib.FinishedStudy, Single
    functions = [getattr(ur5lib, name) for name in dir(ur5lib)]
    functions += [getattr(own, name) for own in classes for name in vars(own) if name[0] != "_"]
    shown = [own for own in functions if callable(own) and not isinstance(own, type)]
    lengths = {own.__qualname__: len(pydoc.render_doc(own).splitlines()) for own in shown}
    assert {"Model.torque", "fit", "read", "Single.torque"} <= {*lengths}
    assert {name: count for name, count in lengths.items() if count > LINES} == {}
