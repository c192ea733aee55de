"""Many runs of one scene: what varies, what is observed, what is asked of them."""
