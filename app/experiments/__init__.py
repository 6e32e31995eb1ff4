"""Many runs: from an experiment to its folder of results, here or on a cluster."""
