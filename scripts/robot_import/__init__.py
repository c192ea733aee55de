"""From a robot that exists, described in URDF or xacro, to a scene."""
