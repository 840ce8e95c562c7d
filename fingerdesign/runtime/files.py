"""Files and folders that are there whole or not at all: written aside, then renamed.

    write_whole(path, text)
    with whole_file(path) as aside: plotter.screenshot(aside)
    with whole_folder(target) as aside: ...

And what goes with it: hidden names, locks, temporary folders, the leavings of killed processes.
"""

import contextlib
import errno
import os
import re
import secrets
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fingerdesign.errors import shown

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

DAY_S = 86400.0
_FRESH_S = 2.0  # between the making of a folder and its lock: microseconds, on a busy machine more
MOST_BYTES = 100_000_000  # of a text that is read whole: an hour's trace at 100 Hz takes 50 MB
_FULL = (errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC))  # no space, or none for this user


class BusyError(OSError):
    """Another process holds the lock."""


def sibling(target: Path, role: str) -> Path:
    """Return a hidden name next to ``target`` that nothing else has."""
    return target.with_name(f".{target.name}.{role}-{secrets.token_hex(4)}")


def is_full(error: OSError) -> bool:
    """Tell whether the disk, or this user's part of it, is full."""
    return error.errno in _FULL


def why_no_place(folder: Path) -> str:
    """Explain in a clause why nothing can be written into ``folder``, which may not exist yet; ""
    where it can.

    A folder is made in the nearest one that is there, and taken away: file systems of the kernel
    and read-only disks grant in name what they then refuse.
    """
    above = folder
    try:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            folder.lstat()  # a name that is too long is none's
        above = next(each for each in (folder, *folder.absolute().parents) if each.exists())
        if not above.is_dir():
            return f"{above} is a file"
        links = (each for each in (folder, *folder.parents) if each.is_symlink())
        if link := next((each for each in links if not each.exists()), None):
            return f"{link} is a link to nothing"
        tempfile.TemporaryDirectory(prefix=".fingerdesign-", dir=above).cleanup()
    except (OSError, ValueError) as error:  # a name with a null character is a ValueError
        system = error.strerror if isinstance(error, OSError) else str(error)
        return f"{shown(str(above))} cannot ({system})"
    return ""


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """A full disk's error, which names no file when it comes of writing, names ``path``."""
    try:
        yield
    except OSError as error:
        if is_full(error) and error.filename is None:
            error.filename = str(path)
        raise


@contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """A hidden path next to ``path``, of the same ending; what the block writes there takes the
    place of ``path``, and is gone where the block raises. A link is replaced, never followed: its
    target may be somebody else's.

    OSError as of the disk, and where ``path`` is a folder, a pipe or a device.
    """
    path = Path(path)
    if path.exists() and not path.is_file():  # it is never replaced
        raise OSError(f"{path} is not a regular file; choose another")
    aside = path.with_name(f".{secrets.token_hex(6)}-{path.name}"[:255])
    try:
        with _naming(path):
            yield aside
        os.replace(aside, path)
    finally:
        with contextlib.suppress(OSError):
            aside.unlink(missing_ok=True)


def write_whole(path: Path | str, content: str | bytes, durable: bool = False) -> Path:
    """Write a file whole or not at all; a text as UTF-8 with its line ends as they are. durable: it
    is on the disk before it takes its place. Returns the path."""
    path = Path(path)
    data = content.encode() if isinstance(content, str) else content
    with whole_file(path) as aside, aside.open("xb") as stream:
        stream.write(data)
        if durable:
            stream.flush()
            os.fsync(stream.fileno())
    return path


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """An empty hidden folder next to ``target``, gone when the block ends; :func:`take_place` puts
    it in place. Those of killed runs go first. OSError where it cannot be made."""
    sweep_abandoned(target)
    aside = sibling(target, "partial")
    target.parent.mkdir(parents=True, exist_ok=True)
    aside.mkdir()
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # no locks here: the sweep goes by age
            stack.enter_context(_in_use(aside))
        try:
            with _naming(target):
                yield aside
        finally:
            shutil.rmtree(aside, ignore_errors=True)


