"""Stone-wool slabs behind 1 mm of steel in a furnace, against their measured cold faces.

Measured: github.com/firemodels/exp, Insulation_Materials/stone_wool_exp.csv. Slabs, furnace (58 °C until
1000 s, then ISO 834) and the binder's rate, heat and residue: github.com/firemodels/fds,
Validation/Insulation_Materials (stone_wool_const_AEn). Its rate is in shares of the whole layer's mass, hence
share^(n - 1). Nothing is fitted here; oxygen comes in from the bare cold face.
"""

import numpy as np
import pytest
from door_scenes import slab

from thermal_node import load_scene, simulate

TEMPERATURE = [20, *range(100, 1001, 100)]
SLABS = {
    1: (99.9, 0.0619, 0.015,
        [.0305, .0405, .0555, .0744, .0982, .1280, .1646, .2090, .2621, .3246, .3974]),
    4: (95.8, 0.0632, 0.012,
        [.0422, .0525, .0699, .0935, .1249, .1652, .2159, .2784, .3538, .4435, .5487]),
    20: (38.0, 0.0520, 0.007,
         [.0362, .0528, .0813, .1209, .1741, .2434, .3313, .4402, .5726, .7306, .9168]),
    23: (64.7, 0.0752, 0.09,
         [.0321, .0441, .0632, .0883, .1210, .1627, .2148, .2787, .3557, .4470, .5541]),
}  # fmt: skip
"""Density with binder, kg/m3, thickness, m, binder's share, conductivity, W/(m K)."""
MEASURED = {1: (170.8, 182.8), 4: (179.3, 193.0), 20: (248.7, 268.6)}
"""°C at 50 and 60 min."""


def cold_face(number, burns):
    density, thickness, share, conductivity = SLABS[number]
    wool = {
        "density": density,
        "specific_heat": {"temperature": [20, 1000], "value": [996.0, 1150.0], "beyond": "hold"},
        "conductivity": {"temperature": TEMPERATURE, "value": conductivity, "beyond": "extend"},
    }
    if burns:
        wool["oxygen_diffusivity"] = 2.05e-5
        kinetics = {"frequency_factor": 0.028 * share**-0.29, "activation_energy": 21700.0, "order": 0.71}
        wool["reactions"] = [
            {"name": "binder", "share": share, "residue": 0.283, "heat_of_combustion": 2.5e7,
             "specific_heat": 1700.0, "kinetics": kinetics, "oxygen": "diffusion"}
        ]  # fmt: skip
    t = np.arange(0.0, 3601.0, 10.0)
    gas = np.where(t < 1000.0, 20.0 + 0.038 * t, 20.0 + 345.0 * np.log10(8.0 * t / 60.0 + 1.0))
    scene = slab(
        thickness,
        wool,
        40,
        furnace={"curve": "table", "time": t, "temperature": gas},
        exposed={"film_coefficient": 18.0, "emissivity": 0.9},
        unexposed={"film_coefficient": 0.2, "emissivity": 0.9},
        mesh={"layers": [1, 40]},
    )
    scene["materials"]["steel"] = {"density": 7850.0}
    scene["leaf"]["layers"].insert(0, {"material": "steel", "thickness": 0.001})
    run = simulate(load_scene(scene), 3600.0, 30.0)
    assert run.balance.worst < 1e-6
    return run.time, run.temperature[:, -1]


@pytest.mark.parametrize("burns", [False, True])
@pytest.mark.parametrize("number", [1, 4, 20])
def test_slabs_of_little_binder(number, burns):
    time, face = cold_face(number, burns)
    np.testing.assert_allclose(np.interp([3000.0, 3600.0], time, face), MEASURED[number], atol=30.0)


def test_a_slab_whose_binder_burns_through():
    """Measured: a peak of 329.6 °C at 1817 s, and cooling from there; without its binder's heat, no peak."""
    time, face = cold_face(23, True)
    peak = int(face.argmax())
    assert face[peak] == pytest.approx(329.6, abs=40.0)
    assert time[peak] == pytest.approx(1817.0, abs=300.0)
    assert face[-1] == pytest.approx(251.7, abs=40.0)
    time, face = cold_face(23, False)
    assert face.argmax() == len(face) - 1
    assert face[-1] < 200.0
