"""What is asked for: presets and experiments, from YAML to values, or to all that is wrong."""
