"""What all views have in common around them: time below, no panels at the sides."""

from __future__ import annotations

import rerun.blueprint as rrb

TIMELINE = "time"


def window(root: rrb.Container, *, live: bool = False, speed: float = 1.0) -> rrb.Blueprint:
    """Return a blueprint that plays at `speed`, or follows what goes on."""
    return rrb.Blueprint(
        root,
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(
            state="collapsed",
            timeline=TIMELINE,
            playback_speed=speed,
            play_state="following" if live else "playing",
        ),
    )
