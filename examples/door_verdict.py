"""A fire test of a door, offline: criteria and the verdict, for two thicknesses of wool."""

from pathlib import Path

from thermal_node import load_scene, simulate

CONFIG = Path(__file__).parents[1] / "config"

for wool in (0.040, 0.058):
    layers = [
        {"material": "steel", "thickness": 0.001},
        {"material": "rock_wool", "thickness": wool},
        {"material": "steel", "thickness": 0.001},
    ]
    scene = load_scene(CONFIG / "thesis_door_column.yaml", {"leaf.layers": layers})
    run = simulate(scene, duration=3600.0, sample_period=300.0)
    print(f"{1e3 * wool:.0f} mm of wool, {run.steps} steps, heat balance to {run.balance.worst:.0e}:")
    for criterion in run.criteria:
        state = f"failed at {criterion.time_of_failure / 60:.1f} min" if criterion.failed else "held"
        print(
            f"  {criterion.name:<40} {criterion.value:8.1f} of {criterion.limit:g} {criterion.unit}, {state}"
        )
    print(" ", run.verdict.partition(":")[0])
