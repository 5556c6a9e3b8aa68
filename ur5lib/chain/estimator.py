"""A fit's settings as arguments, in the protocol of scikit-learn: parameters and copies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

from pydantic import ValidationError

from ur5lib.errors import InputError, expect_known
from ur5lib.robots.friction import Term, take_up
from ur5lib.strict import explain
from ur5lib.study.model import Settings

Terms = Sequence[str | Term]
PARAMETERS = ("cutoff_hz", "terms", "prior")


class Estimator:
    """The settings of a fit that are arguments; None leaves what the study of the recordings says.

    cutoff_hz: of the low-pass of currents [Hz]; terms: of friction besides Coulomb, viscous and
    load friction, names or `Term`s with a name, () for none, by default those that reduce errors on
    paths left out; prior: whether a UR's friction is expected to be as that of other URs.
    """

    def __init__(
        self,
        *,
        cutoff_hz: float | None = None,
        terms: Terms | None = None,
        prior: bool | None = None,
    ) -> None:
        self.cutoff_hz, self.terms, self.prior = cutoff_hz, terms, prior

    def get_params(self, deep: bool = True) -> dict[str, Any]:  # noqa: ARG002 - as asked
        """Return the arguments by name, as scikit-learn asks for them."""
        return {name: getattr(self, name) for name in PARAMETERS}

    def set_params(self, **params: Any) -> Self:
        """Change arguments for the next `fit`, and return the model. Raises InputError for an
        unknown one.
        """
        for name, value in params.items():
            setattr(self, expect_known("argument", name, PARAMETERS), value)
        return self

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, Tags, TargetTags  # who asks has it

        return Tags("regressor", TargetTags(required=False), input_tags=InputTags())

    def _changed(self, known: Settings) -> Settings:
        """Return settings with the arguments. Raises InputError where one is impossible."""
        plain = known.model_dump()
        self._take_up_terms()
        if self.cutoff_hz is not None:
            plain["lowpass"]["currents"]["cutoff_hz"] = self.cutoff_hz
        if self.terms is not None:
            names = [one.name if isinstance(one, Term) else one for one in self.terms]
            plain["friction"]["terms"] = names
        if self.prior is not None:
            plain["friction"]["prior"] = self.prior
        try:
            return Settings.model_validate(plain)
        except ValidationError as error:
            schema = Settings.model_json_schema()
            told = "; ".join(explain(one, schema) for one in error.errors())
            raise InputError(f"fit: {told}") from error

    def _take_up_terms(self) -> None:
        """Let steps know the terms that are no names."""
        if isinstance(self.terms, str):
            raise InputError(f"terms: {self.terms!r:.80} is one name; write [{self.terms!r:.80}]")
        for term in self.terms or ():
            if isinstance(term, Term):
                take_up(term)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take a pickled model; another process learns its terms."""
        vars(self).update(state)
        self._take_up_terms()
