"""Fetching: every file verified, nothing half-written, one sentence on what is wrong."""

import functools
import hashlib
import http.server
import json
import os
import shutil
import struct
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.command import Command, words
from tests.conftest import PROJECT, shared_folder
from ur5lib.commands.check import print_findings
from ur5lib.datasets.catalogue import catalogue, listing
from ur5lib.datasets.fetching import fetch, fetch_archive, fetch_record
from ur5lib.errors import InputError

FILES = {"a/csv_files/one.csv": b"1, 2\n", "b/csv_files/two.csv": b"3, 4\n"}
CHECKSUMS = {name: hashlib.sha256(content).hexdigest() for name, content in FILES.items()}
NOWHERE = "http://localhost:1/nothing"
LISTED = {"data.zip": b"zipped", "README.md": b"read me", "again.pkl": b"the same again"}


@pytest.fixture
def source(tmp_path: Path) -> Path:
    for name, content in FILES.items():
        path = tmp_path / "source" / name
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
    return tmp_path / "source"


@pytest.fixture
def server(tmp_path: Path) -> Iterator[str]:
    """A server of this machine's own, of the folder www."""
    (tmp_path / "www").mkdir()
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=tmp_path / "www")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, args=[0.01], daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


Packed = Callable[[dict[str, str]], str]


@pytest.fixture
def packed(tmp_path: Path, source: Path, server: str) -> Packed:
    """A function that serves the files in an archive, each by its path there; its URL."""

    def pack(paths: dict[str, str]) -> str:
        with zipfile.ZipFile(tmp_path / "www" / "archive.zip", "w") as archive:
            for name, path in paths.items():
                archive.write(source / name, f"repository-1/{path}")
            archive.writestr("repository-1/README.csv", "not wanted")
        return f"{server}/archive.zip"

    return pack


@pytest.fixture
def record(tmp_path: Path, server: str) -> str:
    """A record as Zenodo's interface lists it."""
    for name, content in LISTED.items():
        (tmp_path / "www" / name).write_bytes(content)
    (tmp_path / "www" / "record.json").write_text(json.dumps(recorded(server)))
    return f"{server}/record.json"


def recorded(server: str) -> dict[str, Any]:
    files = [
        {
            "id": "9a9e9e5b-0000-0000-0000-000000000000",
            "key": name,
            "size": len(content),
            "checksum": f"md5:{hashlib.md5(content).hexdigest()}",
            "links": {"self": f"{server}/{name}"},
        }
        for name, content in LISTED.items()
    ]
    metadata = {"title": "Runs of an arm", "license": {"id": "cc-by-4.0"}}
    return {"id": 1, "doi": "10.5281/zenodo.1", "metadata": metadata, "files": files}


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


# Archives


def test_files_are_copied_once(source: Path, tmp_path: Path) -> None:
    assert fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source) == 2
    assert contents(tmp_path / "raw") == FILES
    assert fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source) == 0
    assert fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw") == 0  # nor is the network asked


def test_files_without_a_checksum_are_copied_beside_the_others(
    source: Path, packed: Packed, tmp_path: Path
) -> None:
    """They are never taken for verified ones, nor do they replace what is there."""
    (source / "more.csv").write_bytes(b"5, 6\n")
    (source / "kept.csv").write_bytes(b"new\n")
    (tmp_path / "raw").mkdir()
    (tmp_path / "raw" / "kept.csv").write_bytes(b"mine\n")
    known = {"one.csv": CHECKSUMS["a/csv_files/one.csv"]}
    paths = {"a/csv_files/one.csv": "data/one.csv", "more.csv": "data/more.csv"}
    archive = packed(paths | {"kept.csv": "data/kept.csv"})
    assert fetch_archive(archive, known, tmp_path / "raw", unverified=3) == 1
    names = {"one.csv": b"1, 2\n", "more.csv": b"5, 6\n", "kept.csv": b"mine\n"}
    assert contents(tmp_path / "raw") == names
    (tmp_path / "raw" / "more.csv").unlink()
    assert fetch_archive(archive, known, tmp_path / "raw", unverified=2) == 0
    assert contents(tmp_path / "raw") == names
    assert fetch_archive(NOWHERE, known, tmp_path / "raw", unverified=2) == 0


@pytest.mark.parametrize(
    "paths", [{name: name for name in FILES}, dict(zip(FILES, ["x.csv", "y/1.csv"], strict=True))]
)
def test_the_archive_is_downloaded(packed: Packed, paths: dict[str, str], tmp_path: Path) -> None:
    """Files are found by their content, wherever the archive has them."""
    assert fetch_archive(packed(paths), CHECKSUMS, tmp_path / "raw") == 2
    assert contents(tmp_path / "raw") == FILES


def test_equal_files_are_told_apart_by_name(source: Path, packed: Packed, tmp_path: Path) -> None:
    (source / "b/csv_files/two.csv").write_bytes(b"1, 2\n")
    same = dict.fromkeys(FILES, CHECKSUMS["a/csv_files/one.csv"])
    assert fetch_archive(packed({name: name for name in FILES}), same, tmp_path / "raw") == 2


