"""What a run of the tests leaves besides its results: each test's time, and a failure for a skip
that nobody expected.
"""

import contextlib
import os
import re
import time
from collections import Counter
from collections.abc import Generator
from multiprocessing import forkserver
from pathlib import Path

import pytest

EXPECTED = "EXPECTED_SKIPS"  # names the variable that has the pattern of reasons; unset, all are
# In pytest's cache: seconds by test, the slowest first, on the clock and of the processor.
DURATIONS, PROCESSOR = "durations", "processor"
SPENT = [0.0]  # by this process and its children until the last report [s]


def processor_seconds() -> float:
    """What this process, its children that ended, and those of its fork server have spent [s]."""
    own = time.process_time() + sum(os.times()[2:4])
    server = getattr(forkserver, "_forkserver")._forkserver_pid  # noqa: B009
    with contextlib.suppress(OSError):  # there is none, or the system does not tell
        ticks = Path(f"/proc/{server}/stat").read_text().rpartition(")")[2].split()[11:15]
        own += sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")
    return own


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol() -> None:
    SPENT[0] = processor_seconds()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note what a phase of a test took of the processor."""
    report = yield
    spent = processor_seconds()
    report.user_properties.append((PROCESSOR, spent - SPENT[0]))
    SPENT[0] = spent
    return report


@pytest.hookimpl(trylast=True)  # xdist hands over its last reports before
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep what each test took; fail where one was skipped for a reason that is not expected."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or hasattr(session.config, "workerinput"):
        return
    reports = [one for kind in reporter.stats.values() for one in kind if hasattr(one, "duration")]
    took, spent = Counter[str](), Counter[str]()
    for report in reports:
        took[report.nodeid] += report.duration
        spent[report.nodeid] += float(dict(report.user_properties)[PROCESSOR])
    if getattr(session.config, "cache", None) is not None:
        session.config.cache.set(DURATIONS, dict(took.most_common()))
        session.config.cache.set(PROCESSOR, dict(spent.most_common()))
    reporter.write_line(
        f"\n{spent.total():.0f} s of processor in tests, {took.total():.0f} s on the clock"
    )
    expected = os.environ.get(EXPECTED)
    if expected is None:
        return
    reasons = {str(one.longrepr[2]) for one in reporter.stats.get("skipped", [])}
    if unexpected := [*filter(lambda reason: not re.search(expected, reason), sorted(reasons))]:
        reporter.write_line("skipped, although nothing is known to be missing:", red=True)
        for reason in unexpected:
            reporter.write_line(f"  {reason}", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
