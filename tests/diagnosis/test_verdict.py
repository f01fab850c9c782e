"""Words, sentences and exit status of the verdicts: a contract with those who read the JSON."""

from __future__ import annotations

import json

from diagnosis.verdict import Verdict

WORDS = ["none", "named", "class", "composite", "partial", "generic", "unknown", "not_observable"]
FACTS = {
    "causes": "drift",
    "share": ", explaining all",
    "left": "means",
    "nearest": "; nearest is latency",
    "goes_with": "; it goes with heading",
}


def test_the_words_are_those_of_the_contract() -> None:
    assert json.loads(json.dumps([*Verdict])) == WORDS
    assert [f"{verdict}" for verdict in Verdict] == WORDS
    assert Verdict("class") is Verdict.CLASS


def test_a_gap_counts_as_explained_where_its_causes_are_named() -> None:
    assert [verdict.value for verdict in Verdict if verdict.explained] == ["none", "named", "class", "composite"]


def test_sentences_say_what_is_known() -> None:
    for verdict in Verdict:
        sentence = verdict.sentence(**FACTS)
        assert verdict.meaning
        assert "{" not in sentence
        assert sentence.endswith(".")
        assert ("drift" in sentence) == (verdict not in (Verdict.NONE, Verdict.UNKNOWN))
    assert "heading" in Verdict.UNKNOWN.sentence(**FACTS)
    assert "means" in Verdict.PARTIAL.sentence(**FACTS)
