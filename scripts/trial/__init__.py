"""A trial: a robot and its controller run as processes of their own, recorded and judged from the bag."""
