"""The answer to a question: the diagnosis of one recording, of several recordings, or of an array's sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from calib.numerics.threads import one_thread
from diagnosis.next_leg.advice import advised
from diagnosis.question import Question
from diagnosis.result import Diagnosis
from diagnosis.several.confirmation import confirmed
from diagnosis.several.result import PooledDiagnosis
from diagnosis.several.workflow import check_apart, diagnose_sensors, diagnose_together
from diagnosis.sources import Source, of_one_array
from diagnosis.workflow import diagnosis_of, examine
from scenarios.errors import errors_relocated
from sim.pool import Tasks

CONFIRM = "--confirm"
Progress = Callable[[str], object]


@one_thread()
def answer(
    question: Question,
    sources: Sequence[Source],
    confirm: Source | None = None,
    say: Progress = lambda what: None,
    cluster: Tasks | None = None,
) -> Diagnosis | PooledDiagnosis:
    """Diagnose the sources: a single recording, several recordings together, or the sensors of an array.

    confirm : a second recording, in which the causes found in a single recording must hold too.
    say : called with each stage. cluster : examines several recordings, each a task.
    Raises InputError for files, columns, models and references that cannot be used.
    """
    if len(sources) == 1:
        return _answer_single(question, sources[0], confirm, say)
    problems = [question.problem(source) for source in sources]
    names = [source.name for source in sources]
    models = [question.model_for(source) for source in sources]
    if of_one_array(sources):
        return diagnose_sensors(names, problems, models, say=say)
    return diagnose_together(names, problems, models[0], cluster=cluster, say=say)


def _answer_single(question: Question, source: Source, confirm: Source | None, say: Progress) -> Diagnosis:
    say("direct evidence")
    model, recording = question.model_for(source), question.recording(source)
    second = None if confirm is None else question.recording(confirm)
    if second is not None:
        check_apart(recording, second, CONFIRM)
    known = question.known_field(source, recording)
    seen = examine(question.posed(source, recording, known), model, say=say)
    say("the simulator with the new model")
    found = diagnosis_of(seen)
    if second is not None:
        say("the second recording")
        with errors_relocated(CONFIRM, "recording"):
            found = confirmed(found, second, model, *known)
    say("what to fly next")
    return advised(found)
