"""The library of materials: its page is made of it, and a scene takes from it what it does not say."""

from pathlib import Path

import numpy as np
import pytest
from door_scenes import slab

from thermal_node import SceneError, load_scene
from thermal_node.model.door_model import material_of
from thermal_node.scene.library import LIBRARY

PAGE = Path(__file__).resolve().parents[2] / "docs" / "materials.md"
UNITS = {
    "density": "kg/m3",
    "specific_heat": "J/(kg K)",
    "conductivity": "W/(m K)",
    "elongation": "-",
    "reactions": "",
}


def said(key, value):
    """A value as the page has it."""
    if key == "reactions":
        (r,) = value
        k = r["kinetics"]
        return (
            f"{r['name']}: share {r['share']:g}, residue {r['residue']:g},"
            f" gives {r['heat_of_combustion']:.3g} J/kg;"
            f" A {k['frequency_factor']:.4g} 1/s, E {k['activation_energy']:g} J/mol, n {k['order']:g}"
        )
    if not isinstance(value, dict):
        return f"{value:g}"
    t, v = value["temperature"], value["value"]
    step = max(1, -(-len(t) // 12))
    picked = sorted({*range(0, len(t), step), len(t) - 1})
    return ", ".join(f"{v[i]:.4g} at {t[i]:g} °C" for i in picked)


def page():
    """The tables of docs/materials.md."""
    lines = []
    for name, entry in LIBRARY.items():
        lines += [f"## `{name}`", "", f"{entry.title[0].upper()}{entry.title[1:]}.", ""]
        lines += ["| property | unit | value | source |", "|---|---|---|---|"]
        for key, value in entry.keys.items():
            lines.append(f"| `{key}` | {UNITS[key]} | {said(key, value)} | {entry.sources[key]} |")
        lines.append("")
    return "\n".join(lines)


def test_the_page_is_the_library():
    """To make it anew: python -c "import test_library; print(test_library.page())" in this folder."""
    text = PAGE.read_text(encoding="utf-8")
    assert text[text.index("## `") :].strip() == page().strip()


def test_every_value_has_a_source_and_every_material_loads():
    for name, entry in LIBRARY.items():
        assert set(entry.sources) == set(entry.keys)
        scene = slab(0.05, {}, 4)
        del scene["materials"]
        scene["leaf"]["layers"] = [{"material": name, "thickness": 0.05}]
        material = material_of(name, load_scene(scene))
        assert material.density == entry.keys["density"]
        assert len(material.reactions) == len(entry.keys.get("reactions", []))


def test_stainless_steel_is_annex_c():
    scene = slab(0.05, {"library": "stainless_steel"}, 4)
    steel = material_of("stuff", load_scene(scene))
    t = np.array([20.0, 333.0, 750.0, 1200.0])
    np.testing.assert_allclose(steel.conductivity(t), 14.6 + 1.27e-2 * t, rtol=1e-4)
    heat = 450.0 + 0.280 * t - 2.91e-4 * t**2 + 1.34e-7 * t**3
    np.testing.assert_allclose(steel.specific_heat(t), heat, rtol=1e-3)
    assert float(steel.elongation(20.0)) == 0.0


def test_what_a_scene_says_stands_before_the_library():
    scene = load_scene(slab(0.05, {"library": "stone_wool_65", "density": 70.0, "reactions": []}, 4))
    assert scene.materials["stuff"].density == 70.0
    assert scene.materials["stuff"].reactions == ()
    again = load_scene(scene.model_dump())
    assert again.materials == scene.materials


def test_a_table_of_the_library_may_end_otherwise():
    """Only its end is said: the values stay."""
    scene = slab(0.05, {"library": "calcium_silicate_737", "conductivity": {"beyond": "hold"}}, 4)
    board = load_scene(scene).materials["stuff"].conductivity
    assert board.beyond == "hold" and board.value == (0.13, 0.12, 0.12)
    hot = {"curve": "constant", "temperature": 900.0}
    assert load_scene({**scene, "furnace": hot}).materials["stuff"].conductivity.temperature[-1] == 538.0
    scene["materials"]["stuff"].pop("conductivity")
    with pytest.raises(SceneError, match="ends at 538 °C but the furnace is at 900 °C; give values to 900"):
        load_scene({**scene, "furnace": hot})


def test_a_name_that_the_library_has_not():
    with pytest.raises(SceneError, match=r"materials.stuff.library: is 'stone_wool_99'.*give stone_wool_9"):
        load_scene(slab(0.05, {"library": "stone_wool_99"}, 4))
    scene = slab(0.05, {"library": "stone_wool_65"}, 4)
    scene["leaf"]["layers"] = [{"material": "stone_wool_1000", "thickness": 0.05}]
    with pytest.raises(SceneError, match="did you mean 'stone_wool_100'"):
        load_scene(scene)
