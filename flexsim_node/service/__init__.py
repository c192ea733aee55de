"""The robot as a service: stepping with deadlines, commands, parameters, ROS messages, URDF."""
