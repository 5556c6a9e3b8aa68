"""The settings of a fit as arguments, and what scikit-learn makes of them."""

import copy
import pickle

import numpy as np
import pytest
from sklearn.base import clone, is_regressor
from sklearn.model_selection import GridSearchCV

import ur5lib
from ur5lib.robots.friction import TERMS, JointMotion, Term
from ur5lib.study.model import Settings


def creep(motion: JointMotion) -> list[np.ndarray]:
    return [np.exp(-np.abs(motion.qd) / 0.1) * motion.direction]


CREEP = Term(creep, name="creep")


def test_arguments_are_given_copied_and_changed() -> None:
    given = {"cutoff_hz": 3.0, "terms": ["velocity_root"], "prior": False}
    model = ur5lib.Model(**given)
    assert model.get_params() == clone(model).get_params() == given
    assert is_regressor(model)
    assert model.set_params(cutoff_hz=1.0) is model
    assert model.get_params() == given | {"cutoff_hz": 1.0}
    assert "cutoff_hz=1.0" in repr(model)
    with pytest.raises(ur5lib.InputError, match="did you mean `cutoff_hz`"):
        model.set_params(cutof_hz=1.0)


def test_they_are_settings_of_a_study() -> None:
    plain = Settings()
    changed = ur5lib.Model(cutoff_hz=3.0, terms=("velocity_square",), prior=False)._changed(plain)
    assert changed.lowpass.currents.cutoff_hz == 3.0
    assert changed.friction.terms == ["velocity_square"]
    assert not changed.friction.prior
    assert ur5lib.Model()._changed(plain) == plain
    with pytest.raises(ur5lib.InputError, match=r"fit: `lowpass\.currents\.cutoff_hz` is -1"):
        ur5lib.Model(cutoff_hz=-1)._changed(plain)
    with pytest.raises(ur5lib.InputError, match="terms: 'coulomb' is one name"):
        ur5lib.Model(terms="coulomb")._changed(plain)
    with pytest.raises(ur5lib.InputError, match="'coulomb' is a term of ur5lib"):
        ur5lib.Model(terms=[Term(creep, name="coulomb")])._changed(plain)


def test_what_was_not_fitted_says_so(free: ur5lib.Recordings) -> None:
    model = ur5lib.Model()
    for asked in (model.predict, model.score, model.estimate):
        with pytest.raises(ur5lib.InputError, match="not fitted yet; call its `fit`"):
            asked(free)
    assert copy.deepcopy(model).get_params() == model.get_params()


def test_an_own_term_is_fitted_without_a_folder(free: ur5lib.Recordings) -> None:
    model = ur5lib.fit(free, terms=[CREEP], cutoff_hz=3.0, prior=False)
    rows = model.table("friction")
    assert "creep" in {*rows["parameter"]}
    assert "velocity_root" not in {*rows["parameter"]}
    assert model._settings.lowpass.currents.cutoff_hz == 3.0
    kept = pickle.dumps(model)
    del TERMS["creep"]
    again = pickle.loads(kept)
    q, qd = np.array([0, -1.5, 1.5, -1.2, 0.3, 0]), np.full(6, 0.3)
    np.testing.assert_allclose(again.torque(q, qd, 0), model.torque(q, qd, 0))
    np.testing.assert_allclose(again.single().torque(q, qd, 0 * q), model.torque(q, qd, 0))


@pytest.mark.slow
def test_a_search_has_the_scores_of_fits_by_hand(free: ur5lib.Recordings) -> None:
    """And fits the best settings to all recordings."""
    choices = {"terms": [(), ("velocity_root",)]}
    search = GridSearchCV(
        ur5lib.Model(cutoff_hz=2.0), choices, scoring=ur5lib.nrmse, cv=2, error_score="raise"
    ).fit(free)
    for k, terms in enumerate(choices["terms"]):
        one, two = (
            ur5lib.nrmse(ur5lib.fit(free[fitted], cutoff_hz=2.0, terms=terms), free[left])
            for fitted, left in (("free2", "free1"), ("free1", "free2"))
        )
        assert search.cv_results_["mean_test_score"][k] == pytest.approx((one + two) / 2)
    best = search.best_estimator_
    assert best.get_params()["terms"] == search.best_params_["terms"]
    assert best == ur5lib.fit(free, cutoff_hz=2.0, terms=search.best_params_["terms"])
