"""What the verbs share of ROS: a quiet node and raw subscriptions."""
