"""How each documented command is run by a test, or why it isn't."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Example:
    """A command that is run as it stands.

    Attributes
    ----------
    needs : what lies in the folder beforehand (see inputs.py): run, again, log, larger, bench, parts, urdf
    until : what it says when it has done its work and goes on until Ctrl-C; "": it ends by itself
    makes : files that are there afterwards
    nightly : it takes longer than about twenty seconds, so `make nightly` runs it
    """

    needs: tuple[str, ...] = ()
    until: str = ""
    makes: tuple[str, ...] = ()
    nightly: bool = False


BENCH = "flexsim bench-controller joint_pd config/anthropomorphic_geared.yaml"
GEARED = "flexsim_node --ros-args -p scene:=config/anthropomorphic_geared.yaml"
ARM = "flexsim_node --ros-args -p scene:=config/anthropomorphic.yaml"
DOOR = "thermal_node --ros-args -p scene:=config/thesis_door.yaml"
SWEEP = "flexsim sweep config/studies/door_thickness.yaml"
STUDY = Example(nightly=True)
NODE = Example(until="kernels ready")
RUN = ("run",)

RUN_BY_THE_TEST: dict[str, Example] = {
    # import, new, schema
    "flexsim import arm.urdf -o arm.yaml --beam forearm=tube:0.05x0.003,aluminium,4": Example(
        ("urdf",), makes=("arm.yaml",)
    ),
    "flexsim new -o arm.yaml": Example(makes=("arm.yaml",)),
    "flexsim new -o arm.yaml --axes zyy --lengths 0.2,0.5,0.4 --beam tube:0.04x0.003,aluminium,3": Example(
        makes=("arm.yaml",)
    ),
    "flexsim new door -o door.yaml --layers steel:0.001,stone_wool_100:0.06,steel:0.001": Example(
        makes=("door.yaml",)
    ),
    "flexsim schema robot -o robot.schema.json": Example(makes=("robot.schema.json",)),
    # simulate, modes, effects
    "flexsim simulate config/planar_double_pendulum.yaml --duration 2": Example(),
    "flexsim simulate config/delta.yaml --duration 0.5": Example(),
    "flexsim simulate config/four_bar.yaml --duration 1 --set solver.step=1e-3": Example(),
    "flexsim simulate config/anthropomorphic.yaml --set links.link_2.beam.elements=4 --save run.npz": Example(
        makes=("run.npz",)
    ),
    "flexsim modes config/anthropomorphic.yaml --position 0,0.5,-0.8 --save modes.npz"
    " --plot modes.png": Example(makes=("modes.npz", "modes.png")),
    "flexsim modes config/anthropomorphic.yaml --grid joint_2=-1.5:1.5:5 --grid joint_3=-2.5:2.5:7"
    " --plot map.png": Example(makes=("map.png",), nightly=True),
    "flexsim modes config/anthropomorphic.yaml --grid joint_3=-2.5:2.5:21 --plot workspace.png": Example(
        makes=("workspace.png",)
    ),
    "flexsim effects config/anthropomorphic.yaml --duration 0.2": STUDY,
    "flexsim effects config/anthropomorphic.yaml --duration 0.5": STUDY,
    "flexsim effects config/planar_double_pendulum.yaml --duration 0.2 --tolerance 1e-3 --set effects=auto"
    " --json": STUDY,
    "flexsim effects config/planar_double_pendulum.yaml --duration 0.1 --tolerance 1e-3"
    " --set formulation=auto": STUDY,
    "flexsim effects config/planar_double_pendulum.yaml --tolerance 1e-3 --set formulation=auto"
    " --json": STUDY,
    # accuracy, hard cases
    "flexsim accuracy config/planar_double_pendulum.yaml --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/anthropomorphic.yaml --sine joint_1=5@1 --budget 200us --write": STUDY,
    "flexsim accuracy config/thesis_door.yaml --tolerance 1K": STUDY,
    "flexsim accuracy config/simple_pendulum.yaml --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/spatial_double_pendulum.yaml --set gravity=[0,0,0] --set initial.velocity=[0,0]"
    " --sine joint_1=3@2 --sine joint_2=2@3 --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/anthropomorphic.yaml --sine joint_1=5@1 --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/anthropomorphic_spherical_wrist.yaml -d 0.3 --sine joint_1=5@1"
    " --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/dlr_spherical_wrist.yaml -d 0.3 --sine joint_1=5@1 --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/four_bar.yaml -d 0.2 --sine crank_joint=0.02@5 --tolerance 0.5mm": STUDY,
    "flexsim accuracy config/thesis_door_calibrated.yaml --set solver.model=column_rim --tolerance 1K": STUDY,
    "flexsim hardcases": STUDY,
    "flexsim hardcases 'step_*' folded": STUDY,
    "flexsim hardcases --list": Example(),
    # sweeps; those that do what another does are nightly
    SWEEP: Example(makes=("door_thickness.sqlite",), nightly=True),
    f"{SWEEP} --csv rows.csv --report page.html": Example(makes=("rows.csv", "page.html")),
    f"{SWEEP} --workers 2": Example(nightly=True),
    "flexsim sweep config/studies/door_probability.yaml --part 1/2 -o a.sqlite": Example(makes=("a.sqlite",)),
    "flexsim sweep config/studies/door_probability.yaml --part 2/2 -o b.sqlite": Example(
        makes=("b.sqlite",), nightly=True
    ),
    "flexsim sweep --merge a.sqlite b.sqlite -o c.sqlite": Example(("parts",), makes=("c.sqlite",)),
    # bags
    "flexsim record -o run": Example(until="recording to run", makes=("run/metadata.yaml",)),
    "flexsim record -o run /joint_states '/flexsim_node/*'": Example(
        until="recording to run", makes=("run/metadata.yaml",)
    ),
    "flexsim record -o run --max-size 500": Example(until="recording to run", makes=("run/metadata.yaml",)),
    "flexsim record -o run --duration 60": Example(makes=("run/metadata.yaml",), nightly=True),
    "flexsim info run": Example(RUN),
    "flexsim info run --json": Example(RUN),
    "flexsim play run": Example(RUN),
    "flexsim play run /joint_states --rate 10 --start-offset 0.2": Example(RUN),
    "flexsim play run /flexsim_node/commands --rate 0.5 --loop": Example(RUN, until="Ctrl-C ends"),
    "flexsim play run --lockstep": Example(RUN, makes=("run_again/metadata.yaml",)),
    "flexsim play run --lockstep -o again": Example(RUN, makes=("again/metadata.yaml",)),
    "flexsim compare run again": Example(("run", "again")),
    "flexsim compare run again --plot difference.png --save both.rrd": Example(
        ("run", "again"), makes=("difference.png", "both.rrd")
    ),
    "flexsim compare run again --align elapsed --topic /joint_states": Example(("run", "again")),
    "flexsim export run /joint_states -o joints.csv": Example(RUN, makes=("joints.csv",)),
    "flexsim export run -o tables --format parquet": Example(RUN, makes=("tables",)),
    "flexsim export run -o signals.npz": Example(RUN, makes=("signals.npz",)),
    "flexsim play run --clock 100 --remap /joint_states:=/recorded/joint_states": Example(RUN),
    "flexsim simulate run --save again.npz": Example(RUN, makes=("again.npz",)),
    "flexsim simulate run --set links.link_2.beam.elements=4 --save finer.npz": Example(
        RUN, makes=("finer.npz",)
    ),
    "flexsim recover run": Example(RUN),
    "flexsim report run": Example(RUN, makes=("run.html",)),
    "flexsim report run --scene config/anthropomorphic.yaml -o run.html --json": Example(
        RUN, makes=("run.html",)
    ),
    "flexsim view run --save run.rrd --scale 20": Example(RUN, makes=("run.rrd",)),
    "flexsim view run --web": Example(RUN, until="look at it in a browser"),
    # the robot's node, controllers
    "flexsim demo": Example(makes=("demo/vibration.png",), nightly=True),
    "flexsim demo --output arm --duration 5": Example(makes=("arm/bag/metadata.yaml",), nightly=True),
    BENCH: STUDY,
    f"{BENCH} --against lqg": STUDY,
    f"{BENCH} --only push --no-latency": STUDY,
    f"{BENCH} --against lqg --only push --no-latency -o bench.png": Example(
        makes=("bench.png",), nightly=True
    ),
    f"{BENCH} --against lqg -o side_by_side.png": Example(makes=("side_by_side.png",), nightly=True),
    'flexsim bench-controller "python my_controller.py" robot.yaml --goal 0.5,1.0 --rate 1000': Example(
        ("bench",), nightly=True
    ),
    ARM: NODE,
    f"{ARM} -p elastic_rate:=500.0 -p wait_for_command:=true": NODE,
    f"{ARM} -p override.solver.step:=0.0005": NODE,
    "flexsim_node --ros-args --params-file config/demo.params.yaml"
    " -p scene:=config/anthropomorphic.yaml": NODE,
    f"{GEARED} -p mode:=lockstep -p rate:=500.0 -p elastic_rate:=500.0 -p shape_rate:=500.0"
    " -p clock_rate:=500.0": NODE,
    f"{GEARED} -p clock_rate:=1000.0 -p command_timeout:=0.0": NODE,
    # the door
    DOOR: NODE,
    f"{DOOR} -p time_scale:=60.0 -p duration:=3600.0": NODE,
    f"{DOOR} -p time_scale:=.inf -p field_rate:=0.05": NODE,
    f"{DOOR} -p override.solver.model:=column_rim -p wait_for_furnace:=true": NODE,
    "flexsim door simulate config/thesis_door.yaml --report door.html": Example(
        makes=("door.html",), nightly=True
    ),
    "flexsim door simulate config/thesis_door.yaml --duration 3600 --report door.html": Example(
        makes=("door.html",), nightly=True
    ),
    "flexsim door simulate config/thesis_door.yaml --set solver.model=column_rim --save run.npz": Example(
        makes=("run.npz",), nightly=True
    ),
    "flexsim door fit config/thesis_door.yaml LOG.csv": Example(("log",), nightly=True),
    "flexsim door fit config/thesis_door.yaml LOG.csv --check": Example(("log",), nightly=True),
    "flexsim door fit config/thesis_door.yaml A.csv B.csv --prior density=120±6 --leave-out tc_7": Example(
        ("log",), nightly=True
    ),
    "flexsim door fit config/thesis_door.yaml LOG.csv --json": Example(("log",), nightly=True),
    "flexsim door fit config/thesis_door.yaml LOG.csv --also larger.yaml LARGER_LOG.csv": Example(
        ("log", "larger"), nightly=True
    ),
    "flexsim door fit config/thesis_door.yaml LOG.csv --predict larger.yaml --report larger.html": Example(
        ("log", "larger"), makes=("larger.html",), nightly=True
    ),
}

# Run together, in a test of their own.
A_BURNT_DOOR = (
    "flexsim record -o burnt '/door/*' /furnace/temperature &",
    f"{DOOR} -p time_scale:=60.0 -p duration:=3600.0",
    "flexsim door simulate config/thesis_door.yaml --furnace burnt",
)

# Not run, by how they begin.
NOT_RUN = {
    "make ": "make runs these tests; tests/test_setup.py and CI run make",
    "cd my_workspace": "needs a native ROS 2; tests/ros/test_colcon.py builds with colcon from this checkout",
    "colcon ": "needs a native ROS 2; tests/ros/test_colcon.py builds with colcon from this checkout",
    "ros2 ": "needs a native ROS 2; tests/ros/test_native_tools.py does the same in rclpy where it can",
    "export ": "sets what the shell hands to the next command, and does nothing by itself",
    "flexsim_node --ros-args --enclave ": "needs SROS 2 and its keys, which come with a native ROS 2",
    "python benchmarks/": "a study of minutes to hours that measures this machine; parts of each have tests",
    "flexsim new --ask": "asks a person; tests/scripts/test_new.py answers",
    "flexsim view config/": "opens a window and needs a display; tests/scripts/test_view.py has a robot",
    "flexsim view burnt": "opens a window and needs a display; tests/ros/test_door_view.py shows a door",
}

# Pages whose Python takes longer than about twenty seconds.
LONG_PROGRAMS = ("door.md",)
