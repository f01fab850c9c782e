"""Page of a diagnosis: missing effect, certainty, alternatives and advice, then the plots."""

from __future__ import annotations

from typing import Any

from reports.pages.section import Section, drawn_sections
from reports.pages.template import render_page
from reports.plots import diagnosis as plots
from reports.plots.channel_curves import draw_curves
from reports.presentation.answer import PresentedAnswer
from reports.presentation.diagnosis import CANDIDATE_HEADS, GAP_HEADS, PART_HEADS, PresentedDiagnosis
from reports.presentation.stated_iron import IRON_HEADS

SHARE_HEADS = ("channels that the gap follows", "frame", "share, held out")
SECTIONS = (
    Section("Gap over time",
            "Measured minus simulated, by body axis or as field strength; a single curve where the new model changes "
            "nothing. After (blue): noise about zero if the new model is complete.", plots.draw_gap),
    Section("Curves of channels",
            "Fitted curve with 95 % band; dots: the gap without the curve. A curve identifies the channel that the gap "
            "follows, not the mechanism.", draw_curves, lambda found: bool(found.curves)),
    Section("Gap along the path", "Means over a second or longer; before and after have the same colour scale.",
            plots.draw_map, lambda found: found.series.path.pos_m is not None),
    Section("Gap by channel",
            "The gap against the channels with the largest correlation; bold: means over stretches of the channel. A "
            "correlation is a clue, not a proof.", plots.draw_channel),
    Section("Gap by frequency", "White noise lies on the dashed line.", plots.draw_spectrum),
    Section("Evidence of each candidate",
            "Each effect alone, fitted with hard and soft iron and its own noise model. Blue: accepted; red: cannot be "
            "distinguished from the accepted effect; tick: evidence needed. Beside each bar: the effect's rms over "
            "the noise.",
            plots.draw_ranking, lambda found: bool(found.ranking)),
)  # fmt: skip


def diagnosis_page(found: PresentedDiagnosis, title: str) -> str:
    """Return the page as self-contained HTML."""
    heads = {"candidate_heads": CANDIDATE_HEADS, "part_heads": PART_HEADS}
    return render_page("diagnosis.html", answered(found, title) | heads | {"sections": drawn_sections(SECTIONS, found)})


def answered(found: PresentedAnswer, title: str) -> dict[str, Any]:
    """Return the values that the pages of one recording and of several have in common."""
    shares = [(one.channel, one.frame, f"{100 * one.share:.0f} %") for one in found.where]
    figures = [(value, "", label) for value, label in found.tiles]
    heads = {"gap_heads": GAP_HEADS, "iron_heads": IRON_HEADS, "share_heads": SHARE_HEADS}
    return vars(found) | heads | {"title": title, "figures": figures, "shares": shares}
