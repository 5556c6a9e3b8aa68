"""What the live estimator learns, and when it learns nothing."""

from dataclasses import replace

import numpy as np

from tests.made_records import signals_of
from tests.rubbing_arm import friction, robot
from tests.steps.made_recording import premises
from tests.topics.live.made_arm import samples
from ur5lib.force.residual_model import Residuals
from ur5lib.records.friction import CurrentFit, Friction, JointFit, LeftOut
from ur5lib.topics.live.fit_live import fit_live


def with_coupled(joint: JointFit) -> JointFit:
    """Return a joint that turns with the shaft of another one, which the live estimator lacks."""
    known, parts = joint.estimate, np.zeros(3)
    wider = replace(known, coefficients=np.append(known.coefficients, parts))
    return replace(joint, terms=(*joint.terms, "coupled"), estimate=wider)


def learnt(known: Friction) -> str:
    """Return why nothing is learnt of one recording, "" where something is."""
    run = samples(8.0, moving=True)
    signals = signals_of(run.time, run.q, actual_qd=run.qd, actual_current=run.current)
    fit = fit_live(
        {"one": signals},
        {"one": premises()},
        known,
        Residuals(),
        robot(),
        {"one": [*robot().gravity]},
        1.0,
        None,
    )
    return "" if fit.refused is None else fit.refused.text


def test_a_term_of_the_fit_of_all_that_it_lacks_refuses_the_fit() -> None:
    """Although the fits without a path, which predict the recordings, do without it."""
    usual = friction(robot())
    without = [LeftOut(["one"], usual.fit)]
    wider = CurrentFit(tuple(map(with_coupled, usual.fit.joints)), 5)
    assert "coupled" in learnt(replace(usual, fit=wider, left_out=without))
    assert learnt(replace(usual, left_out=without)) == ""
