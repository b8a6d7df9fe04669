"""A mind behind a folder: it is asked once, answers with a file, and may send anything."""

import os
import threading
import time
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image as Picture

from text2sim.agents.models import mailbox as mailbox_module
from text2sim.agents.models.calls import CallLog
from text2sim.agents.models.endpoint import endpoint_of, never_stop
from text2sim.agents.models.exchange import Image, Message, ModelError, ModelRequest, StoppedError
from text2sim.agents.models.mailbox import Mailbox, MailboxReplay


def picture(name: str = "frame_1.png") -> Image:
    stream = BytesIO()
    Picture.new("RGB", (30, 25)).save(stream, "PNG")
    return Image(name, "image/png", stream.getvalue())


def question(text: str = "What is wrong?", number: int = 1, *images: Image) -> ModelRequest:
    return ModelRequest("critic", (Message("system", "You judge."), Message("user", text, images)), number=number)


def answer(folder: Path, name: str, content: str = "verdict: pass\n", *, age: float = 10.0) -> Path:
    """A reply that has been lying there for a while."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(content, "utf-8")
    os.utime(path, (time.time() - age, time.time() - age))
    return path


class Mind:
    """Answers every request in a folder in a thread of its own, by what `say` makes of its text."""

    def __init__(self, folder: Path, say, ending: str = "md") -> None:
        self._folder, self._say, self._ending = folder, say, ending
        self.read: list[str] = []
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> "Mind":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()

    def _work(self) -> None:
        while not self._end.wait(0.02):
            for path in self._folder.glob("*.request.md"):
                stem = path.name.removesuffix(".request.md")
                if not list(self._folder.glob(f"{stem}.reply.*")):
                    self.read.append(path.read_text("utf-8"))
                    part = self._folder / f".{stem}.part"
                    part.write_text(self._say(self.read[-1]), "utf-8")
                    part.rename(self._folder / f"{stem}.reply.{self._ending}")


@pytest.mark.parametrize("ending", ["md", "yaml", "json", "txt"])
def test_a_mind_reads_the_request_and_answers(tmp_path: Path, ending: str) -> None:
    box = tmp_path / "box"
    endpoint = endpoint_of(f"mailbox:{box}")
    with Mind(box, lambda text: f"I saw {len(text)} characters", ending) as mind:
        reply = endpoint.complete(question("Why?\n## Message 9", 1, picture()), never_stop)
    letter = mind.read[0]
    assert reply.text == f"I saw {len(letter)} characters"
    assert "`critic-01.reply.md`" in letter
    assert "## Message 1 of 2: system\n\nYou judge.\n" in letter
    assert "## Message 2 of 2: user\n\nWhy?" in letter
    assert "Picture `frame_1.png`: see the file `critic-01.1.png`" in letter
    assert (box / "critic-01.1.png").read_bytes() == picture().data
    assert (reply.cost, reply.estimated) == (None, True)
    assert reply.tokens_in > 4 + 1
    assert reply.tokens_out > 3


def test_several_minds_work_at_once(tmp_path: Path) -> None:
    box, replies = Mailbox(tmp_path), {}

    def ask(number: int) -> None:
        replies[number] = box.complete(question(f"number {number}", number), never_stop).text

    with Mind(tmp_path, lambda text: text.split("number ")[-1].strip()):
        threads = [threading.Thread(target=ask, args=(number,)) for number in range(1, 7)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert replies == {number: str(number) for number in range(1, 7)}


def test_a_question_that_lies_there_is_not_asked_twice(tmp_path: Path) -> None:
    with pytest.raises(StoppedError):
        Mailbox(tmp_path).complete(question(), lambda: True)
    before = (tmp_path / "critic-01.request.md").stat()
    answer(tmp_path, "critic-01.reply.md")
    start = time.monotonic()
    assert Mailbox(tmp_path).complete(question(), never_stop).text == "verdict: pass\n"
    assert time.monotonic() - start < 1.5
    after = (tmp_path / "critic-01.request.md").stat()
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_request_has_its_name_only_when_it_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there: list[list[str]] = []
    fsync = os.fsync
    monkeypatch.setattr(os, "fsync", lambda fd: (there.append([p.name for p in tmp_path.iterdir()]), fsync(fd)))
    with pytest.raises(StoppedError):
        Mailbox(tmp_path).complete(question("Why?", 1, picture()), lambda: True)
    assert len(there) == 2, "a picture and the request"
    assert all(names for names in there)
    assert not [name for names in there for name in names if name.endswith(".request.md")]


def test_another_question_of_the_same_number_puts_the_old_pair_away(tmp_path: Path) -> None:
    for text in ("first", "second"):
        with pytest.raises(StoppedError):
            Mailbox(tmp_path).complete(question(text, 1, picture()), lambda: True)
        answer(tmp_path, "critic-01.reply.md", f"to the {text}")
    with Mind(tmp_path, lambda text: "to the third"):
        assert Mailbox(tmp_path).complete(question("third"), never_stop).text == "to the third"
    for count, text in enumerate(("first", "second"), 1):
        away = tmp_path / "superseded" / f"critic-01.{count}"
        assert (away / "critic-01.reply.md").read_text() == f"to the {text}"
        assert text in (away / "critic-01.request.md").read_text()
        assert (away / "critic-01.1.png").is_file()
    assert not (tmp_path / "critic-01.1.png").exists(), "the third question has no picture"


def test_a_reply_without_its_question_answers_nothing(tmp_path: Path) -> None:
    answer(tmp_path, "critic-01.reply.yaml", "stale")
    with Mind(tmp_path, lambda text: "fresh"):
        assert Mailbox(tmp_path).complete(question(), never_stop).text == "fresh"


def test_half_a_reply_is_waited_for(tmp_path: Path) -> None:
    def write_slowly() -> None:
        while not (tmp_path / "critic-01.request.md").exists():
            time.sleep(0.01)
        with (tmp_path / "critic-01.reply.md").open("w") as file:
            for count in range(8):
                file.write(f"{count}\n")
                file.flush()
                time.sleep(0.1)

    thread = threading.Thread(target=write_slowly)
    thread.start()
    reply = Mailbox(tmp_path).complete(question(), never_stop)
    thread.join()
    assert reply.text.split() == [str(count) for count in range(8)]


def too_large(path: Path) -> None:
    path.write_bytes(b"x" * (mailbox_module.MAX_REPLY_SIZE + 1))


def binary(path: Path) -> None:
    path.write_bytes(b"a: \xff\xfe\x00")


def link(path: Path) -> None:
    outside = path.parent.parent / "secret.txt"
    outside.write_text("a secret")
    path.symlink_to(outside)


def dangling(path: Path) -> None:
    path.symlink_to("/no/such/file")


HOSTILE = [
    (too_large, "more than 10,000,000 bytes"),
    (binary, "not UTF-8 text: byte 3 is 0xff"),
    (Path.mkdir, "not a regular file"),
    (os.mkfifo, "not a regular file"),
    (link, "links are not followed"),
    (dangling, "links are not followed"),
]


@pytest.mark.parametrize(("make", "words"), HOSTILE)
@pytest.mark.parametrize("kind", [Mailbox, MailboxReplay])
def test_a_hostile_reply_is_told_and_not_read(tmp_path: Path, kind, make, words: str) -> None:
    box = tmp_path / "box"
    with pytest.raises(StoppedError):
        Mailbox(box).complete(question(), lambda: True)
    make(box / "critic-01.reply.md")
    with pytest.raises(ModelError, match=words) as caught:
        kind(box).complete(question(), never_stop)
    assert "critic-01.reply.md" in str(caught.value)
    assert "a secret" not in str(caught.value)
    assert not isinstance(caught.value, StoppedError)


def test_a_request_that_is_a_link_is_not_written_through(tmp_path: Path) -> None:
    outside = tmp_path / "outside.md"
    outside.write_text("precious")
    (tmp_path / "box").mkdir()
    (tmp_path / "box" / "critic-01.request.md").symlink_to(outside)
    with pytest.raises(ModelError, match="links are not followed"):
        Mailbox(tmp_path / "box").complete(question(), lambda: True)
    assert outside.read_text() == "precious"


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ModelError, match="file"):
        Mailbox(tmp_path / "file" / "box").complete(question(), lambda: True)


def test_a_finished_mailbox_replays_whatever_is_asked(tmp_path: Path) -> None:
    with Mind(tmp_path, lambda text: "played"):
        Mailbox(tmp_path).complete(question("once"), never_stop)
    replay = endpoint_of(f"replay:{tmp_path}")
    assert replay.complete(question("something else"), never_stop).text == "played"
    with pytest.raises(ModelError, match=r"there is no .*critic-02\.reply\.md"):
        replay.complete(question(number=2), never_stop)
    assert not replay.cacheable


def test_a_mailbox_that_moved_is_the_same_mind(tmp_path: Path) -> None:
    with Mind(tmp_path / "a", lambda text: "played"):
        CallLog(tmp_path / "calls").ask(Mailbox(tmp_path / "a"), question())
    reply = CallLog(tmp_path / "calls").ask(Mailbox(tmp_path / "b"), question())
    assert (reply.text, reply.cached) == ("played", True)
    assert not (tmp_path / "b").exists()
