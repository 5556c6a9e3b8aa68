"""Names of the files that the test stand writes, and the keys of a study for them."""

from collections.abc import Collection

from ur5lib.channels import THESIS_FILES

ROBOT_FILES = {"realtime-stream": "capture.csv", "rtde-csv": "robot.csv"}
SENSOR_TIME_KEYS = {
    "realtime-stream": "epoch_s",
    "rtde-csv": "relative_s",
}  # the sensors' time columns
SENSOR_COLUMNS = {"force_sensor": ["time", "ft"], "imu": ["time", "imu_a", "imu_m", "imu_g"]}
FORMATS = ["thesis-csv", *ROBOT_FILES]
FORMATS_OF_UR = ["thesis-csv", "realtime-stream"]  # six joints, with currents
FORMATS_WITH_PAYLOAD = ["rtde-csv"]  # formats that record the payload declared to the controller


def file_names(format: str, sensors: Collection[str]) -> list[str]:
    """Return the files of a simulated recording in its folder; sensors: keys of SENSOR_COLUMNS."""
    if format != "thesis-csv":
        return [ROBOT_FILES[format], *(f"{name}.csv" for name in sensors)]
    names = [*(f"log_{file}.csv" for file in THESIS_FILES), "start_time.csv"]
    names += ["log_force_sensor.csv", "log_force_sensor_start_time.csv"]
    names += ["acc_data.csv", "acc_start_time.csv"] if "imu" in sensors else []
    return [f"csv_files/{name}" for name in names]


def device_keys(
    format: str, sensors: Collection[str]
) -> dict[str, str | dict[str, str | list[str]]]:
    """Return the keys of a study's entry for these files: `file`, `force_sensor`, `imu`."""
    if format == "thesis-csv":
        return {}
    return {"file": ROBOT_FILES[format]} | {
        name: {
            "file": f"{name}.csv",
            "columns": SENSOR_COLUMNS[name],
            "time": SENSOR_TIME_KEYS[format],
        }
        for name in sensors
    }
