"""The page of an empty study, typeset in a warm process, which then has its packages."""

from ur5lib.errors import InputError
from ur5lib.jobs.workers import in_warm_process


def check_page() -> None:
    """Typeset the page of an empty study. Raises InputError with file, line and column of an error
    in its sources.
    """
    if error := in_warm_process(_error_of_page, None):
        raise InputError(error)


def _error_of_page(_: None) -> str:
    from ur5lib.report.page.typeset import check_sources  # slow to import

    try:
        check_sources()
    except InputError as error:
        return str(error)
    return ""
