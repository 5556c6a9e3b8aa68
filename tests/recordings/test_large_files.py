"""Files that would fill the memory, that lead to other files, or whose checksums are wrong."""

import gzip
import random
import re
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as pq
import pytest
import scipy.io
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

from tests.command import SECONDS, Command, time_limit
from tests.conftest import PROJECT
from tests.stored_files import Channels, frame, made_up_channels, write_npz
from ur5lib.errors import InputError
from ur5lib.recordings.array_files import ENDINGS, LOADERS
from ur5lib.recordings.delimited import read_numbers
from ur5lib.recordings.limits import LIMIT_VARIABLE, expect_room
from ur5lib.records.quality import Log
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate

COUNT = 50_000_000  # numbers, 0.4 GB
MOST_GB = 0.02  # that the tests allow
HEAD = b"time," + b",".join(b"actual_q_%d" % joint for joint in range(6)) + b"\n"


def write_hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("actual_q", (COUNT,), "f8", chunks=(10_000,), compression="gzip")


def write_parquet_zeros(path: Path) -> None:
    pq.write_table(pa.table({"actual_q_0": np.zeros(COUNT)}), path, compression="zstd")


def write_feather_lists(path: Path) -> None:
    """Two rows, so that their number tells nothing."""
    ends = np.array([0, COUNT // 2, COUNT], np.int32)
    lists = pa.ListArray.from_arrays(ends, pa.array(np.zeros(COUNT)))
    feather.write_feather(pa.table({"actual_q": lists}), path, compression="zstd")


def write_gzip(path: Path) -> None:
    rows = gzip.compress(b"0,0,0,0,0,0,0\n" * 100_000)
    path.write_bytes(gzip.compress(HEAD) + rows * (COUNT // 700_000))


def write_bag(path: Path) -> None:
    """Messages of a million numbers, each a chunk of its own."""
    ros1 = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    stamp = store.types["builtin_interfaces/msg/Time"](1, 0)
    header = store.types["std_msgs/msg/Header"](*([0] if ros1 else []), stamp, "base")
    state = store.types["sensor_msgs/msg/JointState"]
    message = state(header, [], np.zeros(1_000_000), np.zeros(0), np.zeros(0))
    raw = (store.serialize_ros1 if ros1 else store.serialize_cdr)(message, state.__msgtype__)
    if ros1:
        writer = Ros1Writer(path)
        writer.set_compression(Ros1Writer.CompressionFormat.LZ4)
    else:
        folder = path.with_suffix("")
        writer = Ros2Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer as bag:
        topic = bag.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for second in range(COUNT // 1_000_000):
            bag.write(topic, 10**9 * second, raw)
    if not ros1:
        next(folder.glob("*.mcap")).rename(path)


WRITERS: dict[str, Callable[[Path], None]] = {  # 0.4 GB of zeros, in kilobytes
    ".h5": write_hdf5,
    ".npz": lambda path: np.savez_compressed(path, actual_q=np.zeros(COUNT)),
    ".mat": lambda path: scipy.io.savemat(
        path, {"run": {"actual_q": np.zeros(COUNT)}}, do_compression=True
    ),
    ".parquet": write_parquet_zeros,
    ".feather": write_feather_lists,
    ".gz": write_gzip,
    ".bag": write_bag,
    ".mcap": write_bag,
}
IMPORT = """
import sys
from pathlib import Path
from ur5lib.cli import main
try:
    main()
finally:
    (peak,) = [line for line in Path("/proc/self/status").open() if line.startswith("VmHWM")]
    print(peak.split()[1])
"""
TOLD = re.compile(r"(\S+) holds more than .*; if it should, allow more by `export UR5_MOST_GB=10`")


@pytest.fixture
def limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIMIT_VARIABLE, f"{MOST_GB}")


def test_files_that_would_fill_the_memory_are_refused_before_they_do(
    limited: None, tmp_path: Path
) -> None:
    paths = [tmp_path / f"run{ending}" for ending in WRITERS]
    for path in paths:
        WRITERS[path.suffix](path)
    run = [sys.executable, "-c", IMPORT, "import", *map(str, paths), "--robot", "ur5e"]
    told = subprocess.run(run, cwd=PROJECT, text=True, capture_output=True, check=False)
    assert told.returncode == 1
    refused = TOLD.findall(told.stdout + told.stderr)
    assert {Path(path).name for path in refused} == {path.name for path in paths}
    assert 1024 * int(told.stdout.split()[-1]) < 0.5e9


SMALL_ELEMENTS = {  # of MAT files: tag, and content
    "empty": struct.pack("<II", 1, 0),
    "in their tags": struct.pack("<II", 0x10001, 0),
    "one number each": struct.pack("<IId", 9, 8, 1.0),
}


@pytest.mark.parametrize("kind", SMALL_ELEMENTS)
@pytest.mark.parametrize(("megabytes", "said"), [(4, "is damaged"), (15, "more than 0.02 GB")])
def test_many_small_elements_take_no_longer_than_a_few_large_ones(
    limited: None, tmp_path: Path, kind: str, megabytes: int, said: str
) -> None:
    element = SMALL_ELEMENTS[kind]
    packed = zlib.compress(element * (megabytes * 1_000_000 // len(element)))
    head = b" " * 124 + b"\0\1IM" + struct.pack("<II", 15, len(packed))
    (tmp_path / "run.mat").write_bytes(head + packed)
    with time_limit(SECONDS), pytest.raises(InputError, match=said):
        LOADERS["mat"](tmp_path / "run.mat", None, [])


def test_an_hour_at_500_hz_of_all_that_an_arm_records_has_room(tmp_path: Path) -> None:
    """Before, 79 columns of it were refused, which take 1.1 GB."""
    plan = SimulatedRecording.model_validate({"trajectory": {"kind": "fourier"}, "seconds": 2})
    simulate(load_robot(robot_path("ur5e")), plan, "rtde-csv", tmp_path, tmp_path / "truth")
    with (tmp_path / "robot.csv").open() as file:
        columns = file.readline().count(",") + 1
    assert columns > 70
    expect_room(tmp_path / "robot.csv", 3600 * 500 * columns)


def test_the_limit_may_be_raised(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    made = made_up_channels(tmp_path / "made", 2)
    write_npz(tmp_path / "run.npz", *made)
    arguments = ("import", tmp_path / "run.npz", "--robot", "ur5")
    for most, status in (("0.00001", 1), ("0.1", 0)):
        monkeypatch.setenv(LIMIT_VARIABLE, most)
        assert run_ur5(*arguments).status == status
    monkeypatch.setenv(LIMIT_VARIABLE, "much")
    assert "UR5_MOST_GB is 'much'; give a number of gigabytes" in run_ur5(*arguments).line


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (HEAD + b"1" * 110_000_000, "more than 62,500,000 bytes in a line; .*export"),
        (
            b"q," * 1_000_000 + b"\n" + b"1," * 1_000_000 + b"\n",
            "more than 20,000 columns; .*export",
        ),
    ],
)
def test_lines_and_headers_beyond_measure_are_refused(
    tmp_path: Path, content: bytes, said: str
) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(content)
    with time_limit(SECONDS), pytest.raises(InputError, match=said):
        read_numbers(Log(path, "robot", []), None)


def test_a_channel_may_be_one_long_row(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).normal(size=(6, 20_000))
    np.savetxt(tmp_path / "q.txt", rows, delimiter=",")
    np.testing.assert_allclose(LOADERS["channel-files"](tmp_path, None, [])["q.txt"], rows.T)
    (tmp_path / "q.txt").write_text((tmp_path / "q.txt").read_text()[:-100])
    with pytest.raises(InputError, match=r"q\.txt: its lines differ in length.*; record it again"):
        LOADERS["channel-files"](tmp_path, None, [])


# Numbers of other files


def linked(path: Path, own: str) -> None:
    """Write a file whose array `q` is in the file secret.h5 beside it, or `own`: in itself."""
    with h5py.File(path.with_name("secret.h5"), "w") as secret:
        secret["q"] = np.ones((9, 6))
    path.with_name("secret.raw").write_bytes(bytes(9 * 6 * 8))
    with h5py.File(path, "w") as file:
        file["mine"] = np.zeros((9, 6))
        layout = h5py.VirtualLayout((9, 6), "f8")
        layout[:] = h5py.VirtualSource("." if own == "own part" else "secret.h5", "mine", (9, 6))
        match own:
            case "external link":
                file["q"] = h5py.ExternalLink("secret.h5", "q")
            case "link to an external link":
                file["out"] = h5py.ExternalLink("secret.h5", "/")
                file["q"] = h5py.SoftLink("/out/q")
            case "external storage":
                file.create_dataset("q", (9, 6), "f8", external=[("secret.raw", 0, 432)])
            case "virtual array" | "own part":
                file.create_virtual_dataset("q", layout)
            case "own link":
                file["q"] = h5py.SoftLink("mine")


@pytest.mark.parametrize(
    "link", ["external link", "link to an external link", "external storage", "virtual array"]
)
def test_arrays_in_other_files_are_refused(tmp_path: Path, link: str) -> None:
    linked(tmp_path / "run.h5", link)
    with pytest.raises(
        InputError, match=r"run\.h5: (out/)?q is in another file, secret.*not followed"
    ):
        LOADERS["hdf5"](tmp_path / "run.h5", ["q"], [])


@pytest.mark.parametrize("link", ["own part", "own link"])
def test_links_inside_a_file_are_followed(tmp_path: Path, link: str) -> None:
    linked(tmp_path / "run.h5", link)
    found = LOADERS["hdf5"](tmp_path / "run.h5", ["q"], [])
    np.testing.assert_array_equal(found["q"], np.zeros((9, 6)))


# Checksums


def write_parquet(path: Path, time: np.ndarray, channels: Channels) -> None:
    frame(time, channels).to_parquet(path, write_page_checksum=True)


def write_fletcher(path: Path, time: np.ndarray, channels: Channels) -> None:
    with h5py.File(path, "w") as file:
        for name, values in {"time": time, **channels}.items():
            file.create_dataset(name, data=values, fletcher32=True, chunks=True)


@pytest.mark.parametrize(
    ("name", "write"), [("c.parquet", write_parquet), ("c.h5", write_fletcher)]
)
def test_a_flipped_bit_does_not_pass_a_checksum(
    tmp_path: Path, name: str, write: Callable[..., None]
) -> None:
    path, draw = tmp_path / name, random.Random(1)
    write(path, *made_up_channels(tmp_path / "made", 2))
    load, data, refused = LOADERS[ENDINGS[path.suffix]], path.read_bytes(), 0
    whole = load(path, None, [])
    for _ in range(30):
        changed = bytearray(data)
        changed[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
        path.write_bytes(changed)
        try:
            found = load(path, None, [])
        except InputError:
            refused += 1
        else:
            assert all((found[name] == whole[name]).all() for name in found.keys() & whole.keys())
    assert refused
