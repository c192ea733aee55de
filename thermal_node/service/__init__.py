"""The door as a service: marching with deadlines, parameters, ROS messages."""