def why_unread(error: Exception) -> str:
    """The reason why a file is not read, in words without its path."""
    if isinstance(error, IsADirectoryError):
        return "it is a folder: name a file in it"
    if isinstance(error, UnicodeDecodeError):
        return "it is not UTF-8 text"
    return getattr(error, "strerror", None) or str(error)


def whole_text(path: Path | str, encoding: str = "utf-8", most: int = MOST_BYTES) -> str:
    """A file's text, its line ends as "\\n". Errors as of :func:`whole_content`, and
    UnicodeDecodeError where it is none."""
    text = whole_content(path, most).decode(encoding)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def whole_content(path: Path | str, most: int) -> bytes:
    """A file's bytes. OSError, of which ``strerror`` gives the reason, also for a pipe or a device,
    which may never end, and for more than ``most`` bytes."""
    path = Path(path)
    if path.exists() and not path.is_file() and not path.is_dir():
        raise OSError(errno.EINVAL, "it is no ordinary file and may never end", str(path))
    with path.open("rb") as stream:
        content = stream.read(most + 1) if path.stat().st_size <= most else b""
        if len(content) > most or path.stat().st_size > most:
            words = f"it is larger than {most // 10**6} MB; check the path"
            raise OSError(errno.EFBIG, words, str(path))
    return content


def move_into(folder: Path, files: Iterable[Path]) -> None:
    """Move files one by one into a folder of the same disk, each in the place of an older one."""
    for path in files:
        os.replace(path, folder / path.name)


def take_place(aside: Path, target: Path) -> None:
    """Rename a folder; the older one is deleted only once the new one is in its place. OSError
    where that fails; its message says where the older folder is, if not in its place."""
    older = sibling(target, "older")
    try:
        if target.is_dir():
            target.rename(older)
        aside.rename(target)
    except BaseException as error:  # an interruption between the two as well
        with contextlib.suppress(OSError):
            if older.is_dir() and not target.exists():
                older.rename(target)
        if older.is_dir() and isinstance(error, OSError):
            raise OSError(f"{error}; the older result is in {older}") from error
        raise
    shutil.rmtree(older, ignore_errors=True)


@contextmanager
def locked(path: Path, wait: bool = True) -> Iterator[None]:
    """Hold the lock file ``path``, which goes at the end; it ends with the process. BusyError where
    another process holds it and ``wait`` is False. A file system without locks is no hindrance."""
    try:
        stream = _lock(path, wait)
    except BusyError:
        raise
    except OSError:  # finished work is not lost for that
        stream = None
    try:
        yield
    finally:
        if stream is not None:
            with contextlib.suppress(PermissionError):  # Windows deletes no file that is open
                path.unlink(missing_ok=True)  # who waits for it finds it gone and makes another
            os.close(stream)
            if sys.platform == "win32":
                with contextlib.suppress(OSError):  # another one has it by now
                    path.unlink()


def _lock(path: Path, wait: bool) -> int:
    while True:
        stream = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _take(stream, wait)
            if os.path.samestat(os.fstat(stream), path.stat()):
                return stream
        except FileNotFoundError:
            pass  # its holder is done and took it away
        except BlockingIOError:
            os.close(stream)
            raise BusyError(f"{path} is held by another process") from None
        except BaseException:
            os.close(stream)
            raise
        os.close(stream)


