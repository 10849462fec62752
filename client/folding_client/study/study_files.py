"""The files of a user study: the key that tells which side was whose, and the answers that a browser saves."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from folding_client.interrupts import UsageError
from folding_client.json_files import read_json_file

ChosenPicture = Literal["A", "B", "tie"]
"""What a participant chose: the picture on the left, that on the right, or neither."""
StudySide = Literal["first", "second"]
"""One of the two folders of runs that are compared."""


class KeyedQuestion(BaseModel):
    """A question of a study: what it showed, and whose reconstruction was on the left, A."""

    model_config = ConfigDict(frozen=True)

    question: str
    sequence: str
    frame: int
    left: StudySide


class StudyKey(BaseModel):
    """What turns answers into figures. It stays with whoever makes the study."""

    model_config = ConfigDict(frozen=True)

    format: Literal[1] = 1
    study: str
    seed: int
    first: str
    second: str
    questions: list[KeyedQuestion] = Field(min_length=1)


class StudyAnswer(BaseModel):
    """One answer, and how long it took in seconds."""

    model_config = ConfigDict(frozen=True)

    question: str
    choice: ChosenPicture
    seconds: float | None = Field(default=None, ge=0)


class StudyAnswers(BaseModel):
    """What the page of a study saves for one participant."""

    model_config = ConfigDict(frozen=True)

    format: Literal[1]
    study: str
    rater: str = Field(min_length=1, max_length=200)
    answers: list[StudyAnswer]


def read_key(file: Path) -> StudyKey:
    """The key of a study. UsageError if it is none."""
    return read_json_file(StudyKey, file, "the key of a study", "the key that foldingagent study wrote")


def read_answers(files: list[Path], key: StudyKey) -> list[StudyAnswers]:
    """The answers of all participants. UsageError if a file is malformed, of another study, or a participant's second."""
    known = {each.question for each in key.questions}
    found: dict[str, Path] = {}
    read: list[StudyAnswers] = []
    for file in files:
        answers = read_json_file(
            StudyAnswers, file, "the answers of a participant", "answers that the page of a study saved"
        )
        _check(answers, file, key, known)
        if answers.rater in found:
            message = f"{file} and {found[answers.rater]} are both of the participant {answers.rater!r}; give one of them."
            raise UsageError(message)
        found[answers.rater] = file
        read.append(answers)
    return read


def _check(answers: StudyAnswers, file: Path, key: StudyKey, known: set[str]) -> None:
    if answers.study != key.study:
        message = f"{file} answers the study {answers.study!r}, not {key.study!r} of the key; give the key of that study."
        raise UsageError(message)
    asked: set[str] = set()
    for answer in answers.answers:
        if answer.question not in known:
            message = f"{file} answers {answer.question!r}, which is no question of this study; give the file as the page saved it."
            raise UsageError(message)
        if answer.question in asked:
            message = f"{file} answers {answer.question!r} twice; give the file as the page saved it."
            raise UsageError(message)
        asked.add(answer.question)
