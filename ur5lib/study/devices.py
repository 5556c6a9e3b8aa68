"""A laboratory's devices, as a study names them under `devices`; `ur5lab` records them."""

from typing import Annotated, Literal

from pydantic import Field

from ur5lib.strict import Strict

Port = Annotated[int, Field(gt=0, lt=65536)]


class ArmSettings(Strict):
    """The connection to the arm's controller."""

    address: str = Field(description="name or IP address of the controller")
    interface: Literal["rtde", "realtime"] = Field(
        "rtde",
        description="rtde: RTDE, port 30004; realtime: port 30003, of controllers without RTDE",
    )
    rate_hz: float | None = Field(
        None, gt=0, le=500, description="rate of RTDE; default: the controller's own"
    )
    port: Port | None = Field(None, description="its port; default: that of the interface")


class NetFTSettings(Strict):
    """The connection to an ATI Net F/T force sensor."""

    address: str = Field(description="name or IP address of its box")
    bias: bool = Field(False, description="zero the sensor when the recording starts")
    port: Port = Field(49152, description="UDP port of RDT")
    http_port: Port = Field(80, description="port of the box's web page")


class XsensSettings(Strict):
    """The connection to an Xsens MTi inertial measurement unit."""

    port: str = Field(description="its serial port, e.g. /dev/ttyUSB0")
    rate_hz: float = Field(100.0, gt=0, le=2000, description="rate that it is set to")
    baudrate: int = Field(115_200, gt=0, description="of the port")


DeviceSettings = ArmSettings | NetFTSettings | XsensSettings


class LabSettings(Strict):
    """The devices that `ur5 record` records together."""

    robot: ArmSettings = Field(description="the arm")
    force_sensor: NetFTSettings | None = Field(None, description="ATI Net F/T, if there is one")
    imu: XsensSettings | None = Field(None, description="Xsens MTi, if there is one")
    table_m: float | None = Field(
        0.0,
        description="height in the base frame of a table that the arm must not touch [m]; null for "
        "none",
    )

    def devices(self) -> dict[str, DeviceSettings]:
        """Return the devices of this laboratory by name."""
        devices = {"robot": self.robot, "force_sensor": self.force_sensor, "imu": self.imu}
        return {name: device for name, device in devices.items() if device is not None}