def _take(stream: int, wait: bool) -> None:
    """Lock an open file. BlockingIOError where another process has, and ``wait`` is False."""
    if sys.platform == "win32":
        while True:
            try:
                msvcrt.locking(stream, msvcrt.LK_NBLCK, 1)
                return
            except PermissionError as error:
                if not wait:
                    raise BlockingIOError(*error.args) from error
            time.sleep(0.1)
    else:
        fcntl.flock(stream, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def scratch(kind: str) -> Iterator[Path]:
    """A temporary folder of the system's, gone when the block ends; OSError where there is none."""
    prefix = f"fingerdesign-{kind}-"
    with tempfile.TemporaryDirectory(prefix=prefix, ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def keep_request(kind: str, name: str, content: str | bytes) -> Path:
    """Store the input of native code that failed, for an investigation; the file's path."""
    path = Path(tempfile.mkdtemp(prefix=f"fingerdesign-{kind}-")) / name
    return write_whole(path, content)


def sweep_abandoned(target: Path) -> None:
    """Remove this user's folders next to ``target`` that killed runs of that name left: those that
    no process locks, and older results where a newer one is in place.

    Where a file system has no locks, after a day. What cannot be looked into stays.
    """
    name = re.escape(target.name)
    pattern = re.compile(rf"\.{name}\.(partial|older)-[0-9a-f]{{8}}")
    try:
        neighbours = [*target.absolute().parent.iterdir()]
    except OSError:
        return
    for path in neighbours:
        found = pattern.fullmatch(path.name)
        if found is None or (found[1] == "older" and not target.is_dir()):
            continue
        with contextlib.suppress(OSError):
            mine = not hasattr(os, "getuid") or path.lstat().st_uid == os.getuid()
            if mine and not path.is_symlink() and path.is_dir() and _is_abandoned(path):
                shutil.rmtree(path, ignore_errors=True)


def _is_abandoned(folder: Path) -> bool:
    """Tell whether no process is at work in a folder of :func:`whole_folder`."""
    if time.time() - folder.stat().st_mtime < _FRESH_S:
        return False
    try:
        with _in_use(folder):
            return True
    except BlockingIOError:
        return False
    except OSError:  # no locks here
        last = max(each.lstat().st_mtime for each in (folder, *folder.rglob("*")))
        return time.time() - last > DAY_S


@contextmanager
def _in_use(folder: Path) -> Iterator[None]:
    """Lock a folder while the block lasts; the lock ends with the process. BlockingIOError where
    another one has it, another OSError where there are no locks of folders, as on Windows."""
    if sys.platform == "win32":
        raise OSError(errno.ENOTSUP, "no locks of folders", str(folder))
    stream = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(stream)


def writable_by_others(folders: Iterable[Path]) -> Path | None:
    """Return the first of these folders, or of those above them, into which another user can write
    or put another folder in its place; None where there is none.

    A user's own group, of the same name, is no other; nor is the system's administrator. Windows
    keeps users apart by itself. A folder that does not exist is judged by those above it.
    """
    if sys.platform != "win32":
        inner = [Path(os.path.realpath(each)) for each in folders]
        for folder in dict.fromkeys([*inner, *(each for own in inner for each in own.parents)]):
            try:
                about = folder.stat()
            except OSError:
                continue
            foreign = folder in inner and about.st_uid not in (os.getuid(), 0)
            others = about.st_mode & (stat.S_IWOTH if _is_own_group(about.st_gid) else 0o022)
            if foreign or (others and (folder in inner or not about.st_mode & stat.S_ISVTX)):
                return folder
    return None


def _is_own_group(group: int) -> bool:
    """Tell whether a group is the user's private one, or the administrators'."""
    if sys.platform != "win32":
        import grp
        import pwd

        try:
            known, user = grp.getgrgid(group), pwd.getpwuid(os.getuid()).pw_name
        except KeyError:
            return False
        return group == 0 or (known.gr_name == user and set(known.gr_mem) <= {user})
    return False


def make_private(folder: Path) -> None:
    """Make a folder, and those above it that are absent, for this user alone."""
    for each in (*reversed(folder.absolute().parents), folder):
        if not each.exists():
            each.mkdir(mode=0o700, exist_ok=True)
    folder.mkdir(exist_ok=True)  # FileExistsError where a file is there
