"""A trial: a robot and its controller, each a process of its own, judged by their bag."""
