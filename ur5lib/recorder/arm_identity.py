"""The arm's identity by its controller's dashboard: model, serial number, software."""

from ur5lib.errors import InputError


def identify(address: str) -> dict[str, str]:
    """Return `model`, `serial_number` and `firmware` of the arm at an address.

    Raises InputError when ur_rtde is not installed or the dashboard does not answer.
    """
    try:
        import dashboard_client
    except ImportError as error:
        raise InputError(
            "asking the dashboard needs ur_rtde; install it: pip install 'ur5lib[record]'"
        ) from error
    dashboard = dashboard_client.DashboardClient(address)
    try:
        dashboard.connect()
        identity = {"model": dashboard.getRobotModel(), "firmware": dashboard.polyscopeVersion()}
        identity["serial_number"] = _serial_number(dashboard)
        dashboard.disconnect()
    except RuntimeError as error:
        raise InputError(
            f"the dashboard of {address}, port 29999, does not answer ({error}); check that the "
            "controller is switched on and in remote control"
        ) from error
    return identity


def _serial_number(dashboard: object) -> str:
    """Return the serial number, empty for controllers without this command."""
    try:
        return str(dashboard.getSerialNumber())  # type: ignore[attr-defined]
    except RuntimeError:
        return ""
