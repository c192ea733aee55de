"""Virtual sensors: what instruments on the links would read, without their noise.

    strain_gauge    strain on the beam's surface, along the beam
    imu             angular velocity, specific force (acceleration against free fall), orientation
    pose            position and orientation
    section_force   force and moment that the part beyond puts on the part before

Sensor axes are those of the link's frame, turned with the section; forces and moments stand in beam axes,
turned with the section.  Quaternions are (x, y, z, w); w is not negative in the first reading, and
from reading to reading they go on without a jump of sign.
"""

from __future__ import annotations

import numpy as np

from ..equations.dynamics.end_acceleration import end_acceleration
from ..model.chain import ALPHA, COUNT, FIRST, FIRST_ELEMENT, SPIN, Workspace
from ..model.model import Model
from ..model.reduced.layout import MODES
from ..scene.load import SceneError
from ..scene.schema import Sensor
from .observation import Observation
from .sensing import IMU, KIND, LINK, POSE, SECTION_FORCE, STRAIN_GAUGE, STRAINED, sense

TYPES = {"strain_gauge": STRAIN_GAUGE, "imu": IMU, "pose": POSE, "section_force": SECTION_FORCE}
SIZES = (1, 10, 7, 6)
LETTERS = (
    ("strain",),
    (*(f"angular_velocity_{k}" for k in "xyz"), *(f"specific_force_{k}" for k in "xyz"),
     *(f"orientation_{k}" for k in "xyzw")),
    (*(f"position_{k}" for k in "xyz"), *(f"orientation_{k}" for k in "xyzw")),
    ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"),
)  # fmt: skip


class Sensors:
    """The sensors of a scene, and what they read at the last `look`.

    Attributes
    ----------
    names : of the sensors, in the scene's order; kinds : their types
    values : sensor name to its reading, (1,) strain; (10,) rad/s, m/s2, quaternion; (7,) m, quaternion;
        (6,) N, N m.  Views of one buffer that the next look overwrites
    """

    def __init__(self, model: Model) -> None:
        scene = model.scene
        self.model = model
        self.names = tuple(sensor.name for sensor in scene.sensors)
        self.kinds = {sensor.name: sensor.type for sensor in scene.sensors}
        count = len(scene.sensors)
        self._integers = np.zeros((count, 12), dtype=np.int64)
        self._reals = np.zeros((count, 4))
        sizes = [SIZES[TYPES[sensor.type]] for sensor in scene.sensors]
        ends = np.cumsum([0, *sizes])
        self.buffer = np.zeros(ends[-1])
        self.values = {
            name: self.buffer[a:b] for name, a, b in zip(self.names, ends[:-1], ends[1:], strict=True)
        }
        for row, (sensor, out) in enumerate(zip(scene.sensors, ends[:-1], strict=True)):
            self._set_up(row, sensor, int(out))
        # stress resultants are those of what is beyond, which takes the forces of the whole robot; so are
        # gauges' where few modes tell little of strains.  Beyond a section of a loop is the section itself.
        kinds, reduced = self._integers[:, KIND], model.chain.reduced[self._integers[:, LINK], MODES] >= 0
        resultants, gauges = kinds == SECTION_FORCE, (kinds == STRAIN_GAUGE) & reduced
        self._whole = bool(np.any(resultants | gauges)) and not scene.loops
        if scene.loops and np.any(self._integers[resultants, STRAINED:] == 0):
            raise SceneError(
                f"{scene.name}: sensors: a section_force on a rigid link, or of an effect that is off, is"
                " what all beyond the section needs, which loops leave open; make link and effects flexible"
            )
        if scene.loops and np.any((resultants | gauges) & reduced):
            name = self.names[int(np.flatnonzero((resultants | gauges) & reduced)[0])]
            raise SceneError(
                f"{scene.name}: sensors: {name} is on a reduced link, where strains are what all beyond the"
                " section needs, which loops leave open; keep that link's elements (its `reduction: false`)"
            )
        self._integrals, self._scratch, self._rows = np.zeros(9), np.zeros((30, 6)), np.zeros(model.unknowns)
        self._still = np.zeros(model.joints)
        self._setting = model.chain.setting.copy()
        if model.chain.co_moving:
            # alpha is in the accelerations of the frames, which hold the spin by their geometry
            self._setting[ALPHA], self._setting[SPIN] = 0.0, 1.0

    def _set_up(self, row: int, sensor: Sensor, out: int) -> None:
        """Fill the tables' rows of one sensor."""
        model, scene = self.model, self.model.scene
        names = [link.name for link in scene.links]
        n = names.index(sensor.link) if sensor.link else len(names) - 1
        link = scene.links[n]
        at = sensor.place(link)
        first, count, start = (int(k) for k in model.chain.link[n, [FIRST, COUNT, FIRST_ELEMENT]])
        if model.chain.reduced[n, MODES] >= 0:
            assert link.beam is not None
            first, count, start = 0, link.beam.elements, 0  # numbers within the link
        element, node, xi = -1, first, 0.0
        if count:
            step = link.length / count
            k = min(int(at / step * (1.0 - 1e-12)), count - 1)
            element, node, xi = start + k, first + k + 1, at / step - k
        effects = scene.effects
        flexible = link.beam is not None and link.flexible
        strained = [
            flexible and bool(on)
            for on in (
                effects.axial,
                effects.bending_z,
                effects.bending_y,
                effects.torsion,
                effects.bending_y,
                effects.bending_z,
            )
        ]
        self._integers[row, :STRAINED] = TYPES[sensor.type], n, node, element, out
        self._integers[row, STRAINED : STRAINED + 6] = strained
        y, z = sensor.point_on(link) if sensor.type == "strain_gauge" else (0.0, 0.0)
        self._reals[row] = xi, at, y, z

    def letters(self, name: str) -> tuple[str, ...]:
        """What the numbers of a sensor are called."""
        return LETTERS[TYPES[self.kinds[name]]]

    def begin(self) -> None:
        """Begin a run: quaternions have no reading before."""
        self.buffer[:] = 0.0

    def look(
        self,
        view: Observation,
        work: Workspace,
        x: np.ndarray,
        v: np.ndarray,
        a: np.ndarray,
        felt: np.ndarray | None = None,
    ) -> None:
        """Read the sensors at unknowns x (n,), rates v and accelerations a; `view` has looked at x.

        An IMU reads the accelerations `felt` where they are given (end_acceleration.py).
        """
        if not self.names:
            return
        sense(
            self.model.chain,
            work,
            self._integers,
            self._reals,
            self._setting,
            self.model.axes,
            view.pose,
            x,
            v,
            a,
            a if felt is None else felt,
            self._whole,
            self._still,
            self._rows,
            self._scratch,
            self._integrals,
            self.buffer,
        )

    def look_exactly(
        self,
        view: Observation,
        work: Workspace,
        x: np.ndarray,
        v: np.ndarray,
        torque: np.ndarray,
        a: np.ndarray,
    ) -> None:
        """Read the sensors with the accelerations of the equations, written into a (n,).

        Held joints take theirs from a.
        """
        if self.names:
            end_acceleration(self.model.chain, work, x, v, torque, 0.0, a)
            self.look(view, work, x, v, a)
