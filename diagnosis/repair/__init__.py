"""The model with what was missing in it, refined, and tried on another recording."""
