"""Fetching: every file verified, nothing half-written, one sentence on what is wrong."""

import functools
import hashlib
import http.server
import shutil
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ur5lib import cli
from ur5lib.datasets import DATASETS, Dataset, fetch
from ur5lib.errors import InputError

FILES = {"a/csv_files/one.csv": b"1, 2\n", "b/csv_files/two.csv": b"3, 4\n"}


@pytest.fixture
def source(tmp_path: Path) -> Path:
    for name, content in FILES.items():
        path = tmp_path / "source" / name
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
    return tmp_path / "source"


@pytest.fixture
def dataset() -> Dataset:
    checksums = {name: hashlib.sha256(content).hexdigest() for name, content in FILES.items()}
    return Dataset("http://localhost:1/nothing.zip", "repository-1/data", checksums)


@pytest.fixture
def server(tmp_path: Path, source: Path) -> Iterator[str]:
    """The data set's archive on a server of this machine's own."""
    (tmp_path / "www").mkdir()
    with zipfile.ZipFile(tmp_path / "www" / "archive.zip", "w") as archive:
        for name in FILES:
            archive.write(source / name, f"repository-1/data/{name}")
        archive.writestr("repository-1/README", "not wanted")
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=tmp_path / "www")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/archive.zip"
        server.shutdown()


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_files_are_copied_once(dataset: Dataset, source: Path, tmp_path: Path) -> None:
    assert fetch(dataset, tmp_path / "raw", source) == 2
    assert contents(tmp_path / "raw") == FILES
    assert fetch(dataset, tmp_path / "raw", source) == 0


def test_nothing_is_asked_of_the_network_when_all_is_there(
    dataset: Dataset, source: Path, tmp_path: Path
) -> None:
    fetch(dataset, tmp_path / "raw", source)
    assert fetch(dataset, tmp_path / "raw") == 0


def test_the_archive_is_downloaded(dataset: Dataset, server: str, tmp_path: Path) -> None:
    online = Dataset(server, dataset.folder, dataset.checksums)
    assert fetch(online, tmp_path / "raw") == 2
    assert contents(tmp_path / "raw") == FILES


def test_no_network_is_told(dataset: Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"could not be downloaded .*local folder with --from"):
        fetch(dataset, tmp_path / "raw")
    assert not (tmp_path / "raw").exists()


def test_a_wrong_archive_is_told(dataset: Dataset, server: str, tmp_path: Path) -> None:
    elsewhere = Dataset(server, "repository-2/data", dataset.checksums)
    with pytest.raises(InputError, match=r"archive.zip lacks 2 of 2 files"):
        fetch(elsewhere, tmp_path / "raw")


def test_a_changed_source_file_is_refused(dataset: Dataset, source: Path, tmp_path: Path) -> None:
    (source / "b/csv_files/two.csv").write_bytes(b"3, 4")
    with pytest.raises(InputError, match=r"two.csv is not the published file"):
        fetch(dataset, tmp_path / "raw", source)
    assert set(contents(tmp_path / "raw")) == {"a/csv_files/one.csv"}  # verified, and kept


def test_a_missing_source_file_is_told(dataset: Dataset, source: Path, tmp_path: Path) -> None:
    shutil.rmtree(source / "b")
    with pytest.raises(InputError, match=r"lacks 1 of 2 files, e.g. b/csv_files/two.csv"):
        fetch(dataset, tmp_path / "raw", source)
    assert not (tmp_path / "raw").exists()


def test_a_changed_target_file_is_not_overwritten(
    dataset: Dataset, source: Path, tmp_path: Path
) -> None:
    mine = tmp_path / "raw" / "a/csv_files/one.csv"
    mine.parent.mkdir(parents=True)
    mine.write_bytes(b"my own notes")
    with pytest.raises(InputError, match="differs from the published file; move it away"):
        fetch(dataset, tmp_path / "raw", source)
    assert mine.read_bytes() == b"my own notes"


def test_an_interruption_leaves_whole_files_only(
    dataset: Dataset, source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: Path, target: Path) -> None:
        target.write_bytes(b"1,")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(shutil, "copyfile", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fetch(dataset, tmp_path / "raw", source)
    assert contents(tmp_path / "raw") == {}
    assert fetch(dataset, tmp_path / "raw", source) == 2


def test_the_real_list_matches_the_real_recordings(thesis_data: Path, tmp_path: Path) -> None:
    assert fetch(DATASETS["thesis"], tmp_path / "raw", thesis_data) == 243


def test_the_command_tells_a_wrong_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr("sys.argv", ["ur5", "fetch", "thesi"])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 1
    assert capsys.readouterr().err == "ur5: unknown data set 'thesi'; available: thesis\n"


@pytest.mark.parametrize("command", [[], ["fetch"], ["schema"]])
def test_every_command_explains_itself(command: list[str]) -> None:
    help_text = CliRunner().invoke(cli.app, [*command, "--help"])
    assert help_text.exit_code == 0
    assert "Usage" in help_text.output
