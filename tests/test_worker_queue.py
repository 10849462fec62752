"""Who is next where more jobs wait than can be computed."""

import pytest
from folding_server.workers.job import JobRefused, WorkerJob
from folding_server.workers.job_queue import JobQueue, QueuedJob, QueueLimits
from hypothesis import given
from hypothesis import strategies as st
from long_work import add


def job(owner: str | None, name: str = "propose_actions") -> QueuedJob:
    return QueuedJob(WorkerJob(name, add, (1, 2), owner))


def filled(*owners: str | None, limits: QueueLimits | None = None) -> JobQueue:
    queue = JobQueue(limits or QueueLimits())
    for owner in owners:
        queue.add(job(owner))
    return queue


def taken(queue: JobQueue, count: int) -> list[str | None]:
    """The owners of the next jobs, all of which go on being computed."""
    return [each.job.owner for each in (queue.take() for _ in range(count)) if each]


def test_the_owner_with_fewest_jobs_being_computed_is_next() -> None:
    assert taken(filled("ada", "ada", "ada", "bob"), 4) == ["ada", "bob", "ada", "ada"]


def test_owners_take_turns_one_job_at_a_time() -> None:
    queue, order = filled("ada", "ada", "ada", "bob", "bob"), []
    while (next_one := queue.take()) is not None:
        order.append(next_one.job.owner)
        queue.finished(next_one.job)
    assert order == ["ada", "bob", "ada", "bob", "ada"]


def test_an_owner_at_its_limit_waits_while_others_are_computed() -> None:
    queue = filled("ada", "ada", "bob", limits=QueueLimits(owner_at_once=1))
    first, second = queue.take(), queue.take()
    assert first is not None
    assert second is not None
    assert (first.job.owner, second.job.owner) == ("ada", "bob")
    assert queue.take() is None
    queue.finished(first.job)
    assert taken(queue, 1) == ["ada"]


def test_callers_without_tokens_have_no_limit_of_their_own() -> None:
    queue = filled(None, None, None, limits=QueueLimits(owner_waiting=1, owner_at_once=1))
    assert taken(queue, 3) == [None, None, None]


def test_a_full_queue_refuses_in_words() -> None:
    queue = filled("ada", "bob", limits=QueueLimits(waiting=2))
    with pytest.raises(
        JobRefused, match=r"propose_actions would have to wait, and the queue is full \(2 waiting\); call it"
    ):
        queue.add(job("eve"))
    assert len(queue) == 2


def test_one_owner_cannot_fill_the_queue() -> None:
    queue = filled("ada", "ada", limits=QueueLimits(owner_waiting=2))
    with pytest.raises(JobRefused, match=r"the queue is full for ada \(2 waiting\); call it again when"):
        queue.add(job("ada"))
    queue.add(job("bob"))


def test_where_nothing_may_wait_an_idle_worker_still_gets_a_job() -> None:
    queue = JobQueue(QueueLimits(waiting=0, owner_waiting=0, owner_at_once=1))
    queue.add(job("ada"), idle=True)
    assert taken(queue, 1) == ["ada"]
    with pytest.raises(JobRefused):
        queue.add(job("ada"), idle=True)
    queue.add(job("bob"), idle=True)


def test_a_job_that_is_removed_is_never_next() -> None:
    queue, gone = filled("ada"), job("ada")
    queue.add(gone)
    queue.remove(gone)
    queue.remove(gone)
    assert taken(queue, 2) == ["ada"]


@given(st.lists(st.sampled_from(["ada", "bob", "eve"]), max_size=12), st.integers(1, 3))
def test_every_job_is_computed_once_and_an_owners_jobs_in_order(owners: list[str], at_once: int) -> None:
    queue, jobs = JobQueue(QueueLimits(owner_at_once=at_once)), [job(owner) for owner in owners]
    for each in jobs:
        queue.add(each)
    order: list[QueuedJob] = []
    while (following := queue.take()) is not None:
        order.append(following)
        queue.finished(following.job)
    assert len(queue) == 0
    for owner in set(owners):
        assert [each for each in order if each.job.owner == owner] == [
            each for each in jobs if each.job.owner == owner
        ]
    assert len(order) == len(jobs)
