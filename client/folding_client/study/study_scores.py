"""What the answers to a user study come to: shares with intervals, and how far the participants agree."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from folding_client.critic_accuracy.intervals import Share, share_of
from folding_client.interrupts import UsageError
from folding_client.study.rater_agreement import fleiss_kappa, krippendorff_alpha
from folding_client.study.study_files import ChosenPicture, KeyedQuestion, StudyAnswers, StudyKey

Preference = str
"""``first``, ``second`` or ``tie``."""


@dataclass(frozen=True)
class PreferenceShares:
    """How many judgements were for either side, and how many for neither."""

    first: Share
    second: Share
    tie: Share


@dataclass(frozen=True)
class StudyScores:
    """The figures of a study. ``left`` is the share of the judgements other than ties for what stood on the left: far from a
    half, the side was chosen rather than the reconstruction. ``kappa`` is None unless all questions got the same number of
    answers; see ``rater_agreement``.
    """

    study: str
    first: str
    second: str
    raters: int
    judgements: int
    questions: int
    shares: PreferenceShares
    by_sequence: dict[str, PreferenceShares]
    left: Share
    kappa: float | None
    alpha: float | None
    median_seconds: float | None


def study_scores(answers: Sequence[StudyAnswers], key: StudyKey) -> StudyScores:
    """The figures of the answers. UsageError if there are none."""
    asked = {each.question: each for each in key.questions}
    given = [(asked[answer.question], answer) for each in answers for answer in each.answers]
    if not given:
        message = "The files hold no answers; give those that participants saved after answering."
        raise UsageError(message)
    preferences = [(question, preference_of(question, answer.choice)) for question, answer in given]
    sequences: defaultdict[str, list[Preference]] = defaultdict(list)
    questions: defaultdict[str, list[Preference]] = defaultdict(list)
    for question, preference in preferences:
        sequences[question.sequence].append(preference)
        questions[question.question].append(preference)
    choices = Counter(answer.choice for _, answer in given)
    seconds = [answer.seconds for _, answer in given if answer.seconds is not None]
    return StudyScores(
        key.study,
        key.first,
        key.second,
        len(answers),
        len(given),
        len(questions),
        _shares([preference for _, preference in preferences]),
        {name: _shares(sequences[name]) for name in sorted(sequences)},
        share_of(choices["A"], choices["A"] + choices["B"]),
        fleiss_kappa(list(questions.values())),
        krippendorff_alpha(list(questions.values())),
        median(seconds) if seconds else None,
    )


def preference_of(question: KeyedQuestion, choice: ChosenPicture) -> Preference:
    """Whose reconstruction a choice is for."""
    if choice == "tie":
        return "tie"
    other = "second" if question.left == "first" else "first"
    return question.left if choice == "A" else other


def _shares(preferences: Sequence[Preference]) -> PreferenceShares:
    counts = Counter(preferences)
    return PreferenceShares(
        *(share_of(counts[name], len(preferences)) for name in ("first", "second", "tie"))
    )


def study_lines(scores: StudyScores) -> Iterator[str]:
    """The figures for people, with 95 % intervals."""
    yield f"judgements {scores.judgements}, participants {scores.raters}, questions {scores.questions}"
    for name, share in (
        (scores.first, scores.shares.first),
        (scores.second, scores.shares.second),
        ("tie", scores.shares.tie),
    ):
        yield f"  {name}: {share.text}"
    for name, shares in scores.by_sequence.items():
        yield f"{name}: {shares.first.count} to {shares.second.count}, ties {shares.tie.count}"
    yield f"chosen on the left, without ties: {scores.left.text}"
    yield f"Fleiss' kappa {_figure(scores.kappa)}, Krippendorff's alpha {_figure(scores.alpha)}"
    if scores.median_seconds is not None:
        yield f"{scores.median_seconds:.1f} s a judgement in the median"


def _figure(value: float | None) -> str:
    return "not defined" if value is None else f"{value:.3f}"
