"""What a run of the tests leaves besides its results: each test's time, and a failure for a skip
that nobody expected.
"""

import os
import re
from collections import Counter

import pytest

EXPECTED = "EXPECTED_SKIPS"  # names the variable that has the pattern of reasons; unset, all are
DURATIONS = "durations"  # in pytest's cache: seconds by test, the slowest first


@pytest.hookimpl(trylast=True)  # xdist hands over its last reports before
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep what each test took; fail where one was skipped for a reason that is not expected."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or hasattr(session.config, "workerinput"):
        return
    reports = [one for kind in reporter.stats.values() for one in kind if hasattr(one, "duration")]
    took: Counter[str] = Counter()
    for report in reports:
        took[report.nodeid] += report.duration
    if getattr(session.config, "cache", None) is not None:
        session.config.cache.set(DURATIONS, dict(took.most_common()))
    expected = os.environ.get(EXPECTED)
    if expected is None:
        return
    reasons = {str(one.longrepr[2]) for one in reporter.stats.get("skipped", [])}
    if unexpected := [*filter(lambda reason: not re.search(expected, reason), sorted(reasons))]:
        reporter.write_line("skipped, although nothing is known to be missing:", red=True)
        for reason in unexpected:
            reporter.write_line(f"  {reason}", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
