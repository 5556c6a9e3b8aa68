"""A client's connection to one of the controller's ports."""

import asyncio

from ur5lib.stand.lab.control_box import ControlBox


class Connection(asyncio.Protocol):
    """A connection that the control box can cut."""

    def __init__(self, box: ControlBox) -> None:
        self.box = box

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Enter the connection in the control box."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        self.box.connections.add(transport)

    def connection_lost(self, _: Exception | None) -> None:
        """Forget the connection."""
        self.box.connections.discard(self.transport)
