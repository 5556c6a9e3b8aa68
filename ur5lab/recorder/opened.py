"""The devices that a study names, opened, and the entries of their files."""

from functools import singledispatch
from typing import Any

from ur5lab.recorder.device import Device
from ur5lib.study.devices import ArmSettings, DeviceSettings, NetFTSettings, XsensSettings

FORMATS = {"rtde": "rtde-csv", "realtime": "realtime-stream"}
SENSOR_COLUMNS = {
    NetFTSettings: ["time", "counter", "-", "-", "ft"],
    XsensSettings: ["time", "counter", "-", "imu_a", "imu_g", "imu_m"],
}


@singledispatch
def opened(settings: Any) -> Device:
    """Return the device with these settings, connected. Raises InputError where it does not
    answer.
    """
    raise TypeError(f"{settings} are no device's settings")


@opened.register
def _arm(settings: ArmSettings) -> Device:
    if settings.interface == "realtime":
        from ur5lab.recorder import realtime_arm

        return realtime_arm.RealtimeArm(settings.address, settings.port or realtime_arm.PORT)
    from ur5lab.recorder import rtde_arm

    return rtde_arm.RtdeArm(settings.address, settings.rate_hz, settings.port or rtde_arm.PORT)


@opened.register
def _force_sensor(settings: NetFTSettings) -> Device:
    from ur5lab.recorder.net_ft import NetFT

    return NetFT(settings.address, settings.bias, settings.port, settings.http_port)


@opened.register
def _imu(settings: XsensSettings) -> Device:
    from ur5lab.recorder.xsens import Xsens

    return Xsens(settings.port, settings.rate_hz, settings.baudrate)


def file_entry(settings: DeviceSettings, file: str) -> dict[str, object]:
    """Return the keys of a recording's entry by which the file of a device is found and read."""
    if isinstance(settings, ArmSettings):
        return {"format": FORMATS[settings.interface], "file": file}
    return {"file": file, "columns": SENSOR_COLUMNS[type(settings)], "time": "host_s"}
