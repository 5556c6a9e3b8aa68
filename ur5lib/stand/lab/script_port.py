"""The ports that take programs in URScript: 30002, and 30003 beside its messages.

A program is one line, or all lines from `def` to `end`; a new one replaces the one that runs.
"""

import re

from ur5lib.stand.lab import urscript
from ur5lib.stand.lab.connection import Connection
from ur5lib.stand.lab.control_box import ControlBox
from ur5lib.stand.lab.control_script import ControlScript, is_control_script

LONGEST = 1 << 24  # bytes of a program
WHOLE = re.compile(r"(?:def|sec)\s[^\n]*\n.*?^end[^\n]*\n", re.DOTALL | re.MULTILINE)
LINE = re.compile(r"[^\n]*\n")


class ScriptClient(Connection):
    """One client that sends programs."""

    def __init__(self, box: ControlBox) -> None:
        super().__init__(box)
        self._text = ""

    def data_received(self, data: bytes) -> None:
        """Start every program that is complete."""
        self._text += data.decode("utf-8", "replace")
        while program := self._take():
            self._start(program)
        if len(self._text) > LONGEST:
            self._text = ""

    def connection_lost(self, _: Exception | None) -> None:
        """Start a last line that lacks its end, as the controller does."""
        super().connection_lost(_)
        if self._text.strip():
            self._text += "\n"
            self.data_received(b"")

    def _take(self) -> str:
        """Remove the first complete program from the received text, and return it."""
        self._text = self._text.lstrip()
        kind = WHOLE if re.match(r"(def|sec)\s", self._text) else LINE
        program = kind.match(self._text)
        if program is None:
            return ""
        self._text = self._text[program.end() :]
        return program[0]

    def _start(self, text: str) -> None:
        if is_control_script(text):
            self.box.run(ControlScript(text, self.box).run())
        else:
            self.box.run(urscript.program(text.splitlines(), self.box))