def test_no_network_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"could not be downloaded .*local folder with --from"):
        fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_a_page_in_place_of_an_archive_is_reported(server: str, tmp_path: Path) -> None:
    (tmp_path / "www" / "archive.zip").write_text("<html><body>Sign in</body></html>")
    with pytest.raises(InputError, match=r"archive.zip gives no zip file, .* web page.*--from"):
        fetch_archive(f"{server}/archive.zip", CHECKSUMS, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


# In each head of a zip file: the offsets of flags, of the method, and of the unpacked size
HEADS = {b"PK\3\4": (6, 8, 22), b"PK\1\2": (8, 10, 24)}


def change_heads(archive: Path, flags: int = 0, method: int = 0, size: int | None = None) -> None:
    """Change what the heads say of the archive's first file."""
    data = bytearray(archive.read_bytes())
    for mark, (flags_at, method_at, size_at) in HEADS.items():
        head = data.index(mark)
        data[head + flags_at] |= flags
        data[head + method_at] = method
        if size is not None:
            struct.pack_into("<I", data, head + size_at, size)
    archive.write_bytes(data)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"flags": 1}, r"could not be unpacked \(.*password required.*\); .* with --from"),
        ({"method": 99}, r"could not be unpacked \(.*compression method.*\); .* with --from"),
        ({"size": 2**32 - 2}, r"unpacks to 4 GB, more than 1; .* with --from"),
    ],
)
def test_an_archive_that_cannot_be_unpacked_is_reported(
    packed: Packed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: Any, said: str
) -> None:
    monkeypatch.setattr("ur5lib.datasets.fetching.MOST_GB", 1, raising=False)
    archive = packed({name: name for name in FILES})
    change_heads(tmp_path / "www" / "archive.zip", **changes)
    with pytest.raises(InputError, match=said):
        fetch_archive(archive, CHECKSUMS, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_an_archive_without_end_is_left(
    packed: Packed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ur5lib.datasets.fetching.MOST_GB", 1e-7)
    archive = packed({name: name for name in FILES})
    with pytest.raises(InputError, match=r"archive.zip sends more than 100 bytes; .* with --from"):
        fetch_archive(archive, CHECKSUMS, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_what_a_killed_run_has_left_is_removed(packed: Packed, tmp_path: Path) -> None:
    left = tmp_path / "raw" / ".fetching" / "archive.zip"
    left.parent.mkdir(parents=True)
    left.write_bytes(b"PK")
    fetch_archive(packed({name: name for name in FILES}), CHECKSUMS, tmp_path / "raw")
    assert contents(tmp_path / "raw") == FILES


KILLED = """
import os, pathlib, signal, time, pooch
from ur5lib.cli import main
def killed(url, checksum, name, folder, *others, **options):
    pathlib.Path(folder, name).write_bytes(b"PK")
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(10)
pooch.retrieve = killed
main()
"""


def test_a_run_that_is_killed_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "tmp").mkdir()
    places = {"PYTHONPATH": str(PROJECT), "TMPDIR": str(tmp_path / "tmp")}
    run = [sys.executable, "-c", KILLED, "fetch", "thesis"]
    ended = subprocess.run(
        run, cwd=tmp_path, env=os.environ | places, capture_output=True, check=False
    )
    assert ended.returncode != 0
    assert contents(tmp_path) == {}


def test_a_wrong_archive_is_reported(packed: Packed, tmp_path: Path) -> None:
    archive = packed({"a/csv_files/one.csv": "one.csv"})
    with pytest.raises(InputError, match=r"archive.zip lacks 1 of 2 files, e.g. b/csv_files/two"):
        fetch_archive(archive, CHECKSUMS, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_a_changed_source_file_is_refused(source: Path, tmp_path: Path) -> None:
    (source / "b/csv_files/two.csv").write_bytes(b"3, 4")
    with pytest.raises(InputError, match=r"two.csv is not the published file"):
        fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source)
    assert set(contents(tmp_path / "raw")) == {"a/csv_files/one.csv"}  # verified, and kept


def test_a_changed_target_file_is_not_overwritten(source: Path, tmp_path: Path) -> None:
    mine = tmp_path / "raw" / "a/csv_files/one.csv"
    mine.parent.mkdir(parents=True)
    mine.write_bytes(b"my own notes")
    with pytest.raises(InputError, match="differs from the published file; move it away"):
        fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source)
    assert mine.read_bytes() == b"my own notes"


def test_an_interruption_leaves_whole_files_only(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: Path, target: Path) -> None:
        target.write_bytes(b"1,")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(shutil, "copyfile", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source)
    assert contents(tmp_path / "raw") == {}
    assert fetch_archive(NOWHERE, CHECKSUMS, tmp_path / "raw", source) == 2


# Records


def test_a_record_is_downloaded_and_verified(record: str, tmp_path: Path) -> None:
    files, licence = fetch_record(record, ["again.pkl"], tmp_path / "raw")
    assert [file.name for file in files] == ["data.zip", "README.md"]
    assert licence == "cc-by-4.0"
    assert contents(tmp_path / "raw") == {name: LISTED[name] for name in ("data.zip", "README.md")}


def test_a_record_s_files_are_kept(record: str, tmp_path: Path) -> None:
    fetch_record(record, [], tmp_path / "raw")
    for name in LISTED:
        (tmp_path / "www" / name).unlink()
    assert len(fetch_record(record, [], tmp_path / "raw").files) == 3


def test_a_record_is_copied_from_a_folder(record: str, tmp_path: Path) -> None:
    shutil.copytree(tmp_path / "www", tmp_path / "mine")
    (tmp_path / "www" / "data.zip").unlink()
    assert len(fetch_record(record, [], tmp_path / "raw", tmp_path / "mine").files) == 3
    assert contents(tmp_path / "raw") == LISTED


def test_a_download_that_differs_is_refused(record: str, tmp_path: Path) -> None:
    (tmp_path / "www" / "data.zip").write_bytes(b"torn")
    with pytest.raises(InputError, match=r"data.zip could not be downloaded \(ValueError\)"):
        fetch_record(record, [], tmp_path / "raw")
    assert contents(tmp_path / "raw") == {}


def test_a_download_beyond_its_stated_size_is_left(record: str, tmp_path: Path) -> None:
    (tmp_path / "www" / "data.zip").write_bytes(b"zipped, and more")
    with pytest.raises(InputError, match=r"data.zip sends more than 6 bytes; check the network"):
        fetch_record(record, [], tmp_path / "raw")
    assert contents(tmp_path / "raw") == {}


OUTSIDE = ["../outside", "/etc/passwd", ".hidden", "a\nb"]
NO_RECORDS = ["<html>", "[]", "{}", '{"files": [{"key": "a"}]}', '{"files": 3}']


@pytest.mark.parametrize("text", [*NO_RECORDS, *map(json.dumps, OUTSIDE)])
def test_what_is_no_record_or_names_a_file_outside_is_refused(
    record: str, text: str, tmp_path: Path
) -> None:
    listing = tmp_path / "www" / "record.json"
    whole = listing.read_text().replace('"data.zip"', text, 1)
    listing.write_text(text if text in NO_RECORDS else whole)
    with pytest.raises(InputError, match=r"list of files at .* could not be read"):
        fetch_record(record, [], tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_a_missing_record_is_reported(server: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"could not be read \(HTTPError\)"):
        fetch_record(f"{server}/nothing", [], tmp_path / "raw")


# The catalogue


def test_the_real_list_matches_the_real_recordings(thesis_data: Path, tmp_path: Path) -> None:
    assert "243 files verified, 243 of them new" in fetch("thesis", tmp_path / "raw", thesis_data)


SHARED = {"ur10e": "ur10e", "ur5e-demonstrations": "ur5e", "ur5e-rtde": "ur5e"}
SHARED |= {"ur10-bag": "ur10-bag", "ur3-cb": "ur3-cb"}


@pytest.mark.parametrize(("name", "folder"), SHARED.items(), ids=SHARED)
def test_a_fetched_set_s_study_is_checked_without_errors(
    name: str, folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    fetch(name, source=shared_folder(folder, f"`ur5 fetch {name}` fetches them"))
    study = catalogue()[name].study
    assert study is not None
    assert print_findings(PROJECT / study) == 0


def test_every_study_is_of_a_data_set() -> None:
    studies = {dataset.study for dataset in catalogue().values() if dataset.study}
    there = {str(path.relative_to(PROJECT)) for path in PROJECT.glob("workflow/studies/*.yaml")}
    assert there - {"workflow/studies/thesis_reference.yaml"} == studies


def test_the_list_says_licence_and_purpose_of_each() -> None:
    lines = [*listing()]
    for field in ("good for", "licence", "address", "files", "study"):
        found = [line for line in lines if line.startswith(f"  {field}")]
        assert len(found) == len(catalogue())
    assert lines[-1].startswith("None of these downloads has been tried yet")


def test_a_record_is_fetched_by_name(
    record: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = catalogue()["aursad"].model_copy(update={"record": record})
    monkeypatch.setattr("ur5lib.datasets.fetching.catalogue", lambda: {"aursad": known})
    reported = fetch("aursad", tmp_path / "raw")
    assert reported.startswith(f"{tmp_path / 'raw'}: 3 files verified by the MD5 of {record}")
    assert reported.endswith("the licence cc-by-4.0")


def test_what_no_program_can_list_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="by hand, and let `ur5 import`"):
        fetch("nist-ur5", tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_the_command_names_a_wrong_name_and_what_there_is(run_ur5: Command) -> None:
    said = run_ur5("fetch", "thesi")
    assert said.status == 1
    assert {"'thesi'", "thesis", "ur10e"} <= words(said.err)
