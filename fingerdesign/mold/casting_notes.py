"""Casting notes made from the design: what to do, step by step, in words and numbers."""

from __future__ import annotations

from dataclasses import dataclass

from fingerdesign.mold.casting_bench import Bench
from fingerdesign.mold.casting_closing import closing
from fingerdesign.mold.casting_pouring import finishing, opening, pouring
from fingerdesign.mold.casting_preparation import making, plates_and_gages, preparing


@dataclass(frozen=True)
class Notes:
    """One section of the notes: its title and its steps, in order."""

    title: str
    steps: tuple[str, ...]


def casting_notes(bench: Bench) -> tuple[Notes, ...]:
    """All sections; what this mold does not need is left out."""
    sections = (
        ("Make the parts", making(bench)),
        ("Clean, cure, test", preparing(bench)),
        ("Plates and gages", plates_and_gages(bench)),
        ("Close the mold", closing(bench)),
        ("Mix and pour", pouring(bench)),
        ("Cure and open", opening(bench)),
        ("Finish and measure", finishing(bench)),
    )
    made = (Notes(title, tuple(steps)) for title, steps in sections)
    return tuple(notes for notes in made if notes.steps)
