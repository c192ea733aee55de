"""A furnace of one's own: any function of time heats the door, which can be looked at whenever one likes."""

from pathlib import Path

import numpy as np

from thermal_node import Heat, door_model, load_scene

CONFIG = Path(__file__).parents[1] / "config"


def smouldering_then_flames(time: float) -> float:
    """Gas temperature, °C: slow at first, 900 °C after half an hour, then cooling."""
    if time < 1800.0:
        return 20.0 + 880.0 * (time / 1800.0) ** 2
    return 20.0 + 880.0 * float(np.exp(-(time - 1800.0) / 1200.0))


model = door_model(load_scene(CONFIG / "thesis_door_column.yaml"))
heat = Heat(model, furnace=smouldering_then_flames)
print("t/min   furnace/°C   hot face/°C   cold face/°C   heat taken up/MJ per m2")
for minute in range(0, 61, 10):
    status = heat.advance(60.0 * minute)
    if not status.ok:
        raise SystemExit(status.reason)
    face = heat.temperature[[0, -1]]
    print(
        f"{minute:5d} {smouldering_then_flames(60.0 * minute):12.0f} {face[0]:13.1f} {face[1]:14.1f}"
        f" {heat.balance.stored / 1e6:18.3f}"
    )
