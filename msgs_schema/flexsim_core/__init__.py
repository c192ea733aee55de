"""What both simulators stand on and that is no ROS: scene files, quantities, kept kernels."""
