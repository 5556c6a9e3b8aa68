"""Text files in blocks of whole lines: a long one is never in memory as a whole."""

import gzip
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ur5lib.errors import InputError
from ur5lib.recordings.limits import Unpacking, longest_line, too_large
from ur5lib.recordings.listed_cells import with_lists_apart, with_one_mark
from ur5lib.recordings.npy_rows import SIGNATURE, npy_lines
from ur5lib.records.codes import Found
from ur5lib.records.quality import Log
from ur5lib.strict import expect_file

BLOCK_BYTES = 1 << 25  # bytes of a block
MIN_BLOCK_BYTES = 1 << 20  # bytes; a shorter rest joins the block before it
BRACKETS, LETTERS = b"()[]", re.compile(rb"[A-DF-Za-df-z]")  # all but the e of 1e-3
QUOTED_TEXT, SEPARATORS = re.compile(rb'"[^"\n]*"'), re.compile(rb"[,;\t]")
QUOTED_DECIMAL = re.compile(rb'"([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)"')
OTHER_FILES = {  # by their first bytes, with what to do with them
    b"%PDF": "a PDF, not numbers; save the table that it was made of as CSV",
    b"7z\xbc\xaf": "a 7z archive; unpack it: 7z x",
    b"PK\x03\x04": "a zip archive or a workbook of Excel; unpack it, or save each sheet as CSV",
    b"Rar!": "a RAR archive; unpack it: unrar x",
    b"\x80": "a pickle of Python, which could run code; save its numbers as CSV",
}
GZIP_SIGNATURE, BYTE_ORDER_MARK = b"\x1f\x8b", b"\xef\xbb\xbf"


def text_blocks(log: Log) -> Iterator[bytes]:
    """Yield the text of a file, unpacked if it is compressed, in blocks of whole lines.

    There is at least one block, which may be empty. Byte-order mark, carriage returns, quotes, and
    brackets around numbers are removed, so that each number is a cell. Raises InputError when the
    file cannot be read, is not text, has too long a line, or unpacks to more than may be read.
    """
    path = log.path
    expect_file(path)
    try:
        yield from _blocks(log)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise InputError(f"{path} is a damaged gzip file; copy it again from its source") from error
    except OSError as error:
        raise InputError(
            f"{path} is missing or cannot be read ({error.strerror}); add the file, or leave it out"
        ) from error


def _blocks(log: Log) -> Iterator[bytes]:
    with log.path.open("rb") as plain:
        head = plain.read(len(SIGNATURE))
    if head == SIGNATURE:
        yield from npy_lines(log.path)
        return
    packed = head.startswith(GZIP_SIGNATURE)
    log.add(Found.COMPRESSED_FILE, "note", packed, "decompressed")
    with gzip.open(log.path) if packed else log.path.open("rb") as stream:
        block = _lines(stream, log.path)
        if block.startswith(BYTE_ORDER_MARK):
            log.add(Found.BYTE_ORDER_MARK, "note", 1, "ignored")
            block = block[len(BYTE_ORDER_MARK) :]
        if kind := next((OTHER_FILES[k] for k in OTHER_FILES if block.startswith(k)), ""):
            raise InputError(f"{log.path} is {kind}")
        # Zeros further down may be a lost disk block: that is a damaged line.
        if block[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in block[:1000]:
            raise InputError(f"{log.path}, line 1: not a text file; save it as plain CSV (UTF-8)")
        unpacking = Unpacking(log.path)
        while True:
            if packed:
                unpacking.count(len(block))
            following = _lines(stream, log.path) if block else b""
            if len(following) < MIN_BLOCK_BYTES:
                yield _plain(block + following)
                return
            yield _plain(block)
            block = following


def _lines(stream: BinaryIO | gzip.GzipFile, path: Path) -> bytes:
    """Return the next block of whole lines. Raises InputError where a line is too long."""
    most = longest_line()
    block, rest = stream.read(BLOCK_BYTES), stream.readline(most)
    if len(rest) == most:
        raise too_large(path, f"{most:,} bytes in a line")
    return block + rest


def _plain(block: bytes) -> bytes:
    if b"\r" in block:
        block = block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    # rows may group numbers in brackets, as NIST's files do
    first = block.partition(b"\n")[0]
    grouped = b"[" in first and not LETTERS.search(first)
    block = with_one_mark(with_lists_apart(block))
    if b'"' in block:
        block = _unquoted(block)
    return block.translate(None, BRACKETS) if grouped else block


def _unquoted(block: bytes) -> bytes:
    """Return a block without quotes; a quoted text of several parts becomes one cell, and quoted
    decimal commas become points.
    """
    top = b"\n".join(block.split(b"\n", 2)[:2])
    if any(map(_has_parts, QUOTED_TEXT.findall(top))):
        separated_by_blanks = not SEPARATORS.search(QUOTED_TEXT.sub(b"", top))
        parted = (
            bytes.maketrans(b", ", b"__") if separated_by_blanks else bytes.maketrans(b",", b" ")
        )
        block = QUOTED_TEXT.sub(
            lambda found: found[0].translate(parted) if _has_parts(found[0]) else found[0], block
        )
    return QUOTED_DECIMAL.sub(rb"\1.\2", block).replace(b'"', b"")


def _has_parts(quoted: bytes) -> bool:
    return LETTERS.search(quoted) is not None and (b"," in quoted or b" " in quoted)
