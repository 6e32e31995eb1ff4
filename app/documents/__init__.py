"""What is asked for: presets and experiments, from YAML to values, with every fault at once."""
